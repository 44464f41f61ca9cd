"""Commands on scenes: `scenes` lists and shows them, `validate` checks files without a run, `schema` prints keys."""

from __future__ import annotations

import dataclasses
import json
import math
from importlib import import_module
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.common.options import SCENE, having, json_option, scene_argument
from barchain.cli.common.terminal import say, show_rows

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.registry import Registration
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

DEPENDS = "supports the scene if no bar turns its other face to the wind or the Sun, which a run tells"
PLANETS = (1e-3, 10.0)
"""Least and largest pressure of sunlight on planets, over that on the Earth"""
SAME_RATE = 1e-3  # of the orbital rate: a bar's own longitude turns at another rate than the chain's by (l/r)²
FEW = 6  # bars whose start `validate` tells
LOW_M = 80e3  # the air of the Earth ends an orbit below it within a revolution
SCHEMAS = {
    "scene": "scenarios:SceneFile",
    "request": "adapters.request:request_schema",
    "result": "adapters.request:result_schema",
    "engines": "adapters.command.entries:EngineFile",
    "plan": "barchain.nightly.running.plan:PlanFile",
    "nightly": "reports.results.nights.document:NightlyFile",
}
"""Model, or function, that has the JSON Schema of each kind of file"""


class SceneGroup(click.Group):
    """Group whose fault names the command that shows a scene, for a scene's name typed in its place."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """See `click.Group.resolve_command`."""
        if args[0] not in self.commands and not ctx.resilient_parsing:
            raise click.UsageError(f"scenes has no command {args[0]!r}; to show a scene: barchain scenes show SCENE")
        return super().resolve_command(ctx, args)


@click.group(cls=SceneGroup, invoke_without_command=True, short_help="List the scenes, or show one.")
@click.option("--tag", metavar="T", help="List only scenes with this tag.")
@click.option("--folder", metavar="F", help="List only scenes of this folder, e.g. paper or hard.")
@click.option("--effect", metavar="E", help="List only scenes with this effect, e.g. drag or prescribed_rotation.")
@json_option
@click.pass_context
def scenes(ctx: click.Context, tag: str | None, folder: str | None, effect: str | None, as_json: bool) -> None:
    """List the scenes that come with barchain, or show one of them."""
    if ctx.invoked_subcommand is not None:
        given = [p.opts[0] for p in ctx.command.params if ctx.params.get(str(p.name))]
        if given:  # the subcommand would not heed them
            raise click.UsageError(f"{given[0]} goes with the list of scenes; `barchain scenes show SCENE [--json]`")
        return
    from scenarios import load_scene, scene_names

    found = [load_scene(name) for name in scene_names()]
    if tag is not None:
        found = having(found, "tag", tag, {s.name: s.tags for s in found})
    if folder is not None:
        found = having(found, "folder", folder, {s.name: [s.name.partition("/")[0]] for s in found})
    if effect is not None:
        found = having(found, "effect", effect, {s.name: s.needs for s in found})
    if as_json:
        columns = [
            {
                "name": s.name,
                "bars": s.bars,
                "orbits": s.run.duration_s / s.period_s,
                "tags": list(s.tags),
                "effects": sorted(s.needs),
                "title": s.title,
            }
            for s in found
        ]
        say(json.dumps(columns, indent=2))
        return
    rows = [(s.name, str(s.bars), f"{s.run.duration_s / s.period_s:.3g}", ", ".join(s.tags), s.title) for s in found]
    show_rows(("scene", "bars", "orbits", "tags", "title"), rows, right=("bars", "orbits"))


@scenes.command("show")
@scene_argument
@json_option
def show_scene(scene: str, as_json: bool) -> None:
    """Show SCENE (a name or a file): values in SI units, angles in degrees, invariants, and engines that support it.

    Values are labelled in plain words with units; --json keeps the names of the fields, and angles in radians.
    """
    from scenarios import load_scene

    values = complete(load_scene(scene))
    if as_json:
        say(json.dumps(values, indent=2))
        return
    shown = list(lines(values))
    width = max(len(label) for label, _ in shown)
    for label, value in shown:
        say(f"{label:<{width}}  {value}")


def complete(scene: Scene) -> dict[str, Any]:
    """All values of a scene, what it conserves, and what each engine says: that it supports the scene, or why not."""
    from adapters.registry import ENGINES, engines
    from barchain.record.scene_description import invariant_words
    from barchain.solutions.certified_file import shipped_solution

    bare = dataclasses.replace(scene, given=None)  # the tables that all these values follow from
    values: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(bare), default=str))
    del values["given"]
    solution, support = shipped_solution(scene), {}
    for name, registered in engines().items():
        missing, own = registered.missing, registered in ENGINES.values()
        said = "" if missing and not own else answer(registered, scene, solution)
        support[name] = registered.rejected or "; ".join(filter(None, (said, missing)))
    return values | {
        "orbit_period_s": scene.period_s,
        "lowest_height_m": scene.lowest_height_m,
        "duration_orbits": scene.run.duration_s / scene.period_s,
        "conserves": invariant_words(scene),
        "engines": support,
    }


def answer(registration: Registration, scene: Scene, solution: ReferenceSolution | None) -> str:
    """An engine's own answer whether it supports a scene and its motion, or why it gives none.

    Some engines support a scene as long as no bar turns its other face to the wind or the Sun: only a solution tells.
    """
    from barchain.runs.asking import declarations_of, engine_fault

    try:
        engine = declarations_of(registration)
        reason = engine.unsupported(scene) or (solution and engine.unsupported_motion(solution.scene, solution.fine))
        if reason:
            return reason
        if solution is not None or not scene.effects.on_faces:
            return "supports the scene"
    except Exception as error:
        return engine_fault(error)
    return DEPENDS if "unsupported_motion" in engine.questions else "supports the scene"


def lines(values: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, str]]:
    """Labels in plain words with units, and values as text; angles in degrees, absent effects left out."""
    from scenarios.key_words import labelled, unit

    def within(key: str) -> str:
        return "" if key == "effects" else f"{prefix}{key.replace('_', ' ')}: "  # effects are named by themselves

    for key, value in values.items():
        if prefix + key == "engines":
            yield from ((f"engine {k}", v) for k, v in value.items())
        elif isinstance(value, dict):
            yield from lines(value, within(key))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for number, each in enumerate(value, 1):
                yield from lines(each, within(key if len(value) == 1 else f"{key} {number}"))
        elif value not in (None, [], "") and unit(key) == "rad":  # a scene's file gives angles in degrees
            yield prefix + labelled(f"{key.removesuffix('rad')}deg"), in_words(in_degrees(value))
        elif value not in (None, [], ""):
            yield prefix + labelled(key), in_words(value)


def in_degrees(value: Any) -> Any:
    """Angle, or list of angles, in degrees: to 12 digits, so that a scene's own number returns."""
    if isinstance(value, list):
        return [in_degrees(v) for v in value]
    return value if value is None else float(f"{math.degrees(value):.12g}")


