"""Scenes in Python obey the rules of files: made of tables, changed by keys, replaced field by field, and written."""

import dataclasses
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from barchain import compare, make_scene, simulate
from benchmarks.random_campaign.scenes import NEWER_FROM, draw
from scenarios import SceneError, Thrust, change_scene, check_scene, load_scene, parse_scene, scene_names
from scenarios.scene import Run, Scene
from scenarios.toml.writing import UnwrittenError, in_degrees, scene_toml
from tests.support.slow import one_in

TABLES: dict[str, Any] = {
    "title": "Two bars", "source": "mine", "orbit": {"altitude_m": 5e5},
    "chain": {"bars": 2, "mass_kg": [100.0, 5.0], "length_m": 20.0, "angle_deg": 80.0},
    "effects": {"thrust": [{"bar": 1, "direction_deg": 90.0, "force_N": 0.01}], "oblateness": {}},
    "run": {"orbits": 5.0},
}  # fmt: skip
SCENE = make_scene(TABLES)


# tables


def test_tables_in_python_make_the_scene_of_the_same_file() -> None:
    text = scene_toml(SCENE)
    assert parse_scene(text, name="mine", file="mine.toml").digest == SCENE.digest
    assert make_scene(TABLES, "pair").name == "pair"


def test_numbers_and_arrays_of_numpy_in_tables_are_those_of_python() -> None:
    chain = TABLES["chain"] | {"bars": np.int64(2), "mass_kg": np.array([100.0, 5.0]), "length_m": np.float32(20.0)}
    assert make_scene(TABLES | {"chain": chain}) == SCENE


def test_numbers_of_numpy_and_whole_numbers_in_a_scene_leave_its_digest_alone() -> None:
    mass = tuple(np.float64(each) for each in PUSHED.chain.mass_kg)
    length = tuple(map(int, PUSHED.chain.length_m))
    changed = dataclasses.replace(
        with_chain(mass_kg=mass, length_m=length), run=Run(PUSHED.run.duration_s, np.int64(PUSHED.run.samples))
    )
    assert length == PUSHED.chain.length_m
    assert check_scene(changed).digest == PUSHED.digest


