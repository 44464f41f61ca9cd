"""REBOUND under effects: its particle against closed forms and Encke's method, and the chain's track against it."""

import dataclasses
import functools
import math

import numpy as np
import pytest
import rebound
from scipy.integrate import solve_ivp

from adapters.common.initial_state import initial_state
from adapters.common.kepler import propagate
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.rebound.adapter import Rebound
from adapters.rebound.forces import companion
from barchain.metrics.model_difference import com_displacement, track_response
from barchain.solutions.reference import with_perturbed_start
from scenarios import Axes, End, Gravity, Impulse, load_scene
from tests.support import solutions
from tests.support.changed import lasting, on_orbit, under
from tests.support.slow import one_in, slow_but

EPS = np.finfo(float).eps
TIGHT = Setting(AccuracyParameter.RTOL, 1e-13)
ENCKE_RTOL = 1e-12


def scenes():
    """What a particle feels, one and all of it, on circles and ellipses."""
    flat, tidal = load_scene("effects/oblateness"), load_scene("effects/third_body")
    moon, sun = tidal.effects.third_body
    pushed = under(load_scene("effects/thrust"), thrust=(load_scene("effects/thrust").effects.thrust[1],))
    return {
        "j2": flat,
        "j2 ellipse": lasting(on_orbit(flat, speed_factor=1.3), 8.0 * flat.run.duration_s, 51),
        "moon": under(tidal, third_body=(moon,)),
        "sun": under(tidal, third_body=(sun,)),
        "moon and sun": tidal,
        "moon, j2, ellipse": on_orbit(
            under(tidal, third_body=(moon,), oblateness=flat.effects.oblateness), speed_factor=1.1
        ),
        "thrust": pushed,
    }


def encke(scene):
    """Track of a particle as Kepler's orbit in closed form and a departure from it, (n, 2): only that is integrated."""
    mu, start, effects = scene.central_body.mu_m3_s2, initial_state(scene), scene.effects

    def more(t, z):
        r, found = np.hypot(*z), np.zeros(2)
        if effects.oblateness:
            found -= 1.5 * mu * effects.oblateness.j2 * effects.oblateness.radius_m**2 * z / r**5
        for body in effects.third_body:
            angle = body.longitude_rad + body.rate_rad_s * t
            x = body.distance_m * np.array([math.cos(angle), math.sin(angle)])
            found -= body.mu_m3_s2 * ((z - x) / np.hypot(*(z - x)) ** 3 + x / body.distance_m**3)
        for thrust in effects.thrust:
            way = np.array([math.cos(thrust.direction_rad), math.sin(thrust.direction_rad)])
            found += thrust.size_N(t) / scene.mass_kg * way
        return found

    def rhs(t, y):
        z = propagate(mu, start.com_m, start.com_velocity_m_s, np.array([t]))[0][0]
        d, r = y[:2], np.hypot(*z)
        change = math.expm1(-1.5 * math.log1p((2.0 * z + d) @ d / r**2))
        pull = -mu / r**3 * (d * (1.0 + change) + z * change)
        return np.concatenate([y[2:], pull + more(t, z + d)])

    n, size = scene.orbital_rate_rad_s, 1e-4 * scene.radius0_m
    atol = ENCKE_RTOL * size * np.array([1.0, 1.0, n, n])
    found = solve_ivp(
        rhs, (0, scene.run.duration_s), np.zeros(4), "DOP853", scene.times_s, rtol=ENCKE_RTOL, atol=atol
    ).y.T
    return propagate(mu, start.com_m, start.com_velocity_m_s, scene.times_s)[0] + found[:, :2], found[:, :2]


yardstick = functools.cache(lambda name: encke(scenes()[name]))


def round_off(scene, departure):
    """Of REBOUND's and the yardstick's: an energy off by an eps shifts the phase; the departure's own integration."""
    turns = scene.orbital_rate_rad_s * scene.run.duration_s
    return (6.0 * 1.5 * EPS * scene.radius0_m + 10.0 * ENCKE_RTOL * np.abs(departure).max()) * (1.0 + 3.0 * turns)


@pytest.mark.parametrize("rtol", slow_but([1e-6, 1e-9, 1e-12], [1e-9]))
@pytest.mark.parametrize("name", one_in(2, scenes()))
def test_a_particle_under_effects_is_where_enckes_method_puts_it(name, rtol):
    scene, (place, departure) = scenes()[name], yardstick(name)
    found = Rebound().run(scene, Setting(AccuracyParameter.RTOL, rtol))
    assert found.info["integrator"] == "ias15"  # WHFast knows Kepler's orbit only
    assert np.abs(found.com_m - place).max() < rtol * scene.radius0_m + round_off(scene, departure)
    assert np.abs(departure).max() > 1e3 * round_off(scene, departure)  # the effect itself is seen


