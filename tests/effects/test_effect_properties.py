"""What effects conserve, what they work, that they add up, and that they cost nothing where they are not called for."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.effects.joint_torque import JointTorqueEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.slender import SlenderBarEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.effects.thrust import ThrustEffect
from reference_impl.model.chain import BarTurn, ChainModel, Prescription
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.effect import ChainEffect, EffectState, Modes, total_accelerations
from reference_impl.model.kinematics import cross
from reference_impl.model.relative import Accelerations
from reference_impl.model.state import State
from tests.effects.effect_runs import (
    accounted,
    angular_momentum,
    at_sample,
    energy,
    energy_allowed,
    fastest,
    momentum_allowed,
    placed,
    ran,
)
from tests.support import effect_cases
from tests.support.effect_cases import KINDS, MU, RADIUS, T_S, chain, motion, seen
from tests.support.slow import one_in

SEEDS = st.integers(0, 2**32 - 1)
GRAVITIES: dict[str, tuple[str, tuple[ChainEffect, ...]]] = {
    "point": ("point", ()),
    "gradient": ("gradient", ()),
    "quadrupole": ("gradient", (QuadrupoleEffect(),)),
    "slender": ("point", (SlenderBarEffect(),)),
}


def orbiting(gravity: str, length_m: float, *more: ChainEffect, bars: int = 2) -> tuple[ChainModel, State, float]:
    """A bent chain on a circular orbit, and the orbit's rate."""
    base, effects = GRAVITIES[gravity]
    random = np.random.default_rng(4)
    model = replace(chain(random, bars, length_m, base), effects=(*effects, *more))
    r = RADIUS + 2e6
    n = math.sqrt(MU / r**3)
    angle = np.linspace(0.9, 1.4, bars)
    return model, placed(model, r, n * r, angle, n * np.linspace(0.8, 1.3, bars)), n


# energy and angular momentum


def drifts(gravity: str, length_m: float, orbits: float, rtol: float = 1e-11) -> tuple[float, float, float, float]:
    """Largest change of energy and angular momentum, and what the integrator may make of each."""
    model, state, n = orbiting(gravity, length_m)
    h = ran(model, state, np.linspace(0.0, orbits * 2.0 * np.pi / n, 41), rtol=rtol)
    kept, turned = energy(model, h), angular_momentum(model, h)
    return (
        float(np.abs(kept - kept[0]).max()),
        float(np.abs(turned - turned[0]).max()),
        energy_allowed(model, h, rtol),
        momentum_allowed(model, h, rtol),
    )


@pytest.mark.parametrize("gravity", one_in(3, ["quadrupole", "slender", "point"]))
def test_gravity_with_a_potential_keeps_energy_and_angular_momentum(gravity: str) -> None:
    """Over an orbit and a half, to the integrator's tolerance; bars of a hundred kilometres."""
    lost, turned, lost_allowed, turned_allowed = drifts(gravity, 1e5, 1.5)
    assert lost <= lost_allowed
    assert turned <= turned_allowed


def test_the_gradients_defect_is_the_square_of_size_over_radius() -> None:
    """Its torque without its force: what is missing of the energy is n² m l², of M v² the square of l/r."""
    lengths, lost = [1e4, 3e4, 1e5], []
    for length in lengths:
        off, turned, allowed, turned_allowed = drifts("gradient", length, 0.5, 1e-13)
        assert off > 10.0 * allowed  # no solver's, but the model's
        assert turned > 10.0 * turned_allowed
        lost.append(off)
    exponent = np.polyfit(np.log(lengths), np.log(lost), 1)[0]
    assert exponent == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("gravity", one_in(2, ["quadrupole", "point"]))
def test_third_bodies_of_one_rate_leave_the_jacobi_integral(gravity: str) -> None:
    """E - omega L, with the bodies' potential in E."""
    moment = gravity != "point"
    mu, distance = 0.02 * MU, 4e7
    rate = math.sqrt((MU + mu) / distance**3)
    third = [ThirdBodyEffect(mu, distance, 0.4 + 2.0 * k, rate, moment, moment) for k in range(2)]
    model, state, n = orbiting(gravity, 1e5, *third)
    h = ran(model, state, np.linspace(0.0, 2.0 * np.pi / n, 11), rtol=1e-10)
    stored = sum(np.array([third_potential(model, h, i, b) for i in range(len(h.t_s))]) for b in third)
    kept, turned = energy(model, h) + stored, angular_momentum(model, h)
    jacobi = kept - rate * turned
    allowed = energy_allowed(model, h, 1e-10) + rate * momentum_allowed(model, h, 1e-10)
    assert np.abs(jacobi - jacobi[0]).max() <= allowed
    assert np.abs(kept - kept[0]).max() > 10.0 * allowed


