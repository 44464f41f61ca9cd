"""The start in each of its forms: orbits, states, angles of bars, and places of bars that disagree with them."""

import dataclasses
import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from scenarios import Scene, SceneError, change_scene, check_scene, load_scene, make_scene, scene_names
from scenarios.load import parse_scene

EPS = float(np.finfo(float).eps)
MU, RADIUS_M = 3.986004418e14, 6378e3
AXIS_M, ECCENTRICITY = 1e7, 0.3
SIZES = {
    "semi_major_axis_m": AXIS_M,
    "eccentricity": ECCENTRICITY,
    "periapsis_altitude_m": AXIS_M * (1.0 - ECCENTRICITY) - RADIUS_M,
    "apoapsis_altitude_m": AXIS_M * (1.0 + ECCENTRICITY) - RADIUS_M,
}


def scene_at(orbit: dict[str, Any], **chain: Any) -> Scene:
    """Two bars that start on an orbit."""
    bars = {"bars": 2, "mass_kg": 1.0, "length_m": 10.0} | chain
    return make_scene({"title": "t", "source": "s", "orbit": orbit, "chain": bars, "run": {"duration_s": 10.0}})


@pytest.mark.parametrize("pair", list(itertools.combinations(SIZES, 2)), ids=" and ".join)
def test_any_two_sizes_give_the_orbit_that_has_them_all(pair: tuple[str, str]) -> None:
    shape = {key: SIZES[key] for key in pair}
    scene = scene_at(shape | {"true_anomaly_deg": 100.0, "argument_of_periapsis_deg": 40.0})
    assert scene.orbit.eccentricity == pytest.approx(ECCENTRICITY, rel=1e-14)
    assert math.degrees(scene.orbit.true_anomaly_rad) == pytest.approx(100.0, rel=1e-14)
    assert scene.lowest_radius_m == pytest.approx(AXIS_M * (1.0 - ECCENTRICITY), rel=1e-14)
    assert scene.highest_radius_m == pytest.approx(AXIS_M * (1.0 + ECCENTRICITY), rel=1e-14)
    assert scene.period_s == pytest.approx(2.0 * math.pi * math.sqrt(AXIS_M**3 / MU), rel=1e-14)
    assert math.degrees(scene.orbit.longitude_rad) == pytest.approx(140.0)


@pytest.mark.parametrize("mean_deg", [0.0, 1.0, 180.0, -400.0])
@pytest.mark.parametrize("eccentricity", [0.0, 1e-9, 0.3, 0.99])
def test_a_mean_anomaly_obeys_keplers_equation(eccentricity: float, mean_deg: float) -> None:
    shape = {"periapsis_altitude_m": 500e3, "eccentricity": eccentricity}
    orbit = scene_at(shape | {"mean_anomaly_deg": mean_deg}).orbit
    if eccentricity:
        off = math.remainder(orbit.mean_anomaly_rad - math.radians(mean_deg), 2.0 * math.pi)
        # the start holds an altitude to eps, and e is what differs between two numbers near 1
        assert abs(off) <= 40.0 * EPS * max(1.0 / eccentricity, (1.0 - eccentricity) ** -1.5)
    else:
        assert math.remainder(orbit.longitude_rad - math.radians(mean_deg), 2.0 * math.pi) == pytest.approx(
            0.0, abs=4 * EPS
        )


def test_a_state_is_the_start_to_rounding() -> None:
    rng = np.random.default_rng(3)
    for _ in range(300):
        place, velocity = rng.uniform(-9e6, 9e6, 2), rng.uniform(-9e3, 9e3, 2)
        if place[0] * velocity[1] < place[1] * velocity[0]:
            velocity *= -1.0
        if math.hypot(*place) < 6.5e6:
            continue
        angle, rate = rng.uniform(-20.0, 20.0, 2), rng.uniform(-0.1, 0.1, 2)
        scene = scene_at(
            {"position_m": place.tolist(), "velocity_m_s": velocity.tolist()},
            angle_from="inertial", angle_rad=angle.tolist(), rate_rad_s=rate.tolist(),
        )  # fmt: skip
        state = initial_state(scene)
        assert np.abs(state.com_m - place).max() <= 8.0 * EPS * np.hypot(*place)
        assert np.abs(state.com_velocity_m_s - velocity).max() <= 8.0 * EPS * np.hypot(*velocity)
        assert np.abs(state.angle_rad - angle).max() <= 4.0 * EPS * 24.0
        np.testing.assert_allclose(state.rate_rad_s, rate, rtol=4.0 * EPS, atol=0.0)


def test_degrees_and_radians_are_the_same_start() -> None:
    orbit = {"altitude_m": 500e3, "flight_path_deg": 20.0}
    assert scene_at(orbit, angle_deg=[30.0, 40.0]) == scene_at(
        orbit, angle_rad=[math.radians(30.0), math.radians(40.0)]
    )
    assert scene_at(orbit, rate_deg_s=2.0).chain == scene_at(orbit, rate_rad_s=math.radians(2.0)).chain


