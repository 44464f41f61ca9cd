"""REBOUND under effects: its particle against closed forms and Encke's method, and the chain's track against it."""

import dataclasses
import functools
import math

import numpy as np
import pytest
import rebound
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

import barchain.metrics.model_difference
from adapters.common.initial_state import initial_state
from adapters.common.kepler import propagate
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.rebound.adapter import Rebound
from adapters.rebound.forces import companion
from barchain.metrics.model_difference import com_displacement, track_response
from barchain.solutions.reference import with_perturbed_start
from scenarios import Actuator, Axes, Drag, Frame, Gravity, Impulse, PrescribedRotation, Thrust, load_scene
from tests.support import solutions
from tests.support.slow import one_in, slow_but

EPS = np.finfo(float).eps
TIGHT = Setting(AccuracyParameter.RTOL, 1e-13)
ENCKE_RTOL = 1e-12


def under(scene, **effects):
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **effects))


def lasting(scene, duration_s, samples):
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration_s, samples=samples))


def injected(scene, speed_factor):
    return dataclasses.replace(scene, orbit=dataclasses.replace(scene.orbit, speed_factor=speed_factor))


def moon_and_sun():
    return load_scene("effects/third_body")


def scenes():
    """What a particle feels, one and all of it, on circles and ellipses."""
    flat, tidal = load_scene("effects/oblateness"), moon_and_sun()
    moon, sun = tidal.effects.third_body
    pushed = under(load_scene("effects/thrust"), thrust=(load_scene("effects/thrust").effects.thrust[1],))
    return {
        "j2": flat,
        "j2 ellipse": lasting(injected(flat, 1.3), 8.0 * flat.run.duration_s, 51),
        "moon": under(tidal, third_body=(moon,)),
        "sun": under(tidal, third_body=(sun,)),
        "moon and sun": tidal,
        "moon, j2, ellipse": injected(under(tidal, third_body=(moon,), oblateness=flat.effects.oblateness), 1.1),
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
    scene = injected(scene, math.sqrt(1.0 + 1.5 * flat.j2 * (flat.radius_m / scene.radius0_m) ** 2))
    height = np.hypot(*Rebound().run(scene).com_m.T) - scene.radius0_m
    assert np.abs(height).max() < round_off(scene, np.zeros(1))


def test_oblateness_is_that_of_reboundx():
    reboundx = pytest.importorskip("reboundx")
    scene = load_scene("effects/oblateness")
    start, flat = initial_state(scene), scene.effects.oblateness
    sim = rebound.Simulation()
    sim.G = 1.0
    sim.add(m=scene.central_body.mu_m3_s2)
    sim.add(m=0.0, x=start.com_m[0], y=start.com_m[1], vx=start.com_velocity_m_s[0], vy=start.com_velocity_m_s[1])
    sim.N_active, sim.integrator = 1, "ias15"
    extras = reboundx.Extras(sim)
    extras.add_force(extras.load_force("gravitational_harmonics"))
    sim.particles[0].params["J2"], sim.particles[0].params["R_eq"] = flat.j2, flat.radius_m
    sim.integrate(scene.run.duration_s)
    there = np.array([sim.particles[1].x - sim.particles[0].x, sim.particles[1].y - sim.particles[0].y])
    assert np.abs(Rebound().run(scene).com_m[-1] - there).max() < 2.0 * round_off(scene, np.zeros(1))


@pytest.mark.parametrize("which", [0, 1])
def test_a_third_body_that_is_a_particle_moves_it_as_one_that_is_prescribed_does(which):
    scene = moon_and_sun()
    whole = scene.effects.third_body[which]
    half = dataclasses.replace(whole, mu_m3_s2=0.5 * whole.mu_m3_s2)
    real, prescribed = under(scene, third_body=(whole,)), under(scene, third_body=(half, half))
    assert companion(real) is whole
    assert companion(prescribed) is None
    apart = np.abs(Rebound().run(real).com_m - Rebound().run(prescribed).com_m).max()
    assert apart < 2.0 * round_off(scene, np.zeros(1))


def test_a_third_body_off_its_own_rate_is_no_particle():
    scene = moon_and_sun()
    moon = scene.effects.third_body[0]
    assert companion(under(scene, third_body=(dataclasses.replace(moon, rate_rad_s=0.0),))) is None


def test_moon_and_sun_that_pull_on_each_other_are_another_problem_than_two_circles():
    """In a day the Sun's tide moves the Moon, relative to the Earth, by up to g t²/2 with g = 2 mu_s d/D³.

    That changes the Moon's pull on the chain by 3/d of it: 2 mu_m r/d³ times 3 g t²/2d, which acts for a day.
    """
    scene = moon_and_sun()
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


def blown(at_s, axes=Axes.INERTIAL):
    end = load_scene("effects/impulse").effects.impulse[0].end
    return Impulse(bar=2, end=end, axes=axes, direction_rad=2.0, impulse_N_s=30.0, at_s=at_s)


def test_a_blow_adds_its_momentum_and_a_sample_at_it_shows_what_was_before():
    scene = lasting(load_scene("basics/kepler_circular"), 2000.0, 201)
    scene = under(scene, impulse=(dataclasses.replace(blown(500.0), bar=1),))
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
    first = Rebound().run(under(scene, impulse=(dataclasses.replace(blown(0.0), bar=1),)))
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
    [("drag", "drag"), ("solar_shadow", "sunlight"), ("thrust", "turns with its bar"), ("impulse", "bar's own axes")],
)
def test_forces_that_depend_on_attitude_are_rejected_with_the_reason(name, words):
    reason = Rebound.unsupported(load_scene(f"effects/{name}"))
    assert "moves a particle" in reason
    assert words in reason


