"""Effects against closed forms and limits, in runs of the NumPy reference; tolerances by `effect_runs.budget`."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.effects.thrust import ThrustEffect
from reference_impl.integrate.discrete_modes import DiscreteModes
from reference_impl.model.arrays import Array
from reference_impl.model.chain import BarTurn, ChainModel, Prescription
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.relative import accelerations
from reference_impl.model.state import State
from scenarios import load_scene
from tests.effects.effect_runs import (
    RTOL,
    angular_momentum,
    at_sample,
    budget,
    fastest,
    momentum_allowed,
    placed,
    ran,
)
from tests.support.effect_cases import J2, MU, RADIUS, vectors
from tests.support.joint_roundoff import Case, forward, joint_bound
from tests.support.radial_chain import first_moments, radial_tension
from tests.support.slow import one_in


def uniform(bars: int, length_m: float = 100.0, gravity: str = "point", mass_kg: float = 100.0) -> ChainModel:
    """Equal slender bars."""
    one = np.ones(bars)
    return ChainModel(MU, mass_kg * one, length_m * one, mass_kg * length_m**2 / 12.0 * one, gravity)


def circular(model: ChainModel, r_m: float, angle_rad: float = 0.0, speed_m_s: float | None = None) -> State:
    """All bars at one angle, turning with the orbit."""
    v = math.sqrt(MU / r_m) if speed_m_s is None else speed_m_s
    return placed(model, r_m, v, np.full(model.bars, angle_rad), np.full(model.bars, v / r_m))


# oblateness


@pytest.mark.parametrize("j2", [J2, 0.1])
def test_an_orbit_at_the_oblate_bodys_circular_speed_keeps_its_radius(j2: float) -> None:
    """v² = mu/r (1 + (3/2) J2 (R/r)²); a speed's error of one part raises the far side by four."""
    r, lone = 7e6, uniform(1, 1e-3)
    model = replace(lone, effects=(OblatenessEffect(0.5 * MU * j2 * RADIUS**2, turns=False, second_moment=False),))
    speed = math.sqrt(MU / r * (1.0 + 1.5 * j2 * (RADIUS / r) ** 2))
    h = ran(model, circular(model, r, speed_m_s=speed), np.linspace(0.0, 6000.0, 13))
    allowed = 4.0 * budget(h, speed / r)
    assert np.abs(np.linalg.norm(h.com_m, axis=1) / r - 1.0).max() <= allowed
    longitude = np.unwrap(np.arctan2(h.com_m[:, 1], h.com_m[:, 0]))
    assert np.abs(longitude - speed / r * h.t_s).max() <= 3.0 * allowed


# third body


def test_without_the_central_bodys_pull_a_bar_goes_round_the_third_body() -> None:
    """Both go round it: Z = X + Y with two uniform circular motions, each of its own Kepler rate."""
    mu, distance, near = MU, 4e7, 3e7
    outer, inner = math.sqrt(mu / distance**3), math.sqrt(mu / near**3)
    body = ThirdBodyEffect(mu, distance, 0.3, outer, turns=False, second_moment=False)
    model = replace(uniform(1, 1e-3, "none"), effects=(body,))

    def exact(t: Array) -> Array:
        return distance * np.exp(1j * (0.3 + outer * t)) + near * np.exp(1j * (2.0 + inner * t))

    def drift(t: float) -> complex:
        return 1j * (outer * distance * np.exp(1j * (0.3 + outer * t)) + inner * near * np.exp(1j * (2.0 + inner * t)))

    start, speed = vectors(exact(np.zeros(1)))[0], vectors(np.array([drift(0.0)]))[0]
    state = consistent_state(model, start, speed, np.zeros(1), np.zeros(1))
    t = np.linspace(0.0, 1.5 * np.pi / inner, 13)
    h = ran(model, state, t)
    # a speed off by rtol (in units of the far start's) lengthens the near orbit by 2, and its phase by 3 n t of that
    unit = max(1.0, np.linalg.norm(start) / near)
    allowed = h.steps * RTOL * unit * 2.0 * (1.0 + 3.0 * inner * t[-1]) * np.linalg.norm(start)
    assert np.abs(h.com_m[:, 0] + 1j * h.com_m[:, 1] - exact(t)).max() <= allowed


# drag