def third_potential(model: ChainModel, h, i: int, body: ThirdBodyEffect) -> float:
    """Potential energy at a sample: -mu_b (1/|Y| - X·Z/D³) per unit mass, and that of the second moments."""
    at = seen(model, at_sample(model, h, i), float(h.t_s[i]))
    x = body.body_position(float(h.t_s[i]))
    y = at.position_from_body - x
    stored = -body.mu_m3_s2 * (1.0 / np.abs(y) - (np.conj(x) * at.position_from_body).real / body.distance_m**3)
    c2 = ((at.unit.conj() * y).real / np.abs(y)) ** 2
    moment = -0.5 * body.mu_m3_s2 * model.inertia_kg_m2 / np.abs(y) ** 3 * (3.0 * c2 - 1.0)
    return float(model.mass_kg @ stored + body.second_moment * moment.sum())


# work


def working(name: str) -> tuple[ChainModel, State, float]:
    """A chain in low orbit with the named effects, as strong as to be felt."""
    random = np.random.default_rng(8)
    model = replace(chain(random, 3, 100.0), effects=(SlenderBarEffect(),))
    r = RADIUS + 3e5
    n = math.sqrt(MU / r**3)
    state = placed(model, r, n * r, np.array([1.2, 1.6, 1.9]), n * np.array([1.0, 0.5, 1.5]))
    law = Prescription(1, (BarTurn(0.5, 200.0, 100.0),), frame="local_horizontal", reacts_on=None)
    added: dict[str, tuple[ChainEffect, ...]] = {
        "drag": (effect_cases.drag(random, model),),
        "solar pressure": (replace(effect_cases.sunlight(random, model), pressure_Pa=1e-2),),
        "thrust": (ThrustEffect(np.array([100.0, 300.0, 500.0]), np.array([0.1, 0.3, 0.2]), 2, 1.0, False, 1.0),),
        "springs": (JointSpringDamperEffect(np.array([5.0, 2.0]), np.array([400.0, 300.0]), np.array([0.1, -0.2])),),
        "motor": (JointTorqueEffect(np.array([0.0, 300.0, 700.0]), np.array([0.5, -0.3, 0.2]), 1),),
        "prescribed": (),
    }
    added["everything"] = tuple(e for es in added.values() for e in es)
    laws = (law,) if name in ("prescribed", "everything") else ()
    for _ in range(50 * len(laws)):  # at rest against its horizontal, as the law asks
        z, v = state.com_m + state.position_m[1], state.com_velocity_m_s + state.velocity_m_s[1]
        turning = n * np.array([1.0, cross(z, v) / (z @ z) / n, 1.5])
        state = placed(model, r, n * r, state.angle_rad, turning)
    return replace(model, effects=(*model.effects, *added[name]), prescriptions=laws), state, n


def power_given(model: ChainModel, t_s: float, state: State, a: Accelerations, modes: Modes) -> float:
    """Rate at which energy comes in: of each element of a bar, each joint, each torque, by no effect's code."""
    total = 0.0
    place = state.com_m + state.position_m
    speed = state.com_velocity_m_s + state.velocity_m_s
    z, v, u = (
        x[:, 0] + 1j * x[:, 1] for x in (place, speed, np.stack([np.cos(state.angle_rad), np.sin(state.angle_rad)], 1))
    )
    nodes, weights = np.polynomial.legendre.leggauss(4)
    s = model.half_m[:, None] * nodes
    moving = v[:, None] + 1j * s * (state.rate_rad_s * u)[:, None]
    for effect, mode in zip(model.effects, modes, strict=True):
        name = effect.name
        if name == "drag":
            wind = np.conj(u) * (v - 1j * effect.rotation_rad_s * z)
            face = np.sign(wind.imag) if mode is None else mode
            across = wind.imag[:, None] + s * (state.rate_rad_s - effect.rotation_rad_s)[:, None]
            lapse = ((np.conj(u) * z).real / np.abs(z) / effect.scale_height_m)[:, None]
            thick = effect.density_kg_m3 * np.exp((effect.radius_m - np.abs(z)) / effect.scale_height_m)
            flow = effect.tangential_coefficient * wind.real[:, None] + 1j * effect.normal_coefficient * across
            force = -(0.5 * effect.width_m * thick * face * u)[:, None] * (1.0 - lapse * s) * across * flow
            total += float(((np.conj(force) * moving).real @ weights) @ model.half_m)
        elif name == "solar_pressure" and (mode is None or mode[0] > 0.0):
            sun = np.exp(1j * (effect.longitude_rad + effect.rate_rad_s * t_s))
            facing = (np.conj(1j * u) * sun).real
            light = (1.0 - effect.reflectivity) * sun * np.abs(facing) + 2.0 * effect.reflectivity * facing**2 * (
                1j * u * np.sign(facing)
            )
            total -= float((effect.pressure_Pa * effect.width_m * model.length_m) @ (np.conj(light) * v).real)
        elif name == "thrust":
            size = np.interp(t_s, effect.times_s, effect.sizes) if mode is None or mode[0] >= 0.0 else 0.0
            force = size * np.exp(1j * effect.direction_rad) * (1.0 if effect.inertial else u[effect.bar])
            end = (
                v[effect.bar]
                + 1j * effect.side * model.half_m[effect.bar] * state.rate_rad_s[effect.bar] * u[effect.bar]
            )
            total += float((np.conj(force) * end).real)
        elif name == "joint_torque":
            total += float(np.interp(t_s, effect.times_s, effect.sizes) * np.diff(state.rate_rad_s)[effect.joint])
        elif name == "joint_spring_damper":
            total -= float(effect.damping_N_m_s_rad @ np.diff(state.rate_rad_s) ** 2)
    for p, torque in zip(model.prescriptions, a.torque_N_m, strict=True):
        total += float(torque * state.rate_rad_s[p.bar])
    return total


