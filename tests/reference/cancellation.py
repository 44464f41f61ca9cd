"""Digits that the reference keeps of everything it makes of a tiny chain, against exact arithmetic.

Run as a script it prints them as JSON: so a test can ask the same of a copy of the reference with a fault in it.
"""

import json
from dataclasses import replace
from unittest import mock

import numpy as np

from barchain.studies.roundoff.formulations import FORMULATIONS, EvaluationCase, StateKind, Turned, exact_case, model_of
from reference_impl.integrate.simulate import Simulation
from reference_impl.integrate.stepper import Integration
from reference_impl.kernel import layout
from reference_impl.kernel.library import evaluate
from reference_impl.model.chain import BarTurn, ChainModel, Prescription
from reference_impl.model.complex_vectors import unit_along
from reference_impl.model.invariants import relative_angular_momentum, relative_kinetic_energy, tidal_energy
from reference_impl.model.relative import accelerations, external_accelerations
from reference_impl.model.state import Accelerations, State
from reference_impl.precision import formulations
from reference_impl.precision.arithmetic import EXACT, FLOAT64, exact_numbers
from reference_impl.precision.chain import ChainAccelerations, bar_centres, consistent_chain_state, directions, dot
from reference_impl.precision.formulations import absolute, gradient_angular_accelerations

RATIO, MEMBERS = 1e-9, 4  # bars of 6 mm: a cancelling subtraction leaves 7 digits


def errors_of_all(kind: StateKind, bars: int = 5, compact: float = 1.0) -> dict[str, float]:
    """Largest error of each quantity, over its own largest value; gaps over the bars' length.

    Bars may be more `compact` than uniform ones: their inertia is divided by that.
    """
    with exact_numbers():
        exact = exact_case(EvaluationCase(kind, bars, RATIO, MEMBERS))
        exact = replace(exact, bars=replace(exact.bars, inertia_kg_m2=exact.bars.inertia_kg_m2 / int(compact)))
        given = FORMULATIONS["minimal"].given(exact, FLOAT64).cast(FLOAT64)
        found = [seen_by_both(given, k) for k in range(MEMBERS)]
        answers = exact_answers(given.cast(EXACT))
        return {
            name: max(apart(found[k][name], answers[name.split()[-1]], k) for k in range(MEMBERS)) for name in found[0]
        }


def apart(found: np.ndarray, answer: np.ndarray, member: int) -> float:
    """Error of one member's quantity."""
    own = np.asarray(answer[..., member])
    scale = abs(own).max() if own.any() else 1
    return float(abs(EXACT.cast(np.asarray(found)) - own).max() / scale)


def seen_by_both(given, member: int) -> dict[str, np.ndarray]:
    """Quantities of a state by the reference and by its compiled form."""
    state: Turned = given.state
    model = model_of(given.bars, member)
    com, angle, rate = state.com_m[:, member].copy(), state.angle_rad[:, member].copy(), state.rate_rad_s[:, member]
    drift = np.array([-5000.0, 6000.0])
    run = Simulation(model, com, drift, angle, rate.copy(), rtol=1e-12)
    a, start = run.coordinates.accelerations(0.0, run.y0), run.coordinates.unpack(run.y0)
    seen = run.history(Integration(np.zeros(1), run.y0[None], 0, 0, None))
    again = Simulation(model, com, drift, angle, rate.copy(), rtol=1e-12, coordinates="redundant")
    whole = again.coordinates.accelerations(0.0, again.y0)
    y, work = layout.pack(com, np.zeros(2), angle, rate), layout.workspace(model.bars, 0)
    rates = np.zeros_like(y)
    assert evaluate(0.0, y, rates, layout.compiled_chain(model), work)
    n = model.bars
    return {
        "reference reaction": a.reaction_N.T,
        "reference angular": a.angle_rad_s2,
        "reference relative": a.position_m_s2.T,
        "reference com": a.com_m_s2,
        "reference gap": run.coordinates.joint_gaps_m(run.y0) / model.length_m.max(),
        "reference com residual gap": seen.com_residual_m / model.length_m.max(),
        "reference velocity": start.velocity_m_s.T,
        "reference kinetic": relative_kinetic_energy(model, angle[None], rate[None]),
        "reference momentum": relative_angular_momentum(model, angle[None], rate[None]),
        "reference redundant reaction": whole.reaction_N.T,
        "reference redundant relative": whole.position_m_s2.T,
        **by_point_gravity(model, start, a),
        **by_a_law(given, model, start, member),
        "reference energy": tidal_energy(model, com[None], angle[None]),
        "compiled reaction": work.bars[[layout.RX, layout.RY], : n - 1],
        "compiled angular": rates[n + 2 : 2 * n + 2],
        "compiled com": rates[2 * n + 2 : 2 * n + 4],
    }


