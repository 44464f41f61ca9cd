"""A scene changed in Python: what its file leaves out follows from the changed values, or the scene is rejected."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from barchain import change_scene, load_scene, make_scene, simulate
from scenarios import SceneError, check_scene, scene_names
from tests.support.slow import one_in

TABLES: dict[str, Any] = {
    "title": "Two bars", "source": "mine", "orbit": {"altitude_m": 5e5},
    "chain": {"bars": 2, "mass_kg": [100.0, 5.0], "length_m": 20.0, "angle_deg": 80.0},
    "effects": {"thrust": [{"bar": 1, "direction_deg": 90.0, "force_N": 0.01}], "oblateness": {}},
    "run": {"orbits": 5.0},
}  # fmt: skip
SCENE = make_scene(TABLES)


@pytest.mark.parametrize(
    ("part", "values"),
    [
        ("orbit", {"speed_factor": 1.3}),
        ("orbit", {"altitude_m": 9e6}),
        ("central_body", {"mu_m3_s2": 4.28e13}),
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


def test_values_replaced_before_are_kept_by_a_later_change() -> None:
    heavy = dataclasses.replace(SCENE, chain=dataclasses.replace(SCENE.chain, rate_factor=(2.0, 3.0)))
    assert change_scene(heavy, {"orbit": {"speed_factor": 1.2}}).chain.rate_factor == (2.0, 3.0)


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
        ({"orbit": {"speed_factor": -1.0}}, "orbit.speed_factor: -1.0 given"),
        ({"orbit": None}, "orbit"),
        ([("orbit", 1)], "given as changes, allowed: a mapping"),
    ],
)
def test_a_wrong_change_is_named_by_its_key(changes: Any, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        change_scene(SCENE, changes)
