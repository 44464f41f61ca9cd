"""Effects of the certified solution against potentials, elements along a bar, closed forms and balances of their own.

Forces and torques are those on a lone bar, in quadruple precision against fifty digits: what is left is 1e-30 of the
largest term times a few dozen operations. In double the same equations may lose no more than round-off.
"""

from __future__ import annotations

import dataclasses
import math

import mpmath as mp
import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, Setting
from adapters.heyoka.adapter import Heyoka, HeyokaQuad
from adapters.heyoka.compiled import DOUBLE, QUAD
from adapters.heyoka.events import Modes
from adapters.heyoka.run import HeyokaRun
from adapters.heyoka.structure import structure_of
from reference_impl.model import invariants
from reference_impl.model.kinematics import relative_positions, relative_velocities
from scenarios import (
    Actuator,
    Axes,
    Drag,
    Effects,
    End,
    Frame,
    Gravity,
    Impulse,
    JointSpringDamper,
    Oblateness,
    PrescribedRotation,
    SolarPressure,
    ThirdBody,
    Thrust,
)
from tests.adapters.exact_loads import exact_accelerations, exact_bar
from tests.harness.certified_start import scene_of, start
from tests.support import solutions
from tests.support.changed import lasting, on_orbit, under
from tests.support.slow import one_in

U = 2.0**-53
MU = 3.986004418e14
QUAD_DIGITS = 1e-28  # some hundred roundings of 1e-34, ten times over for what is subtracted in the judge
OBLATE = Oblateness(1e-3, 6.4e6)
BODIES = (ThirdBody("moon", 4.9e12, 3.8e8, 0.3, 2.7e-6), ThirdBody("other", 1e13, 5e7, -1.2, 1e-5))
FIELDS = {
    "central": {},
    "oblate": {"oblateness": OBLATE},
    "third bodies": {"third_body": BODIES},
    "all": {"oblateness": OBLATE, "third_body": BODIES},
}
AIR = Drag(2e-11, 340e3, 50e3, 7.3e-5, (0.3,), 2.2, 1.8)
LIGHT = SolarPressure(4.6e-6, 1.0, 2e-7, (0.5,), 0.3, shadow=True)
PAIR = {"mass_kg": (60.0, 40.0), "length_m": (80.0, 50.0), "angle_rad": (0.7, 1.1), "rate_factor": (1.3, 0.8)}


@pytest.fixture(autouse=True)
def fifty_digits():
    with mp.workdps(50):
        yield


def check_near(scene, size=0.0):
    """Compare the accelerations of a lone bar at the start with the exact ones, of some size; give the force's."""
    begun = start(scene)
    x, y, vx, vy, angle, rate = begun.si
    bar = exact_bar(scene, 0, mp.mpc(x, y), mp.mpc(vx, vy), angle, rate)
    pull, spin = exact_accelerations(scene, [bar], 0, 0.0)
    ax, ay, (turn,) = begun.accelerations
    assert abs(mp.mpc(ax, ay) - pull) <= QUAD_DIGITS * abs(pull)
    # a bar that nothing turns may turn by the rounding of moments of its whole force
    levers = bar.mass * max(abs(pull), size) * bar.length if spin == 0 else abs(spin) * bar.inertia
    assert abs(turn - spin) * bar.inertia <= QUAD_DIGITS * levers
    return abs(pull)


@pytest.mark.parametrize("length_m", one_in(3, [0.1, 80.0, 2e5]))
@pytest.mark.parametrize("fields", FIELDS)
@pytest.mark.parametrize("gravity", ["point", "gradient", "quadrupole", "slender"])
def test_fields_pull_and_turn_a_bar_as_their_potentials_say(gravity, fields, length_m):
    assert check_near(scene_of(Effects(Gravity(gravity), **FIELDS[fields]), length_m=(length_m,))) > 0


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("gravity", ["quadrupole", "slender"])
def test_in_double_no_digit_is_lost_with_size(gravity, size):
    """What reaches the joint of two bars: a tide of size l/r of gravity, in double as in quadruple precision."""
    lengths = tuple(size * x for x in PAIR["length_m"])
    scene = scene_of(Effects(Gravity(gravity), **FIELDS["all"]), **PAIR | {"length_m": lengths})
    exact, rounded = start(scene).reactions, start(scene, DOUBLE).reactions
    largest = max(abs(x) for x in exact)
    # each of the terms of a reaction is of the pull's size; a hundred operations, an inversion of condition below 10
    assert max(abs(a - b) for a, b in zip(exact, rounded, strict=True)) <= 1000 * U * largest


