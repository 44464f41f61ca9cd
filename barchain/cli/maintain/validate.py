"""`barchain validate`: scene files checked without a run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.common.names import SCENE
from barchain.cli.common.terminal import say

if TYPE_CHECKING:
    from scenarios import Scene

LOW_M = 80e3  # the air of the Earth ends an orbit below it within a revolution


@click.command(short_help="Check scene files without a run.")
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=SCENE)
def validate(files: tuple[str, ...]) -> None:
    """Check scene FILEs without a run, and print each fault in one line.

    The line names the file, the key, the given value, the allowed values and the nearest name.
    A valid scene has a line on the period and the lowest height of its orbit. A height below 80 km is a warning.
    A line proposes another duration and number of samples where engines reject a scene for its instants alone.
    A scene whose run would take longer than is allowed is a fault, and the line says what allows more.
    Exits with 2 if a file has a fault.
    """
    checked = [valid(file) for file in files]  # all of them, also after a fault
    if not all(checked):
        raise click.exceptions.Exit(ExitCode.BAD_INPUT)


def valid(file: str) -> bool:
    """Print whether a file holds a scene, and if not, its faults to standard error."""
    from adapters.registry import engines  # noqa: PLC0415
    from barchain.crossval.external_coverage import instants_advice  # noqa: PLC0415
    from barchain.runs.timing.estimate import TOLD_S, estimated_run_s, need_runnable, work_words  # noqa: PLC0415
    from scenarios import SceneError, load_scene  # noqa: PLC0415

    try:
        scene = load_scene(file)
        need_runnable([scene])
    except SceneError as error:
        say(str(error), err=True)
        return False
    orbits = scene.run.duration_s / scene.period_s
    say(f"{file}: valid: {scene.bars} bars, {orbits:.3g} orbits, {scene.run.samples} samples")
    say(f"{file}: {orbit_words(scene)}")
    if scene.lowest_height_m < LOW_M:
        say(f"{file}: warning: {low_words(scene)}", err=True)
    if estimated_run_s(scene) > TOLD_S:
        say(f"{file}: {work_words(scene)}")
    if advice := instants_advice(scene, {n: r for n, r in engines().items() if r.by_default}):
        say(f"{file}: {advice}")
    return True


def orbit_words(scene: Scene) -> str:
    """Period and lowest height of the centre of mass, of the osculating orbit at the start."""
    from reports.text.numerals import span  # noqa: PLC0415
    from scenarios import Gravity  # noqa: PLC0415

    lowest = f"lowest height {scene.lowest_height_m / 1e3:.6g} km"
    if scene.bound:
        return f"orbit of the centre of mass: period {scene.period_s:.6g} s ({span(scene.period_s)}), {lowest}"
    kind = "straight path" if scene.effects.gravity is Gravity.NONE else "open orbit"
    return f"{kind} of the centre of mass: no period, {lowest}"


def low_words(scene: Scene) -> str:
    """Warning of an orbit that air would end, or the surface."""
    late = scene.orbit.speed_factor < 1.0 and scene.run.duration_s < scene.period_s / 2.0
    when = ", after the end of this run" if late else ""
    low = f"the orbit's lowest height is below {LOW_M / 1e3:g} km"
    said = "the orbit meets the surface, where a run ends" if scene.lowest_height_m < 0 else low
    return f"{said}{when}; was another altitude_m or speed_factor meant?"