def test_a_bar_held_broadside_makes_a_circular_orbit_decay_at_the_rate_of_its_drag() -> None:
    """da/dt = -2 F a/(m v), F = (b/2) rho C_n (l v² + I n² - 2 I v n/H); higher orders in rho by Richardson."""
    span, lost, height = 5400.0, [], RADIUS + 250e3  # in air that does not turn
    held = Prescription(0, (BarTurn(0.0, 60.0, 0.0),), frame="local_horizontal", reacts_on=None)
    for share in (1.0, 0.5, 0.25):
        air = DragEffect(1e-11 * share, height, 45e3, 0.0, np.array([0.1]), 2.2, 1.8)
        model = replace(uniform(1), prescriptions=(held,), effects=(air,))
        state = circular(model, height)
        h = ran(model, state, np.array([0.0, span]), rtol=1e-13)
        r, v2 = np.linalg.norm(h.com_m, axis=1), np.sum(h.com_velocity_m_s**2, axis=1)
        a = 1.0 / (2.0 / r - v2 / MU)
        lost.append((a[1] - a[0]) / share)
        noise = 4.0 * h.steps * 1e-13 * r[0] / share
    r, n = RADIUS + 250e3, math.sqrt(MU / (RADIUS + 250e3) ** 3)
    v, inertia = n * r, 100.0**3 / 12.0
    force = 0.05 * 1e-11 * 2.2 * (100.0 * v**2 + inertia * n**2 - 2.0 * inertia * v * n / 45e3)
    exact = -2.0 * force * r / (100.0 * v) * span
    once = [2.0 * fine - coarse for coarse, fine in itertools.pairwise(lost)]
    limit = (4.0 * once[1] - once[0]) / 3.0
    # the third order left is smaller than the second, which is what the last extrapolation took off
    assert abs(limit - exact) <= 8.0 * noise + abs(limit - once[1])
    assert abs(limit / exact - 1.0) < 1e-5
    assert abs(lost[0] / exact - 1.0) > 1e-4


# light


def test_light_on_a_bar_in_free_space_makes_a_parabola() -> None:
    light = SolarPressureEffect(1e-3, 0.7, 0.0, np.array([2.0]), 0.3, 0.0)
    model = replace(uniform(1, gravity="none"), effects=(light,))
    state = placed(model, 7e6, 10.0, np.array([0.2]), np.zeros(1))
    h = ran(model, state, np.linspace(0.0, 3000.0, 7))
    facing = math.sin(0.7 - 0.2)  # n·s
    sun, normal = np.exp(0.7j), 1j * np.exp(0.2j)
    a = -1e-3 * 2.0 * 100.0 * facing / 100.0 * (0.7 * sun + 2.0 * 0.3 * facing * normal)
    exact = 7e6 + 10j * h.t_s + 0.5 * a * h.t_s**2
    allowed = budget(h, math.sqrt(MU / 7e6**3)) * 7e6
    assert np.abs(h.com_m[:, 0] + 1j * h.com_m[:, 1] - exact).max() <= allowed
    assert np.array_equal(h.angle_rad, np.full((7, 1), 0.2))