def test_air_pushes_as_the_sum_over_a_bars_elements_does():
    assert check_near(scene_of(Effects(Gravity.NONE, drag=AIR))) > 0


@pytest.mark.parametrize("sun", [1.0, -0.9, 2.1, 3.6])
def test_light_pushes_from_either_side_and_not_in_the_shadow(sun):
    light = dataclasses.replace(LIGHT, sun_longitude_rad=sun)
    scene = scene_of(Effects(Gravity.NONE, solar_pressure=light))
    (angle,), (length,), (mass,) = scene.chain.angle_rad, scene.chain.length_m, scene.chain.mass_kg
    in_the_light = light.pressure_Pa * light.width_m[0] * length * abs(math.sin(sun - angle)) / mass
    assert (check_near(scene, in_the_light) == 0) == (sun == 3.6)


def circling(effects):
    """One bar on a circle, not moved by anything to speak of, through one revolution."""
    scene = on_orbit(scene_of(effects), speed_factor=1.0)
    return lasting(scene, scene.period_s, 41)


def zeros(phase, rate, duration):
    """Instants in a run at which phase + rate t is a multiple of pi."""
    turns = sorted([phase / math.pi, (phase + rate * duration) / math.pi])
    return [(k * math.pi - phase) / rate for k in range(math.ceil(turns[0]), math.floor(turns[1]) + 1)]


@pytest.mark.parametrize(("engine", "rtol"), [(Heyoka, 1e-15), (HeyokaQuad, 1e-22)])
def test_the_shadow_and_faces_to_the_sun_are_met_at_their_instants_in_closed_form(engine, rtol):
    """In at 180 degrees less asin(R/r) from the Sun, out as far behind; n·s = 0 by two uniform rotations."""
    scene = circling(Effects(Gravity.POINT, solar_pressure=dataclasses.replace(LIGHT, pressure_Pa=1e-25)))
    made = engine()
    seen = made.run(scene, Setting(AccuracyParameter.RTOL, rtol))
    turn, at = initial_state(scene), scene.orbit.longitude_rad
    dark = math.asin(scene.central_body.radius_m / scene.radius0_m)
    chase = scene.orbital_rate_rad_s - LIGHT.sun_rate_rad_s
    edges = [((LIGHT.sun_longitude_rad - at + math.pi + side * dark) % (2 * math.pi)) / chase for side in (-1, 1)]
    rate = float(turn.rate_rad_s[0]) - LIGHT.sun_rate_rad_s
    faces = zeros(float(turn.angle_rad[0]) - LIGHT.sun_longitude_rad, rate, scene.run.duration_s)
    np.testing.assert_allclose(made.ran.mode_changes_s, sorted(edges + faces), rtol=0, atol=100 * U * scene.period_s)
    np.testing.assert_array_equal(seen.t_s, scene.times_s)


def test_faces_to_the_wind_turn_when_the_bar_lies_along_its_track():
    still = dataclasses.replace(AIR, density_kg_m3=1e-30, rotation_rad_s=0.0)
    scene = circling(Effects(Gravity.POINT, drag=still))
    run = HeyokaRun(scene, scene.times_s, QUAD, 1e-22)
    run.walk()
    begun = initial_state(scene)
    phase = float(begun.angle_rad[0]) - scene.orbit.longitude_rad - math.pi / 2
    wanted = zeros(phase, float(begun.rate_rad_s[0]) - scene.orbital_rate_rad_s, scene.run.duration_s)
    np.testing.assert_allclose(run.mode_changes_s, wanted, rtol=0, atol=100 * U * scene.period_s)


