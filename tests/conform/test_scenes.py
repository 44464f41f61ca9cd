"""Scenes of conformance: unequal bars, past a full turn, every effect alone, each with a certified solution."""

from __future__ import annotations

import copy
import dataclasses
import itertools
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from barchain.conform.target import STAGES, scene_of, solved
from barchain.metrics.quantities import differences
from pictures.pages.scene_keys import HEAD, key_tables
from scenarios import Actuator, Axes, End, Frame, SceneFile, scene_names
from scenarios.effect_types import all_effect_names
from scenarios.toml.resolve import resolve
from tests.diagnosis.planting import run
from tests.support.slow import one_in

SCENARIOS = Path(__file__).parents[2] / "scenarios"
SCENES = [name for scenes in STAGES.values() for name in scenes]
FOURTH_ORDER_ERROR_RAD = 1e-5
"""Error of the classical Runge-Kutta method with a thousand steps an orbit, 3e-6 rad, with slack"""
PLAIN = {"gravity.none", "gravity.point", "gravity.gradient"}
NO_PHYSICS = {"title", "source", "description", "tags", "orbits", "samples"}
OTHER_WAY = {"centre_m"}
"""Keys that give numbers of other keys in another way: an engine sees no difference"""
WITH_ANOTHER = {"times_s"}
"""Keys that may be left out with another one only"""


def scene_file(name: str) -> dict[str, Any]:
    """Content of a scene's file."""
    return tomllib.loads((SCENARIOS / f"{name}.toml").read_text(encoding="utf-8"))


def entries(data: dict[str, Any], table: str) -> list[dict[str, Any]]:
    """Tables of a name in a scene's file."""
    found: list[dict[str, Any]] = [data]
    for part in filter(None, table.strip("`[]").split(".") if table != "Top level" else []):
        inner = [each[part] for each in found if part in each]
        found = [entry for each in inner for entry in (each if isinstance(each, list) else [each])]
    return found


def as_in_the_reference(value: object) -> str:
    """Value of a key as the reference page writes a default."""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f'`"{value}"`' if isinstance(value, str) else f"{value:.12g}" if isinstance(value, float) else str(value)


def keys_of_scenes() -> list[tuple[str, str, str]]:
    """Table, key and default of each key that is physics."""
    return [
        (table, key, row[HEAD.index("default")])
        for table, _, rows in key_tables()
        for row in rows
        if (key := row[0].strip("`")) not in NO_PHYSICS | OTHER_WAY
    ]


def test_the_stages_hold_every_scene_of_its_folder_once() -> None:
    assert sorted(SCENES) == sorted(name for name in scene_names() if name.startswith("conform/"))


def test_every_effect_that_an_engine_can_declare_stands_in_a_scene() -> None:
    assert frozenset().union(*(scene_of(name).effects.names for name in SCENES)) == all_effect_names()


@pytest.mark.parametrize(("table", "key", "default"), keys_of_scenes(), ids=lambda value: str(value).strip("`"))
def test_every_key_has_another_value_than_its_default_in_some_scene(table: str, key: str, default: str) -> None:
    """An engine that ignores a key must fail somewhere."""
    values = [entry[key] for name in SCENES for entry in entries(scene_file(name), table) if key in entry]
    assert values
    assert {as_in_the_reference(value) for value in values} - {default}


@pytest.mark.parametrize("effect", ["thrust", "impulse"])
def test_thrusts_and_impulses_act_at_both_ends_in_both_axes(effect: str) -> None:
    pushes = [push for name in SCENES for push in getattr(scene_of(name).effects, effect)]
    assert {(push.end, push.axes) for push in pushes} == set(itertools.product(End, Axes))


def test_prescribed_rotations_have_both_frames_with_both_actuators() -> None:
    laws = [law for name in SCENES for law in scene_of(name).effects.prescribed_rotation]
    assert {(law.frame, law.actuator) for law in laws} == set(itertools.product(Frame, Actuator))


def test_some_bars_turn_clockwise_and_some_chain_has_five_bars() -> None:
    assert min(min(scene_of(name).chain.rate_factor) for name in SCENES) < 0.0
    assert max(scene_of(name).bars for name in SCENES) == 5


def test_some_scene_lasts_more_than_an_orbit_with_both_signs_of_the_radial_velocity() -> None:
    scene, motion = scene_of("conform/one_bar_eccentric"), solved("conform/one_bar_eccentric").trajectory
    radius = np.linalg.norm(motion.com_m, axis=1)
    assert np.argmax(radius) not in (0, len(radius) - 1)  # apogee
    assert np.argmin(radius[len(radius) // 2 :]) not in (0, len(radius) // 2)  # and perigee again
    assert scene.run.duration_s > 2.0 * 1200.0


def test_each_scene_of_the_last_stage_adds_one_effect() -> None:
    families = [
        {e.partition(".")[0] for e in scene_of(name).effects.names - PLAIN} for name in STAGES["with one effect"]
    ]
    assert all(len(family) == 1 for family in families)


@pytest.mark.parametrize("name", one_in(5, SCENES))
def test_bars_differ_and_turn_past_a_full_turn_from_a_longitude_of_30_degrees(name: str) -> None:
    scene, motion = scene_of(name), solved(name).trajectory
    for values in (scene.chain.mass_kg, scene.chain.length_m, scene.chain.angle_rad, scene.chain.rate_factor):
        assert len(set(values)) == scene.bars
    assert math.isclose(scene.orbit.longitude_rad, math.radians(30.0))
    assert motion.angle_rad is not None
    turned = np.abs(motion.angle_rad - motion.angle_rad[0]).max()
    assert turned > 2.0 * math.pi


@pytest.mark.parametrize("name", STAGES["with one effect"])
def test_an_effect_alone_turns_the_bars_by_more_than_the_error_of_most_methods(name: str) -> None:
    """A missing effect must show, whatever the method."""
    with_effect = solved(name).trajectory
    without = dataclasses.replace(scene_of(name), effects=scene_of("conform/three_bars_gradient").effects)
    assert differences(with_effect, run(without, 1e-12))["attitude"].max() > FOURTH_ORDER_ERROR_RAD


def keys_with_default() -> list[tuple[str, str]]:
    """Table and name of each key that is physics and may be left out alone."""
    keys = ((table, key) for table, key, default in keys_of_scenes() if not default.startswith("required"))
    return [(table, key) for table, key in keys if key not in WITH_ANOTHER]


def without_key(data: dict[str, Any], table: str, key: str) -> dict[str, Any]:
    """Content of a scene's file without a key, so that its default holds."""
    altered = copy.deepcopy(data)
    for entry in entries(altered, table):
        entry.pop(key, None)
    return altered


@pytest.mark.parametrize(("table", "key"), keys_with_default(), ids=str)
def test_an_engine_that_ignores_a_key_is_off_by_more_than_the_error_of_most_methods(table: str, key: str) -> None:
    """Some scene shows the default in the place of the given value."""
    shown = []
    for name in (name for name in SCENES if any(key in entry for entry in entries(scene_file(name), table))):
        altered = resolve(SceneFile.model_validate(without_key(scene_file(name), table, key)), name)
        if altered.bars == scene_of(name).bars:
            run_of = dataclasses.replace(altered, run=scene_of(name).run)
            shown.append(differences(solved(name).trajectory, run(run_of, 1e-12))["attitude"].max())
    assert max(shown) > FOURTH_ORDER_ERROR_RAD