@pytest.mark.parametrize(("height_m", "rtol"), [(3e5, 1e-11), (3.6e7, 1e-6), (4e8, 1e-4)])
def test_a_circular_orbit_enters_and_leaves_the_shadow_where_its_sine_is_r_over_r(
    height_m: float, rtol: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Longitudes pi -+ arcsin(R/r) from the Sun's; light too weak to move anything; one bar that never faces about.

    Nothing but the shadow divides the orbit's long steps.
    """
    found: list[float] = []
    plain = DiscreteModes.apply_event

    def noted(self, exact, t, step):
        met = plain(self, exact, t, step)
        found.append(met[0])
        return met

    monkeypatch.setattr(DiscreteModes, "apply_event", noted)
    r, rate = RADIUS + height_m, 2e-7
    light = SolarPressureEffect(1e-20, 0.7, rate, np.array([1.0]), 0.0, RADIUS)
    model = replace(uniform(1), effects=(light,))
    n = math.sqrt(MU / r**3)
    state = replace(circular(model, r, 2.0), rate_rad_s=np.zeros(1))
    h = ran(model, state, np.linspace(0.0, 2.0 * np.pi / n, 5), rtol=rtol)
    half = math.asin(RADIUS / r)
    exact = [(0.7 + math.pi - half) / (n - rate), (0.7 + math.pi + half) / (n - rate)]
    # a phase's error by the budget, three times by the speed; the grazing angle makes 1/cos(half) of a radius' error
    allowed = 3.0 * budget(h, n, rtol) * (1.0 + math.tan(half)) / n
    assert len(found) == 2
    assert np.abs(np.array(found) - exact).max() <= allowed


# springs and dampers


def hinged(stiffness: float, damping: float) -> ChainModel:
    """Two unequal bars in free space, with a spring and a damper at their joint."""
    mass, length = np.array([30.0, 70.0]), np.array([2.0, 3.0])
    effect = JointSpringDamperEffect(np.array([stiffness]), np.array([damping]), np.zeros(1))
    return ChainModel(MU, mass, length, mass * length**2 / 12.0, "none", effects=(effect,))


def hinge_inertia(model: ChainModel) -> tuple[float, float]:
    """(AB - C²)/(A + B + 2C) of the straight pair at no angular momentum, and the change of ln of it by that of C."""
    m, half = model.mass_kg, model.half_m
    reduced = m[0] * m[1] / m.sum()
    a, b = model.inertia_kg_m2 + reduced * half**2
    c = reduced * half[0] * half[1]
    steep = 2.0 * c * c / (a * b - c * c) + 2.0 * c / (a + b + 2.0 * c)
    return (a * b - c * c) / (a + b + 2.0 * c), steep


@pytest.mark.parametrize(("bend", "damping"), [(1e-3, 0.0), (1e-2, 1.5)])
def test_a_sprung_hinge_swings_at_the_root_of_k_over_its_inertia_and_decays_by_c(bend: float, damping: float) -> None:
    """At a bend g, J(g) is that of the straight pair within bend²/2 x its slope: so are the phase and the decay."""
    model = hinged(200.0, damping)
    inertia, steep = hinge_inertia(model)
    decay = damping / (2.0 * inertia)
    rate = math.sqrt(200.0 / inertia - decay**2)
    state = placed(model, 7e6, 0.0, np.array([0.0, bend]), np.zeros(2))
    h = ran(model, state, np.linspace(0.0, 3.0 * 2.0 * np.pi / rate, 31))
    opened, t = h.angle_rad[:, 1] - h.angle_rad[:, 0], h.t_s
    exact = bend * np.exp(-decay * t) * (np.cos(rate * t) + decay / rate * np.sin(rate * t))
    off = 0.5 * bend**2 * steep * (1.0 + (rate + decay) * t[-1]) * bend
    noise = h.steps * RTOL * 2.0 * 2.0  # two bars, an angle and a rate each: both in units of one swing
    assert np.abs(opened - exact).max() <= off + noise
    assert decay == 0.0 or abs(opened[-1]) < 0.8 * bend


# thrust

TABLE = np.array([3.0, 11.0, 17.0, 40.0]), np.array([4.0, 20.0, 20.0, -6.0])


def pushed(inertial: bool, effects: tuple[ThrustEffect, ...] | None = None, gravity: str = "none") -> ChainModel:
    one = ThrustEffect(*TABLE, 1, 1.0, inertial, 0.8)
    return replace(uniform(3, 10.0, gravity), effects=(one,) if effects is None else effects)


def bent(model: ChainModel) -> State:
    return placed(model, 7e6, 7500.0, np.array([0.1, 0.9, 1.4]), np.array([0.01, -0.02, 0.03]))


def test_a_thrust_along_inertial_axes_gives_the_momentum_of_its_table() -> None:
    """M V0 = integral F dt, by trapezia; the integrator sums a polynomial of the first degree exactly."""
    model = pushed(inertial=True)
    h = ran(model, bent(model), np.linspace(0.0, 50.0, 11))
    given = np.sum(0.5 * (TABLE[1][1:] + TABLE[1][:-1]) * np.diff(TABLE[0]))
    gained = (h.com_velocity_m_s[-1] - h.com_velocity_m_s[0]) * model.mass_kg.sum()
    speed = fastest(model, h) * 7e6
    right = given * np.array([math.cos(0.8), math.sin(0.8)])
    assert np.abs(gained - right).max() <= h.steps * RTOL * model.mass_kg.sum() * speed
    turned = angular_momentum(model, h)
    assert abs(turned[-1] - turned[0]) > momentum_allowed(model, h)  # which the other laws leave


@pytest.mark.parametrize("inertial", one_in(2, [True, False]))
def test_a_table_is_met_at_every_instant_as_if_each_piece_were_a_run_of_its_own(inertial: bool) -> None:
    """Pieces run one after the other, from instant to instant, at a tenth of the tolerance."""
    model = pushed(inertial, gravity="gradient")
    start = bent(model)
    h = ran(model, start, np.array([0.0, 50.0]))
    state, marks = start, [0.0, *TABLE[0], 50.0]
    for i, (a, b) in enumerate(itertools.pairwise(marks)):
        inside = 0 < i < len(marks) - 2
        piece = ThrustEffect(TABLE[0][i - 1 : i + 1], TABLE[1][i - 1 : i + 1], 1, 1.0, inertial, 0.8)
        alone = pushed(inertial, (piece,) if inside else (), "gradient")
        state = at_sample(model, ran(alone, state, np.array([a, b]), rtol=0.1 * RTOL), -1)
    turn = fastest(model, h)
    allowed = 2.0 * budget(h, turn)
    assert np.abs(h.angle_rad[-1] - state.angle_rad).max() <= allowed * 4.0
    assert np.abs(h.rate_rad_s[-1] - state.rate_rad_s).max() <= allowed * 4.0 * turn
    assert np.abs(h.com_m[-1] - state.com_m).max() <= allowed * 7e6


# unequal chains


def test_the_pull_between_two_tip_masses_is_three_n2_times_the_lower_mass_and_its_distance() -> None:
    """Upright and turning with the orbit; exactly the sum over the bars, and 3 n² m d to the size over the radius."""
    scene = load_scene("effects/tip_masses")
    upright = replace(scene, chain=replace(scene.chain, angle_rad=(math.pi / 2.0,) * scene.bars))
    start, model = initial_state(upright), chain_model(upright)
    state = consistent_state(model, start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
    found = accelerations(model, 0.0, state)
    exact, c = radial_tension(upright), Case(model, state)
    assert np.all(np.abs(np.linalg.norm(found.reaction_N, axis=1) - exact) <= forward(c, joint_bound(c, found)))
    simple = 3.0 * upright.mean_motion_rad_s**2 * first_moments(upright)
    assert np.abs(exact / simple - 1.0).max() <= upright.size_m / upright.radius0_m
