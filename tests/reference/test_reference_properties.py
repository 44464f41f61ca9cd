"""Laws that the reference's accelerations must obey, on random chains: 40 bars, 6 decades of mass, length.

What is asked of a law is a small residual, and of two answers that their difference fits through the joints;
`roundoff` derives both bounds.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference_impl.integrate.simulate import Simulation
from reference_impl.kernel.simulate import KernelSimulation
from reference_impl.model import absolute, relative
from reference_impl.model.arrays import Array
from reference_impl.model.chain import BarTurn, Prescription
from reference_impl.model.complex_vectors import as_vectors, unit_along
from reference_impl.model.invariants import (
    com_angular_momentum,
    com_energy,
    relative_angular_momentum,
    relative_kinetic_energy,
    tidal_energy,
)
from reference_impl.model.kinematics import cross, directions
from reference_impl.model.state import Accelerations, State
from tests.reference.laws import LAWS
from tests.support.arbiter import field as exact_field
from tests.support.compiled_evaluation import compiled_accelerations
from tests.support.joint_roundoff import MU, RADIUS, C, Case, U, case, forward, joint_bound, magnitudes, sums


def cases(laws: tuple[Prescription, ...] = ()) -> st.SearchStrategy[Case]:
    return st.builds(
        case,
        seed=st.integers(0, 2**32 - 1),
        bars=st.integers(1 + bool(laws), 40),
        gravity=st.sampled_from(["none", "point", "gradient"]),
        decades=st.sampled_from([0.0, 2.0, 6.0]),
        laws=st.just(laws),
    )


IMPLEMENTATIONS = {
    "numpy": (relative.accelerations, Simulation),
    "compiled": (compiled_accelerations, KernelSimulation),
}


@pytest.fixture(scope="module", params=IMPLEMENTATIONS, autouse=True)
def implementation(request: pytest.FixtureRequest) -> None:
    """Every law here binds both forms of the reference."""
    global evaluate, simulation
    evaluate, simulation = IMPLEMENTATIONS[request.param]


def accelerations(c: Case) -> Accelerations:
    return evaluate(c.model, 25.0, c.state)


@settings(max_examples=30, deadline=None)
@given(c=cases())
def test_newton_holds_bar_by_bar(c: Case) -> None:
    """m d'' = tide + reactions, with the tide subtracted in fifty digits."""
    a, size = accelerations(c), magnitudes(c, accelerations(c))
    _, tide = exact_field(c.model, c.state)
    residual = np.linalg.norm(a.position_m_s2 - tide - sums(a.reaction_N)[1] / c.model.mass_kg[:, None], axis=1)
    decimals = 1e-45 * MU / RADIUS**2  # the judge's own rounding, where a lone bar's tide is nothing
    assert np.all(residual <= U * ((C + c.model.bars) * size.tide + 4.0 * size.pull) + decimals)


@settings(max_examples=30, deadline=None)
@given(c=cases())
def test_euler_holds_bar_by_bar(c: Case) -> None:
    """J theta'' = torque of gravity + lever of the reactions; 3 n² of each radius bounds the first."""
    a, size = accelerations(c), magnitudes(c, accelerations(c))
    m, (along, across) = c.model, directions(c.state.angle_rad)
    place = c.state.com_m + c.state.position_m
    r = np.linalg.norm(place, axis=1)
    torque = 3.0 * MU / r**5 * np.sum(place * along, axis=1) * cross(along, place) if m.gravity == "gradient" else 0.0
    lever = m.half_m / m.inertia_kg_m2 * np.sum(across * sums(a.reaction_N)[0], axis=1)
    assert np.all(np.abs(a.angle_rad_s2 - torque - lever) <= C * U * size.angular)


@settings(max_examples=30, deadline=None)
@given(c=cases())
def test_joints_hold_in_acceleration(c: Case) -> None:
    a, m = accelerations(c), c.model
    along, across = directions(c.state.angle_rad)
    end = m.half_m[:, None] * (a.angle_rad_s2[:, None] * across - (c.state.rate_rad_s**2)[:, None] * along)
    opening = a.position_m_s2[1:] - end[1:] - a.position_m_s2[:-1] - end[:-1]
    assert np.all(np.linalg.norm(opening, axis=1) <= joint_bound(c, a))


@settings(max_examples=30, deadline=None)
@given(c=cases())
def test_internal_forces_move_no_centre_of_mass(c: Case) -> None:
    """Sum mu_j d_j'' = 0 (6), and the centre's acceleration is the mean field's: the sum of all forces."""
    a, size, m = accelerations(c), magnitudes(c, accelerations(c)), c.model
    drift = np.linalg.norm(m.weight @ a.position_m_s2)
    assert drift <= (C + m.bars) * U * (m.weight @ size.pull + size.tide)
    mean, _ = exact_field(m, c.state)
    assert np.linalg.norm(a.com_m_s2 - mean) <= (C + m.bars) * U * (np.linalg.norm(mean) + size.tide)


@settings(max_examples=30, deadline=None)
@given(c=cases())
def test_relative_and_absolute_formulations_agree(c: Case) -> None:
    """To the absolute one's round-off, u n² r in each bar's gravity, taken through the joints."""
    a = accelerations(c)
    place, velocity = c.state.com_m + c.state.position_m, c.state.com_velocity_m_s + c.state.velocity_m_s
    other = absolute.accelerations(c.model, 25.0, place, velocity, c.state.angle_rad, c.state.rate_rad_s)
    m, n2 = c.model, MU / np.linalg.norm(c.state.com_m) ** 3 if c.model.gravity != "none" else 0.0
    # a place rounded by u r moves gravity by 2 n² u r, and its evaluation by 6 u n² r more
    pulled = 2.0 * 8.0 * U * n2 * np.linalg.norm(place, axis=1).max()
    allowed = forward(c, pulled + 2.0 * joint_bound(c, a)) if m.bars > 1 else np.zeros(0)
    assert np.all(np.linalg.norm(other.reaction_N - a.reaction_N, axis=1) <= allowed)
    turned = sums(np.repeat(allowed[:, None], 2, axis=1))[0][:, 0] * m.half_m / m.inertia_kg_m2
    spin = 3.0 * 8.0 * U * n2  # the torque of gravity at a rounded place
    difference = np.abs(other.angle_rad_s2 - a.angle_rad_s2)
    assert np.all(difference <= turned + spin + C * U * magnitudes(c, a).angular)


def power_and_torque(c: Case, a: Accelerations) -> tuple[float, float, float, float]:
    """Rates of relative energy and angular momentum beyond gravity's own, and the round-off allowed."""
    m, s, size = c.model, c.state, magnitudes(c, a)
    _, tide = exact_field(m, s)
    beyond = m.mass_kg[:, None] * (a.position_m_s2 - tide)
    power = float(np.sum(s.velocity_m_s * beyond) + np.sum(m.inertia_kg_m2 * s.rate_rad_s * a.angle_rad_s2))
    torque = float(np.sum(cross(s.position_m, beyond)) + np.sum(m.inertia_kg_m2 * a.angle_rad_s2))
    force = m.mass_kg * (size.pull + size.tide)
    speed, reach = np.linalg.norm(s.velocity_m_s, axis=1).max(), np.linalg.norm(s.position_m, axis=1).max()
    turn = m.inertia_kg_m2 * size.angular
    roundings = (C + m.bars) * U
    # velocities and places are sums over the bars: rounded in units of the largest
    return (
        power,
        torque,
        roundings * float(np.sum(force) * speed + np.abs(s.rate_rad_s) @ turn),
        roundings * float(np.sum(force) * reach + np.sum(turn)),
    )


