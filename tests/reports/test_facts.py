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
    ("scene", "fact", "value"),
    [
        ("paper/fig05", "Initial angles", "5 × 0° from the chain's local horizontal"),
        ("conform/bar_angles", "Initial angles", "20, 55, -15° from each bar's local horizontal"),
        ("paper/fig05", "Initial rates", "1 times the orbital rate, every bar"),
        ("conform/bar_angles", "Initial rates", "6, 6.6, 5.2 times the orbital rate"),
        ("paper/fig05", "Orbit", "at the local circular speed"),
        ("paper/fig13", "Orbit", "at 1.1 times the local circular speed: eccentricity 0.21"),
        ("effects/impulse", "Effect", "impulse of 5 N s on the right end of bar 4, at 90° from the bar, at 305 s"),
        (
            "effects/thrust_table",
            "Effect",
            "thrust of up to 0.005 N on the left end of bar 1, at 120° from the z1 axis, from 405 to 1105 s",
        ),
    ],
)
def test_the_facts_of_a_scene_have_their_origins_points_directions_and_instants(
    scene: str, fact: str, value: str
) -> None:
    assert value in told(scene)[fact]


def test_an_amplification_beyond_what_is_measured_is_a_bound() -> None:
    assert told("paper/fig09", amplification_total=1.5e19)["Total error amplification"] == ["more than 10¹⁶ times"]
    assert "Orbit" not in told("basics/two_bars_free")
