"""`barchain validate`: scene files checked without a run."""

from __future__ import annotations

import click

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.common.names import SCENE
from barchain.cli.common.terminal import say


@click.command()
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=SCENE)
def validate(files: tuple[str, ...]) -> None:
    """Check scene FILEs without a run, and print each fault in one line.

    The line names the file, the key, the given value, the allowed values and the nearest name.
    Exits with 2 if a file has a fault.
    """
    checked = [valid(file) for file in files]  # all of them, also after a fault
    if not all(checked):
        raise click.exceptions.Exit(ExitCode.BAD_INPUT)


def valid(file: str) -> bool:
    """Print whether a file holds a scene, and if not, its faults to standard error."""
    from scenarios import SceneError, load_scene  # noqa: PLC0415

    try:
        scene = load_scene(file)
    except SceneError as error:
        say(str(error), err=True)
        return False
    orbits = scene.run.duration_s / scene.period_s
    say(f"{file}: valid: {scene.bars} bars, {orbits:.3g} orbits, {scene.run.samples} samples")
    return True