@pytest.mark.parametrize("rate", [1.3, -1.3])
@pytest.mark.parametrize("precision", [DOUBLE, QUAD])
def test_a_bar_edge_on_to_the_sun_at_the_start_shows_the_face_it_turns_to(rate, precision):
    scene = scene_of(Effects(Gravity.POINT, solar_pressure=LIGHT), rate_factor=(rate,))
    on_edge = dataclasses.replace(LIGHT, sun_longitude_rad=float(initial_state(scene).angle_rad[0]))
    scene = scene_of(Effects(Gravity.POINT, solar_pressure=on_edge), rate_factor=(rate,))
    run = HeyokaRun(scene, scene.times_s, precision, 1e-15)
    run.walk()
    slot = run.structure.slots["light_face_0"]
    faces = np.concatenate([r.given[:, slot] for r in run.rows]).astype(float)
    # at t = 0 itself, where nothing pushes, the rounding of n·s may tell the other one
    np.testing.assert_array_equal(faces[1:], np.full(len(scene.times_s) - 1, -math.copysign(1.0, rate)))


@pytest.mark.parametrize("rate", [1.3, -1.3])
@pytest.mark.parametrize("precision", [DOUBLE, QUAD])
def test_where_it_is_exactly_edge_on_the_sign_a_moment_later_counts(rate, precision):
    begun = start(scene_of(Effects(Gravity.POINT, solar_pressure=LIGHT), rate_factor=(rate,)), precision)
    number, slots = precision.number, begun.structure.slots
    begun.state[4] = begun.parameters[slots["light_longitude"]] = number(0.0)
    modes = Modes(begun.structure, precision)
    assert modes.event_values(begun.state, number(0.0), begun.parameters)[0] == 0.0
    modes.set(begun.state, number(0.0), begun.parameters)
    assert float(begun.parameters[slots["light_face_0"]]) == -math.copysign(1.0, rate)


def test_a_thrusts_table_adds_its_integral_to_momentum_and_spin():
    """Without gravity, along a fixed direction: M dV = integral of F; in body axes: J dw = -+h sin(delta) of it."""
    times, force = (100.0, 250.0, 400.0, 500.0), (0.2, 0.5, 0.5, 0.1)
    integral = sum(0.5 * (a + b) * (t - s) for a, b, s, t in zip(force, force[1:], times, times[1:], strict=False))
    fixed = Thrust(1, End.LEFT, Axes.INERTIAL, 2.0, times, force)
    scene = scene_of(Effects(Gravity.NONE, thrust=(fixed,)))
    seen = HeyokaQuad().run(scene, Setting(AccuracyParameter.RTOL, 1e-20))
    gained = scene.chain.mass_kg[0] * (seen.com_velocity_m_s[-1] - seen.com_velocity_m_s[0])
    # velocities of 8 km/s are rounded to double
    wanted = integral * np.array([math.cos(2.0), math.sin(2.0)])
    np.testing.assert_allclose(gained, wanted, atol=4 * U * scene.chain.mass_kg[0] * scene.speed0_m_s)
    turning = dataclasses.replace(fixed, axes=Axes.BODY)
    seen = HeyokaQuad().run(scene_of(Effects(Gravity.NONE, thrust=(turning,))), Setting(AccuracyParameter.RTOL, 1e-20))
    spin = scene.chain.inertia_kg_m2[0] * (seen.rate_rad_s[-1, 0] - seen.rate_rad_s[0, 0])
    assert spin == pytest.approx(-40.0 * math.sin(2.0) * integral, rel=100 * U)


