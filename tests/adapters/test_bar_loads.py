"""What acts on bars in plain floats, against the plain formulas of docs/effects in fifty digits."""

import dataclasses
import math

import mpmath as mp
import numpy as np
import pytest

from adapters.bar_loads.chain_loads import ChainLoads
from adapters.bar_loads.falling_frame import free_fall, orbit_noise
from adapters.bar_loads.forces import impulse_jumps, size_on_segment
from adapters.bar_loads.gravity import AbsoluteLoads, MovingLoads
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.bar_loads.joint_tree import tree_positions, tree_rates
from adapters.common.initial_state import initial_state
from adapters.common.joint_coordinates import from_joint_coordinates
from adapters.common.step_alignment import events_by_step, inner_events_s, misalignment
from scenarios import Axes, End, Gravity, Impulse, Thrust, load_scene
from tests.support.slow import one_in

mp.mp.dps = 50
EPS = np.finfo(float).eps
ROUNDINGS = 64.0  # a load is some thirty operations, several of which count twice or five times (powers)
SIZES = [1e5, 1e2, 1.0, 1e-2]


def scene_of(name, gravity, size, bars=3):
    """Scene `effects/name` with unequal bars of `size` m."""
    scene = load_scene(f"effects/{name}")
    mass, length = (70.0, 20.0, 110.0)[:bars], tuple(size * f for f in (0.4, 1.0, 0.7))[:bars]
    chain = dataclasses.replace(
        scene.chain,
        mass_kg=mass,
        length_m=length,
        inertia_kg_m2=tuple(m * a * a / 12.0 for m, a in zip(mass, length, strict=True)),
        angle_rad=(1.0, 0.3, -2.0)[:bars],
        rate_factor=(1.0, -2.0, 0.5)[:bars],
    )
    return dataclasses.replace(scene, chain=chain, effects=dataclasses.replace(scene.effects, gravity=Gravity(gravity)))


def state(size, seed=3):
    """Frame and bars in no particular state."""
    rng = np.random.default_rng(seed)
    r, longitude = 7.1e6, rng.uniform(-3.0, 3.0)
    here = FrameState(r * math.cos(longitude), r * math.sin(longitude), 3100.0, -6900.0, 1234.5, 1234.0)
    spots = [(*rng.uniform(-size, size, 2).tolist(), float(rng.uniform(-3.0, 3.0))) for _ in range(3)]
    rates = [(*rng.uniform(-1e-3 * size, 1e-3 * size, 2).tolist(), float(rng.uniform(-3e-3, 3e-3))) for _ in range(3)]
    return here, spots, rates


def loads_of(scene, here, spots, rates, *, free_falling=True):
    gravity = (MovingLoads if free_falling else AbsoluteLoads)(scene, surface=False)
    return ChainLoads(scene, gravity, falling=free_falling)(here, spots, rates)


def attraction(strength, power, z):
    return -strength * z / abs(z) ** power


def moment(strength, power, z, u, spread):
    """Acceleration by a bar's second moment and angular acceleration, by the formulas of oblateness.md."""
    p, q, r = (z * mp.conj(u)).real, (z * mp.conj(u)).imag, abs(z)
    k = power * strength * spread / (2 * r ** (power + 2))
    return k * (z + 2 * p * u - (power + 2) * (p / r) ** 2 * z), power * strength * p * q / r ** (power + 2)


def slender_by_quadrature(mu, z, u, length):
    h = mp.mpf(length) / 2
    field = lambda s: -mu * (z + s * u) / abs(z + s * u) ** 3  # noqa: E731
    force = mp.quad(field, [-h, 0, h]) / length
    torque = mp.quad(lambda s: s * (field(s) * mp.conj(u)).imag, [-h, 0, h])
    return force, torque * 12 / mp.mpf(length) ** 3  # over m l²/12, with m/l under the integral


def exact(scene, here, spot, bar, *, free_falling):
    """Acceleration and angular acceleration of one bar by all fields, in fifty digits."""
    effects, mu = scene.effects, mp.mpf(scene.central_body.mu_m3_s2)
    origin = mp.mpc(here.x, here.y)
    z = origin + mp.mpc(spot[0], spot[1])
    u = mp.expj(mp.mpf(spot[2]))
    length, m = scene.chain.length_m[bar], mp.mpf(scene.chain.mass_kg[bar])
    spread = scene.chain.inertia_kg_m2[bar] / m
    sources = [(mu, 3, mp.mpc(0))]
    if effects.oblateness:
        j2 = effects.oblateness
        sources.append((mp.mpf(3) / 2 * mu * mp.mpf(j2.j2) * mp.mpf(j2.radius_m) ** 2, 5, mp.mpc(0)))
    for b in effects.third_body:
        x = mp.mpf(b.distance_m) * mp.expj(mp.mpf(b.longitude_rad) + mp.mpf(b.rate_rad_s) * mp.mpf(here.t_s))
        sources.append((mp.mpf(b.mu_m3_s2), 3, x))
    pull, spin = mp.mpc(0), mp.mpf(0)
    for i, (strength, power, x) in enumerate(sources):
        pull += attraction(strength, power, z - x)
        if free_falling:
            pull -= attraction(strength, power, origin - x)
        elif x:
            pull -= attraction(strength, power, -x)
        if effects.gravity.turns and not (i == 0 and effects.gravity is Gravity.SLENDER):
            more, turn = moment(strength, power, z - x, u, spread)
            spin += turn
            pull += more if effects.gravity is not Gravity.GRADIENT else 0
    if effects.gravity is Gravity.SLENDER:
        force, turn = slender_by_quadrature(mu, z, u, length)
        pull, spin = pull + force - attraction(mu, 3, z), spin + turn
    return pull, spin