@pytest.mark.parametrize("name", one_in(4, ["everything", "solar pressure", "thrust", "motor", "drag"]))
def test_the_energy_gained_is_the_work_done(name: str) -> None:
    """E(t) - E(0) = W(t), the work integrated beside the motion; both to the integrator's tolerance."""
    model, state, n = working(name)
    t = np.linspace(0.0, 400.0, 5)
    unit = model.mass_kg.sum() * (n * (RADIUS + 3e5)) ** 2
    h, work = accounted(model, state, t, power_given, unit, rtol=1e-10)
    gained = energy(model, h) - energy(model, h)[0]
    allowed = energy_allowed(model, h, 1e-10)
    assert np.abs(gained - work).max() <= allowed
    assert np.abs(work).max() > 10.0 * allowed


@pytest.mark.parametrize("name", ["springs", "prescribed"])
def test_the_energy_gained_inside_a_free_chain_is_the_work_done(name: str) -> None:
    """The same of what is too little beside an orbit's energy: at rest in free space, in units of the chain's own."""
    model, state, _ = working(name)
    springs = tuple(e for e in model.effects if isinstance(e, JointSpringDamperEffect))
    laws = tuple(replace(p, frame="inertial") for p in model.prescriptions)
    model = replace(model, gravity="none", effects=springs, prescriptions=laws)
    rate = state.rate_rad_s * [1.0, 0.0 if laws else 1.0, 1.0]
    state = placed(model, RADIUS + 3e5, 0.0, state.angle_rad, rate)
    h, work = accounted(model, state, np.linspace(0.0, 600.0, 7), power_given, 1.0, rtol=1e-10)
    gained = energy(model, h) - energy(model, h)[0]
    turn = fastest(model, h)
    stiffness = sum(float(e.stiffness_N_m_rad.sum()) for e in springs)
    # a gradient M L² turn by rates and springs' torques by angles, in each bar, and the work's own unit of a joule
    scale = model.mass_kg.sum() * model.length_m.sum() ** 2 * turn**2 + 4.0 * stiffness + 1.0
    allowed = h.steps * 1e-10 * 4.0 * scale
    assert np.abs(gained - work).max() <= allowed
    assert np.abs(work).max() > 100.0 * allowed
    if springs:  # they turn neighbours against each other
        momentum = angular_momentum(model, h)
        spun = h.steps * 1e-10 * 4.0 * model.mass_kg.sum() * model.length_m.sum() ** 2 * turn
        assert np.abs(momentum - momentum[0]).max() <= spun


# sums


@settings(max_examples=20, deadline=None)
@given(seed=SEEDS, kinds=st.lists(st.sampled_from(sorted(KINDS)), max_size=8, unique=True), bars=st.integers(2, 6))
def test_any_effects_together_push_as_the_sum_of_each_alone(seed: int, kinds: list[str], bars: int) -> None:
    """Added in the model's order: to the last bit. The motion feels the sum: so do accelerations, to round-off."""
    random = np.random.default_rng(seed)
    model = chain(random, bars, 50.0)
    effects = tuple(KINDS[kind](random, model) for kind in kinds)
    state = motion(random, model)
    at = EffectState(replace(model, effects=effects), T_S, state, unit_along(state.angle_rad))
    together, sideways = total_accelerations(at, (None,) * len(effects))
    common, difference, spin, aside = 0j, np.zeros(bars, complex), np.zeros(bars), np.zeros(bars, complex)
    for effect in effects:
        alone, own = total_accelerations(EffectState(replace(model, effects=(effect,)), T_S, state, at.unit), (None,))
        common, difference, spin = common + alone.common, difference + alone.difference, spin + alone.angular
        aside = aside + own
    assert together.common == common
    assert np.array_equal(together.difference, difference)
    assert np.array_equal(together.angular, spin)
    assert np.array_equal(sideways, aside)
