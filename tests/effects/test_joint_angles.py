"""Laws of joints' angles: motors inside the chain."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from adapters.common.reference_model import chain_model
from barchain.metrics.derived import Motion, columns_of
from reference_impl.model import invariants
from scenarios import Gravity, Scene, SceneError, load_scene
from scenarios.load import parse_scene
from tests.effects.joint_runs import forms, moved

FORMS = forms("reference", "reference-fast", "heyoka")


def arm(bars: int, *, gravity: Gravity = Gravity.NONE, rate: float = 0.0) -> Scene:
    """The shipped arm with its first bars, and its laws of these."""
    scene = load_scene("effects/joint_slew")
    c = scene.chain
    chain = dataclasses.replace(
        c,
        mass_kg=c.mass_kg[:bars],
        length_m=c.length_m[:bars],
        inertia_kg_m2=c.inertia_kg_m2[:bars],
        angle_rad=c.angle_rad[:bars],
        rate_factor=(rate,) * bars,
    )
    laws = tuple(law for law in scene.effects.prescribed_rotation if law.bar <= bars)
    effects = dataclasses.replace(scene.effects, gravity=gravity, prescribed_rotation=laws)
    return dataclasses.replace(scene, name="mine", chain=chain, effects=effects)


@pytest.mark.parametrize("engine", FORMS)
def test_the_base_of_an_arm_turns_back_by_the_arms_momentum(engine: str) -> None:
    """Two bars at rest without forces: the base turns by an integral over the joint's angle, whatever the law in time.

    No angular momentum about the centre of mass: theta_1' D = -delta' (J_2 + m (h_2^2 + h_1 h_2 cos delta)) with
    D = J_1 + J_2 + m (h_1^2 + h_2^2 + 2 h_1 h_2 cos delta), m the reduced mass and h half lengths. A hundred steps
    of 1e-13 each, and quad's 1e-12.
    """
    scene = arm(2)
    seen, c = moved(scene, engine), scene.chain
    (m1, m2), (h1, h2), (j1, j2) = c.mass_kg, np.array(c.length_m) / 2.0, c.inertia_kg_m2
    m, bent = m1 * m2 / (m1 + m2), c.angle_rad[1] - c.angle_rad[0]

    def turned(angle: float) -> float:
        far = j2 + m * (h2**2 + h1 * h2 * math.cos(angle))
        return -far / (far + j1 + m * (h1**2 + h1 * h2 * math.cos(angle)))

    expected = quad(turned, bent, bent + math.pi / 2.0, epsabs=1e-13, epsrel=1e-13)[0]
    assert seen.angle_rad[-1, 0] - seen.angle_rad[0, 0] == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("engine", FORMS)
def test_joints_follow_their_laws_and_a_locked_one_keeps_its_angle(engine: str) -> None:
    scene = arm(4, gravity=Gravity.GRADIENT, rate=1.0)
    seen = moved(scene, engine)
    for law in scene.effects.prescribed_rotation:
        bent = seen.angle_rad[:, law.bar - 1] - seen.angle_rad[:, law.bar - 2]
        wanted = bent[0] + np.array([law.law(t)[0] for t in seen.t_s.tolist()])
        np.testing.assert_allclose(bent, wanted, atol=1e-9)


@pytest.mark.parametrize("engine", FORMS)
def test_motors_give_the_chain_the_energy_of_their_power(engine: str) -> None:
    """No forces: kinetic energy about the centre of mass is the integral of torque times the joint's rate.

    Simpson's rule on samples of 2 s over a law of 120 s: its error is below (2 pi 3/120 2)^4/180 of the work.
    """
    scene = arm(4)
    seen, model = moved(scene, engine), chain_model(scene)
    energy = invariants.relative_kinetic_energy(model, seen.angle_rad, seen.rate_rad_s)
    power = sum(columns_of(Motion(seen), "torque_power").values())
    middle = len(seen.t_s) // 2 // 2 * 2  # inside the law, where the arm moves
    step = seen.t_s[1]
    work = step / 3.0 * (power[0] + 4.0 * power[1:middle:2].sum() + 2.0 * power[2:middle:2].sum() + power[middle])
    assert energy[middle] > 1e-3
    assert energy[middle] - energy[0] == pytest.approx(work, abs=1e-4 * energy.max())
    assert np.abs(invariants.relative_angular_momentum(model, seen.angle_rad, seen.rate_rad_s)).max() < 1e-9


TURNED_TWICE = """
title = "Two bars, the second turned twice"
source = "test"
[orbit]
altitude_m = 500e3
[chain]
bars = 2
mass_kg = [500.0, 20.0]
length_m = [2.0, 1.5]
angle_deg = [90.0, 20.0]
rate_factor = 0.0
[effects]
gravity = "none"
[[effects.prescribed_rotation]]
bar = 2
amplitude_deg = {first}
duration_s = 60.0
start_s = 90.0
frame = "previous_bar"
course = "{course}"
[[effects.prescribed_rotation]]
bar = 2
amplitude_deg = 40.0
duration_s = 50.0
start_s = {start}
frame = "{frame}"
course = "quintic"
[run]
duration_s = 200.0
samples = 101
"""


def turned_twice(first: float = 90.0, course: str = "paper", start: float = 20.0, frame: str = "previous_bar") -> Scene:
    """An arm whose joint is turned by a quintic and then by another course."""
    return parse_scene(
        TURNED_TWICE.format(first=first, course=course, start=start, frame=frame), name="mine", file="mine.toml"
    )


@pytest.mark.parametrize("engine", FORMS)
@pytest.mark.parametrize("course", ["paper", "quintic"])
def test_a_joint_turned_twice_is_held_between_and_follows_both_courses(engine: str, course: str) -> None:
    """10 s^3 - 15 s^4 + 6 s^5, by its coefficients, and the integrator's error of a hundred steps of 1e-13."""
    seen = moved(turned_twice(course=course), engine)
    bent = np.degrees(np.diff(seen.angle_rad, axis=1)[:, 0] - seen.angle_rad[0, 1] + seen.angle_rad[0, 0])
    s = np.clip((seen.t_s - 20.0) / 50.0, 0.0, 1.0)
    quintic = 40.0 * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
    x = np.clip((seen.t_s - 90.0) / 60.0, 0.0, 1.0)
    share = 10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5
    if course == "paper":
        share = (np.cos(3.0 * np.pi * x) - 9.0 * np.cos(np.pi * x) + 8.0) / 16.0
    np.testing.assert_allclose(bent, quintic + 90.0 * share, atol=1e-8)