def impulse_sum(laws=()):
    """Two impulses at one instant on a bent chain, its state before and after, and the impulsive reactions."""
    applied = (Impulse(2, End.RIGHT, Axes.BODY, 1.9, 3.0, 200.0), Impulse(1, End.LEFT, Axes.INERTIAL, 0.4, -2.0, 200.0))
    scene = scene_of(Effects(Gravity.POINT, prescribed_rotation=laws, impulse=applied), **PAIR)
    run = HeyokaRun(scene, scene.times_s, QUAD, 1e-15)
    run.solver.state[:] = run.start
    run.apply_impulses(run.scaled_time(200.0), run.parameters)
    n, units = 2, run.units
    after = np.array(run.solver.state).astype(float)
    jump = (np.array(run.solver.state) - run.start).astype(float)
    impulses = []
    for blow in applied:
        at = blow.direction_rad + (after[4 + blow.bar - 1] if blow.axes is Axes.BODY else 0.0)
        impulses.append((blow, blow.impulse_N_s * np.array([math.cos(at), math.sin(at)])))
    reaction = run.impulse_sum.astype(float) * units.force * units.time_s
    return scene, jump[2:4] * units.length_m / units.time_s, jump[4 + n :] / units.time_s, reaction, impulses


def test_impulses_keep_each_bars_momentum_and_spin_and_the_joints_closed():
    scene, track, spin, reaction, impulses = impulse_sum()
    model, angle = chain_model(scene), initial_state(scene).angle_rad
    jump = track + relative_velocities(model, angle, spin)
    for j, side in ((0, 1.0), (1, -1.0)):
        half = model.half_m[j] * np.array([math.cos(angle[j]), math.sin(angle[j])])
        mine = [(b.end.sign * half, i) for b, i in impulses if b.bar == j + 1] + [(side * half, side * reaction)]
        size = sum(np.linalg.norm(i) for _, i in mine)
        np.testing.assert_allclose(model.mass_kg[j] * jump[j], sum(i for _, i in mine), atol=64 * U * size)
        moment = sum(a[0] * i[1] - a[1] * i[0] for a, i in mine)
        arm = model.half_m[j] * size
        assert abs(model.inertia_kg_m2[j] * spin[j] - moment) <= 64 * U * arm
    # joints: `relative_velocities` hangs the bars together; the chain's own momentum is what was given
    given = sum(i for _, i in impulses)
    np.testing.assert_allclose(model.mass_kg @ jump, given, atol=64 * U * np.abs(given).max())


@pytest.mark.parametrize("actuator", list(Actuator))
@pytest.mark.parametrize("frame", list(Frame))
def test_a_prescribed_bar_keeps_the_rate_of_its_law_through_impulses(frame, actuator):
    law = PrescribedRotation(2, 0.5, 100.0, 50.0, frame, actuator)
    scene, track, spin, reaction, impulses = impulse_sum((law,))
    model, begun = chain_model(scene), initial_state(scene)
    jump = (track + relative_velocities(model, begun.angle_rad, spin))[1]
    place = begun.com_m + relative_positions(model, begun.angle_rad)[1]
    horizontal = (place[0] * jump[1] - place[1] * jump[0]) / (place @ place)
    wanted = {Frame.INERTIAL: 0.0, Frame.LOCAL_HORIZONTAL: horizontal, Frame.PREVIOUS_BAR: spin[0]}[frame]
    assert spin[1] == pytest.approx(wanted, abs=64 * U * float(np.abs(jump).max() / scene.radius0_m + 1e-30))
    assert spin[0] != 0.0
    own = impulses[0][1]
    np.testing.assert_allclose(model.mass_kg[1] * jump, own - reaction, atol=64 * U * np.abs(own).max())


