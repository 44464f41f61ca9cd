"""Mistakes in the equations of motion: in the reference's code, or in the chain that an engine is given."""

from __future__ import annotations

import contextlib
import dataclasses
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import numpy as np

from adapters.common.reference_model import chain_model
from adapters.reference import numpy_engines as reference_adapter
from adapters.reference.numpy_engines import Reference
from barchain.studies.selftest.faults import reasons
from barchain.studies.selftest.faults.fault import Fault, FaultGroup, Size
from reference_impl.model import relative
from reference_impl.model.gravity import point_field
from reference_impl.model.kinematics import by_levers
from reference_impl.model.relative import ReactionSolution, external_accelerations

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager

    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.faults.fault import CodeChange
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.state import State
    from scenarios import Scene


def other_model(change: Callable[[ChainModel, float], ChainModel]) -> CodeChange:
    """The reference given another model than the scene's."""

    def within(size: float) -> AbstractContextManager[object]:
        return patch.object(reference_adapter, "chain_model", lambda scene: change(chain_model(scene), size))

    return within


def of_chain(scene: Scene, **values: Any) -> Scene:
    """Scene with another chain."""
    return dataclasses.replace(scene, chain=dataclasses.replace(scene.chain, **values))


def heavier(scene: Scene, size: float) -> Scene:
    """Scene whose last bar is too heavy, its moment of inertia right."""
    mass = scaled(np.array(scene.chain.mass_kg), -1, 1.0 + size)
    return of_chain(scene, mass_kg=tuple(map(float, mass)))


def scaled(values: Array, bar: int, factor: float) -> Array:
    """Values with that of one bar scaled."""
    changed = values.copy()
    changed[bar] *= factor
    return changed


def less_centrifugal(size: float) -> AbstractContextManager[object]:
    """Ends of bars without a part of theta'^2 l/2."""

    class WrongReactions(ReactionSolution):
        def __init__(self, model: ChainModel, state: State, *given: Any, **how: Any) -> None:
            slower = dataclasses.replace(state, rate_rad_s=state.rate_rad_s * np.sqrt(1.0 - size))
            super().__init__(model, slower, *given, **how)

    return patch.object(relative, "ReactionSolution", WrongReactions)


def wrong_lever(size: float) -> AbstractContextManager[object]:
    """Reactions at left ends that turn their bars the wrong way."""
    del size

    def levered(self: ReactionSolution, reaction: ComplexArray) -> Array:
        before, after = np.zeros((2, self.model.bars), complex)
        after[:-1] = before[1:] = reaction
        before, after = by_levers(self.model, before, after)
        turned: Array = self.model.lever * (self.unit.conj() * (after - before)).imag
        return turned

    return patch.object(ReactionSolution, "rotation_from_reactions", levered)


def nothing_holds(self: ReactionSolution, torque: Array) -> ComplexArray:
    """No reactions."""
    del torque
    return np.zeros_like(self.torque_free_reactions)


def silent_joints(size: float) -> AbstractContextManager[object]:
    """Bars that turn as if free, drawn as if joined."""
    del size
    return patch.object(ReactionSolution, "reaction", nothing_holds)


@contextlib.contextmanager
def open_joints(size: float) -> Iterator[None]:
    """Free bars, in coordinates in which joints may open."""
    with silent_joints(size), patch.object(Reference, "coordinate_set", "redundant"):
        yield


def particle(size: float) -> AbstractContextManager[object]:
    """Centre of mass without the bars' own positions in its gravity."""

    def wrong(model: ChainModel, state: State, unit: ComplexArray) -> tuple[Array, ComplexArray, Array]:
        field, tide, spin = external_accelerations(model, state, unit)
        alone = point_field(model.mu_m3_s2, state.com_m)
        return field + size * (alone - field), tide, spin

    return patch.object(relative, "external_accelerations", wrong)


def no_tide(size: float) -> AbstractContextManager[object]:
    """Motion about the centre of mass without a part of the differences of gravity."""

    def wrong(model: ChainModel, state: State, unit: ComplexArray) -> tuple[Array, ComplexArray, Array]:
        field, tide, spin = external_accelerations(model, state, unit)
        return field, tide * (1.0 - size), spin

    return patch.object(relative, "external_accelerations", wrong)


