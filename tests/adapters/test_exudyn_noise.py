"""Noise of Exudyn's multipliers: small bars far out, where round-off and Newton's tolerance are all that is left."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.exudyn.adapter import Exudyn, ExudynAbsolute, ExudynAbsoluteIndex3, ExudynIndex3
from adapters.exudyn.noise import index3_gain
from adapters.reference.compiled_engine import ReferenceWide
from barchain.studies.comparison.run import run_comparison
from reports.results.outcome import Outcome
from scenarios import parse_scene
from tests.support.here import HERE
from tests.support.slow import slow_but

if TYPE_CHECKING:
    from scenarios import Scene

FAR_OUT = """
title = "Small bars far out"
source = "test"
[orbit]
altitude_m = {altitude}
[chain]
bars = 4
mass_kg = [1.0, 2.0, 1.5, 0.7]
length_m = {length}
angle_deg = [20.0, 70.0, -30.0, 110.0]
rate_factor = [0.5, 1.0, 0.2, 1.4]
{effects}
[run]
orbits = 0.1
samples = 31
"""
BODIES = """
[[effects.third_body]]
body = "moon"
[[effects.third_body]]
body = "sun"
"""
SPRINGS = """
[effects.joint_spring_damper]
stiffness_N_m_rad = 1e-9
rest_deg = 10.0
"""
MOTOR = """
title = "A motor between two small bars"
source = "test"
[orbit]
altitude_m = 300e3
[chain]
bars = 2
mass_kg = [1.6, 2.9]
length_m = [0.12, 0.1]
angle_deg = [40.0, 170.0]
[[effects.prescribed_rotation]]
bar = 2
amplitude_deg = 30.0
duration_s = 400.0
start_s = 100.0
frame = "inertial"
actuator = "joint"
[run]
orbits = 0.1
samples = 31
"""
FINE = Setting(AccuracyParameter.STEPS_PER_ORBIT, 80000)
FORMS = (ExudynIndex3, ExudynAbsolute, ExudynAbsoluteIndex3)
PLACES = ((30000e3, 0.5, BODIES), (40000e3, 0.1, ""), (20000e3, 0.3, SPRINGS), (100000e3, 1.0, BODIES))


def far_out(altitude_m: float, length_m: float, effects: str) -> Scene:
    return parse_scene(FAR_OUT.format(altitude=altitude_m, length=length_m, effects=effects), name="far", file="far")


def shares(form: type[Exudyn], scene: Scene, setting: Setting = FINE) -> np.ndarray:
    """Error of the reactions over the declared noise, at each sample but the first."""
    run = form().run(scene, setting)
    right = ReferenceWide().run(scene, Setting(AccuracyParameter.RTOL, 1e-16))
    assert run.reaction_N is not None
    assert right.reaction_N is not None
    error = np.abs(run.reaction_N - right.reaction_N).reshape(len(run.t_s), -1).max(axis=1)
    share: np.ndarray = (error / form.noise(scene, setting, scene.times_s)["reaction"])[1:]
    return share


@cache
def largest_share(form: type[Exudyn], place: tuple) -> float:
    """Largest of :func:`shares` at a place."""
    return float(shares(form, far_out(*place)).max())


@pytest.mark.parametrize("place", slow_but(PLACES, PLACES[:2]), ids=str)
@pytest.mark.parametrize("form", FORMS)
def test_noise_contains_the_error_of_forces_between_small_bars(form: type[Exudyn], place: tuple) -> None:
    assert largest_share(form, place) <= 1.0


@pytest.mark.parametrize("form", [ExudynAbsolute, ExudynAbsoluteIndex3])
def test_noise_is_no_wider_than_the_error_asks_for(form: type[Exudyn]) -> None:
    """Four standard deviations: the largest of 93 is some two and a half."""
    assert largest_share(form, PLACES[0]) > 0.1


def test_noise_of_absolute_places_is_their_rounding_where_newton_iterates() -> None:
    """Bars of 100 m in a low orbit: the tolerance is a dozen roundings wide, and iterations end far inside it."""
    scene = far_out(500e3, 100.0, "")
    assert 0.1 < shares(ExudynAbsoluteIndex3, scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 20000)).max() <= 1.0


def test_alternating_errors_are_what_generalized_alpha_amplifies_most() -> None:
    """The peak of the gain is 4 (1 - 2 alpha_m) over P(-1) and 1 - 2 alpha_f; without damping there is no bound."""
    assert index3_gain(0.5) < index3_gain(0.9) < index3_gain(0.99)
    assert index3_gain(0.9) == pytest.approx(619.4, rel=1e-3)


def test_a_motor_between_small_bars_does_not_fail() -> None:
    """Its residual is an angle: no tolerance below the rounding of an angle is reached, however short the bars."""
    scene = parse_scene(MOTOR, name="motor", file="motor")
    run = ExudynIndex3().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 5000))
    assert len(run.t_s) == scene.run.samples


def test_a_balance_that_drifts_by_declared_noise_accuses_nobody() -> None:
    """Energy about the centre of mass follows from angles and rates; both are as uncertain as the engine declares."""
    scene = far_out(30000e3, 0.5, BODIES)
    found = run_comparison([scene], ["exudyn-absolute", "reference"], executor=HERE)
    assert found.outcomes["far", "exudyn-absolute"] is Outcome.UNSUPPORTED