FAULTS = [
    ({}, "no start of the centre of mass"),
    ({"altitude_m": 5e5, "eccentricity": 0.1}, "altitude_m and eccentricity are of different forms"),
    ({"position_m": [7e6, 0.0]}, "position_m alone is given"),
    ({"eccentricity": 0.1}, "exactly two of"),
    ({**SIZES}, "exactly two of"),
    ({"semi_major_axis_m": 1e7, "eccentricity": 1.2}, "from 1 with periapsis_altitude_m"),
    ({"periapsis_altitude_m": 5e5, "eccentricity": 1.2, "true_anomaly_deg": 170.0}, "within 146.443 degrees"),
    ({"periapsis_altitude_m": 5e5, "eccentricity": 1.2, "mean_anomaly_deg": 10.0}, "allowed: true_anomaly_deg"),
    ({"eccentricity": 0.1, "semi_major_axis_m": 1e7, "true_anomaly_deg": 1.0, "mean_anomaly_deg": 1.0}, "one of them"),
    ({"apoapsis_altitude_m": 5e5, "periapsis_altitude_m": 6e5}, "at most that of the apoapsis"),
    ({"position_m": [7e6, 0.0], "velocity_m_s": [0.0, -7e3]}, "clockwise"),
    ({"position_m": [6e6, 0.0], "velocity_m_s": [0.0, 7e3]}, "378000 m below the surface"),
    ({"position_m": [0.0, 0.0], "velocity_m_s": [0.0, 7e3]}, "centre of the body"),
    ({"altitude_m": 5e5, "radial_velocity_m_s": 3.0}, "flight_path_deg is the angle of the velocity"),
]  # fmt: skip


@pytest.mark.parametrize(("orbit", "words"), FAULTS, ids=lambda value: value if isinstance(value, str) else "")
def test_a_start_that_contradicts_itself_or_lacks_something_is_one_line(orbit: dict[str, Any], words: str) -> None:
    with pytest.raises(SceneError) as error:
        scene_at(orbit)
    assert words in str(error.value)
    assert str(error.value).startswith("mine: orbit")
    assert "\n" not in str(error.value)


def test_angles_and_rates_are_given_once() -> None:
    for chain in ({"rate_factor": 1.0, "rate_rad_s": 0.1}, {"angle_deg": 1.0, "angle_rad": 1.0}):
        with pytest.raises(SceneError, match=r"^mine: chain: \w+ and \w+ are given, allowed: one of"):
            scene_at({"altitude_m": 5e5}, **chain)


def test_absolute_rates_of_a_chain_at_rest_are_refused_and_zeros_are_not() -> None:
    rest = {"altitude_m": 5e5, "speed_factor": 0.0}
    assert scene_at(rest, rate_rad_s=0.0).chain.rate_factor == (0.0, 0.0)
    with pytest.raises(SceneError, match="allowed: with a horizontal velocity"):
        scene_at(rest, rate_rad_s=0.1)


def test_a_change_to_another_form_replaces_the_first() -> None:
    elements = scene_at({"semi_major_axis_m": 1e7, "eccentricity": 0.3, "true_anomaly_deg": 100.0})
    assert change_scene(elements, {"orbit": {"mean_anomaly_deg": 0.0}}).orbit.flight_path_rad == 0.0
    assert change_scene(elements, {"orbit": {"altitude_m": 5e5}}).orbit == scene_at({"altitude_m": 5e5}).orbit
    moved = dataclasses.replace(elements, orbit=dataclasses.replace(elements.orbit, longitude_rad=1.0))
    assert check_scene(moved).orbit.longitude_rad == 1.0
    assert change_scene(moved, {"chain": {"angle_deg": 5.0}}).orbit.eccentricity == pytest.approx(0.3)


@pytest.mark.parametrize("name", scene_names())
def test_a_shipped_scene_that_is_written_and_read_again_is_equal(name: str, tmp_path: Path) -> None:
    scene = load_scene(name)
    path = tmp_path / f"{name.rpartition('/')[2]}.toml"
    scene.to_toml(path)
    assert load_scene(path) == dataclasses.replace(scene, name=path.stem)


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


@pytest.mark.parametrize("gap", [0.0, 5e-10])
def test_a_gap_of_rounding_is_taken_as_closed(gap: float) -> None:
    assert started(gap).description == ""


def test_a_small_gap_is_closed_by_the_angles_and_told() -> None:
    assert "the angles decide the places" in started(9e-7).description
    assert "9e-07" in started(9e-7).description


@pytest.mark.parametrize("gap", [1e-5, 0.5])
def test_a_large_gap_is_rejected_in_one_line(gap: float) -> None:
    with pytest.raises(SceneError, match=rf"joint 1.*{gap:.3g}") as told:
        started(gap)
    assert "\n" not in str(told.value)


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