@pytest.mark.parametrize("size", one_in(2, SIZES))
@pytest.mark.parametrize("name", ["oblateness", "third_body", "slender"])
@pytest.mark.parametrize("gravity", ["point", "gradient", "quadrupole", "slender"])
def test_fields_are_the_inertial_formulas_differences_to_round_off(name, gravity, size):
    scene = scene_of(name, gravity, size)
    here, spots, rates = state(size)
    found = loads_of(scene, here, spots, rates)
    solution = [exact(scene, here, spot, j, free_falling=True) for j, spot in enumerate(spots)]
    scale, turning = max(abs(a) for a, _ in solution), max(abs(w) for _, w in solution)
    for (ax, ay, spin), (a, w) in zip(found, solution, strict=True):
        assert abs(mp.mpc(ax, ay) - a) < ROUNDINGS * EPS * scale
        assert abs(spin - w) <= ROUNDINGS * EPS * turning


@pytest.mark.parametrize("name", ["oblateness", "third_body", "slender"])
def test_fields_from_the_centre_are_whole(name):
    scene = scene_of(name, "slender", 100.0)
    here, spots, rates = state(100.0)
    far = [(here.x + x, here.y + y, a) for x, y, a in spots]
    found = loads_of(scene, FrameState(0.0, 0.0, 0.0, 0.0, here.t_s), far, rates, free_falling=False)
    for j, (ax, ay, _) in enumerate(found):
        a, _ = exact(scene, FrameState(0.0, 0.0, 0.0, 0.0, here.t_s), far[j], j, free_falling=False)
        assert abs(mp.mpc(ax, ay) - a) < ROUNDINGS * EPS * abs(a)


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-6])
def test_what_a_short_slender_bar_feels_beyond_a_point_keeps_all_digits(size):
    from adapters.bar_loads.fields import slender

    mu, z, u = mp.mpf("3.986004418e14"), mp.mpc(6.1e6, 2.3e6), mp.expj(mp.mpf(0.7))
    ax, ay, spin = slender(float(mu), 6.1e6, 2.3e6, 0.7, 0.5 * size)
    force, turn = slender_by_quadrature(mu, z, u, size)
    beyond = force - attraction(mu, 3, z)
    assert abs(mp.mpc(ax, ay) - beyond) < ROUNDINGS * EPS * abs(beyond)
    assert abs(spin - turn) < ROUNDINGS * EPS * abs(turn)


def test_drag_is_the_integral_along_the_bar():
    scene = scene_of("drag", "none", 80.0)
    scene = dataclasses.replace(
        scene,
        effects=dataclasses.replace(
            scene.effects, drag=dataclasses.replace(scene.effects.drag, width_m=(0.1, 0.3, 0.2), altitude_m=7e5)
        ),
    )
    here, spots, rates = state(80.0)
    drag, found = scene.effects.drag, loads_of(scene, here, spots, rates)
    for j, ((x, y, a), (vx, vy, w)) in enumerate(zip(spots, rates, strict=True)):
        z, u = mp.mpc(here.x, here.y) + mp.mpc(x, y), mp.expj(mp.mpf(a))
        wind = (mp.mpc(here.vx, here.vy) + mp.mpc(vx, vy) - 1j * mp.mpf(drag.rotation_rad_s) * z) * mp.conj(u)
        t, v, turn = wind.real, wind.imag, mp.mpf(w) - mp.mpf(drag.rotation_rad_s)
        higher = abs(z) - mp.mpf(scene.central_body.radius_m) - mp.mpf(drag.altitude_m)
        density = drag.density_kg_m3 * mp.exp(-higher / drag.scale_height_m)
        kappa = (z * mp.conj(u)).real / (abs(z) * drag.scale_height_m)

        def push(s, across=v, along=t, turn=turn, kappa=kappa):
            speed = across + s * turn
            k = -(1 - kappa * s) * mp.sign(across) * speed
            return k * mp.mpc(drag.tangential_coefficient * along, drag.normal_coefficient * speed)

        h = mp.mpf(scene.chain.length_m[j]) / 2
        scale = density * drag.width_m[j] / 2
        force, torque = scale * mp.quad(push, [-h, h]) * u, scale * mp.quad(lambda s: s * push(s).imag, [-h, h])
        ax, ay, spin = found[j]
        # distances are rounded before they are divided by the scale height
        lost = ROUNDINGS * EPS * abs(z) / drag.scale_height_m
        assert abs(mp.mpc(ax, ay) * scene.chain.mass_kg[j] - force) < lost * abs(force)
        assert abs(spin * scene.chain.inertia_kg_m2[j] - torque) < 2.0 * lost * abs(torque) / abs(
            torque / (scale * v * v * h * h * mp.mpf(1e-4))
        ) + lost * abs(torque)


