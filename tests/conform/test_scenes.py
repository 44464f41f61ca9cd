"""Scenes of conformance: unequal bars, past a full turn, every effect alone, each with a certified solution."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from barchain.conform.scenes import STAGES, scene_of, solved
from barchain.metrics.quantities import differences
from scenarios import scene_names
from scenarios.effect_types import all_effect_names
from tests.diagnosis.planting import run

SCENES = [name for stage in STAGES for name in stage.scenes]
FOURTH_ORDER_ERROR_RAD = 1e-5
"""Error of the classical Runge-Kutta method with a thousand steps an orbit, 3e-6 rad, with slack"""
PLAIN = {"gravity.none", "gravity.point", "gravity.gradient"}


def test_the_stages_hold_every_scene_of_its_folder_once() -> None:
    assert sorted(SCENES) == sorted(name for name in scene_names() if name.startswith("conform/"))


def test_every_effect_that_an_engine_can_declare_stands_in_a_scene() -> None:
    assert frozenset().union(*(scene_of(name).effects.names for name in SCENES)) == all_effect_names()


def test_each_scene_of_the_last_stage_adds_one_effect() -> None:
    families = [{e.partition(".")[0] for e in scene_of(name).effects.names - PLAIN} for name in STAGES[-1].scenes]
    assert all(len(family) == 1 for family in families)


@pytest.mark.parametrize("name", SCENES)
def test_bars_differ_and_turn_past_a_full_turn_from_a_longitude_of_30_degrees(name: str) -> None:
    scene, motion = scene_of(name), solved(name).trajectory
    for values in (scene.chain.mass_kg, scene.chain.length_m, scene.chain.angle_rad, scene.chain.rate_factor):
        assert len(set(values)) == scene.bars
    assert math.isclose(scene.orbit.longitude_rad, math.radians(30.0))
    assert motion.angle_rad is not None
    turned = np.abs(motion.angle_rad - motion.angle_rad[0]).max()
    assert turned > 2.0 * math.pi


@pytest.mark.parametrize("name", STAGES[-1].scenes)
def test_an_effect_alone_turns_the_bars_by_more_than_the_error_of_most_methods(name: str) -> None:
    """A missing effect must show, whatever the method."""
    with_effect = solved(name).trajectory
    without = dataclasses.replace(scene_of(name), effects=scene_of("conform/three_bars_gradient").effects)
    assert differences(with_effect, run(without, 1e-12))["attitude"].max() > FOURTH_ORDER_ERROR_RAD
