"""Command `certified`: the certified solutions of the scenes that come with barchain."""

from __future__ import annotations

import time
from pathlib import Path

import click

from barchain.cli.common.exit_codes import findings
from barchain.cli.common.numbers import NamedPath
from barchain.cli.common.options import need_loaded, optional_scenes, overwrite_option
from barchain.cli.common.terminal import say

MAKER = "heyoka-quad"


@click.command("certified", short_help="Make or check certified solutions.")
@optional_scenes
@click.option("--out", metavar="DIR", type=NamedPath(path_type=Path, file_okay=False),
              help="Write the certified solution of each scene into this folder.")  # fmt: skip
@click.option("--check", "only_check", is_flag=True,
              help="Compare a fresh run with the solution that comes with barchain; write nothing.")  # fmt: skip
@overwrite_option
def certified_solutions(scenes: tuple[str, ...], out: Path | None, only_check: bool, overwrite: bool) -> None:
    """Make or check certified solutions of SCENEs that come with barchain; default: all of these.

    A certified solution is a run in quadruple precision with error bars. Its file has a few instants, and, but of hard
    scenes, all samples, which judge engines in comparisons. Needs the engine heyoka-quad. A check exits with 1 where a
    fresh run is not inside the error bars.
    """
    from barchain.record.claim import claim
    from barchain.solutions.certified import check, commit
    from barchain.solutions.certified_file import shipped_path
    from scenarios import load_scene

    names = shipped(scenes)
    if only_check is (out is not None):
        raise click.UsageError("give either --out DIR or --check")
    need_loaded(MAKER)
    if out is not None:
        there = [path for name in names if (path := shipped_path(name, out)).exists()]
        claim(there, f"{', '.join(map(str, there))}: there already", overwrite=overwrite)
    agree = True
    for name in names:
        begun, scene = time.perf_counter(), load_scene(name)
        if out is None:
            found = check(scene)
            agree = agree and found.agrees
            say(found.said)
        else:
            worst = commit(scene, out).error["attitude"][-1]
            say(f"{name}: attitude to {worst:.1e} rad at the end, in {time.perf_counter() - begun:.1f} s")
    if not agree:
        raise findings()


def shipped(scenes: tuple[str, ...]) -> list[str]:
    """Names asked for, all by default; only scenes that come with barchain have certified solutions."""
    from scenarios import nearest, scene_names

    known = scene_names()
    unknown = [name for name in scenes if name not in known]
    if unknown:
        raise click.UsageError(
            f"{unknown[0]}: only scenes that come with barchain have certified solutions"
            f"{nearest(unknown[0], known)}; there are: {', '.join(known)}"
        )
    return list(scenes or known)
