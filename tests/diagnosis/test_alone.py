"""A mistake of reading, or a wrong start, alone in a result is named, and no other one."""

import dataclasses

import numpy as np
import pytest

from barchain.judge.diagnosis.diagnose import Diagnosis
from barchain.judge.diagnosis.mistake import Mistake
from barchain.judge.diagnosis.readings import READINGS, TIMINGS
from barchain.judge.diagnosis.starts import STARTS, Start
from scenarios import Scene, load_scene
from tests.diagnosis.planting import RTOL, diagnosis_of_runs, diagnosis_of_scene, planted, unequal_chain
from tests.support.slow import one_in

SCENE = unequal_chain()
FROM_JUMPS = ("angles-from", "angles-and-rates-from", "angles-jump")
JUMPING = tuple(m for m in READINGS if "-wrapped" in m.name and m.name.startswith(FROM_JUMPS))
"""Mistakes that alter something where the longitude jumps alone"""
WITHOUT_TRACE = {"torque-sign", "torques-in-kn-m", "impulses-in-kn-s", "impulses-of-each-interval", "torques-twice",
                 "torques-half", "torques-in-reversed-order", "torques-repeated-at-end", "impulses-of-last-instant",
                 "angles-with-other-turns", "angles-unwrapped", "angles-of-unwrapped-joints",
                 *(m.name for m in READINGS if m.name.endswith("sorted-as-text")),
                 *(m.name for m in JUMPING)}  # fmt: skip
"""Mistakes that alter nothing in this scene: no torques or impulses, few bars, small turns, no jump of the longitude"""
OF_TORQUES = [m for m in (*READINGS, *TIMINGS) if m.name.startswith("torques")]
SAME_START = {
    "central-body-earth",
    "initial-rates-all-positive",
    "radius-equatorial-rounded",
    "mu-km3",
    "mu-g-times-mass",
    "mu-of-g",
    "flight-path-zero",
    "flight-path-opposite",
    "anomaly-zero",
    "mean-anomaly-as-true",
    "true-anomaly-as-mean",
}
"""Starts that are the right one in this scene, or that its gravity shows in the motion, too"""
OF_ANOMALIES = [m for m in STARTS if "anomaly" in m.name or "flight-path" in m.name]


def diagnosis_of(scene: Scene, mistake: Mistake) -> Diagnosis:
    """Diagnosis of a result with a mistake of reading."""
    return diagnosis_of_runs(scene, *(planted(scene, mistake, rtol) for rtol in (RTOL, 0.1 * RTOL)))


ELSEWHERE = [
    *(("effects/impulse", m) for m in READINGS if m.name.startswith("impulses")),
    *(("conform/prescribed_neighbours", m) for m in OF_TORQUES),
    *(("conform/together_5", m) for m in READINGS if "unwrapped" in m.name),  # turns between few samples
    *(("conform/eleven_bars_loads", m) for m in READINGS if m.name.endswith("sorted-as-text")),  # from ten bars on
]


@pytest.mark.parametrize("case", one_in(3, ELSEWHERE, lambda case: case[1].name))
def test_a_mistake_of_reading_is_named_in_a_scene_that_shows_it(case: tuple[str, Mistake]) -> None:
    found = diagnosis_of(load_scene(case[0]), case[1])
    assert (case[1].name,) in found.names, str(found)


@pytest.mark.parametrize("mistake", one_in(6, JUMPING, lambda m: m.name))
def test_a_longitude_that_jumps_is_named_where_it_does(mistake: Mistake) -> None:
    start_rad = np.radians(-30.0 if "positive" in mistake.name else 150.0)
    scene = dataclasses.replace(SCENE, orbit=dataclasses.replace(SCENE.orbit, longitude_rad=float(start_rad)))
    found = diagnosis_of(scene, mistake)
    assert (mistake.name,) in found.names, str(found)


SHOWN = [
    *(m for m in READINGS if m.name not in WITHOUT_TRACE),
    *(m for m in TIMINGS if m not in OF_TORQUES),
]


@pytest.mark.parametrize("mistake", one_in(10, SHOWN, lambda m: m.name))
def test_a_mistake_of_reading_or_late_samples_are_named_alone(mistake: Mistake) -> None:
    found = diagnosis_of(SCENE, mistake)
    assert found.names == {(mistake.name,)}, str(found)


@pytest.mark.parametrize("mistake", one_in(11, [m for m in STARTS if m.name not in SAME_START], lambda m: m.name))
def test_a_wrong_start_is_named_alone(mistake: Start) -> None:
    found = diagnosis_of_scene(SCENE, mistake.change)
    assert (mistake.name,) in found.names, str(found)
    assert len(found.names) <= 2, str(found)


@pytest.mark.parametrize("mistake", one_in(3, OF_ANOMALIES, lambda m: m.name))
def test_another_place_on_the_orbit_is_named_where_the_start_is_no_apsis(mistake: Start) -> None:
    found = diagnosis_of_scene(load_scene("conform/mid_orbit"), mistake.change)
    assert (mistake.name,) in found.names, str(found)


@pytest.mark.parametrize("name", one_in(4, sorted(WITHOUT_TRACE)))
def test_a_mistake_that_alters_nothing_is_not_named(name: str) -> None:
    mistake = next(m for m in READINGS if m.name == name)
    if planted(SCENE, mistake, RTOL) is not None:
        found = diagnosis_of(SCENE, mistake)
        assert found.inside_tolerances
        assert not found.names
