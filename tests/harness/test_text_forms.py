"""Text forms of scenes, trajectories and comparisons: one short line, whatever their size."""

from __future__ import annotations

import numpy as np
import pandas as pd

import barchain
from barchain.studies.comparison.run import ComparisonResult
from reports.results.comparison import ALL_SCENES
from reports.results.outcome import Outcome

LONGEST = 200  # characters, of a scene with every effect


def trajectory(**more: object) -> barchain.Trajectory:
    n = 501
    arrays = {"com_m": np.zeros((n, 2)), "com_velocity_m_s": np.zeros((n, 2)), "angle_rad": np.zeros((n, 5))}
    return barchain.Trajectory(np.linspace(0.0, 5668.0, n), **(arrays | more))


def test_a_trajectory_tells_run_size_and_span() -> None:
    named = trajectory(scene="paper/fig05", engine="exudyn", setting="steps_per_orbit=2000")
    assert repr(named) == (
        "<Trajectory of paper/fig05 in exudyn, steps_per_orbit=2000: 5 bars, 501 samples from 0 to 5668 s>"
    )


def test_a_trajectory_leaves_out_unknown_things() -> None:
    assert repr(trajectory(angle_rad=None)) == "<Trajectory: 501 samples from 0 to 5668 s>"
    assert repr(trajectory().samples(slice(0, 0))) == "<Trajectory: 5 bars, 0 samples>"


def test_a_trajectory_that_ended_early_says_so() -> None:
    landed = trajectory(ended="a bar reached the surface").samples(slice(0, 1))
    assert repr(landed) == "<Trajectory: 5 bars, 1 sample from 0 to 0 s, ended early>"


def test_a_scene_tells_size_duration_and_effects() -> None:
    assert repr(barchain.load_scene("paper/fig05")) == (
        "<Scene paper/fig05: 5 bars, 27460.6 s (5 orbits), 501 samples; gravity gradient>"
    )


def test_no_shipped_scene_has_a_longer_text() -> None:
    for name in barchain.scenes():
        text = repr(barchain.load_scene(name))
        assert "\n" not in text
        assert len(text) <= LONGEST, text


def test_a_comparison_tells_size_verdict_and_outcomes() -> None:
    outcomes = {
        ("a", "exudyn"): Outcome.PASS,
        ("b", "exudyn"): Outcome.PASS,
        ("b", "rebound"): Outcome.UNSUPPORTED,
        (ALL_SCENES, "exudyn"): Outcome.PASS,
    }
    result = ComparisonResult(pd.DataFrame(), outcomes)
    assert repr(result) == "<ComparisonResult of 2 scenes, 2 engines: passed; 2 pass, 1 unsupported>"


def test_a_comparison_of_nothing_says_so() -> None:
    assert repr(ComparisonResult(pd.DataFrame(), {})) == (
        "<ComparisonResult of 0 scenes, 0 engines: not passed; nothing compared>"
    )