def test_sunlight_is_the_momentum_of_what_is_absorbed_and_mirrored():
    scene = scene_of("solar_pressure", "none", 50.0)
    here, spots, rates = state(50.0)
    light, found = scene.effects.solar_pressure, loads_of(scene, here, spots, rates)
    longitude = light.sun_longitude_rad + light.sun_rate_rad_s * here.t_s
    sun = np.array([math.cos(longitude), math.sin(longitude)])
    for j, (_, _, a) in enumerate(spots):
        across = np.array([-math.sin(a), math.cos(a)])
        k = abs(across @ sun)
        facing = across if across @ sun > 0 else -across
        size = light.pressure_Pa * light.width_m[j] * scene.chain.length_m[j] * k
        force = -size * ((1.0 - light.reflectivity) * sun + 2.0 * light.reflectivity * k * facing)
        np.testing.assert_allclose(np.array(found[j][:2]) * scene.chain.mass_kg[j], force, rtol=ROUNDINGS * EPS)
        assert found[j][2] == 0.0


def test_springs_turn_bars_against_each_other_and_dampers_only_take():
    scene = dataclasses.replace(load_scene("effects/joint_springs"))
    scene = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, gravity=Gravity.NONE))
    rng = np.random.default_rng(5)
    angle, rate = rng.uniform(-3, 3, 4), rng.uniform(-1e-2, 1e-2, 4)
    spots, rates = [(0.0, 0.0, a) for a in angle.tolist()], [(0.0, 0.0, w) for w in rate.tolist()]
    found = loads_of(scene, FrameState(7e6, 0.0), spots, rates)
    torque = np.array([load[2] for load in found]) * np.array(scene.chain.inertia_kg_m2)
    s = scene.effects.joint_spring_damper
    k, c, rest = map(np.array, (s.stiffness_N_m_rad, s.damping_N_m_s_rad, s.rest_rad))
    bend, bending = np.diff(angle), np.diff(rate)
    assert abs(torque.sum()) < ROUNDINGS * EPS * np.abs(torque).max()
    power = -(k * (bend - rest) * bending).sum() - (c * bending**2).sum()
    assert torque @ rate == pytest.approx(power, rel=ROUNDINGS * EPS)
    assert all(load[:2] == (0.0, 0.0) for load in found)


def test_a_thrust_pushes_and_turns_its_bar_only():
    scene = load_scene("effects/thrust")
    scene = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, gravity=Gravity.NONE))
    here = FrameState(7e6, 0.0, 0.0, 0.0, 100.0, 100.5)
    spots = [(0.0, 0.0, 0.4), (0.0, 0.0, -1.1), (0.0, 0.0, 2.2)]
    found, chain = loads_of(scene, here, spots, []), scene.chain
    assert found[1] == (0.0, 0.0, 0.0)
    for load, j, aim, end in ((found[2], 2, 2.2 + math.radians(30), 1.0), (found[0], 0, math.radians(120), -1.0)):
        size = {2: 0.01, 0: 0.005}[j]
        force = size * np.array([math.cos(aim), math.sin(aim)])
        assert np.array(load[:2]) * chain.mass_kg[j] == pytest.approx(force, rel=ROUNDINGS * EPS)
        torque = end * 0.5 * chain.length_m[j] * size * math.sin(aim - spots[j][2])
        assert load[2] * chain.inertia_kg_m2[j] == pytest.approx(torque, rel=ROUNDINGS * EPS)


def test_a_thrusts_size_at_a_jump_is_that_of_the_side_meant():
    thrust = Thrust(1, End.RIGHT, Axes.BODY, 0.0, (10.0, 20.0, 40.0), (1.0, 3.0, 5.0))
    assert size_on_segment(thrust, 10.0, 9.0) == 0.0
    assert size_on_segment(thrust, 10.0, 11.0) == 1.0
    assert size_on_segment(thrust, 20.0, 19.0) == size_on_segment(thrust, 20.0, 21.0) == 3.0
    assert size_on_segment(thrust, 40.0, 39.0) == 5.0
    assert size_on_segment(thrust, 40.0, 41.0) == 0.0
    assert size_on_segment(thrust, 15.0, 15.0) == 2.0