def test_springs_give_back_what_they_take_and_dampers_lose_what_they_turn_to_heat():
    """Without gravity: energy of motion and springs; losses by Simpson's rule on 2001 samples, of order 4."""
    springs = JointSpringDamper((2.0,), (0.0,), (0.3,))
    scene = scene_of(Effects(Gravity.NONE, joint_spring_damper=springs), **PAIR)
    scene = lasting(scene, scene.run.duration_s, 2001)
    for damping in (0.0, 50.0):
        damped = under(scene, joint_spring_damper=dataclasses.replace(springs, damping_N_m_s_rad=(damping,)))
        seen = Heyoka().run(damped, Setting(AccuracyParameter.RTOL, 1e-15))
        model, bend = chain_model(scene), np.diff(seen.angle_rad, axis=1)[:, 0]
        energy = invariants.relative_kinetic_energy(model, seen.angle_rad, seen.rate_rad_s) + (bend - 0.3) ** 2
        power = damping * np.diff(seen.rate_rad_s, axis=1)[:, 0] ** 2
        step = seen.t_s[1]
        lost = step / 3 * (power[0] + 4 * power[1:-1:2].sum() + 2 * power[2:-1:2].sum() + power[-1])
        assert damping == 0.0 or lost > 0.01 * energy[0]
        # Simpson: (step rate)^4/180 of what is lost, and a hundred steps of 1e-15 of the fastest rate
        assert abs(energy[0] - energy[-1] - lost) <= (step * scene.fastest_rate_rad_s) ** 4 / 180 * lost + 1e-12
        spin = invariants.relative_angular_momentum(model, seen.angle_rad, seen.rate_rad_s)
        np.testing.assert_allclose(spin, spin[0], rtol=1e-12)


def test_a_bar_held_to_its_horizon_stays_there_whatever_else_moves_it():
    law = PrescribedRotation(2, 0.0, 60.0, 0.0, Frame.LOCAL_HORIZONTAL, Actuator.EXTERNAL)
    effects = Effects(
        Gravity.SLENDER,
        prescribed_rotation=(law,),
        oblateness=OBLATE,
        third_body=BODIES,
        drag=dataclasses.replace(AIR, density_kg_m3=1e-8, altitude_m=6.7e6, width_m=(0.3, 0.2)),
        solar_pressure=dataclasses.replace(LIGHT, pressure_Pa=1.0, width_m=(0.5, 0.4), shadow=False),
        thrust=(Thrust(1, End.LEFT, Axes.BODY, 1.0, (0.0, 600.0), (1.0, 2.0)),),
        impulse=(Impulse(2, End.RIGHT, Axes.BODY, 1.5, 5.0, 250.0),),
    )
    scene = scene_of(effects, **PAIR)
    body = dataclasses.replace(scene.central_body, radius_m=0.0)  # no surface to be watched
    orbit = dataclasses.replace(scene.orbit, altitude_m=scene.radius0_m)
    scene = dataclasses.replace(scene, central_body=body, orbit=orbit)
    seen = Heyoka().run(scene, Setting(AccuracyParameter.RTOL, 1e-15))
    place = seen.com_m + relative_positions(chain_model(scene), seen.angle_rad)[:, 1]
    off = seen.angle_rad[:, 1] - np.unwrap(np.arctan2(place[:, 1], place[:, 0]))
    # each step may err by 1e-15 in the angle and in the longitude, and its rates carry that through the run
    steps = float(seen.info["steps"])
    assert np.ptp(seen.angle_rad[:, 1]) > 0.5
    np.testing.assert_allclose(off, off[0], rtol=0, atol=2e-15 * steps * (1 + 600.0 * scene.fastest_rate_rad_s))


def test_a_scene_that_a_thrust_brings_down_ends_at_the_surface_as_the_references_does():
    brake = Thrust(1, End.LEFT, Axes.INERTIAL, 0.4 - math.pi / 2, (0.0, 900.0), (15.0, 15.0))
    scene = scene_of(Effects(Gravity.POINT, thrust=(brake,)), angle_rad=(0.0,), rate_factor=(0.0,))
    scene = lasting(on_orbit(scene, speed_factor=1.0), 4000.0, 41)
    assert structure_of(scene).lands
    seen, solution = Heyoka().run(scene, Setting(AccuracyParameter.RTOL, 1e-15)), solutions.run(scene, 1e-13)
    assert seen.ended[:-5] == solution.ended[:-5] != ""  # to 0.01 s
    assert len(seen.t_s) == len(solution.t_s) < scene.run.samples
