"""C functions that CVODE calls: a chain's rates and its height above the surface, with no Python in between.

CVODE passes vectors as `N_Vector` and :class:`reference_impl.kernel.layout.CvodeData` as `user_data`; the functions are
those of ``reference_impl/kernel/c/cvode.c``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.solver_driver import CFunctions
from reference_impl.kernel.layout import CvodeData
from reference_impl.kernel.library import address, height_above_surface
from reference_impl.model.joints import NOT_POSITIVE_DEFINITE

if TYPE_CHECKING:
    from adapters.ode_solvers.compiled_rates import RatesFunction
    from adapters.trajectory import Array

EVALUATIONS, EVENT_CALLS, LOST = range(3)  # of CvodeData.counts


class CompiledFunctions(CFunctions):
    """Compiled functions of one chain."""

    def __init__(self, function: RatesFunction) -> None:
        """Take the functions' addresses."""
        self.function = function
        self.counted = np.zeros(3)
        self.rates, self.height = address("cvode_rates"), address("cvode_height")
        self.read_vectors(0)

    def height_m(self, y: Array) -> float:
        """Least distance of the chain from the surface, m; `y` (size,) in the kernel's order."""
        return height_above_surface(np.ascontiguousarray(y), self.data)

    def read_vectors(self, data_of: int) -> None:
        """Take the address of SUNDIALS' function from a vector to its numbers."""
        own, model = self.function, self.function.model
        self.data = CvodeData(
            data_of, own.chain, own.work, model.half_m, model.weight, float(model.body_radius_m), self.counted
        )
        self.user_data = self.data.address

    def counts(self) -> tuple[int, int]:
        """Evaluations of the rates and of the height since the last call."""
        found = int(self.counted[EVALUATIONS]), int(self.counted[EVENT_CALLS])
        self.counted[[EVALUATIONS, EVENT_CALLS]] = 0.0
        return found

    def failure(self) -> Exception | None:
        """Exception of the last run's equations."""
        if self.counted[LOST] == 0.0:
            return None
        self.counted[LOST] = 0.0
        return np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
