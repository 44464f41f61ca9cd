"""`barchain scenes`: the scenes that come with barchain."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.options import json_option, scene_argument
from barchain.cli.common.terminal import say

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.engine import Engine
    from adapters.registry import Registration
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

DEPENDS = "supports the scene if no bar turns its other face to the wind or the Sun, which a run tells"
HEADINGS = ("scene", "bars", "orbits", "tags", "title")


@click.group(invoke_without_command=True, short_help="List the scenes, or show one.")
@click.option("--tag", metavar="T", help="List only scenes with this tag.")
@click.option("--folder", metavar="F", help="List only scenes of this folder, e.g. paper or hard.")
@click.option("--effect", metavar="E", help="List only scenes with this effect, e.g. drag or prescribed_rotation.")
@json_option
@click.pass_context
def scenes(ctx: click.Context, tag: str | None, folder: str | None, effect: str | None, as_json: bool) -> None:
    """List the scenes that come with barchain, or show one of them."""
    if ctx.invoked_subcommand is not None:
        reject_filters(ctx)
        return
    found = all_scenes()
    for option, wanted, of in (("tag", tag, tags), ("folder", folder, folders), ("effect", effect, effects_of)):
        if wanted is not None:
            found = having(found, option, wanted, {s.name: of(s) for s in found})
    if as_json:
        say(json.dumps([summary(s) for s in found], indent=2))
    else:
        show_scenes(found)


def reject_filters(ctx: click.Context) -> None:
    """Reject options of the list before a subcommand, which would not heed them."""
    given = [p.opts[0] for p in ctx.command.params if ctx.params.get(str(p.name))]
    if given:
        raise click.UsageError(f"{given[0]} goes with the list of scenes; `barchain scenes show SCENE [--json]`")


@scenes.command("show")
@scene_argument
@json_option
def show_scene(scene: str, as_json: bool) -> None:
    """Show SCENE (a name or a file): values in SI units, angles in degrees, invariants, and engines that support it.

    Values are labelled in plain words with units; --json keeps the names of the fields, and angles in radians.
    """
    from scenarios import load_scene  # noqa: PLC0415

    found = load_scene(scene)
    if as_json:
        say(json.dumps(complete(found), indent=2))
        return
    shown = list(lines(complete(found)))
    width = max(len(label) for label, _ in shown)
    for label, value in shown:
        say(f"{label:<{width}}  {value}")


def all_scenes() -> list[Scene]:
    """Scenes that come with barchain."""
    from scenarios import load_scene, scene_names  # noqa: PLC0415

    return [load_scene(name) for name in scene_names()]


def tags(scene: Scene) -> tuple[str, ...]:
    """Tags of a scene."""
    return scene.tags


def folders(scene: Scene) -> tuple[str, ...]:
    """Folder that a scene's name begins with."""
    return (scene.name.partition("/")[0],)


def effects_of(scene: Scene) -> tuple[str, ...]:
    """Names of the effects that a scene has."""
    return tuple(sorted(scene.effects.names))


def having(found: list[Scene], option: str, wanted: str, labels: Mapping[str, Iterable[str]]) -> list[Scene]:
    """Scenes that have a label, of some scenes.

    Raises
    ------
    UsageError
        If none has it; the message names the nearest label and all there are.
    """
    from scenarios import nearest  # noqa: PLC0415

    known = sorted({label for own in labels.values() for label in own})
    if wanted not in known:
        there = f"there are: {', '.join(known)}" if known else "there are none"
        raise click.UsageError(f"--{option} {wanted}: no such scene has it{nearest(wanted, known)}; {there}")
    return [s for s in found if wanted in labels[s.name]]


def tagged(found: list[Scene], tag: str) -> list[Scene]:
    """Scenes that carry `tag`, of some scenes; none is bad usage."""
    return having(found, "tag", tag, {s.name: s.tags for s in found})


def summary(scene: Scene) -> dict[str, Any]:
    """Columns of the list for one scene."""
    return {
        "name": scene.name,
        "bars": scene.bars,
        "orbits": scene.run.duration_s / scene.period_s,
        "tags": list(scene.tags),
        "effects": list(effects_of(scene)),
        "title": scene.title,
    }


def show_scenes(found: Iterable[Scene]) -> None:
    """Print name, bars, orbits, tags and title of each scene."""
    from barchain.cli.common.terminal import show_rows  # noqa: PLC0415

    show_rows(HEADINGS, map(row, map(summary, found)), right=("bars", "orbits"))