def test_on_the_circular_speed_of_a_flattened_body_the_particle_stays_at_its_height():
    scene = load_scene("effects/oblateness")
    flat = scene.effects.oblateness
    scene = on_orbit(scene, speed_factor=math.sqrt(1.0 + 1.5 * flat.j2 * (flat.radius_m / scene.radius0_m) ** 2))
    height = np.hypot(*Rebound().run(scene).com_m.T) - scene.radius0_m
    assert np.abs(height).max() < round_off(scene, np.zeros(1))


@pytest.mark.parametrize("which", [0, 1])
def test_a_third_body_that_is_a_particle_moves_it_as_one_that_is_prescribed_does(which):
    scene = load_scene("effects/third_body")
    whole = scene.effects.third_body[which]
    half = dataclasses.replace(whole, mu_m3_s2=0.5 * whole.mu_m3_s2)
    real, prescribed = under(scene, third_body=(whole,)), under(scene, third_body=(half, half))
    assert companion(real) is whole
    assert companion(prescribed) is None
    assert companion(under(scene, third_body=(dataclasses.replace(whole, rate_rad_s=0.0),))) is None
    apart = np.abs(Rebound().run(real).com_m - Rebound().run(prescribed).com_m).max()
    assert apart < 2.0 * round_off(scene, np.zeros(1))


def test_moon_and_sun_that_pull_on_each_other_are_another_problem_than_two_circles():
    """In a day the Sun's tide moves the Moon, relative to the Earth, by up to g t²/2 with g = 2 mu_s d/D³.

    That changes the Moon's pull on the chain by 3/d of it: 2 mu_m r/d³ times 3 g t²/2d, which acts for a day.
    """
    scene = load_scene("effects/third_body")
    moon, sun = scene.effects.third_body
    start, end = initial_state(scene), scene.run.duration_s
    sim = rebound.Simulation()
    sim.G = 1.0
    sim.add(m=scene.central_body.mu_m3_s2)
    for body in (moon, sun):
        z = body.distance_m * np.exp(1j * body.longitude_rad)
        v = 1j * body.rate_rad_s * z
        sim.add(m=body.mu_m3_s2, x=z.real, y=z.imag, vx=v.real, vy=v.imag)
    sim.add(m=0.0, x=start.com_m[0], y=start.com_m[1], vx=start.com_velocity_m_s[0], vy=start.com_velocity_m_s[1])
    sim.N_active, sim.integrator = 3, "ias15"
    sim.integrate(end)
    earth, chain = sim.particles[0], sim.particles[3]
    apart = np.hypot(*(Rebound().run(scene).com_m[-1] - [chain.x - earth.x, chain.y - earth.y]))
    tide = 2.0 * sun.mu_m3_s2 * moon.distance_m / sun.distance_m**3
    pull = 2.0 * moon.mu_m3_s2 * scene.radius0_m / moon.distance_m**3 * 3.0 * 0.5 * tide * end**2 / moon.distance_m
    assert 0.01 < apart < 0.5 * pull * end**2 * (1.0 + 3.0 * scene.orbital_rate_rad_s * end)
    assert apart > 1e3 * round_off(scene, np.zeros(1))  # so that several are prescribed, and do not interact


def test_a_blow_adds_its_momentum_and_a_sample_at_it_shows_what_was_before():
    scene = lasting(load_scene("basics/kepler_circular"), 2000.0, 201)
    blow = Impulse(bar=1, end=End.LEFT, axes=Axes.INERTIAL, direction_rad=2.0, impulse_N_s=30.0, at_s=500.0)
    scene = under(scene, impulse=(blow,))
    jump = 30.0 / scene.mass_kg * np.array([math.cos(2.0), math.sin(2.0)])
    mu, start, t = scene.central_body.mu_m3_s2, initial_state(scene), scene.times_s
    place, velocity = propagate(mu, start.com_m, start.com_velocity_m_s, t)
    at = 50
    assert t[at] == pytest.approx(500.0)
    after, _ = propagate(mu, place[at], velocity[at] + jump, t[at:] - 500.0)
    found = Rebound().run(scene)
    tolerance = 2.0 * round_off(scene, np.zeros(1))
    assert np.abs(found.com_m[: at + 1] - place[: at + 1]).max() < tolerance
    assert np.abs(found.com_velocity_m_s[at] - velocity[at]).max() < tolerance
    assert np.abs(found.com_m[at:] - after).max() < tolerance
    first = Rebound().run(under(scene, impulse=(dataclasses.replace(blow, at_s=0.0),)))
    assert np.abs(first.com_velocity_m_s[0] - start.com_velocity_m_s - jump).max() < 4.0 * EPS * scene.speed0_m_s