def single_numbers(model: ChainModel, size: float) -> ChainModel:
    """Model whose numbers went through single precision."""
    del size

    def single(values: Array) -> Array:
        return values.astype(np.float32).astype(np.float64)

    return dataclasses.replace(
        model,
        mu_m3_s2=float(np.float32(model.mu_m3_s2)),
        mass_kg=single(model.mass_kg),
        length_m=single(model.length_m),
        inertia_kg_m2=single(model.inertia_kg_m2),
    )


def same_in_single(solution: ReferenceSolution) -> str:
    """Scenes with a number that single precision changes; mu counts only where something pulls."""
    model = chain_model(solution.scene)
    numbers = [model.mass_kg, model.length_m, model.inertia_kg_m2] if model.bars > 1 else []
    numbers += [np.array([model.mu_m3_s2])] if model.gravity != "none" else []
    exact = all(np.array_equal(v, v.astype(np.float32)) for v in numbers)
    return "all numbers of the model are exact in single precision" if exact else ""


PART = Size(1.0)
PERCENT = Size(1e-2, most=1.0)
SINGLE = Fault(
    "float32-model",
    "masses, lengths, moments of inertia and mu through single precision",
    "a model file written in single precision",
    FaultGroup.ACCURACY,
    code=other_model(single_numbers),
    nothing=same_in_single,
)
HEAVIER = Fault("mass", "the last bar too heavy, its moment of inertia right", "one entry of a mass matrix",
                FaultGroup.EQUATIONS, scene=heavier, size=PERCENT, nothing=reasons.joints)  # fmt: skip
FAULTS = (
    Fault("centrifugal-missing", "the ends' accelerations without (a part of) theta'² l/2",
          "a term forgotten in eq. (19)", FaultGroup.EQUATIONS, code=less_centrifugal, size=PART,
          nothing=reasons.joints),
    Fault("lever-sign", "the reaction at a bar's left end turns it the wrong way",
          "R_j - R_(j-1) for R_j + R_(j-1) in eq. (15)", FaultGroup.EQUATIONS, code=wrong_lever,
          nothing=reasons.joints),
    Fault("joints-ignored", "bars move as if free, and their ends part", "constraints not assembled",
          FaultGroup.EQUATIONS, code=open_joints, nothing=reasons.first_of(reasons.joints, reasons.no_motor)),
    Fault("joints-ignored-in-silence", "bars turn as if free, gaps are said to be closed",
          "constraint forces computed and not applied", FaultGroup.EQUATIONS, code=silent_joints,
          nothing=reasons.first_of(reasons.joints, reasons.no_motor)),
    Fault("inertia", "moments of inertia too large", "m l²/12 with another length or mass", FaultGroup.EQUATIONS,
          code=other_model(lambda m, s: dataclasses.replace(m, inertia_kg_m2=m.inertia_kg_m2 * (1.0 + s))),
          size=PERCENT, nothing=reasons.inertia),
    HEAVIER,
    dataclasses.replace(HEAVIER, name="mass-stuck", stands_for="a cached result", stuck=True,
                        words="the last bar too heavy, and one setting whatever is asked for"),
    Fault("length", "the first bar too long", "a joint in the wrong place", FaultGroup.EQUATIONS,
          code=other_model(lambda m, s: dataclasses.replace(m, length_m=scaled(m.length_m, 0, 1.0 + s))),
          size=PERCENT, nothing=reasons.joints),
    Fault("com-decoupled", "the centre of mass moves as a particle, whatever the bars' places",
          "global and relative motion not coupled, eq. (9)", FaultGroup.EQUATIONS, code=particle, size=PART,
          nothing=reasons.first_of(reasons.gravity, reasons.joints)),
    Fault("tide-missing", "the motion about the centre of mass without (a part of) the differences of gravity",
          "relative motion not coupled to the orbit, eq. (13)", FaultGroup.EQUATIONS, code=no_tide, size=PART,
          nothing=reasons.first_of(reasons.gravity, reasons.joints)),
)  # fmt: skip