@settings(max_examples=30, deadline=None)
@given(c=cases().filter(lambda c: c.model.gravity != "gradient"))
def test_reactions_do_no_work_and_turn_nothing(c: Case) -> None:
    """dE/dt and dL/dt less gravity's work and moment vanish, without gravity and with point gravity."""
    power, torque, power_bound, torque_bound = power_and_torque(c, accelerations(c))
    assert abs(power) <= power_bound
    assert abs(torque) <= torque_bound


@settings(max_examples=30, deadline=None)
@given(c=cases().filter(lambda c: c.model.gravity == "point"))
def test_angular_momentum_about_the_body_is_constant(c: Case) -> None:
    """Central forces: M Z0 x Z0'' + sum m d x d'' + sum J theta'' = 0, all of it."""
    a, m, s = accelerations(c), c.model, c.state
    _, _, _, bound = power_and_torque(c, a)
    whole = m.mass_kg.sum() * cross(s.com_m, a.com_m_s2)
    rest = np.sum(m.mass_kg * cross(s.position_m, a.position_m_s2)) + m.inertia_kg_m2 @ a.angle_rad_s2
    main = (C + m.bars) * U * m.mass_kg.sum() * np.linalg.norm(s.com_m) * np.linalg.norm(a.com_m_s2)
    assert abs(whole + rest) <= bound + main


