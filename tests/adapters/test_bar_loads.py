"""What acts on bars in plain floats, against the plain formulas of docs/effects in fifty digits."""

import dataclasses
import math

import mpmath as mp
import numpy as np
import pytest

from adapters.bar_loads.chain_loads import ChainLoads
from adapters.bar_loads.falling_frame import free_fall, orbit_noise
from adapters.bar_loads.fields import slender
from adapters.bar_loads.forces import impulse_jumps, size_on_segment
from adapters.bar_loads.gravity import AbsoluteLoads, MovingLoads
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.bar_loads.joint_tree import tree_positions, tree_rates
from adapters.common.initial_state import initial_state
from adapters.common.joint_coordinates import from_joint_coordinates
from adapters.common.step_alignment import events_by_step, inner_events_s, misalignment
from scenarios import Axes, End, Gravity, Impulse, Thrust, load_scene
from tests.adapters.exact_loads import exact_accelerations, exact_bar, exact_effects, point_pull
from tests.support.changed import lasting, under, with_chain
from tests.support.generic_scenes import of_bars
from tests.support.slow import one_in

EPS = np.finfo(float).eps
ROUNDINGS = 64.0  # a load is some thirty operations, several of which count twice or five times (powers)
SIZES = [1e5, 1e2, 1.0, 1e-2]


@pytest.fixture(autouse=True)
def fifty_digits():
    with mp.workdps(50):
        yield


def scene_of(name, gravity, size):
    """Scene `effects/name` with three unequal bars of `size` m."""
    scene = load_scene(f"effects/{name}")
    mass, length = (70.0, 20.0, 110.0), tuple(size * f for f in (0.4, 1.0, 0.7))
    scene = with_chain(
        scene,
        mass_kg=mass,
        length_m=length,
        inertia_kg_m2=tuple(m * a * a / 12.0 for m, a in zip(mass, length, strict=True)),
        angle_rad=(1.0, 0.3, -2.0),
        rate_factor=(1.0, -2.0, 0.5),
    )
    return under(scene, gravity=Gravity(gravity))


def state(size, bars=3):
    """Frame and bars in no particular state."""
    rng = np.random.default_rng(3)
    r, longitude = 7.1e6, rng.uniform(-3.0, 3.0)
    here = FrameState(r * math.cos(longitude), r * math.sin(longitude), 3100.0, -6900.0, 612.5, 612.0)
    spots = [(*rng.uniform(-size, size, 2).tolist(), float(rng.uniform(-3.0, 3.0))) for _ in range(bars)]
    fast = 1e-3 * size
    rates = [(*rng.uniform(-fast, fast, 2).tolist(), float(rng.uniform(-3e-3, 3e-3))) for _ in range(bars)]
    return here, spots, rates


def loads_of(scene, here, spots, rates, *, free_falling=True):
    gravity = (MovingLoads if free_falling else AbsoluteLoads)(scene, surface=False)
    return ChainLoads(scene, gravity, falling=free_falling)(here, spots, rates)


def exact(scene, here, spots, rates, *, free_falling=True):
    """Accelerations and angular accelerations of the bars; those of a falling frame are less its origin's fall."""
    origin, drift = mp.mpc(here.x, here.y), mp.mpc(here.vx, here.vy)
    bars = [
        exact_bar(scene, j, origin + mp.mpc(x, y), drift + mp.mpc(vx, vy), angle, rate)
        for j, ((x, y, angle), (vx, vy, rate)) in enumerate(zip(spots, rates, strict=True))
    ]
    falls = free_falling and scene.effects.gravity is not Gravity.NONE
    fall = fall_of(scene, origin, here.t_s) if falls else 0
    found = [exact_accelerations(scene, bars, j, here.t_s) for j in range(scene.bars)]
    return [(pull - fall, spin) for pull, spin in found]


def fall_of(scene, place, t_s):
    """Acceleration of a point by all fields."""
    point = under(scene, gravity=Gravity.POINT)
    return exact_accelerations(point, [exact_bar(point, 0, place, 0, 0, 0)], 0, t_s)[0]


@pytest.mark.parametrize("size", one_in(2, SIZES))
@pytest.mark.parametrize("name", ["oblateness", "third_body", "slender"])
@pytest.mark.parametrize("gravity", ["point", "gradient", "quadrupole", "slender"])
def test_fields_are_the_inertial_fields_differences_to_round_off(name, gravity, size):
    scene = scene_of(name, gravity, size)
    here, spots, rates = state(size)
    found = loads_of(scene, here, spots, rates)
    solution = exact(scene, here, spots, rates)
    scale, turning = max(abs(a) for a, _ in solution), max(abs(w) for _, w in solution)
    for (ax, ay, spin), (a, w) in zip(found, solution, strict=True):
        assert abs(mp.mpc(ax, ay) - a) < ROUNDINGS * EPS * scale
        assert abs(spin - w) <= ROUNDINGS * EPS * turning


