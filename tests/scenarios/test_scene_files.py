"""Drawn scenes are files that hold each number digit for digit."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from benchmarks.random_campaign.scenes import NEWER_FROM, draw
from scenarios import Gravity, load_scene
from scenarios.effect_types import Frame
from scenarios.toml.writing import UnwrittenError, in_degrees, scene_toml

if TYPE_CHECKING:
    from pathlib import Path


TURNED_DEG = 57.29577951308232


@pytest.mark.parametrize("first", [0, 100, 200, NEWER_FROM])
def test_every_scene_is_read_back_from_its_file_digit_for_digit(first: int, tmp_path: Path) -> None:
    for seed in range(first, first + 100):
        scene = draw(seed)
        path = tmp_path / f"{seed}.toml"
        path.write_text(scene_toml(scene), encoding="utf-8")
        assert load_scene(path).digest == scene.digest


def test_a_scene_is_the_same_for_ever() -> None:
    assert draw(7) == draw(7)
    assert draw(7).digest != draw(8).digest
    assert {draw(seed).effects.gravity for seed in range(100)} == set(Gravity)
    newer = [draw(seed) for seed in range(NEWER_FROM, NEWER_FROM + 40)]
    assert any(scene.chain.com_share for scene in newer)
    assert any(scene.effects.joint_torque for scene in newer)
    assert any(law.frame is Frame.PREVIOUS_BAR for scene in newer for law in scene.effects.prescribed_rotation)


def test_shipped_scenes_can_be_written_too() -> None:
    for name in ("paper/fig17", "effects/everything", "effects/solar_shadow", "basics/libration"):
        assert scene_toml(load_scene(name)).startswith("title")


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