@settings(max_examples=30, deadline=None)
@given(c=cases(), turn=st.floats(-3.0, 3.0))
def test_turning_everything_turns_the_answer(c: Case, turn: float) -> None:
    """To the round-off of turned inputs: angles u |theta|, places u d, taken through the joints."""
    a, s, m = accelerations(c), c.state, c.model
    spin = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])  # acts on rows
    turned = State(
        s.com_m @ spin,
        s.com_velocity_m_s @ spin,
        s.angle_rad + turn,
        s.rate_rad_s,
        s.position_m @ spin,
        s.velocity_m_s @ spin,
    )
    other = evaluate(m, 25.0, turned)
    # an angle off by 2 ulp(2 pi) = 8 u turns every unit vector by that much, on both sides of the system
    allowed = forward(c, 2.0 * 8.0 * joint_bound(c, a)) if m.bars > 1 else np.zeros(0)
    assert np.all(np.linalg.norm(other.reaction_N - a.reaction_N @ spin, axis=1) <= allowed)
    levers = sums(np.repeat(allowed[:, None], 2, axis=1))[0][:, 0] * m.half_m / m.inertia_kg_m2
    assert np.all(np.abs(other.angle_rad_s2 - a.angle_rad_s2) <= levers + 8.0 * C * U * magnitudes(c, a).angular)
    assert np.linalg.norm(other.com_m_s2 - a.com_m_s2 @ spin) <= C * U * np.linalg.norm(a.com_m_s2)


def driven(name: str, seed: int, bars: int, gravity: str, decades: float) -> Case:
    """A case with the named laws; "all bars" drives every one, by turns from outside and by motors."""
    laws = LAWS[name]
    if laws == "all":
        laws = tuple(
            Prescription(
                j,
                (BarTurn(0.1 * (j + 1), 60.0, 5.0),),
                frame="local_horizontal" if j % 3 == 0 else "inertial",
                reacts_on=j - 1 if j % 2 else None,
            )
            for j in range(min(bars, 8))
        )
    return case(seed, bars, gravity, decades, laws)


def driven_cases(name: str) -> st.SearchStrategy[Case]:
    return st.builds(
        driven,
        name=st.just(name),
        seed=st.integers(0, 2**32 - 1),
        bars=st.integers(2, 40),
        gravity=st.sampled_from(["none", "point", "gradient"]),
        decades=st.sampled_from([0.0, 2.0, 6.0]),
    )


def torque_terms(c: Case, a: Accelerations) -> Array:
    """Magnitudes (N,), rad/s², of what a bar's angular acceleration is summed from, torque by torque.

    The reactions to several torques may cancel each other, so their sum says too little.
    """
    m = c.model
    unit = unit_along(c.state.angle_rad)
    _, tide, spin = relative.external_accelerations(m, c.state, unit)
    turning = relative.ReactionSolution(m, c.state, unit, tide, spin)
    torque = np.abs(a.torque_N_m)
    free, by_torque = as_vectors(turning.torque_free_reactions), as_vectors(turning.reactions_per_torque)
    reaction = np.abs(free) + np.tensordot(torque, np.abs(by_torque), axes=1)
    direct = sum(t * np.abs(turning.rotation_per_unit_torque(p)) for t, p in zip(torque, m.prescriptions, strict=True))
    return np.abs(spin) + direct + m.half_m / m.inertia_kg_m2 * sums(reaction)[0].sum(axis=1)


@pytest.mark.parametrize("name", LAWS)
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_prescribed_bars_follow_their_laws(name: str, data: st.DataObject) -> None:
    c = data.draw(driven_cases(name))
    a, s, size = accelerations(c), c.state, magnitudes(c, accelerations(c))
    response = torque_terms(c, a)
    for p in c.model.prescriptions:
        followed, law, terms = a.angle_rad_s2[p.bar], p.acceleration_rad_s2(25.0), response[p.bar]
        if p.frame == "previous_bar":
            followed -= a.angle_rad_s2[p.bar - 1]
            terms += response[p.bar - 1]
        if p.frame == "local_horizontal":
            place, motion = s.com_m + s.position_m[p.bar], s.com_velocity_m_s + s.velocity_m_s[p.bar]
            z, v, w = (complex(*x) for x in (place, motion, a.com_m_s2 + a.position_m_s2[p.bar]))
            followed -= (w / z - (v / z) ** 2).imag
            terms += abs(w / z) + abs(v / z) ** 2 + size.pull[p.bar] / abs(z)
        # besides: the torques' small dense system, solved with P roundings in each of its own terms
        assert abs(followed - law) <= (C + 8 * len(c.model.prescriptions)) * U * (terms + abs(law))


