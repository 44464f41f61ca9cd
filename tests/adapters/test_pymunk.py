"""pymunk against the reference and closed forms.

The method's error is C dt² + O(dt⁴) with C from the run itself: halving the step takes three quarters of
it away, so |error| = |coarse - fine|/3 of the finer run. A tolerance here is that, with HEADROOM for the
next order.
"""

import functools
import math

import numpy as np
import pytest

import adapters.pymunk.adapter as adapter_module
from adapters.bar_loads.falling_frame import free_fall
from adapters.common.initial_state import initial_state
from adapters.common.kepler import propagate
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.pymunk.adapter import Pymunk, PymunkAbsolute
from adapters.pymunk.iteration_count import sweeps
from adapters.trajectory import Observable
from reference_impl.model.invariants import relative_angular_momentum, relative_kinetic_energy
from scenarios import load_scene
from tests.support.changed import lasting, on_orbit, with_chain
from tests.support.generic_scenes import solution, worst
from tests.support.step_order import by_steps, effect_scene

BOTH = pytest.mark.parametrize("engine", [Pymunk, PymunkAbsolute])
CHANNELS = ("angle_rad", "rate_rad_s", "reaction_N")
HEADROOM = 1.2
EPS = np.finfo(float).eps


def of_masses(scene, *mass_kg):
    """`scene` with bars of these masses, each 100 m long, at the first bar's angle and rate."""
    n = len(mass_kg)
    return with_chain(
        scene,
        mass_kg=mass_kg,
        length_m=(100.0,) * n,
        inertia_kg_m2=tuple(m * 1e4 / 12.0 for m in mass_kg),
        angle_rad=scene.chain.angle_rad[:1] * n,
        rate_factor=scene.chain.rate_factor[:1] * n,
    )


@functools.cache
def steep(orbits=1.0, samples=51, **orbit):
    """The 80 degree chain: stable, so that a step's error can be seen."""
    scene = on_orbit(load_scene("paper/fig15"), **({"speed_factor": 1.0} | orbit))
    return lasting(scene, orbits * scene.period_s, samples)


@functools.cache
def seen(engine, scene, steps):
    return engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, steps))


