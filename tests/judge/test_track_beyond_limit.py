"""Effect of parted attitudes on the track: no more than a force of unknown direction gives, and not far more."""

import dataclasses
import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from barchain.judge.parted_track import parted_track_bound
from scenarios import (
    Actuator,
    Axes,
    Drag,
    End,
    Frame,
    Impulse,
    PrescribedRotation,
    Scene,
    SolarPressure,
    Thrust,
    load_scene,
)

LIMIT_S, START_S, FORCE_N, PUSH_S = 1000.0, 4000.0, 2.0, 60.0
FIXED = math.radians(40.0)


class Solved(NamedTuple):
    """The part of a solution that the bound needs."""

    scene: Scene
    trajectory: Trajectory
    fine: Trajectory


def bar(speed_factor: float, *, thrust: tuple[Thrust, ...] = (), impulse: tuple[Impulse, ...] = ()) -> Scene:
    """One bar over ten orbits, in point gravity: the pull does not depend on its attitude."""
    base = load_scene("basics/kepler_circular")
    orbit = dataclasses.replace(base.orbit, altitude_m=2000e3, speed_factor=speed_factor)
    effects = dataclasses.replace(base.effects, thrust=thrust, impulse=impulse)
    run = dataclasses.replace(base.run, duration_s=60e3, samples=601)
    return dataclasses.replace(base, orbit=orbit, effects=effects, run=run)


def thrust(direction_rad: float, axes: Axes = Axes.INERTIAL) -> Thrust:
    return Thrust(1, End.RIGHT, axes, direction_rad, (START_S, START_S + PUSH_S), (FORCE_N, FORCE_N))


def run(scene: Scene) -> Trajectory:
    return ENGINES["reference"].load()().run(scene, Setting(AccuracyParameter.RTOL, 1e-11))


def bound(scene: Scene) -> dict[str, np.ndarray]:
    found = run(scene)
    return parted_track_bound(Solved(scene, found, found), found.t_s, LIMIT_S)


@pytest.mark.exhaustive
@pytest.mark.parametrize("speed_factor", [1.0, 1.2, 0.95])
def test_opposite_thrusts_move_the_track_by_less_than_the_bound_and_not_by_far_less(speed_factor: float) -> None:
    allowed = bound(bar(speed_factor, thrust=(thrust(0.0, Axes.BODY),)))
    apart = {"com": np.zeros(601), "com_velocity": np.zeros(601)}
    for angle in np.radians(np.arange(0.0, 180.0, 30.0)):
        one, other = (run(bar(speed_factor, thrust=(thrust(a),))) for a in (angle, angle + math.pi))
        for name, field in (("com", "com_m"), ("com_velocity", "com_velocity_m_s")):
            difference = np.linalg.norm(getattr(one, field) - getattr(other, field), axis=1)
            apart[name] = np.maximum(apart[name], difference)
    pull = bound(bar(speed_factor))  # of the gravity of a chain's attitude, which point gravity of one bar has not
    for name, values in apart.items():
        assert np.all(values <= allowed[name] + 1e-3)
        assert values[-1] > 0.05 * (allowed[name] - pull[name])[-1]


@pytest.mark.slow
def test_a_thrust_or_an_impulse_of_fixed_direction_moves_the_track_alike_at_any_attitude() -> None:
    plain = bound(bar(1.0))
    fixed = bound(bar(1.0, thrust=(thrust(FIXED),), impulse=(Impulse(1, End.LEFT, Axes.INERTIAL, FIXED, 50.0, 3e3),)))
    for name, values in plain.items():
        np.testing.assert_allclose(fixed[name], values, rtol=1e-3)


@pytest.mark.exhaustive
def test_what_acts_before_the_limit_adds_nothing_and_what_acts_later_nothing_before_it_acts() -> None:
    plain, early = bound(bar(1.0)), Impulse(1, End.LEFT, Axes.BODY, FIXED, 50.0, LIMIT_S - 400.0)
    np.testing.assert_allclose(bound(bar(1.0, impulse=(early,)))["com"], plain["com"], rtol=1e-2)
    late = bound(bar(1.0, thrust=(thrust(FIXED, Axes.BODY),)))["com"]
    before = np.linspace(0.0, 60e3, 601) <= START_S
    np.testing.assert_allclose(late[before], plain["com"][before], rtol=1e-6)
    assert np.all(late[~before] > plain["com"][~before])


def faces(scene: Scene, frame: Frame) -> list[Scene]:
    """A bar held at several angles to the wind, or to the Sun."""
    held = dataclasses.replace(
        scene.effects, prescribed_rotation=(PrescribedRotation(1, 1e-9, 1.0, 0.0, frame, Actuator.EXTERNAL),)
    )
    turned = [dataclasses.replace(scene.chain, angle_rad=(a,)) for a in np.radians([0.0, 30.0, 60.0, 90.0, 120.0])]
    return [dataclasses.replace(scene, effects=held, chain=chain) for chain in turned]


@pytest.mark.exhaustive
@pytest.mark.parametrize(("speed_factor", "force", "least_share"), [(1.17, "drag", 0.04), (1.3, "light", 0.004)])
def test_air_and_light_part_tracks_by_no_more_than_their_strength_along_the_orbit(
    speed_factor: float, force: str, least_share: float
) -> None:
    """Drag is strongest at each perigee. Light from one side does not add up over an orbit: its bound is wider."""
    scene = bar(speed_factor)
    scene = dataclasses.replace(scene, orbit=dataclasses.replace(scene.orbit, altitude_m=350e3))
    drag = Drag(1e-11, 350e3, 50e3, 7.292e-5, (0.3,), 2.2, 0.3) if force == "drag" else None
    light = SolarPressure(4.5e-3, 0.3, 0.0, (0.3,), 0.4, shadow=False) if force == "light" else None
    effects = dataclasses.replace(scene.effects, drag=drag, solar_pressure=light)
    run_ = dataclasses.replace(scene.run, duration_s=2.9 * scene.period_s, samples=291)
    scene = dataclasses.replace(scene, effects=effects, run=run_)
    frame = Frame.LOCAL_HORIZONTAL if force == "drag" else Frame.INERTIAL
    runs = [run(each) for each in faces(scene, frame)]
    allowed = parted_track_bound(Solved(scene, runs[0], runs[0]), runs[0].t_s, 0.0)
    pull = bound(dataclasses.replace(scene, effects=dataclasses.replace(effects, drag=None, solar_pressure=None)))
    for name, field in (("com", "com_m"), ("com_velocity", "com_velocity_m_s")):
        pairs = itertools.combinations([getattr(each, field) for each in runs], 2)
        apart = np.max([np.linalg.norm(a - b, axis=1) for a, b in pairs], axis=0)
        assert np.all(apart <= allowed[name] + 1e-3)
        assert apart[-1] > least_share * (allowed[name] - pull[name])[-1]
