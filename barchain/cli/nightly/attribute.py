"""`barchain attribute` and `barchain bisect`: whose change it was, by real runs in fresh environments."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.numbers import WORDS
from barchain.cli.common.terminal import say
from barchain.cli.nightly.options import history_option, opened
from barchain.nightly.errors import need_extra

if TYPE_CHECKING:
    from barchain.nightly.attribution.attribute import Attribution

MOST_CHANGES = 10
scene_option = click.option("--scene-file", "scenes", metavar="FILE", multiple=True, type=WORDS,
                            help="Measure figures of this scene of a file, as it was on a night. May be "
                                 "repeated.")  # fmt: skip


@click.command("attribute", short_help="Find whose change it was, by runs with old and new parts.")
@click.argument("night", metavar="[NIGHT]", default="latest", type=WORDS)
@click.option("--change", "names", metavar="CHANGE", multiple=True, type=WORDS,
              help="Attribute this change: an id of `barchain history changes`, or the name of a figure. May be "
                   "repeated; default: the changes of NIGHT with suspects, one for each engine and set of suspects, "
                   "bits and times apart.")  # fmt: skip
@scene_option
@history_option
def attribute_night(night: str, names: tuple[str, ...], scenes: tuple[str, ...], url: str | None) -> None:
    """Find out whose change it was: runs with old and new states of each suspect, in fresh environments.

    Versions of engines and libraries come from the package index, from folders of wheels, or from the repository from
    which they were installed; barchain's own sources come from its repository. The results are kept in the history.
    Exits with 1 if a change is not reproduced.
    """
    need_extra("packaging", "pypi_simple", "uv")
    from barchain.nightly.attribution.attribute import (  # noqa: PLC0415
        attribute,
        reasons_against,
        worth_attributing,
    )
    from barchain.nightly.attribution.trials import own_scenes  # noqa: PLC0415
    from barchain.nightly.history.judging import change_named, judge  # noqa: PLC0415

    own = own_scenes(scenes)
    store = opened(url)
    judged = judge(store, night)
    chosen = [change_named(judged, name) for name in names] or worth_attributing(judged, MOST_CHANGES, own)
    if not chosen:
        say(f"{judged.night.name}: no change with a suspect that can be exchanged")
        for reason in reasons_against(judged, own):
            say(f"  {reason}")
        return
    found = attribute(store, judged, chosen, note=lambda text: say(f"  {text}", err=True), told=show, scenes=own)
    if any(one.verdict == "not reproduced" for one in found):
        raise findings()


def show(one: Attribution) -> None:
    """Print an attribution."""
    say(f"{one.figure}: {one.words}")
    for cell, result in one.cells:
        say(f"  {cell}: {result}")
    for reason in one.fixed:
        say(f"  not exchanged: {reason}")


@click.command("bisect", short_help="Find the release or commit that changed a figure.")
@click.argument("figure", metavar="FIGURE", type=WORDS)
@click.option("--good", metavar="NIGHT", required=True, type=WORDS, help="Take the old value of this night.")
@click.option("--bad", metavar="NIGHT", required=True, type=WORDS, help="Take the new value of this night.")
@click.option("--part", metavar="PART", type=WORDS, help="Walk the states of this part; default: the one that differs.")
@scene_option
@history_option
def bisect_figure(figure: str, good: str, bad: str, part: str | None, scenes: tuple[str, ...], url: str | None) -> None:
    """Find the release, or the commit, between two nights since which FIGURE has its new value.

    Both ends are confirmed first; releases and commits that do not run are skipped and named.
    """
    need_extra("packaging", "pypi_simple", "uv")
    from barchain.nightly.attribution.bisection import bisect_nights  # noqa: PLC0415
    from barchain.nightly.attribution.trials import own_scenes  # noqa: PLC0415

    own = own_scenes(scenes)
    store = opened(url)
    say(bisect_nights(store, figure, good, bad, part, lambda text: say(f"  {text}", err=True), own))