@pytest.mark.parametrize(("tables", "message"), [
    (TABLES | {"orbit": {"altitude_km": 500.0}}, r"mine: orbit.altitude_km: unknown key \(did you mean altitude_m\?\)"),
    ({k: v for k, v in TABLES.items() if k != "run"}, "mine: run: missing"),
    ("tether.toml", "'tether.toml' given as a scene's tables, allowed: a mapping"),
])  # fmt: skip
def test_a_fault_of_tables_in_python_is_told_as_that_of_a_file(tables: Any, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        make_scene(tables)


# changes


@pytest.mark.parametrize(
    ("part", "values"),
    [
        ("orbit", {"speed_factor": 1.3}),
        ("central_body", {"radius_m": 3.4e6}),
    ],
)
def test_a_run_of_five_orbits_has_five_orbits_of_the_changed_scene(part: str, values: dict[str, float]) -> None:
    changed = change_scene(SCENE, {part: values})
    assert changed.run.duration_s / changed.period_s == pytest.approx(5.0)
    assert changed.run.duration_s != pytest.approx(SCENE.run.duration_s)
    assert changed.effects.thrust[0].times_s == (0.0, changed.run.duration_s), "to the end of the run"
    assert changed.effects.oblateness is not None
    assert changed.effects.oblateness.radius_m == changed.central_body.radius_m
    assert check_scene(changed) == changed


def test_slender_bars_stay_slender() -> None:
    changed = change_scene(SCENE, {"chain": {"length_m": [30.0, 10.0]}})
    assert changed.chain.inertia_kg_m2 == pytest.approx((100.0 * 900.0 / 12.0, 5.0 * 100.0 / 12.0))


def test_a_duration_in_seconds_takes_the_place_of_one_in_orbits_and_back() -> None:
    short = change_scene(SCENE, {"run": {"duration_s": 300.0}})
    assert short.run.duration_s == 300.0
    assert change_scene(short, {"orbit": {"speed_factor": 1.3}}).run.duration_s == 300.0
    assert change_scene(short, {"run": {"orbits": 5.0}}) == SCENE


def test_changes_are_those_of_a_file_with_the_same_keys() -> None:
    tables = TABLES | {"orbit": {"altitude_m": 5e5, "speed_factor": 1.2}, "effects": {"oblateness": {}}}
    changed = change_scene(SCENE, {"orbit": {"speed_factor": 1.2}, "effects": {"thrust": None}})
    assert changed == make_scene(tables)
    assert changed.digest == make_scene(tables).digest


@pytest.mark.parametrize(
    ("part", "values", "stale"),
    [
        ("orbit", {"speed_factor": 1.3}, "run.duration_s: .* given, allowed: .*, which follows from the other values"),
        ("chain", {"mass_kg": (10.0, 5.0)}, r"chain.inertia_kg_m2\[1\]: .*, which follows from the other values"),
        ("run", {"duration_s": 300.0}, r"effects.thrust\[1\].times_s\[2\]: .* given, allowed: 300.0, which follows"),
        ("central_body", {"radius_m": 6e6}, "effects.oblateness.radius_m: .*, which follows from the other values"),
    ],
)
def test_a_number_that_no_longer_follows_is_named_and_never_run(part: str, values: dict[str, Any], stale: str) -> None:
    changed = dataclasses.replace(SCENE, **{part: dataclasses.replace(getattr(SCENE, part), **values)})
    with pytest.raises(SceneError, match=stale) as told:
        simulate(changed, "reference")
    assert "change_scene computes it" in str(told.value)


def test_numbers_that_are_all_given_anew_are_taken() -> None:
    orbit = dataclasses.replace(SCENE.orbit, speed_factor=1.3)
    run = dataclasses.replace(SCENE.run, duration_s=SCENE.run.duration_s + 1.0)
    effects = dataclasses.replace(SCENE.effects, thrust=())
    changed = dataclasses.replace(SCENE, orbit=orbit, run=run, effects=effects)
    assert check_scene(changed) == changed


@pytest.mark.parametrize("name", one_in(10, [n for n in scene_names() if not n.startswith("hard/bars_")]))
def test_a_change_to_the_same_value_changes_nothing(name: str) -> None:
    scene = load_scene(name)
    same = change_scene(scene, {"title": scene.title})
    assert same == scene
    assert same.digest == scene.digest


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"orbit": {"speed_facter": 1.2}}, "did you mean speed_factor"),
        ({"orbit": None}, "orbit"),
        ([("orbit", 1)], "given as changes, allowed: a mapping"),
    ],
)
def test_a_wrong_change_is_named_by_its_key(changes: Any, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        change_scene(SCENE, changes)


# fields

PUSHED = load_scene("effects/thrust")


def with_chain(**changes: Any) -> Scene:
    return dataclasses.replace(PUSHED, chain=dataclasses.replace(PUSHED.chain, **changes))


def with_thrust(**changes: Any) -> Scene:
    first: Thrust = dataclasses.replace(PUSHED.effects.thrust[0], **changes)
    return dataclasses.replace(PUSHED, effects=dataclasses.replace(PUSHED.effects, thrust=(first,)))


def with_moon(rate_rad_s: float) -> Scene:
    scene = load_scene("effects/third_body")
    moon = dataclasses.replace(scene.effects.third_body[0], rate_rad_s=rate_rad_s)
    changed = dataclasses.replace(scene.effects, third_body=(moon,))
    return dataclasses.replace(scene, name=PUSHED.name, effects=changed)


WRONG = {
    "chain.mass_kg[1]: -1.0 given, allowed: greater than 0": with_chain(mass_kg=(-1.0, 1.0, 1.0)),
    "chain.length_m: .* given, a list needs one value per bar: 3": with_chain(length_m=(10.0, 10.0)),
    "chain.mass_kg: array.* given": with_chain(mass_kg=np.ones(3)),
    "chain.angle_from: 'Bar' given, allowed: 'chain', 'bar' or 'inertial'": with_chain(angle_from="Bar"),
    "run.samples: 0 given, allowed: at least 2": dataclasses.replace(PUSHED, run=Run(100.0, 0)),
    "effects.thrust[1].bar: 4 given, allowed: 1 to 3": with_thrust(bar=4),
    "effects.thrust[1].end: 'left' given, allowed: of type End": with_thrust(end="left"),
    "effects.third_body[1].rate_rad_s: -1e-06 given, allowed: .*, which follows": with_moon(-1e-6),
    "effects.thrust[1].times_s[1]: .* given, allowed: .*, the sample beside it": with_thrust(
        times_s=(PUSHED.times_s[1] * (1.0 + 1e-13), PUSHED.times_s[5])
    ),
    "of an array with more than one element": dataclasses.replace(
        PUSHED, effects=dataclasses.replace(PUSHED.effects, thrust=np.array([1.0, 2.0]))  # type: ignore[arg-type]
    ),
    "not of its type": dataclasses.replace(
        PUSHED, effects=dataclasses.replace(PUSHED.effects, thrust=PUSHED.effects.thrust[0])  # type: ignore[arg-type]
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


TURNED_DEG = 57.29577951308232


@pytest.mark.parametrize("first", [0, NEWER_FROM])
def test_every_scene_is_read_back_from_its_file_digit_for_digit(first: int, tmp_path: Path) -> None:
    path, rng = tmp_path / "drawn.toml", np.random.default_rng(5)
    for seed in range(first, first + 60):
        scene = dataclasses.replace(draw(seed), name="drawn")
        if seed % 2:
            state = {"position_m": rng.uniform(6e6, 9e6, 2).tolist(), "velocity_m_s": [*rng.uniform(-4e3, 0.0, 1), 6e3]}
            bars = {"angle_from": "inertial", "angle_rad": rng.uniform(-9.0, 9.0, scene.bars).tolist(),
                    "rate_rad_s": rng.uniform(-0.01, 0.01, scene.bars).tolist()}  # fmt: skip
            scene = change_scene(scene, {"orbit": state, "chain": bars, "effects": {"drag": None}})
        scene.to_toml(path)
        assert load_scene(path) == scene


def test_degrees_are_found_where_there_are_such() -> None:
    for deg in np.random.default_rng(1).uniform(-400.0, 400.0, 300).tolist():
        assert math.radians(in_degrees(math.radians(deg))) == math.radians(deg)
    assert in_degrees(1.0) == pytest.approx(TURNED_DEG)
    assert in_degrees(math.radians(30.0)) == 30.0


def test_an_angle_that_no_degrees_give_is_refused() -> None:
    """From 1/4 to 1/2 radians are spaced more closely than the degrees that they are."""
    scene = draw(8)
    angles = [0.39567 + k * 2.0**-54 for k in range(40)]
    without = [a for a in angles if math.radians(in_degrees(a)) != a]
    assert without
    odd = dataclasses.replace(scene, orbit=dataclasses.replace(scene.orbit, longitude_rad=without[0]))
    with pytest.raises(UnwrittenError, match="no number of degrees"):
        scene_toml(odd)
