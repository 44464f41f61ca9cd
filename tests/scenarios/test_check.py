"""Scenes that were made in Python obey the rules of scene files."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from barchain import compare, simulate
from scenarios import SceneError, Thrust, check_scene, load_scene, make_scene, parse_scene
from scenarios.scene import Run
from scenarios.toml.writing import scene_toml

if TYPE_CHECKING:
    from scenarios.scene import Scene

SCENE = load_scene("effects/thrust")


def with_chain(**changes: Any) -> Scene:
    return dataclasses.replace(SCENE, chain=dataclasses.replace(SCENE.chain, **changes))


def with_thrust(**changes: Any) -> Scene:
    first: Thrust = dataclasses.replace(SCENE.effects.thrust[0], **changes)
    return dataclasses.replace(SCENE, effects=dataclasses.replace(SCENE.effects, thrust=(first,)))


def with_moon(rate_rad_s: float) -> Scene:
    scene = load_scene("effects/third_body")
    moon = dataclasses.replace(scene.effects.third_body[0], rate_rad_s=rate_rad_s)
    changed = dataclasses.replace(scene.effects, third_body=(moon,))
    return dataclasses.replace(scene, name=SCENE.name, effects=changed)


WRONG = {
    "chain.mass_kg[1]: -1.0 given, allowed: greater than 0": with_chain(mass_kg=(-1.0, 1.0, 1.0)),
    "chain.length_m: .* given, a list needs one value per bar: 3": with_chain(length_m=(10.0, 10.0)),
    "chain.length_m: 20.0 given, allowed: of type tuple": with_chain(length_m=20.0),
    "chain.mass_kg: array.* given": with_chain(mass_kg=np.ones(3)),
    "chain.angle_deg[2]: nan given, allowed: a finite number": with_chain(angle_rad=(0.0, float("nan"), 0.0)),
    "chain.angle_from: 'Bar' given, allowed: 'chain', 'bar' or 'inertial'": with_chain(angle_from="Bar"),
    "chain.inertia_kg_m2[3]: -1.0 given": with_chain(inertia_kg_m2=(1.0, 1.0, -1.0)),
    "run.samples: 0 given, allowed: at least 2": dataclasses.replace(SCENE, run=Run(100.0, 0)),
    "run.duration_s: -10.0 given, allowed: greater than 0": dataclasses.replace(SCENE, run=Run(-10.0, 11)),
    "effects.thrust[1].bar: 0 given, allowed: at least 1": with_thrust(bar=0),
    "effects.thrust[1].bar: 4 given, allowed: 1 to 3": with_thrust(bar=4),
    "effects.thrust[1].end: 'left' given, allowed: of type End": with_thrust(end="left"),
    "effects.third_body[1].rate_rad_s: nan given, allowed: .*, which follows": with_moon(float("nan")),
    "effects.third_body[1].rate_rad_s: -1e-06 given, allowed: .*, which follows": with_moon(-1e-6),
    "effects.third_body[1].rate_rad_s: True given": with_moon(True),
    "effects.thrust[1].times_s[1]: .* given, allowed: .*, the sample beside it": with_thrust(
        times_s=(SCENE.times_s[1] * (1.0 + 1e-13), SCENE.times_s[5])
    ),
    "of an array with more than one element": dataclasses.replace(
        SCENE, effects=dataclasses.replace(SCENE.effects, thrust=np.array([1.0, 2.0]))  # type: ignore[arg-type]
    ),
    "not of its type": dataclasses.replace(
        SCENE, effects=dataclasses.replace(SCENE.effects, thrust=SCENE.effects.thrust[0])  # type: ignore[arg-type]
    ),
}  # fmt: skip


@pytest.mark.parametrize("message", WRONG)
def test_a_wrong_scene_is_named_by_its_key_and_never_run(message: str) -> None:
    pattern = ".*".join(map(re.escape, message.split(".*")))
    with pytest.raises(SceneError, match=pattern) as told:
        simulate(WRONG[message])
    assert str(told.value).startswith("effects/thrust: ")
    with pytest.raises(SceneError, match=pattern):
        compare([WRONG[message]], ["reference"])


TABLES: dict[str, Any] = {
    "title": "Two bars", "source": "mine", "orbit": {"altitude_m": 5e5},
    "chain": {"bars": 2, "mass_kg": [100.0, 5.0], "length_m": 20.0, "angle_deg": 80.0}, "run": {"orbits": 1.0},
}  # fmt: skip


def test_tables_in_python_make_the_scene_of_the_same_file() -> None:
    text = scene_toml(make_scene(TABLES))
    assert parse_scene(text, name="mine", file="mine.toml").digest == make_scene(TABLES).digest
    assert make_scene(TABLES, "pair").name == "pair"


def test_numbers_and_arrays_of_numpy_in_tables_are_those_of_python() -> None:
    chain = TABLES["chain"] | {"bars": np.int64(2), "mass_kg": np.array([100.0, 5.0]), "length_m": np.float32(20.0)}
    assert make_scene(TABLES | {"chain": chain}) == make_scene(TABLES)


def test_numbers_of_numpy_and_whole_numbers_in_a_scene_leave_its_digest_alone() -> None:
    mass = tuple(np.float64(each) for each in SCENE.chain.mass_kg)
    length = tuple(map(int, SCENE.chain.length_m))
    changed = dataclasses.replace(
        with_chain(mass_kg=mass, length_m=length), run=Run(SCENE.run.duration_s, np.int64(SCENE.run.samples))
    )
    assert length == SCENE.chain.length_m
    assert check_scene(changed).digest == SCENE.digest


@pytest.mark.parametrize(("tables", "message"), [
    (TABLES | {"orbit": {"altitude_km": 500.0}}, r"mine: orbit.altitude_km: unknown key \(did you mean altitude_m\?\)"),
    ({k: v for k, v in TABLES.items() if k != "run"}, "mine: run: missing"),
    ("tether.toml", "'tether.toml' given as a scene's tables, allowed: a mapping"),
])  # fmt: skip
def test_a_fault_of_tables_in_python_is_told_as_that_of_a_file(tables: Any, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        make_scene(tables)
