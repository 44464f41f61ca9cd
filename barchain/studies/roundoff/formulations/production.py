"""The reference and its compiled form as formulations: double precision only, one state after the other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.studies.roundoff.formulations.definitions import Given, MinimalAngles, RelativePlaces
from reference_impl.kernel import layout
from reference_impl.kernel.library import evaluate
from reference_impl.model import relative
from reference_impl.model.chain import ChainModel
from reference_impl.model.state import State
from reference_impl.precision.arithmetic import FLOAT64

if TYPE_CHECKING:
    from reference_impl.precision.arithmetic import Arithmetic, Values
    from reference_impl.precision.chain import ChainParameters

NOTHING = np.zeros(2)


def model_of(bars: ChainParameters, member: int) -> ChainModel:
    """One member's chain, in the paper's gravity."""
    mass, length, inertia = (v[:, member].copy() for v in (bars.mass_kg, bars.length_m, bars.inertia_kg_m2))
    return ChainModel(float(bars.mu_m3_s2[member]), mass, length, inertia, "gradient")


class NumPyReference(RelativePlaces):
    """The code that `reference` runs."""

    name = "reference"

    def reactions(self, a: Arithmetic, given: Given) -> Values:
        """Of each member."""
        assert a is FLOAT64
        s = given.state
        found = []
        for k in range(s.com_m.shape[-1]):
            place = np.ascontiguousarray(s.position_m[..., k].T)
            state = State(s.com_m[:, k].copy(), NOTHING, s.angle_rad[:, k], s.rate_rad_s[:, k], place, 0.0 * place)
            found.append(relative.accelerations(model_of(given.bars, k), 0.0, state).reaction_N.T)
        return np.stack(found, axis=-1)


class CompiledReference(MinimalAngles):
    """The code that `reference-fast` runs, which makes places of the angles itself."""

    name = "reference-fast"

    def reactions(self, a: Arithmetic, given: Given) -> Values:
        """Of each member."""
        assert a is FLOAT64
        s, found = given.state, []
        for k in range(s.com_m.shape[-1]):
            model = model_of(given.bars, k)
            work = layout.workspace(model.bars, 0)
            y = layout.pack(s.com_m[:, k], NOTHING, s.angle_rad[:, k], s.rate_rad_s[:, k])
            if not evaluate(0.0, y, np.zeros_like(y), layout.compiled_chain(model), work):
                raise np.linalg.LinAlgError("the joint system is not positive definite in double precision")
            found.append(work.bars[[layout.RX, layout.RY], : model.bars - 1].copy())
        return np.stack(found, axis=-1)


PRODUCTION = {f.name: f for f in (NumPyReference(), CompiledReference())}