def test_blows_at_one_instant_add():
    bars = bars_of(load_scene("effects/impulse").chain)
    one = Impulse(1, End.LEFT, Axes.INERTIAL, 0.5, 4.0, 0.0)
    single, double = impulse_jumps(bars, [one], [0.1] * 4), impulse_jumps(bars, [one, one], [0.1] * 4)
    assert np.array(double) == pytest.approx(2.0 * np.array(single))
    assert single[0][2] == pytest.approx(-bars[0].half_length_m * 4.0 * math.sin(0.5 - 0.1) / bars[0].inertia_kg_m2)
    assert single[1:] == [(0.0, 0.0, 0.0)] * 3


def test_a_tree_in_plain_floats_is_the_tree():
    scene = load_scene("effects/drag")
    rng = np.random.default_rng(1)
    q, q_t = rng.uniform(-2, 2, 6), rng.uniform(-2, 2, 6)
    bars, length = bars_of(scene.chain), np.array(scene.chain.length_m)
    spots, rates = list(tree_positions(q.tolist(), bars)), list(tree_rates(q.tolist(), q_t.tolist(), bars))
    close = {"atol": ROUNDINGS * EPS * scene.size_m, "rtol": 0.0}
    bars_in_frame = from_joint_coordinates(length, q[None], q_t[None])
    np.testing.assert_allclose(np.array(spots)[:, :2], bars_in_frame.position_m[0], **close)
    np.testing.assert_allclose(np.array(rates)[:, :2], bars_in_frame.velocity_m_s[0], **close)
    np.testing.assert_allclose([w for *_, w in rates], np.cumsum(q_t[2:]))


def test_the_frame_about_a_flattened_body_keeps_energy_inside_its_declared_noise():
    scene = load_scene("effects/oblateness")
    t_s, start = scene.times_s, initial_state(scene)
    position, drift = free_fall(scene, start, t_s)
    r, speed = np.linalg.norm(position, axis=1), np.linalg.norm(drift, axis=1)
    mu, j2, noise = scene.central_body.mu_m3_s2, scene.effects.oblateness, orbit_noise(scene, t_s)
    energy = 0.5 * speed**2 - mu / r - 0.5 * mu * j2.j2 * j2.radius_m**2 / r**3
    assert np.all(np.abs(energy - energy[0]) <= noise["com"] * mu / r**2 + noise["com_velocity"] * speed)
    assert np.array_equal(position[0], start.com_m)
    assert np.array_equal(drift[0], start.com_velocity_m_s)


@pytest.mark.parametrize("name", ["oblateness", "third_body"])
def test_the_frame_falls_with_the_plain_inertial_fields(name):
    """Its second difference over three instants is the field there, to the step's square."""
    scene = load_scene(f"effects/{name}")
    position, _ = free_fall(scene, initial_state(scene), np.array([0.0, 980.0, 1000.0, 1020.0]))
    gained = (position[1] - 2.0 * position[2] + position[3]) / 20.0**2
    effects = dataclasses.replace(scene.effects, gravity=Gravity.POINT)
    plain, here = dataclasses.replace(scene, effects=effects), FrameState(0.0, 0.0, 0.0, 0.0, 1000.0)
    field, _ = exact(plain, here, (*position[2].tolist(), 0.0), 0, free_falling=False)
    n = scene.orbital_rate_rad_s  # fourth derivative n^4 r, over 12; and the rounding of three places
    rounded = 4.0 * orbit_noise(scene, np.array([1020.0]))["com"][0] / 20.0**2
    allowed = 2.0 * n**4 * scene.radius0_m * 20.0**2 / 12.0 + rounded
    assert abs(mp.mpc(*gained.tolist()) - field) < allowed
    beside = field - attraction(mp.mpf(scene.central_body.mu_m3_s2), 3, mp.mpc(*position[2].tolist()))
    assert allowed < 0.1 * abs(beside)


def test_events_coincide_with_ends_of_steps_or_are_rejected():
    scene = load_scene("effects/thrust_table")
    assert misalignment(scene) is None
    assert events_by_step(scene, 2.5) == {round(t / 2.5): () for t in (105.0, 295.0, 405.0, 605.0, 815.0, 1105.0)}
    assert inner_events_s(load_scene("effects/thrust")) == []
    off = dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=2001.0))
    assert "midway between two" in misalignment(off)
    struck = load_scene("effects/impulse")
    assert [len(found) for found in events_by_step(struck, 1.25).values()] == [1, 1]
