"""Files of arms on laws of their joints, with angles and rates and without the torques of the motors."""

import numpy as np
import pytest

from barchain import change_scene, simulate
from barchain.judge.written import Declared

ARM = """
title = "An arm"
source = "Test"
[orbit]
altitude_m = 500e3
[chain]
bars = 2
mass_kg = [500.0, 40.0]
length_m = [2.0, 3.0]
angle_deg = [90.0, 0.0]
rate_factor = 0.0
[effects]
gravity = "none"
"""
TURNED = f"""{ARM}
[[effects.prescribed_rotation]]
bar = 2
frame = "previous_bar"
amplitude_deg = 90.0
duration_s = 60.0
start_s = 10.0
course = "quintic"
[run]
duration_s = 80.0
samples = 81
"""
SPRUNG = f"""{ARM}
[effects.joint_spring_damper]
stiffness_N_m_rad = [10.0]
damping_N_m_s_rad = [20.0]
rest_deg = [-90.0]
[[effects.joint_spring_damper.set_point]]
joint = 1
times_s = [10.0, 70.0]
angle_deg = [-90.0, 0.0]
[run]
duration_s = 80.0
samples = 81
"""


def angles_and_rates(scene):
    found = simulate(scene, "reference", rtol=1e-10).to_frame()
    return found[[name for name in found if name.startswith(("t_s", "angle", "rate"))]]


def heavier_arm(scene):
    return change_scene(scene, {"chain": {"mass_kg": [500.0, 42.0]}})


@pytest.mark.parametrize("text", [TURNED, SPRUNG])
def test_a_wrong_mass_is_named_by_angles_and_rates_alone(judged, scene_of, text):
    scene = scene_of(text)
    found = judged(angles_and_rates(heavier_arm(scene)), scene=scene)
    assert not found.passed
    assert "mass of bar 2, in the moment of inertia too, is 1.05 times the right value" in found.mistakes


@pytest.mark.parametrize("digits", [6, 8, 17])
def test_a_right_file_without_torques_passes_and_its_rounding_is_no_other_start(judged, scene_of, digits):
    scene = scene_of(TURNED)
    assert judged(angles_and_rates(scene), scene=scene, float_format=f"%.{digits}g").passed


def test_what_is_left_is_told_of_the_bars_that_motors_hold_together(judged, scene_of):
    scene = scene_of(TURNED)
    wrong = angles_and_rates(scene)
    for bar in (1, 2):
        wrong[f"angle_{bar}_rad"] += 1e-3 * (1.0 - np.cos(wrong.t_s / 3.0))
        wrong[f"rate_{bar}_rad_s"] += 1e-3 / 3.0 * np.sin(wrong.t_s / 3.0)
    assert "on bars 1 and 2 together" in judged(wrong, Declared(rtol=1e-9), scene=scene).mistakes