def in_words(value: Any) -> str:
    """Text of a value; of a list of equal values the value and their number."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list) and len(value) > 1 and all(v == value[0] for v in value):
        return f"{value[0]} ({len(value)} times)"
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


@click.command(short_help="Check scene files without a run.")
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=SCENE)
def validate(files: tuple[str, ...]) -> None:
    """Check scene FILEs without a run, and print each fault in one line.

    The line names the file, the key, the given value, the allowed values and the nearest name.
    A valid scene has lines on its orbit and on its start in numbers. A lowest height below 80 km is a warning.
    A prescribed bar whose law starts at another rate than its rate_factor gives is a note, and so are a law of no
    amplitude that begins late, a torque in a joint that a law drives, and sunlight that no planet has.
    A line proposes another duration and number of samples where engines reject a scene for its instants alone.
    A scene whose run would take longer than is allowed is a fault, and the line says what allows more.
    Exits with 2 if a file has a fault.
    """
    checked = [valid(file) for file in files]  # all of them, also after a fault
    if not all(checked):
        raise click.exceptions.Exit(ExitCode.BAD_INPUT)


def valid(file: str) -> bool:
    """Print whether a file holds a scene, and if not, its faults to standard error."""
    from adapters.registry import engines
    from barchain.runs.estimate import TOLD_S, estimated_run_s, need_runnable, work_words
    from barchain.studies.comparison.external_coverage import instants_advice
    from scenarios import SceneError, load_scene

    try:
        scene = load_scene(file)
        need_runnable([scene])
    except SceneError as error:
        say(str(error), err=True)
        return False
    length_s = scene.run.duration_s
    length = f"{length_s / scene.period_s:.3g} orbits" if scene.bound else f"{length_s:.6g} s"
    say(f"{file}: valid: {scene.bars} bars, {length}, {scene.run.samples} samples")
    say(f"{file}: {orbit_words(scene)}")
    for words in start_words(scene):
        say(f"{file}: {words}")
    warn_of_height(file, scene)
    notes = (held_all_along, rates_of_laws, torques_in_driven_joints, light_of_no_planet)
    for words in (words for note in notes for words in note(scene)):
        say(f"{file}: note: {words}")
    if estimated_run_s(scene) > TOLD_S:
        say(f"{file}: {work_words(scene)}")
    if advice := instants_advice(scene, {n: r for n, r in engines().items() if r.by_default}):
        say(f"{file}: {advice}")
    return True


def orbit_words(scene: Scene) -> str:
    """Period and lowest height of the centre of mass, of the osculating orbit at the start."""
    from reports.text.numerals import span
    from scenarios import Gravity

    lowest = f"lowest height {scene.lowest_height_m / 1e3:.6g} km"
    if scene.bound:
        return f"orbit of the centre of mass: period {scene.period_s:.6g} s ({span(scene.period_s)}), {lowest}"
    kind = "straight path" if scene.effects.gravity is Gravity.NONE else "open orbit"
    return f"{kind} of the centre of mass: no period, {lowest}"


def start_words(scene: Scene) -> Iterable[str]:
    """Start in numbers: place and velocity of the centre of mass, elements, angles and rates of a few bars."""
    from adapters.common.initial_state import initial_state
    from scenarios.scene import semi_major_axis_m

    orbit, state = scene.orbit, initial_state(scene)
    path = math.degrees(orbit.flight_path_rad)
    place, velocity = (", ".join(f"{v + 0.0:.10g}" for v in vector) for vector in (state.com_m, state.com_velocity_m_s))
    yield (
        f"start: {orbit.altitude_m / 1e3:.9g} km high at longitude {math.degrees(orbit.longitude_rad):.9g}°, "
        f"{scene.speed0_m_s:.9g} m/s, {abs(path):.9g}° {'below' if path < 0.0 else 'above'} the horizontal; "
        f"position ({place}) m, velocity ({velocity}) m/s"
    )
    if scene.bound:
        axis_m = semi_major_axis_m(scene.central_body, orbit)
        periapsis = round(math.degrees(orbit.longitude_rad - orbit.true_anomaly_rad), 9) % 360.0
        yield (
            f"elements at the start: semi-major axis {axis_m:.10g} m, eccentricity {orbit.eccentricity:.9g}, "
            f"argument of periapsis {periapsis:.9g}°, "
            f"true anomaly {math.degrees(orbit.true_anomaly_rad):.9g}°, "
            f"mean anomaly {math.degrees(orbit.mean_anomaly_rad):.9g}°"
        )
    for bar, (angle, rate) in enumerate(zip(state.angle_rad[:FEW], state.rate_rad_s[:FEW], strict=True), 1):
        name = f"end body {bar}" if bar in scene.chain.bodies else f"bar {bar}"
        yield f"{name}: {math.degrees(angle):.9g}° from the z1 axis, {rate:.9g} rad/s"
    if scene.bars > FEW:
        yield f"{scene.bars - FEW} more bars"


def held_all_along(scene: Scene) -> Iterable[str]:
    """Sentence on each law without amplitude from a later instant on: a law holds before it begins, too."""
    for law in scene.effects.prescribed_rotation:
        if law.turns[0].start_s > 0.0 and not any(turn.amplitude_rad for turn in law.turns):
            yield (
                f"bar {law.bar} is prescribed with an amplitude of 0 from {law.turns[0].start_s:g} s on: its angle is "
                "held from the start to the end of the run; a lock between two instants takes runs that go on"
            )


def rates_of_laws(scene: Scene) -> Iterable[str]:
    """Sentence on each prescribed bar whose law starts at another rate than the scene gives the bar."""
    from adapters.common.initial_state import initial_state

    laws = scene.effects.prescribed_rotation
    started = initial_state(scene).rate_rad_s if laws else ()
    for bar in sorted(law.bar for law in laws):
        given, own = scene.chain.rate_factor[bar - 1] * scene.orbital_rate_rad_s, float(started[bar - 1])
        if abs(own - given) > SAME_RATE * scene.orbital_rate_rad_s:
            yield (
                f"bar {bar} is prescribed: it starts at the rate of its law, {own:.4g} rad/s, and not at the rate that "
                f"the scene gives it, {given:.4g} rad/s"
            )


def torques_in_driven_joints(scene: Scene) -> Iterable[str]:
    """Sentence on each joint with the motor of a law and another torque, which that motor takes up."""
    from scenarios import Actuator
    from scenarios.toml.checks import joint_of_motor

    laws = [law for law in scene.effects.prescribed_rotation if law.actuator is Actuator.JOINT]
    driven = {joint_of_motor(law.bar) for law in laws}
    for joint in sorted(driven & {motor.joint for motor in scene.effects.joint_torque}):
        yield (
            f"a prescribed rotation drives joint {joint}: a joint_torque or a set point there changes the torque of "
            "that law alone, and not the motion"
        )


def light_of_no_planet(scene: Scene) -> Iterable[str]:
    """Sentence on sunlight of a pressure that no planet has: Mercury's is 7 times the Earth's, Neptune's 1/900."""
    from scenarios.toml.effect_tables import SUNLIGHT_PA

    light = scene.effects.solar_pressure
    if light and not PLANETS[0] <= light.pressure_Pa / SUNLIGHT_PA <= PLANETS[1]:
        yield (
            f"effects.solar_pressure.pressure_Pa: {light.pressure_Pa:g} Pa is {light.pressure_Pa / SUNLIGHT_PA:.3g} "
            f"times the Sun's at the Earth's distance, {SUNLIGHT_PA:g} Pa"
        )


def warn_of_height(file: str, scene: Scene) -> None:
    """Print a warning, to standard error, of an orbit that air would end, or the surface."""
    if scene.lowest_height_m >= LOW_M:
        return
    phase = scene.orbit.mean_anomaly_rad / (2.0 * math.pi) if scene.bound else 0.0
    late = scene.run.duration_s < -phase % 1.0 * scene.period_s
    when = ", after the end of this run" if late else ""
    low = f"the orbit's lowest height is below {LOW_M / 1e3:g} km"
    said = "the orbit meets the surface, where a run ends" if scene.lowest_height_m < 0 else low
    say(f"{file}: warning: {said}{when}; was another start meant?", err=True)


@click.command(short_help="Print the JSON Schema of a kind of file.")
@click.argument("file", type=click.Choice(list(SCHEMAS)), default="scene")
def schema(file: str) -> None:
    """Print the JSON Schema of a kind of file; default: a scene file.

    A program in any language reads a request and writes a result; engines.toml names such programs.
    """
    module, name = SCHEMAS[file].split(":")
    found = getattr(import_module(module), name)
    say(json.dumps(getattr(found, "model_json_schema", found)(), indent=2))
