"""From a scene to its TOML file, digit for digit."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import TYPE_CHECKING, Any

from scenarios.effect_types import Course
from scenarios.toml.file import SceneFile
from scenarios.toml.reading import tables_of
from scenarios.toml.resolve import ANGLES, resolve
from scenarios.toml.scene_tables import MATERIAL_KEYS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenarios.effect_types import PrescribedRotation
    from scenarios.scene import Chain, Orbit, Scene

    Data = dict[str, Any]

TABLES = ("third_body", "joint_torque", "thrust", "impulse")
"""Effects of which there may be several"""
BODY = ("mass_kg", "inertia_kg_m2", "joint_m")
DERIVED = {"third_body": ("rate_rad_s",)}
"""Fields that follow from the others, and that a file does not hold"""
RENAMED = {"third_body": {"name": "body"}}
NEIGHBOURS = 3  # units in the last place: a degree that is a given number of radians is as near, if there is one


class UnwrittenError(ValueError):
    """A scene that no file gives back digit for digit."""


def in_degrees(rad: float) -> float:
    """Degrees that are an angle in radians to the last digit, the shortest where there are such; else the nearest."""
    found = math.degrees(rad)
    near = [found]
    for end in (-math.inf, math.inf):
        one = found
        for _ in range(NEIGHBOURS):
            one = math.nextafter(one, end)
            near.append(one)
    return min(near, key=lambda deg: (abs(math.radians(deg) - rad), len(repr(deg)), abs(deg - found)))


def scene_data(scene: Scene) -> Data:
    """Tables of a scene's file, as `tomllib` reads them."""
    effects = {
        name: [table(one, name) for one in value] if name in TABLES else table(value, name)
        for name, value in vars(scene.effects).items()
        if name not in ("gravity", "prescribed_rotation") and value
    }
    laws = [each for law in scene.effects.prescribed_rotation for each in turn_tables(law)]
    effects |= {"prescribed_rotation": laws} if laws else {}
    return {
        "title": scene.title,
        "source": scene.source,
        "description": scene.description,
        "tags": list(scene.tags),
        "central_body": table(scene.central_body),
        "orbit": orbit_table(scene.orbit),
        "chain": {"bars": scene.bars} | chain_table(scene.chain),
        "effects": {"gravity": str(scene.effects.gravity)} | effects,
        "run": table(scene.run),
    }


def turn_tables(law: PrescribedRotation) -> Iterator[Data]:
    """Tables of the turns of a law; the paper's course is the default, and pieces of one spline are one table."""
    points: list[tuple[float, float]] = []
    for turn in law.turns:
        found = table(dataclasses.replace(law, **vars(turn), further=()))
        del found["further"], found["rates_rad_s"], found["accelerations_rad_s2"]
        if turn.course is Course.PAPER:
            del found["course"]
        if turn.course is Course.SPLINE:
            points = points or [(turn.start_s, 0.0)]
            points.append((turn.end_s, points[-1][1] + found["amplitude_deg"]))
            if turn.rates_rad_s[1] != 0.0:  # it goes on
                continue
            for key in ("amplitude_deg", "duration_s", "start_s", "course"):
                del found[key]
            found |= {"times_s": [t for t, _ in points], "angle_deg": [angle for _, angle in points]}
            points = []
        yield found


def orbit_table(orbit: Orbit) -> Data:
    """Table of the start of the centre of mass; a horizontal velocity is the default."""
    found = table(orbit)
    if not orbit.flight_path_rad:
        del found["flight_path_deg"]
    return found


def chain_table(chain: Chain) -> Data:
    """Table of the bars and end bodies; angles that are no numbers of degrees are in radians."""
    found = table(chain)
    if not chain.com_share:
        del found["com_share"]
    bodies = [{"at": end} for end in found.pop("end_bodies")]
    for body, bar in zip(bodies, chain.bodies, strict=True):
        length = chain.length_m[bar - 1]
        body |= dict(zip(BODY, (chain.mass_kg[bar - 1], chain.inertia_kg_m2[bar - 1], 0.5 * length), strict=True))
    for key in set(MATERIAL_KEYS) & set(found) if bodies else ():
        found[key] = [value for bar, value in enumerate(found[key], 1) if bar not in chain.bodies]
    found |= {"end_body": bodies} if bodies else {}
    if any(
        math.radians(deg) != rad and not math.isnan(rad)
        for deg, rad in zip(found["angle_deg"], chain.angle_rad, strict=True)
    ):
        del found["angle_deg"]
        found["angle_rad"] = list(chain.angle_rad)
    return found


def table(part: Any, effect: str = "") -> Data:
    """Table of one part of a scene."""
    found: Data = {}
    for name, value in vars(part).items():
        if name in DERIVED.get(effect, ()):
            continue
        key = RENAMED.get(effect, {}).get(name, name)
        found[key.removesuffix("_rad") + "_deg" if name in ANGLES else key] = plain(value, degrees=name in ANGLES)
    return found


def plain(value: Any, *, degrees: bool) -> Any:
    """Value as TOML has it."""
    if isinstance(value, tuple):
        return [plain(one, degrees=degrees) for one in value]
    if degrees and isinstance(value, float | int):
        return in_degrees(value)
    return str(value) if isinstance(value, str) else value


def toml(data: Data, path: str = "") -> Iterator[str]:
    """Lines of a file: values first, then tables."""
    for key, value in data.items():
        if not is_table(value):
            yield f"{key} = {written(value)}"
    for key, value in data.items():
        if isinstance(value, dict):
            yield f"\n[{path}{key}]"
            yield from toml(value, f"{path}{key}.")
        elif is_table(value):
            for one in value:
                yield f"\n[[{path}{key}]]"
                yield from toml(one, f"{path}{key}.")


def is_table(value: Any) -> bool:
    """Whether a value is a table, or a list of them."""
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def written(value: Any) -> str:
    """One value; Python's shortest digits of a float are read back as the same one."""
    if isinstance(value, list):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool):
        return str(value).lower()
    return repr(float(value)) if isinstance(value, float) else repr(value)


def scene_toml(scene: Scene) -> str:
    """Text of a file that `barchain compare` takes.

    Raises
    ------
    UnwrittenError
        If it is not read back as the same scene.
    """
    text = "\n".join(toml(scene_data(scene))) + "\n"
    if resolve(SceneFile.model_validate(tables_of(text)), scene.name).digest != scene.digest:
        raise UnwrittenError(f"{scene.name}: an angle that is no number of degrees, or an instant beside a sample")
    return text