@pytest.mark.parametrize("engine", FORMS)
def test_an_arm_turned_there_and_back_leaves_its_base_where_it_was(engine: str) -> None:
    """Without angular momentum the base's angle follows from the joint's, whatever the courses."""
    seen = moved(turned_twice(first=-40.0), engine)
    assert abs(seen.angle_rad[25, 0] - seen.angle_rad[0, 0]) > 1e-3
    np.testing.assert_allclose(seen.angle_rad[-1], seen.angle_rad[0], atol=1e-10)


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"start": 100.0}, r"bar 2 is turned by another table from 90 to 150 s; allowed: one turn after the other"),
        ({"frame": "inertial"}, 'bar 2 has a law already, with frame = "previous_bar"'),
    ],
    ids=["at once", "in two frames"],
)
def test_turns_that_contradict_each_other_are_told(change: dict[str, Any], fault: str) -> None:
    with pytest.raises(SceneError, match=fault):
        turned_twice(**change)


def test_a_scene_with_two_turns_is_written_and_read_back(tmp_path: Path) -> None:
    scene = turned_twice()
    scene.to_toml(tmp_path / "again.toml")
    assert load_scene(str(tmp_path / "again.toml")).effects == scene.effects
    assert "prescribed_rotation.several_turns" in scene.effects.names