@pytest.mark.parametrize("name", LAWS)
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_torques_from_outside_change_angular_momentum_by_themselves_and_motors_do_not(name: str, data) -> None:
    """dL/dt is the sum of the outside torques; dE/dt the torques' work at their bars' (relative) rates."""
    c = data.draw(driven_cases(name).filter(lambda c: c.model.gravity != "gradient"))
    a, rate = accelerations(c), c.state.rate_rad_s
    power, torque, power_bound, torque_bound = power_and_torque(c, a)
    for p, value in zip(c.model.prescriptions, a.torque_N_m, strict=True):
        if p.reacts_on is None:
            torque -= value
            power -= value * rate[p.bar]
        else:
            power -= value * (rate[p.bar] - rate[p.reacts_on])
    assert abs(torque) <= torque_bound
    assert abs(power) <= power_bound


@pytest.mark.parametrize("gravity", ["none", "point"])
@pytest.mark.parametrize("name", ["free", "joint, inertial", "joint, local"])
def test_runs_keep_angular_momentum_and_free_runs_energy(gravity: str, name: str) -> None:
    """Each step may err by rtol in every block: steps x rtol x the invariant's gradient along the units."""
    laws, rtol = () if name == "free" else LAWS[name], 1e-11
    c = case(12, 5, gravity, 0.5, laws, turning=2.0)
    m, s = c.model, c.state
    run = simulation(m, s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s, rtol=rtol)
    h = run.history(run.integrate(np.linspace(0.0, 500.0, 11)))
    inner = relative_angular_momentum(m, h.angle_rad, h.rate_rad_s)
    outer = com_angular_momentum(m, h.com_m, h.com_velocity_m_s)
    mass, size, radius = m.mass_kg.sum(), m.length_m.sum(), np.linalg.norm(h.com_m, axis=1).max()
    turn = np.sqrt(MU / np.linalg.norm(s.com_m) ** 3) + np.abs(h.rate_rad_s).max()
    # position and velocity blocks, two components each: four terms of size M r² turn and M L² turn
    inner_allowed = h.steps * rtol * 4.0 * mass * size**2 * turn
    assert (
        np.abs(inner + outer - inner[0] - outer[0]).max()
        <= inner_allowed + h.steps * rtol * 4.0 * mass * radius**2 * turn
    )
    if gravity == "none":  # then it is constant by itself, on its own small scale
        assert np.abs(inner - inner[0]).max() <= inner_allowed
    if name == "free":
        energy = relative_kinetic_energy(m, h.angle_rad, h.rate_rad_s) + com_energy(m, h.com_m, h.com_velocity_m_s)
        energy = energy + (tidal_energy(m, h.com_m, h.angle_rad) if gravity == "point" else 0.0)
        speed = np.linalg.norm(h.com_velocity_m_s, axis=1).max() + turn * radius
        assert np.abs(energy - energy[0]).max() <= h.steps * rtol * 4.0 * mass * speed**2


def test_a_motor_that_loses_its_grip_stops_the_run_with_a_reason() -> None:
    """A motor's effect on its bar's inertial angle can vanish: the law then asks for an infinite torque."""
    c = case(11, 5, "none", 0.5, LAWS["joint, inertial"], turning=2.0)
    s = c.state
    run = simulation(c.model, s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s, rtol=1e-9)
    with pytest.raises(ArithmeticError, match="joint motor"):
        run.integrate(np.linspace(0.0, 100.0, 3))


def test_a_chain_that_double_precision_cannot_tell_apart_says_so() -> None:
    """A bar 1e20 times lighter than its neighbours that no lever turns: its two joints become one."""
    c = case(3, 3, "none", 0.0)
    model = replace(c.model, mass_kg=np.array([1e20, 1.0, 1e20]), inertia_kg_m2=np.full(3, 1e40))
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        relative.accelerations(model, 0.0, c.state)  # compiled, it is solved