def row(known: Mapping[str, Any]) -> tuple[str, ...]:
    """Cells of a scene."""
    return known["name"], str(known["bars"]), f"{known['orbits']:.3g}", ", ".join(known["tags"]), known["title"]


def complete(scene: Scene) -> dict[str, Any]:
    """All values of a scene, what it conserves, and which engines support it."""
    from barchain.record.scene_description import invariant_words  # noqa: PLC0415

    bare = dataclasses.replace(scene, given=None)  # the tables that all these values follow from
    values: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(bare), default=str))
    del values["given"]
    derived = {
        "orbit_period_s": scene.period_s,
        "lowest_height_m": scene.lowest_height_m,
        "duration_orbits": scene.run.duration_s / scene.period_s,
    }
    return values | derived | {"conserves": invariant_words(scene), "engines": support(scene)}


def support(scene: Scene) -> dict[str, str]:
    """For each engine "supports the scene", or the reason why the engine does not or is missing."""
    from adapters.registry import engines  # noqa: PLC0415
    from barchain.solutions.shipped import shipped_solution  # noqa: PLC0415

    solution = shipped_solution(scene)
    return {name: r.rejected or installed_or_not(r, scene, solution) for name, r in engines().items()}


def installed_or_not(registration: Registration, scene: Scene, solution: ReferenceSolution | None) -> str:
    """Answer of an engine; of one of barchain's that is not installed, with the command that installs its library."""
    from adapters.registry import ENGINES  # noqa: PLC0415

    missing = registration.missing
    if missing is None:
        return of_engine(registration, scene, solution)
    own = registration in ENGINES.values()
    return f"{of_engine(registration, scene, solution)}; {missing}" if own else missing


def of_engine(registration: Registration, scene: Scene, solution: ReferenceSolution | None) -> str:
    """An engine's own answer whether it supports a scene and its motion, or why it gives none.

    Some engines support a scene as long as no bar turns its other face to the wind or the Sun: only a solution tells.
    """
    from barchain.runs.declared import engine_class, engine_fault  # noqa: PLC0415

    try:
        engine = engine_class(registration)
        reason = engine.unsupported(scene) or (solution and engine.unsupported_motion(solution.scene, solution.fine))
        if reason:
            return reason
        return DEPENDS if solution is None and depends_on_motion(engine, scene) else "supports the scene"
    except Exception as error:
        return engine_fault(error)


def depends_on_motion(engine: type[Engine], scene: Scene) -> bool:
    """Whether an engine supports a scene only if no bar turns its other face to the wind or the Sun."""
    from barchain.runs.declared import OutsideEngine  # noqa: PLC0415
    from barchain.runs.questions import overrides  # noqa: PLC0415

    if scene.effects.drag is None and scene.effects.solar_pressure is None:
        return False
    method = "unsupported_motion"
    return method in engine.asks if issubclass(engine, OutsideEngine) else overrides(engine, method)


def lines(values: Mapping[str, Any], prefix: str = "") -> Iterable[tuple[str, str]]:
    """Labels in plain words with units, and values as text; angles in degrees, absent effects left out."""
    from scenarios.key_words import labelled  # noqa: PLC0415

    for key, value in values.items():
        if isinstance(value, dict):
            engines = prefix + key == "engines"
            yield from ((f"engine {k}", v) for k, v in value.items()) if engines else lines(value, within(prefix, key))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for number, each in enumerate(value, 1):
                yield from lines(each, within(prefix, key if len(value) == 1 else f"{key} {number}"))
        elif value not in (None, [], ""):
            shown = (f"{key.removesuffix('rad')}deg", in_degrees(value)) if is_angle(key) else (key, value)
            yield prefix + labelled(shown[0]), in_words(shown[1])


def is_angle(key: str) -> bool:
    """Whether a key holds angles, which a scene's file gives in degrees; stiffnesses per rad are none."""
    from scenarios.key_words import unit  # noqa: PLC0415

    return unit(key) == "rad"


def in_degrees(value: Any) -> Any:
    """Angle, or list of angles, in degrees: to 12 digits, so that a scene's own number returns."""
    if isinstance(value, list):
        return [in_degrees(v) for v in value]
    return value if value is None else float(f"{math.degrees(value):.12g}")


def within(prefix: str, key: str) -> str:
    """Beginning of the labels of a table; the effects are named by themselves."""
    return "" if key == "effects" else f"{prefix}{key.replace('_', ' ')}: "


def in_words(value: Any) -> str:
    """Text of a value; of a list of equal values the value and their number."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list) and len(value) > 1 and all(v == value[0] for v in value):
        return f"{value[0]} ({len(value)} times)"
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)
