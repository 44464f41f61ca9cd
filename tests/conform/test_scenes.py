"""Scenes of conformance: unequal bars, past a full turn, every effect alone, each with a certified solution."""

from __future__ import annotations

import math

import numpy as np
import pytest

from barchain.conform.scenes import STAGES, scene_of, solved
from barchain.metrics.quantities import differences
from scenarios import scene_names
from scenarios.effect_types import all_effect_names

SCENES = [name for stage in STAGES for name in stage.scenes]
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
def test_an_effect_alone_moves_the_bars_by_far_more_than_the_solution_s_error(name: str) -> None:
    """A missing effect must show."""
    with_effect, without = solved(name), solved("conform/three_bars_gradient")
    apart = differences(with_effect.trajectory, without.trajectory)
    assert any(float(apart[q].max()) > 1e3 * float(with_effect.error[q].max()) for q in ("attitude", "reaction", "com"))
