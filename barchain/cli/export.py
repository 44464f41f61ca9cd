"""Command `export`: scenes as folders that need no barchain, and all of them as a data set."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.numbers import RealNumber
from barchain.cli.common.options import optional_scenes, out_option, overwrite_option, time_limit_option
from barchain.cli.common.terminal import say
from barchain.runs.job import TIME_LIMIT_S

if TYPE_CHECKING:
    from pathlib import Path


ON_PAGE = (1e-6, 1e-9)
"""Requests whose tubes a page has where none is given"""


@click.command(short_help="Write scenes as problems to solve elsewhere.")
@optional_scenes
@click.option("--all", "every", is_flag=True, help="Write all scenes with certified samples, as a data set to cite.")
@out_option(None, required=True, help_text="Write a folder for each scene, or the data set, into this folder.")
@click.option("--rtol", "rtols", multiple=True, metavar="X", type=RealNumber(1e-18, 1e-1),
              help="Write the curves between which a right answer lies if it requests this relative error of each "
              "step. May be repeated; default: none.")  # fmt: skip
@click.option("--page", is_flag=True, help="Write a page for a browser that compares a table with the case, offline.")
@click.option("--mjcf", is_flag=True, help="Write MuJoCo's model of the chain too, and a program for Basilisk, where "
              "these carry the scene.")  # fmt: skip
@time_limit_option(TIME_LIMIT_S)
@overwrite_option
def export(
    scenes: tuple[str, ...], every: bool, out: Path, rtols: tuple[float, ...], page: bool, mjcf: bool,
    time_limit_s: float, overwrite: bool,
) -> None:  # fmt: skip
    """Write each SCENE as a folder: the problem in words and equations, certified samples with error bars, settings.

    A program that knows nothing of barchain can solve it, and `barchain judge` tells whether its table passes.
    """
    from barchain.record.claim import claim
    from barchain.result_files.case import not_carried, page_data, write_case
    from barchain.result_files.data_set import folder_name, terms, write_surroundings
    from barchain.result_files.judging import solution_of
    from barchain.solutions.case_versions import case_scenes
    from barchain.solutions.reference import at_own_samples, closely_sampled
    from reports.case_page import case_page
    from reports.notebook.card import picture
    from reports.notebook.scene import WIDTH_PX, drawing
    from scenarios import load_scene

    if every == bool(scenes):
        raise click.UsageError("give scenes, or --all for those with certified samples")
    place, licence = out, ""
    if every:
        place, licence = out / folder_name(), terms(programs=mjcf)
        claim([place], f"{place} is there", overwrite=overwrite)
    chosen = [load_scene(name) for name in (case_scenes() if every else scenes)]
    wanted = tuple(dict.fromkeys(rtols))
    for scene in chosen:
        solution = at_own_samples(solution_of(closely_sampled(scene), time_limit_s), scene)
        html = case_page(page_data(solution, wanted or ON_PAGE)) if page else ""
        files = write_case(
            solution, place / scene.name, str(picture(drawing(scene), WIDTH_PX)), html, mjcf=mjcf,
            overwrite=overwrite, rtols=wanted, terms=licence,
        )  # fmt: skip
        say(f"{place / scene.name}: {', '.join(files)}")
        for name, reason in not_carried(scene).items() if mjcf and not every else ():
            say(f"{place / scene.name}: no {name}: {reason}", err=True)
    if every:
        write_surroundings(place, chosen)
        say(f"{place}: {len(chosen)} cases")
