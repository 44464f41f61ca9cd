"""Starts whose places and angles of bars disagree: accepted, corrected or rejected by the size of the gap."""

import numpy as np
import pytest

from scenarios.load import SceneError, parse_scene

TEXT = """
title = "two bars"
source = "made here"
[orbit]
altitude_m = 350e3
[chain]
bars = 2
mass_kg = 100.0
length_m = [10.0, 20.0]
angle_deg = [90.0, 0.0]
centre_m = [[0.0, 0.0], [10.0, {height!r}]]
[run]
orbits = 1.0
"""


def started(gap: float):
    """The scene with its joint open by that share of the shorter bar."""
    return parse_scene(TEXT.format(height=5.0 + 10.0 * gap), name="two", file="two.toml")


@pytest.mark.parametrize("gap", [0.0, 1e-12, 5e-10])
def test_a_gap_of_rounding_is_taken_as_closed(gap: float) -> None:
    assert started(gap).description == ""


@pytest.mark.parametrize("gap", [1e-8, 9e-7])
def test_a_small_gap_is_closed_by_the_angles_and_told(gap: float) -> None:
    assert "the angles decide the places" in started(gap).description
    assert f"{gap:.2g}" in started(gap).description


@pytest.mark.parametrize("gap", [1e-5, 1e-3, 0.5])
def test_a_large_gap_is_rejected_in_one_line(gap: float) -> None:
    with pytest.raises(SceneError) as told:
        started(gap)
    assert "\n" not in str(told.value)
    assert "joint 1" in str(told.value)
    assert f"{gap:.3g}" in str(told.value)


def test_places_change_nothing_of_the_physics() -> None:
    bare = parse_scene("\n".join(r for r in TEXT.split("\n") if "centre_m" not in r), name="two", file="two.toml")
    assert {started(gap).digest for gap in (0.0, 1e-12, 1e-8)} == {bare.digest}
    assert np.array_equal(started(1e-8).chain.angle_rad, bare.chain.angle_rad)


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("[[0.0, 0.0], [10.0, {height!r}]]", "[[0.0, 0.0]]", "one for each of 2"),
        ("angle_deg = [90.0, 0.0]", 'angle_deg = [90.0, 0.0]\nangle_from = "bar"', "same axes"),
    ],
)
def test_places_that_can_not_be_compared_are_rejected(old: str, new: str, word: str) -> None:
    with pytest.raises(SceneError, match=word):
        parse_scene(TEXT.replace(old, new).replace("{height!r}", "5.0"), name="two", file="two.toml")
