"""Command `export`: scenes as folders that need no barchain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.options import out_option, overwrite_option, required_scenes, time_limit_option
from barchain.cli.common.terminal import say
from barchain.runs.job import TIME_LIMIT_S

if TYPE_CHECKING:
    from pathlib import Path


@click.command(short_help="Write scenes as problems to solve elsewhere.")
@required_scenes
@out_option(None, required=True, help_text="Write a folder for each scene into this folder.")
@click.option("--mjcf", is_flag=True, help="Write MuJoCo's model of the chain too, and a program for Basilisk, where "
              "these carry the scene.")  # fmt: skip
@time_limit_option(TIME_LIMIT_S)
@overwrite_option
def export(scenes: tuple[str, ...], out: Path, mjcf: bool, time_limit_s: float, overwrite: bool) -> None:
    """Write each SCENE as a folder: the problem in words and equations, certified samples with error bars, settings.

    A program that knows nothing of barchain can solve it, and `barchain judge` tells whether its table passes.
    """
    from barchain.result_files.case import write_case
    from barchain.result_files.judging import solution_of
    from barchain.solutions.reference import at_own_samples, closely_sampled
    from reports.notebook.card import picture
    from reports.notebook.scene import WIDTH_PX, drawing
    from scenarios import load_scene

    for name in scenes:
        scene = load_scene(name)
        folder = out / scene.name
        drawn = str(picture(drawing(scene), WIDTH_PX))
        solution = at_own_samples(solution_of(closely_sampled(scene), time_limit_s), scene)
        files = write_case(solution, folder, drawn, mjcf=mjcf, overwrite=overwrite)
        say(f"{folder}: {', '.join(files)}")