def test_all_unsupported_forces_are_rejected_in_one_sentence():
    assert Rebound.unsupported(load_scene("effects/everything")) == (
        "REBOUND moves a particle without attitude and does not support drag, sunlight or a thrust that turns with "
        "its bar"
    )


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
    assert isinstance(push[0], Thrust)
    return under(scene, drag=None, solar_pressure=None, thrust=push)


CHAINS = ("oblateness", "third_body", "quadrupole", "slender", "slews", "tip_masses", "joint_springs", "everything")


@pytest.mark.parametrize("name", slow_but(CHAINS, ["joint_springs"]))
def test_a_chains_track_leaves_the_particles_by_what_is_predicted(name):
    scene = everything_it_carries() if name == "everything" else load_scene(f"effects/{name}")
    apart, allowed, size = prediction(scene)
    assert np.all(apart <= allowed)
    assert size > 3.0 * allowed[-1]


def prediction(scene):
    """What the prediction leaves, what may be left, (n,) each, and the size of what is predicted, m."""
    solution, looser = (solutions.run(scene, rtol) for rtol in (1e-13, 1e-12))
    seen, predicted = Rebound().run(scene), com_displacement(scene, solution)
    own = np.maximum.accumulate(np.hypot(*(solution.com_m - looser.com_m).T)) + 1e-12 * scene.radius0_m
    apart = np.hypot(*(solution.com_m - seen.com_m - predicted.vector_m).T)
    return apart, predicted.uncertainty_m + 2.0 * own, float(np.hypot(*predicted.vector_m.T).max())


@pytest.mark.exhaustive
@pytest.mark.parametrize("left_out", ["quadrupole", "oblateness"])
def test_a_mean_pull_that_were_left_out_of_the_prediction_would_be_seen(left_out, monkeypatch):
    monkeypatch.setattr(
        barchain.metrics.model_difference, "FIELD_EFFECTS", barchain.metrics.model_difference.FIELD_EFFECTS - {left_out}
    )
    scene = under(load_scene("effects/quadrupole"), oblateness=load_scene("effects/oblateness").effects.oblateness)
    scene = scene if left_out == "quadrupole" else under(load_scene("effects/oblateness"), gravity=Gravity.QUADRUPOLE)
    apart, allowed, _ = prediction(scene)
    assert apart[-1] > allowed[-1]


def driven(scene, push, times_s):
    """Track of REBOUND's particle, (n, 2), under central gravity and a push of time, place and velocity."""
    start, seen = initial_state(scene), []
    sim = rebound.Simulation()
    sim.G = 1.0
    sim.add(m=scene.central_body.mu_m3_s2)
    sim.add(m=0.0, x=start.com_m[0], y=start.com_m[1], vx=start.com_velocity_m_s[0], vy=start.com_velocity_m_s[1])
    sim.N_active, sim.integrator, sim.force_is_velocity_dependent = 1, "ias15", 1
    p, failed = sim.particles[1], []

    def callback(pointer):
        try:
            ax, ay = push(pointer.contents.t, np.array([p.x, p.y]), np.array([p.vx, p.vy]))
            p.ax, p.ay = p.ax + ax, p.ay + ay
        except Exception as error:  # ctypes would print and forget it
            failed.append(error)

    sim.additional_forces = callback
    for t in times_s:
        sim.integrate(t)
        assert not failed, failed
        seen.append((p.x, p.y, p.vx, p.vy))
    return np.array(seen)


def drag_force(drag, scene, j, z, v, angle, rate):
    """Force on bar j, the page on drag written out."""
    length, u = scene.chain.length_m[j], np.array([math.cos(angle), math.sin(angle)])
    n, r = np.array([-u[1], u[0]]), math.hypot(*z)
    wind = v - drag.rotation_rad_s * np.array([-z[1], z[0]])
    across, along, w = n @ wind, u @ wind, rate - drag.rotation_rad_s
    kappa, second = u @ z / (r * drag.scale_height_m), length**3 / 12.0
    rho = drag.density_kg_m3 * math.exp(-(r - scene.central_body.radius_m - drag.altitude_m) / drag.scale_height_m)
    k = -0.5 * drag.width_m[j] * rho * math.copysign(1.0, across)
    normal = drag.normal_coefficient * (length * across**2 + second * w * w - 2.0 * kappa * second * across * w)
    return k * (normal * n + drag.tangential_coefficient * along * (length * across - kappa * second * w) * u)