def test_a_thrusts_table_is_a_polynomial_in_empty_space():
    """Without gravity a force that goes straight from one size to another moves by t²/2 and t³/6 of it."""
    free = under(load_scene("basics/kepler_circular"), gravity=Gravity.NONE)
    scene = lasting(free, 1000.0, 11)
    push = dataclasses.replace(load_scene("effects/thrust").effects.thrust[1], direction_rad=0.0, bar=1)
    push = dataclasses.replace(push, times_s=(155.0, 455.0, 655.0), force_N=(2.0, 8.0, 8.0))
    found = Rebound().run(under(scene, thrust=(push,)))
    start = initial_state(scene)
    speed = (0.5 * (2.0 + 8.0) * 300.0 + 8.0 * 200.0) / scene.mass_kg
    way = (2.0 * 300.0**2 / 2 + 6.0 * 300.0**2 / 6 + 1500.0 * 200.0 + 8.0 * 200.0**2 / 2) / scene.mass_kg
    way += speed * 345.0
    moved = found.com_m[-1] - start.com_m - 1000.0 * start.com_velocity_m_s
    assert found.com_velocity_m_s[-1] - start.com_velocity_m_s == pytest.approx([speed, 0.0], abs=1e-10)
    assert moved == pytest.approx([way, 0.0], abs=20.0 * EPS * float(np.hypot(*found.com_m[-1])))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("impulse", ["bar's own axes"]),
        ("everything", ["moves a particle", "drag, sunlight or a thrust that turns with its bar"]),
    ],
)
def test_forces_that_depend_on_attitude_are_rejected_with_the_reason(name, words):
    reason = Rebound.unsupported(load_scene(f"effects/{name}"))
    assert all(each in reason for each in words)


def test_what_a_callback_raises_is_raised_by_the_engine_and_not_printed(capfd):
    engine = Rebound()
    engine.build(load_scene("effects/oblateness"), Rebound.sweep.setting())
    engine.forces[0] = lambda _t, _x, _y: 1.0 / 0.0
    with pytest.raises(EngineError, match="ZeroDivisionError"):
        engine.simulate()
    assert capfd.readouterr() == ("", "")


def everything_it_carries():
    scene = load_scene("effects/everything")
    push = tuple(dataclasses.replace(t, axes=Axes.INERTIAL) for t in scene.effects.thrust)
    return under(scene, drag=None, solar_pressure=None, thrust=push)


CHAINS = ("oblateness", "third_body", "quadrupole", "slender", "slews", "tip_masses", "joint_springs", "everything")


@pytest.mark.parametrize("name", slow_but(CHAINS, ["quadrupole", "joint_springs"]))
def test_a_chains_track_leaves_the_particles_by_what_is_predicted(name):
    scene = everything_it_carries() if name == "everything" else load_scene(f"effects/{name}")
    solution, looser = (solutions.run(scene, rtol) for rtol in (1e-13, 1e-12))
    seen, predicted = Rebound().run(scene), com_displacement(scene, solution)
    own = np.maximum.accumulate(np.hypot(*(solution.com_m - looser.com_m).T)) + 1e-12 * scene.radius0_m
    apart = np.hypot(*(solution.com_m - seen.com_m - predicted.vector_m).T)
    allowed = predicted.uncertainty_m + 2.0 * own
    assert np.all(apart <= allowed)
    assert np.hypot(*predicted.vector_m.T).max() > 3.0 * allowed[-1]


def sails():
    """Sails so wide that bars tumble, and turn one face and then the other to the Sun."""
    scene = load_scene("effects/solar_pressure")
    return under(scene, solar_pressure=dataclasses.replace(scene.effects.solar_pressure, width_m=(1.0, 2.0, 0.5)))


PUSHED = ("drag", "solar_pressure", "sails", "thrust", "impulse")


@pytest.mark.parametrize("name", slow_but(PUSHED, ["thrust"]))
def test_a_tracks_answer_to_the_attitude_counts_what_pushes_by_it(name):
    """A run perturbed a million times more than usual: what its track does stands out of the tracks' own errors."""
    scene = sails() if name == "sails" else load_scene(f"effects/{name}")
    aside = with_perturbed_start(scene)
    moved = dataclasses.replace(
        scene.chain,
        angle_rad=tuple(a + 1e6 * (b - a) for a, b in zip(scene.chain.angle_rad, aside.chain.angle_rad, strict=True)),
    )
    solution, other = (solutions.run(s, TIGHT.value) for s in (scene, dataclasses.replace(scene, chain=moved)))
    apart = np.hypot(*(solution.com_m - other.com_m).T)
    found = track_response(scene, solution, other)["com"]
    assert found[-1] == pytest.approx(apart[-1], rel=0.05, abs=2e-12 * scene.radius0_m)
    assert apart[-1] > 5.0 * 2e-12 * scene.radius0_m