@pytest.mark.parametrize("name", ["oblateness", "third_body", "slender"])
def test_fields_from_the_centre_are_whole(name):
    scene = scene_of(name, "slender", 100.0)
    here, spots, rates = state(100.0)
    far = [(here.x + x, here.y + y, a) for x, y, a in spots]
    still = FrameState(0.0, 0.0, 0.0, 0.0, here.t_s)
    found = loads_of(scene, still, far, rates, free_falling=False)
    for (ax, ay, _), (a, _) in zip(found, exact(scene, still, far, rates, free_falling=False), strict=True):
        assert abs(mp.mpc(ax, ay) - a) < ROUNDINGS * EPS * abs(a)


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-6])
def test_what_a_short_slender_bar_feels_beyond_a_point_keeps_all_digits(size):
    scene = of_bars(scene_of("slender", "slender", size / 0.4), 1)
    ax, ay, spin = slender(scene.central_body.mu_m3_s2, 6.1e6, 2.3e6, 0.7, 0.5 * scene.chain.length_m[0])
    beyond, turn = exact_effects(scene, [exact_bar(scene, 0, mp.mpc(6.1e6, 2.3e6), 0, 0.7, 0)], 0, 0.0)
    assert abs(mp.mpc(ax, ay) - beyond) < ROUNDINGS * EPS * abs(beyond)
    assert abs(spin - turn) < ROUNDINGS * EPS * abs(turn)


def without_gravity(name):
    """Scene `effects/name` of its own bars without gravity, in air that is thick at the place of :func:`state`."""
    scene = under(load_scene(f"effects/{name}"), gravity=Gravity.NONE)
    drag = scene.effects.drag
    return under(scene, drag=dataclasses.replace(drag, altitude_m=7e5)) if drag else scene


@pytest.mark.parametrize("name", ["drag", "solar_pressure", "thrust", "joint_springs"])
def test_what_pushes_a_bar_is_the_sum_over_its_elements(name):
    scene = without_gravity(name)
    here, spots, rates = state(80.0, bars=scene.bars)
    found, right = loads_of(scene, here, spots, rates), exact(scene, here, spots, rates)
    for j, ((ax, ay, spin), (a, w)) in enumerate(zip(found, right, strict=True)):
        lost, lever = ROUNDINGS * EPS, 0.0
        if name == "drag":
            # distances are rounded before they are divided by the scale height
            lost *= math.hypot(here.x, here.y) / scene.effects.drag.scale_height_m
            # torques are differences of those on both halves: their arms are a quarter of the bar
            across = abs((a * mp.expj(-spots[j][2])).imag) * scene.chain.mass_kg[j] / scene.chain.inertia_kg_m2[j]
            lever = 1e-4 * across * 0.5 * scene.chain.length_m[j] / scene.effects.drag.normal_coefficient
        if name == "joint_springs":
            lever = max(abs(turn) for _, turn in right)  # neighbouring joints' torques are subtracted
        assert abs(mp.mpc(ax, ay) - a) <= lost * abs(a)
        assert abs(spin - w) <= lost * (abs(w) + lever)


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
    place = mp.mpc(*position[2].tolist())
    field = fall_of(scene, place, 1000.0)
    n = scene.orbital_rate_rad_s  # fourth derivative n^4 r, over 12; and the rounding of three places
    rounded = 4.0 * orbit_noise(scene, np.array([1020.0]))["com"][0] / 20.0**2
    allowed = 2.0 * n**4 * scene.radius0_m * 20.0**2 / 12.0 + rounded
    assert abs(mp.mpc(*gained.tolist()) - field) < allowed
    assert allowed < 0.1 * abs(field - point_pull(scene.central_body.mu_m3_s2, place))


def test_events_coincide_with_ends_of_steps_or_are_rejected():
    scene = load_scene("effects/thrust_table")
    assert misalignment(scene) is None
    assert events_by_step(scene, 2.5) == {round(t / 2.5): () for t in (105.0, 295.0, 405.0, 605.0, 815.0, 1105.0)}
    assert inner_events_s(load_scene("effects/thrust")) == []
    assert "midway between two" in misalignment(lasting(scene, 2001.0))
    struck = load_scene("effects/impulse")
    assert [len(found) for found in events_by_step(struck, 1.25).values()] == [1, 1]
