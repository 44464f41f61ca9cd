"""Effect of each of the paper's misprints, measured on a generic state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.chain import BarTurn, ChainModel, Prescription
from reference_impl.model.kinematics import consistent_state
from reference_impl.paper.form import NotSquareError, PaperSolution, solve
from reference_impl.paper.misprints import ERRATA, Misprint, MisprintConsequence
from reference_impl.paper.state import units_of

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.state import State

SEED = 2002  # arbitrary, fixed for a reproducible table
EARTH_MU_M3_S2 = 3.986004418e14
EARTH_RADIUS_M = 6378e3
UNEQUAL_LENGTHS_M = (100.0, 80.0, 120.0, 60.0, 90.0)  # for the misprint without effect on equal bars


@dataclass(frozen=True)
class MisprintEffect:
    """One row of the table."""

    id: str
    place: str
    printed: str
    right: str
    effect_on_reactions: float | None
    """Largest change of a reaction component relative to the largest; None if not computable"""
    effect_on_angular_acceleration: float | None
    """Largest change of phi_j'', the paper's unknown, relative to the largest"""
    note: str


def generic_model(length_m: tuple[float, ...] = (100.0,) * 5) -> ChainModel:
    """Five bars of different masses around the Earth."""
    mass, length = np.array([100.0, 60.0, 130.0, 80.0, 40.0]), np.array(length_m)
    return ChainModel(EARTH_MU_M3_S2, mass, length, mass * length**2 / 12.0, "gradient", EARTH_RADIUS_M)


def generic_state(model: ChainModel) -> State:
    """Random angles and rates, on an ascending orbit."""
    random = np.random.default_rng(SEED)
    longitude = random.uniform(-np.pi, np.pi)
    radial, across = (
        np.array([np.cos(longitude), np.sin(longitude)]),
        np.array([-np.sin(longitude), np.cos(longitude)]),
    )
    radius = 1.2 * EARTH_RADIUS_M
    speed = np.sqrt(EARTH_MU_M3_S2 / radius)
    angle = random.uniform(-np.pi, np.pi, model.bars)
    rate = speed / radius * random.uniform(-1.0, 2.0, model.bars)
    return consistent_state(model, radius * radial, speed * (across + 0.3 * radial), angle, rate)


def misprint_effects() -> list[MisprintEffect]:
    """All misprints with their measured effects, in the table's order."""
    return [measured_effect(misprint) for misprint in Misprint]


def measured_effect(misprint: Misprint) -> MisprintEffect:
    """Row of one misprint: the corrected solution against the solution with that misprint."""
    entry = ERRATA[misprint]
    reactions = angles = None
    note = f"{entry.effect}: {entry.reason}"
    if entry.effect is MisprintConsequence.NOT_SOLVABLE:
        note = f"{entry.effect}: {rejection(misprint)}"
    elif entry.effect is not MisprintConsequence.TEXT_ONLY:
        model = generic_model(UNEQUAL_LENGTHS_M) if misprint is Misprint.HALF_LENGTH else generic_model()
        right, wrong = generic_solution(model, frozenset()), generic_solution(model, frozenset({misprint}))
        reactions = relative_change(wrong.reaction, right.reaction)
        angles = relative_change(wrong.bars[:, 2], right.bars[:, 2])
    return MisprintEffect(misprint.value, entry.place, entry.printed, entry.right, reactions, angles, note)


def generic_solution(model: ChainModel, as_printed: frozenset[Misprint]) -> PaperSolution:
    """Solution of the paper's equations at the generic state of a model."""
    state = generic_state(model)
    return solve(model, 0.0, state, units_of(model, state.com_m), as_printed)


def rejection(misprint: Misprint) -> str:
    """Error message of the paper's formulation for a prescribed rotation with this misprint."""
    slewed = Prescription(4, (BarTurn(np.pi / 4, 60.0, 0.0),), frame="local_horizontal", reacts_on=None)
    try:
        generic_solution(replace(generic_model(), prescriptions=(slewed,)), frozenset({misprint}))
    except NotSquareError as error:
        return str(error)
    raise AssertionError(f"{misprint} was solvable")


def relative_change(wrong: Array, right: Array) -> float:
    """Largest change relative to the largest magnitude."""
    return float(np.abs(wrong - right).max() / np.abs(right).max())