def by_point_gravity(model: ChainModel, start: State, a: Accelerations) -> dict[str, np.ndarray]:
    """Accelerations by the field alone: the gradient has the same field, so the branches differ by the torque."""
    bare = replace(model, gravity="point")
    unit = unit_along(start.angle_rad)
    _, tide, none = external_accelerations(bare, start, unit)
    _, same, spin = external_accelerations(model, start, unit)
    assert not none.any()
    apart_m_s2 = np.array([tide.real - same.real, tide.imag - same.imag])
    return {"reference point tide": apart_m_s2 / np.abs(same).max(), "reference spin": spin}


def by_a_law(given, model: ChainModel, start: State, member: int) -> dict[str, np.ndarray]:
    """Torque and reactions where a bar is prescribed, less those of the exact chain under the same torque."""
    law = Prescription(1, (BarTurn(1.0, 60.0, 0.0),), frame="inertial", reacts_on=None)
    t_s = 17.0
    moved = replace(model, prescriptions=(law,))
    a = accelerations(moved, t_s, start)
    work = layout.workspace(model.bars, 1)
    y = layout.pack(start.com_m, np.zeros(2), start.angle_rad, start.rate_rad_s)
    rates = np.zeros_like(y)
    assert evaluate(t_s, y, rates, layout.compiled_chain(moved), work)
    compiled = work.bars[[layout.RX, layout.RY], : model.bars - 1]
    exact = given.cast(EXACT)
    bars, s = exact.bars, exact.state
    place = consistent_chain_state(EXACT, bars, s.com_m, s.angle_rad, s.rate_rad_s).absolute

    def under(torque: float) -> ChainAccelerations:
        turned = EXACT.zeros(s.angle_rad.shape)
        turned[law.bar] = turned[law.bar] + EXACT.cast(torque) / bars.inertia_kg_m2[law.bar]
        plain = formulations.gradient_angular_accelerations
        with mock.patch.object(formulations, "gradient_angular_accelerations", lambda *of: plain(*of) + turned):
            return absolute(EXACT, bars, place)

    free, pushed = under(0.0), under(1.0)
    gained = pushed.angle_rad_s2[law.bar] - free.angle_rad_s2[law.bar]
    lacking = EXACT.cast(law.acceleration_rad_s2(t_s)) - free.angle_rad_s2[law.bar]
    torque = (lacking / gained)[member]
    reaction = free.reaction_N[..., member] + (pushed.reaction_N - free.reaction_N)[..., member] * torque
    return {
        "reference law torque gap": np.array([float((EXACT.cast(a.torque_N_m)[0] - torque) / torque)]),
        "reference law reaction gap": off(a.reaction_N.T, reaction),
        "compiled law torque gap": np.array([float((EXACT.cast(work.torque_N_m)[0] - torque) / torque)]),
        "compiled law reaction gap": off(compiled, reaction),
    }


def off(found: np.ndarray, answer: np.ndarray) -> np.ndarray:
    """Error over the largest value, as one number."""
    return np.array([float(abs(EXACT.cast(np.asarray(found)) - answer).max() / abs(answer).max())])


def exact_answers(given) -> dict[str, np.ndarray]:
    """What they should be, by absolute coordinates in exact arithmetic."""
    bars, s = given.bars, given.state
    state = consistent_chain_state(EXACT, bars, s.com_m, s.angle_rad, s.rate_rad_s)
    found, d = absolute(EXACT, bars, state.absolute), state.position_m
    velocity = bar_centres(bars, bars.half_m * s.rate_rad_s * directions(EXACT, s.angle_rad)[1])
    place = state.absolute.place_m
    spun = bars.inertia_kg_m2 * s.rate_rad_s
    nearness = 1 / EXACT.sqrt(dot(place, place)) - 1 / EXACT.sqrt(dot(s.com_m, s.com_m))
    return {
        "reaction": found.reaction_N,
        "angular": found.angle_rad_s2,
        "relative": found.place_m_s2 - found.com_m_s2[:, None],
        "com": found.com_m_s2,
        "gap": 0 * found.reaction_N[0],
        "tide": 0 * found.place_m_s2,
        "spin": gradient_angular_accelerations(EXACT, bars, place, *directions(EXACT, s.angle_rad)),
        "velocity": velocity,
        "kinetic": (bars.mass_kg * dot(velocity, velocity) / 2 + spun * s.rate_rad_s / 2).sum(axis=0)[None],
        "momentum": (bars.mass_kg * (d[0] * velocity[1] - d[1] * velocity[0]) + spun).sum(axis=0)[None],
        "energy": -(bars.mass_kg * bars.mu_m3_s2 * nearness).sum(axis=0)[None],
    }


if __name__ == "__main__":
    states = {str(kind): errors_of_all(kind) for kind in (StateKind.GENERIC, StateKind.STRAIGHT)}
    print(json.dumps(states | {"compact": errors_of_all(StateKind.GENERIC, compact=20.0)}))