def allowed(engine, scene, steps, channel):
    """Error of a run with `steps`, from it and one of about half as many (counts are rounded from sample to sample)."""
    fine, coarse = (seen(engine, scene, s) for s in (steps, steps // 2))
    ratio = coarse.info["dt_s"] / fine.info["dt_s"]
    return HEADROOM * worst(getattr(fine, channel), getattr(coarse, channel)) / (ratio**2 - 1.0)


@BOTH
def test_order_is_two_by_richardson_and_against_the_reference(engine):
    scene = steep()
    for channel in CHANNELS:
        a, b, c = (getattr(seen(engine, scene, n), channel) for n in (500, 1000, 2000))
        assert math.log2(worst(a, b) / worst(b, c)) == pytest.approx(2.0, abs=0.1), channel
        true = getattr(solution(scene), channel)
        assert math.log2(worst(a, true) / worst(b, true)) == pytest.approx(2.0, abs=0.1), channel


@BOTH
@pytest.mark.parametrize("speed_factor", [1.1, 1.6])
def test_eccentric_and_hyperbolic_orbits_agree_with_the_reference(engine, speed_factor):
    scene = steep(orbits=0.5, speed_factor=speed_factor, longitude_rad=2.5)
    for channel in CHANNELS:
        error = worst(getattr(seen(engine, scene, 2000), channel), getattr(solution(scene), channel))
        assert error < allowed(engine, scene, 2000, channel), channel


def test_unequal_bars_agree_with_the_reference():
    scene = of_masses(steep(orbits=0.25), 100.0, 10.0, 100.0, 1.0, 50.0)
    for channel in (*CHANNELS, "com_m"):
        own = 1e-12 * scene.radius0_m if channel == "com_m" else 0.0  # the reference's track, 3e-6 m at its tightest
        error = worst(getattr(seen(Pymunk, scene, 2000), channel), getattr(solution(scene), channel))
        assert error < allowed(Pymunk, scene, 2000, channel) + own, channel


def test_reactions_are_right_from_the_first_sample_on():
    scene = steep(orbits=0.1, samples=21)  # every fifth step: see pymunk_space on the very first one
    error = np.abs(seen(Pymunk, scene, 1000).reaction_N - solution(scene).reaction_N).max(axis=(1, 2))
    assert error[:4].max() < HEADROOM * error[4:].max()


@pytest.mark.parametrize("sample", [4, 6])
def test_reactions_do_not_jump_where_the_engine_goes_over_to_fewer_sweeps(sample):
    """After the start it sweeps more often; what fewer sweeps leave of a step's change is of second order as well."""
    scene = steep()
    dt_s = scene.step_period_s / 10_000
    short = lasting(scene, 7.99 * sample * dt_s, 9)
    engine = Pymunk()
    seen, right = engine.run(short, Setting(AccuracyParameter.STEPS_PER_ORBIT, 10_000)), solution(short)
    assert engine.every == sample
    error = np.abs(seen.reaction_N - right.reaction_N).max(axis=(1, 2))[1:]
    assert error[0] < 3.0 * error[1:].max()


@BOTH
def test_gaps_are_the_bars_turning_in_one_step(engine):
    scene = steep(orbits=0.5)
    run = seen(engine, scene, 1000)
    half_m, rate = 50.0, run.rate_rad_s
    along = np.stack([np.cos(run.angle_rad), np.sin(run.angle_rad)], axis=-1)
    turn = 0.5 * run.info["dt_s"] ** 2 * half_m * (rate**2)[..., None] * along
    law = np.linalg.norm(turn[:, :-1] + turn[:, 1:], axis=-1)
    dt_rate = run.info["dt_s"] * np.abs(rate).max()
    assert np.all(np.abs(run.gap_m - law) < 2.0 * dt_rate * law.max() + 8.0 * np.spacing(scene.radius0_m))


@BOTH
def test_free_rotation_has_the_centrifugal_tension(engine):
    scene = load_scene("basics/free_rotation")
    run, omega = seen(engine, scene, 20000), scene.chain.rate_factor[0] * scene.orbital_rate_rad_s
    angle = math.radians(30.0) - 0.5 * math.pi + omega * scene.times_s
    along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    tension = 100.0 * omega**2 * 100.0 * np.array([2.0, 3.0, 3.0, 2.0])  # m w² (distance beyond the joint)
    floor = 10.0 * np.spacing(2.0 * scene.radius0_m) * 100.0 / run.info["dt_s"] ** 2
    error = worst(run.reaction_N, tension[:, None] * along[:, None, :])
    assert error < allowed(engine, scene, 20000, "reaction_N") + (floor if engine is PymunkAbsolute else 0.0)
    assert worst(run.angle_rad, angle[:, None]) < allowed(engine, scene, 20000, "angle_rad")


def test_radial_chain_has_the_tension_of_the_tide_and_the_turning():
    scene = load_scene("basics/radial_equilibrium")
    run = seen(Pymunk, scene, 5000)
    n2 = scene.orbital_rate_rad_s**2
    expected = 3.0 * n2 * 100.0 * 100.0 * np.array([2.0, 3.0, 3.0, 2.0])
    # the next order of the field is (L/r); bars are driven by it off equilibrium by no more than a few of it
    size = 4.0 * scene.size_m / scene.radius0_m
    tension = np.linalg.norm(run.reaction_N, axis=-1)
    assert np.all(np.abs(tension - expected) < size * expected + allowed(Pymunk, scene, 5000, "reaction_N"))


@pytest.mark.parametrize("name", ["kepler_circular", "kepler_elliptic", "kepler_hyperbolic"])
def test_a_point_follows_kepler(name):
    scene = load_scene(f"basics/{name}")
    start = np.array([scene.radius0_m, 0.0]), np.array([0.0, scene.speed0_m_s])
    place, velocity = propagate(scene.central_body.mu_m3_s2, *start, scene.times_s)
    moving, still = seen(Pymunk, scene, 1000), seen(PymunkAbsolute, scene, 4000)
    rounded_m = 2.0 * EPS * scene.speed0_m_s * scene.run.duration_s  # an instant rounded, at the fastest
    assert worst(moving.com_m, place) < rounded_m + np.spacing(np.abs(place).max())
    assert worst(moving.com_velocity_m_s, velocity) < 2.0 * scene.orbital_rate_rad_s * rounded_m
    assert worst(still.com_m, place) < allowed(PymunkAbsolute, scene, 4000, "com_m")
    assert moving.reaction_N.shape == (scene.run.samples, 0, 2)


def test_two_free_bars_keep_energy_and_angular_momentum_to_second_order():
    scene = load_scene("basics/two_bars_free")
    model = chain_model(scene)
    drift, dt = {}, []
    for steps in (10000, 20000):
        run = seen(Pymunk, scene, steps)
        dt.append(run.info["dt_s"])
        for name, law in (("energy", relative_kinetic_energy), ("momentum", relative_angular_momentum)):
            value = law(model, run.angle_rad, run.rate_rad_s)
            drift.setdefault(name, []).append(worst(value, value[0]))
    for coarse, fine in drift.values():
        assert math.log(coarse / fine) / math.log(dt[0] / dt[1]) == pytest.approx(2.0, abs=0.1)


def test_the_moving_frame_keeps_the_chains_departure_from_kepler():
    scene = steep()
    start = np.array([scene.radius0_m, 0.0]), np.array([0.0, scene.speed0_m_s])
    track = propagate(scene.central_body.mu_m3_s2, *start, scene.times_s)[0]
    departs = worst(seen(Pymunk, scene, 2000).com_m, track)
    true = worst(solution(scene).com_m, track)
    own = 1e-12 * scene.radius0_m  # the reference's
    assert true > 0.1
    assert abs(departs - true) < allowed(Pymunk, scene, 2000, "com_m") + own


def test_the_place_of_injection_does_not_matter():
    one, other = steep(orbits=0.5), steep(orbits=0.5, longitude_rad=math.radians(137.0))
    a, b = seen(Pymunk, one, 2000), seen(Pymunk, other, 2000)
    # round-off of angles, n steps of it, grown along a stable chain by no more than the time
    turns = 2000 * 0.5 * EPS * 10.0
    assert worst(b.angle_rad - math.radians(137.0), a.angle_rad) < turns
    assert worst(np.linalg.norm(b.com_m, axis=1), np.linalg.norm(a.com_m, axis=1)) < 1e-14 * one.radius0_m


def test_reactions_in_inertial_coordinates_are_as_noisy_as_places_are_rounded():
    scene = steep(orbits=0.01, samples=41)
    run = seen(PymunkAbsolute, scene, 200000)
    unit = np.spacing(scene.radius0_m) * 100.0 / run.info["dt_s"] ** 2  # ulp(r) m/dt²
    error = run.reaction_N - solution(scene).reaction_N
    setting = Setting(AccuracyParameter.STEPS_PER_ORBIT, 200000)
    assert np.abs(error).max() < PymunkAbsolute.noise(scene, setting, run.t_s)["reaction"]
    assert worst(run.rate_rad_s, solution(scene).rate_rad_s) < PymunkAbsolute.noise(scene, setting, run.t_s)["rate"]
    assert 0.7 < error.std() / unit < 2.0  # measured 1.2 to 1.4 from dt = 0.27 to 0.005 s
    moving = seen(Pymunk, scene, 200000).reaction_N - solution(scene).reaction_N
    assert moving.std() < 1e-3 * unit


@BOTH
def test_fall_ends_at_the_surface_within_a_step(engine):
    scene = steep(orbits=0.2, samples=28, speed_factor=0.0)
    run, true = engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 20000)), solution(scene)
    assert "a bar reached the surface" in run.ended
    instant, expected = (float(t.ended.split()[-2]) for t in (run, true))
    assert expected - 1e-6 <= instant <= expected + 1.01 * run.info["dt_s"]
    assert len(run.t_s) == len(true.t_s) < scene.run.samples
    assert len(run.angle_rad) == len(run.t_s)


