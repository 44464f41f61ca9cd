"""Digits that the reference keeps of everything it makes of a tiny chain, against exact arithmetic.

Run as a script it prints them as JSON: so a test can ask the same of a copy of the reference with a fault in it.
"""

from __future__ import annotations

import json

import numpy as np

from barchain.roundoff.formulations import FORMULATIONS, Turned
from barchain.roundoff.production import model_of
from barchain.roundoff.states import Case, Kind, exact_case
from reference_impl.fast import layout
from reference_impl.fast.accelerations import evaluate
from reference_impl.invariants import tidal_energy
from reference_impl.precision.arithmetic import EXACT, FLOAT64, exact_numbers
from reference_impl.precision.chain import dot, joined
from reference_impl.precision.formulations import absolute
from reference_impl.simulate import Simulation

RATIO, MEMBERS = 1e-9, 4  # bars of 6 mm: a cancelling subtraction leaves 7 digits


def errors_of_all(kind: Kind, bars: int = 5) -> dict[str, float]:
    """Largest error of each quantity, over its own largest value; gaps over the bars' length."""
    with exact_numbers():
        exact = exact_case(Case(kind, bars, RATIO, MEMBERS))
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
    run = Simulation(model, com, np.array([0.0, 1.0]), angle, rate.copy(), rtol=1e-12)
    a = run.packing.accelerations(0.0, run.y0)
    y, work = layout.pack(com, np.zeros(2), angle, rate), layout.work(model.bars, 0)
    rates = np.zeros_like(y)
    assert evaluate(0.0, y, rates, layout.chain(model), work)
    n = model.bars
    return {
        "reference reaction": a.reaction_N.T,
        "reference angular": a.angle_rad_s2,
        "reference relative": a.position_m_s2.T,
        "reference com": a.com_m_s2,
        "reference gap": run.packing.gaps(run.y0) / model.length_m.max(),
        "reference energy": tidal_energy(model, com[None], angle[None]),
        "compiled reaction": work.bars[[layout.RX, layout.RY], : n - 1],
        "compiled angular": rates[n + 2 : 2 * n + 2],
        "compiled com": rates[2 * n + 2 : 2 * n + 4],
    }


def exact_answers(given) -> dict[str, np.ndarray]:
    """What they should be, by absolute coordinates in exact arithmetic."""
    bars, s = given.bars, given.state
    state = joined(EXACT, bars, s.com_m, s.angle_rad, s.rate_rad_s)
    found = absolute(EXACT, bars, state.absolute)
    place = state.absolute.place_m
    nearness = 1 / EXACT.sqrt(dot(place, place)) - 1 / EXACT.sqrt(dot(s.com_m, s.com_m))
    return {
        "reaction": found.reaction_N,
        "angular": found.angle_rad_s2,
        "relative": found.place_m_s2 - found.com_m_s2[:, None],
        "com": found.com_m_s2,
        "gap": 0 * found.reaction_N[0],
        "energy": -(bars.mass_kg * bars.mu_m3_s2 * nearness).sum(axis=0)[None],
    }


if __name__ == "__main__":
    print(json.dumps({str(kind): errors_of_all(kind) for kind in (Kind.GENERIC, Kind.STRAIGHT)}))
