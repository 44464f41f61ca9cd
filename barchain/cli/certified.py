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
@click.option("--enclose", is_flag=True,
              help="Enclose the exact motion in balls, and write the solution that comes with barchain with this proof "
                   "into the folder of --out. Needs python-flint; may take minutes.")  # fmt: skip
@overwrite_option
def certified_solutions(
    scenes: tuple[str, ...], out: Path | None, only_check: bool, enclose: bool, overwrite: bool
) -> None:
    """Make or check certified solutions of SCENEs that come with barchain; default: all of these.

    A certified solution is a run in quadruple precision with error bars. Its file has a few instants, and, but of hard
    scenes, all samples, which judge engines in comparisons. Needs the engine heyoka-quad. A check exits with 1 where a
    fresh run is not inside the error bars, or a stored proof is none. A scene whose motion is not enclosed is reported
    with the reason.
    """
    from barchain.record.claim import claim
    from barchain.solutions.certified import check, commit
    from barchain.solutions.certified_file import shipped_path
    from barchain.solutions.proof import MISSING
    from scenarios import load_scene

    names = shipped(scenes)
    if only_check is (out is not None):
        raise click.UsageError("give either --out DIR or --check")
    if enclose and (only_check or MISSING):
        raise click.UsageError("--enclose goes with --out DIR" if only_check else f"--enclose: {MISSING}")
    if not enclose:
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
        elif enclose:
            agree = enclosed(name, out) and agree
        else:
            worst = commit(scene, out).error["attitude"][-1]
            say(f"{name}: attitude to {worst:.1e} rad at the end, in {time.perf_counter() - begun:.1f} s")
    if not agree:
        raise findings()


def enclosed(name: str, out: Path) -> bool:
    """Enclose a scene's motion; whether its certified solution is not excluded."""
    from barchain.solutions.certified_file import shipped_path
    from barchain.solutions.enclosure.run import NotEnclosedError
    from barchain.solutions.enclosure.series import TooWideError
    from barchain.solutions.proof import ExcludedError, attach
    from scenarios import load_scene

    try:
        say(f"{name}: {attach(shipped_path(name), load_scene(name), out).words}")
    except (NotEnclosedError, TooWideError) as error:
        say(f"{name}: not enclosed: {str(error).removeprefix(f'{name}: ')}")
    except ExcludedError as error:
        say(str(error))
        return False
    return True


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