def test_an_exception_in_the_engines_callback_is_not_swallowed():
    def raises(*_):
        raise ZeroDivisionError("no distance")

    engine = Pymunk()
    engine.build(steep(), Setting(AccuracyParameter.STEPS_PER_ORBIT, 500))
    engine.loads.chain_loads.gravity.load = raises
    with pytest.raises(EngineError, match="no distance"):
        engine.simulate()


def test_joints_that_burst_are_an_error(monkeypatch):
    monkeypatch.setattr(adapter_module, "step_sweeps", lambda scene, dt_s: 8)
    engine = Pymunk()
    light_between_heavy = of_masses(steep(orbits=0.25), 1e3, 1.0, 1e3, 1.0, 1e3)  # needs 2999 sweeps
    engine.build(light_between_heavy, Setting(AccuracyParameter.STEPS_PER_ORBIT, 2000))
    with pytest.raises(EngineError, match="ends at a joint"):
        engine.simulate()


def test_a_state_that_is_not_finite_is_an_error():
    engine = Pymunk()
    engine.build(steep(), Setting(AccuracyParameter.STEPS_PER_ORBIT, 500))
    engine.chain.bars[2].velocity = (math.nan, 0.0)
    with pytest.raises(EngineError):
        engine.simulate()


@BOTH
def test_what_it_can_not_do_is_said_with_a_reason(engine):
    assert "sweeps" in engine.unsupported(of_masses(steep(), *[100.0] * 60))
    assert "sweeps" in engine.unsupported(of_masses(steep(), 1e5, 1.0, 1e5))
    assert engine.unsupported(of_masses(steep(), *[100.0] * 50)) is None
    assert engine.observables - {Observable.IMPULSE} == seen(engine, steep(orbits=0.5), 1000).observables
    assert Observable.COM_RESIDUAL not in engine.observables


def test_sweeps_are_those_of_gauss_seidels_slowest_error():
    for bars in (5, 20, 50):
        left = math.cos(math.pi / bars) ** (2 * sweeps(of_masses(steep(), *[100.0] * bars).chain))
        assert left <= 0.05


def test_steps_are_rounded_up_to_a_multiple_of_the_samples():
    scene = steep(orbits=0.5, samples=8)
    run = Pymunk().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 100))
    assert run.info["steps"] == 56  # 7 intervals of 8 steps, for the 50 asked for
    assert run.info["dt_s"] == pytest.approx(scene.run.duration_s / 56)


def test_steps_that_an_event_does_not_end_are_rejected():
    with pytest.raises(EngineError, match="twice the steps"):
        by_steps(Pymunk, effect_scene("thrust_table", 0.1), 2)


@pytest.mark.parametrize("name", ["drag", "solar_pressure", "thrust", "thrust_table", "impulse"])
def test_the_chain_stays_as_near_its_frame_as_its_noise_takes_for_granted(name):
    scene = effect_scene(name)
    frame, _ = free_fall(scene, initial_state(scene), scene.times_s)
    away = np.linalg.norm(by_steps(Pymunk, scene, 4).com_m - frame, axis=1).max()
    assert away + scene.size_m < 2.0 * Pymunk.farthest_m(scene)
