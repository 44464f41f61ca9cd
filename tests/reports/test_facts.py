"""A scene's facts in a report tell the physics that a reader needs to run the scene in another program."""

from __future__ import annotations

import pytest

from barchain.record.scene_description import scene_facts
from reports.chapters.comparison.scene import facts
from reports.text.record import SceneRecord
from scenarios import load_scene


def told(name: str, **solution: object) -> dict[str, list[object]]:
    """Values of each fact of a scene; some facts stand there several times."""
    found: dict[str, list[object]] = {}
    for fact, value in facts(SceneRecord(name, scene_facts(load_scene(name)) | solution)):
        found.setdefault(fact, []).append(value)
    return found


@pytest.mark.parametrize(
    ("scene", "angles", "rates"),
    [
        ("paper/fig05", "5 × 0° from the chain's local horizontal", "1 times the orbital rate, every bar"),
        ("conform/bar_angles", "20, 55, -15° from each bar's local horizontal", "6, 6.6, 5.2 times the orbital rate"),
    ],
)
def test_initial_angles_and_rates_are_told_with_their_origin(scene: str, angles: str, rates: str) -> None:
    assert told(scene)["Initial angles"] == [angles]
    assert told(scene)["Initial rates"] == [rates]


@pytest.mark.parametrize(
    ("scene", "orbit"),
    [
        ("paper/fig05", ["at the local circular speed"]),
        ("paper/fig13", ["at 1.1 times the local circular speed: eccentricity 0.21"]),
        ("basics/kepler_elliptic", ["at 1.2 times the local circular speed: eccentricity 0.44"]),
        ("basics/two_bars_free", []),
    ],
)
def test_the_speed_at_the_start_and_the_eccentricity_are_told(scene: str, orbit: list[str]) -> None:
    assert told(scene).get("Orbit", []) == orbit


def test_thrusts_and_impulses_are_told_with_point_direction_and_instants() -> None:
    assert told("effects/impulse")["Effect"][0] == (
        "impulse of 5 N s on the right end of bar 4, at 90° from the bar, at 305 s"
    )
    assert told("effects/thrust_table")["Effect"][1] == (
        "thrust of up to 0.005 N on the left end of bar 1, at 120° from the z1 axis, from 405 to 1105 s"
    )


def test_an_amplification_beyond_what_is_measured_is_a_bound() -> None:
    assert told("paper/fig09", amplification_total=1.5e19)["Total error amplification"] == ["more than 10¹⁶ times"]
    assert told("paper/fig05", amplification_total=5.5e8)["Total error amplification"] == ["5.50×10⁸ times"]