def chain_push(scene, seen, every):
    """Drag on all bars and their tides over the mass, along an attitude seen at every `every`-th sample."""
    drag, chain, mu = scene.effects.drag, scene.chain, scene.central_body.mu_m3_s2
    knots = np.arange(0, len(seen.t_s), every)
    angle = CubicHermiteSpline(seen.t_s[knots], seen.angle_rad[knots], seen.rate_rad_s[knots])
    turning, share = angle.derivative(), np.array(chain.mass_kg) / scene.mass_kg

    def bar_centres(reach):
        from_first = np.concatenate([np.zeros((1, 2)), np.cumsum(reach[:-1] + reach[1:], axis=0)])
        return from_first - share @ from_first

    def push(t, z, v):
        theta, rate = angle(t), turning(t)
        half = 0.5 * np.array(chain.length_m)[:, None]
        d = bar_centres(half * np.stack([np.cos(theta), np.sin(theta)], axis=1))
        d_t = bar_centres(half * rate[:, None] * np.stack([-np.sin(theta), np.cos(theta)], axis=1))
        r2 = z @ z
        change = np.expm1(-1.5 * np.log1p(((2.0 * z + d) * d).sum(axis=1) / r2))[:, None]
        tide = share @ (-mu / r2**1.5 * (d * (1.0 + change) + z * change))
        bars = range(len(share))
        return tide + sum(drag_force(drag, scene, j, z + d[j], v + d_t[j], theta[j], rate[j]) for j in bars) / (
            scene.mass_kg
        )

    return push


@pytest.mark.exhaustive
def test_a_chains_track_in_thin_air_is_rebounds_under_the_same_force():
    """What is allowed: 16/15 of what every other sample of the attitude changes, round-off, the reference's own."""
    scene = load_scene("effects/drag")
    scene = lasting(scene, scene.run.duration_s, 401)
    solution, looser = (solutions.run(scene, rtol) for rtol in (1e-13, 1e-12))
    fine, coarse = (driven(scene, chain_push(scene, solution, n), solution.t_s[::80])[:, :2] for n in (1, 2))
    own = np.abs(solution.com_m - looser.com_m).max() + 1e-12 * scene.radius0_m
    allowed = 2.0 * np.abs(fine - coarse).max() + 2.0 * own
    still = Rebound().run(under(scene, drag=None)).com_m
    assert np.hypot(*(solution.com_m - still).T).max() > 1e6 * allowed  # drag is seen to six digits
    assert np.abs(solution.com_m[::80] - fine).max() < allowed


def broadside(density):
    """One bar held upright across its own circular motion, in air that does not turn."""
    scene = load_scene("basics/kepler_circular")
    chain = dataclasses.replace(
        scene.chain, length_m=(10.0,), mass_kg=(100.0,), inertia_kg_m2=(833.0,), angle_rad=(0.5 * math.pi,)
    )
    height = scene.orbit.altitude_m
    air = Drag(density, height, 45e3, 0.0, (0.5,), 2.2, 1.8)
    hold = PrescribedRotation(1, 0.0, 1.0, 0.0, Frame.LOCAL_HORIZONTAL, Actuator.EXTERNAL)
    scene = under(dataclasses.replace(scene, chain=chain), drag=air, prescribed_rotation=(hold,), gravity=Gravity.POINT)
    return lasting(scene, scene.period_s, 51)


def broadside_push(scene):
    """Its drag from its place and velocity alone: it turns with its longitude."""

    def push(_t, z, v):
        angle, rate = math.atan2(z[1], z[0]), (z[0] * v[1] - z[1] * v[0]) / (z @ z)
        return drag_force(scene.effects.drag, scene, 0, z, v, angle, rate) / scene.mass_kg

    return push


def semi_major_m(scene, place, velocity):
    return 1.0 / (2.0 / np.hypot(*place) - velocity @ velocity / scene.central_body.mu_m3_s2)


@pytest.mark.parametrize("density", one_in(2, [1e-13, 1e-12]))
def test_a_bar_broadside_to_thin_air_descends_by_the_closed_form(density):
    """da/dt = -2 D a/(m v): 4 pi a² (D/m v²) less in a revolution.

    Beyond the small-drag limit, a share of da/H (the air is thicker below) and a few da/a.
    """
    scene = broadside(density)
    r = scene.radius0_m
    falls = 4.0 * math.pi * r * r * 0.5 * 2.2 * 0.5 * 10.0 * density / 100.0
    found = driven(scene, broadside_push(scene), scene.times_s)
    start = initial_state(scene)
    before = semi_major_m(scene, start.com_m, start.com_velocity_m_s)
    reference = solutions.run(scene, TIGHT.value)
    own = 100.0 * EPS * r
    tracks = ((found[-1, :2], found[-1, 2:]), (reference.com_m[-1], reference.com_velocity_m_s[-1]))
    for place, velocity in tracks:
        after = semi_major_m(scene, place, velocity)
        assert before - after == pytest.approx(falls, abs=falls * (falls / 45e3 + 10.0 * falls / r) + own + 1e-12 * r)
    assert np.abs(reference.com_m - found[:, :2]).max() < round_off(scene, np.zeros(1)) + 1e-12 * r


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
