"""Text forms of scenes, trajectories and comparisons: one short line, whatever their size."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import barchain
from barchain.studies.comparison.run import ComparisonResult
from reports.results.comparison import ALL_SCENES
from reports.results.outcome import Outcome

LONGEST = 200  # characters, of a scene with every effect


def trajectory(**more: object) -> barchain.Trajectory:
    n = 501
    arrays = {"com_m": np.zeros((n, 2)), "com_velocity_m_s": np.zeros((n, 2)), "angle_rad": np.zeros((n, 5))}
    return barchain.Trajectory(np.linspace(0.0, 5668.0, n), **(arrays | more))


NAMED = trajectory(scene="paper/fig05", engine="exudyn", setting="steps_per_orbit=2000")
LANDED = trajectory(angle_rad=None, ended="a bar reached the surface").samples(slice(0, 1))
OUTCOMES = {
    ("a", "exudyn"): Outcome.PASS,
    ("b", "rebound"): Outcome.UNSUPPORTED,
    (ALL_SCENES, "exudyn"): Outcome.PASS,
}


@pytest.mark.parametrize(
    ("shown", "text"),
    [
        (NAMED, "<Trajectory of paper/fig05 in exudyn, steps_per_orbit=2000: 5 bars, 501 samples from 0 to 5668 s>"),
        (LANDED, "<Trajectory: 1 sample from 0 to 0 s, ended early>"),
        (trajectory().samples(slice(0, 0)), "<Trajectory: 5 bars, 0 samples>"),
        (
            ComparisonResult(pd.DataFrame(), OUTCOMES),
            "<ComparisonResult of 2 scenes, 2 engines: passed; 1 pass, 1 unsupported>",
        ),
    ],
)
def test_the_text_tells_what_was_run_its_size_and_its_end(shown: object, text: str) -> None:
    assert repr(shown) == text


def test_no_shipped_scene_has_a_longer_text() -> None:
    for name in barchain.scenes():
        scene = barchain.load_scene(name)
        text = repr(scene)
        assert text.startswith(f"<Scene {name}: {scene.bars} bar")
        assert "\n" not in text
        assert len(text) <= LONGEST, text
