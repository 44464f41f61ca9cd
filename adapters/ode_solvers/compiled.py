"""The kernel's right-hand side for library solvers: rates from Python, and C functions that CVODE calls by address.

CVODE passes vectors as `N_Vector` and :class:`reference_impl.kernel.layout.CvodeData` as `user_data`; the functions are
those of ``reference_impl/kernel/c/cvode.c``. The state is that of :mod:`reference_impl.kernel.layout`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.solver_driver import CFunctions
from reference_impl.kernel import layout
from reference_impl.kernel.library import address, height_above_surface
from reference_impl.kernel.simulate import CompiledRates, modes_at, reference_order, set_modes
from reference_impl.model.joints import NOT_POSITIVE_DEFINITE

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import Modes

EVALUATIONS, EVENT_CALLS, LOST = range(3)  # of CvodeData.counts


class RatesFunction(CompiledRates):
    """Rates of a chain in machine code, in the kernel's order of components."""

    def __init__(self, model: ChainModel) -> None:
        """Load the kernel, and bind its rates to arrays."""
        order, chain = reference_order(model.bars), layout.compiled_chain(model)
        super().__init__(chain, layout.workspace_of(chain), np.zeros(len(order)), order, model)
        self.hold(None)

    def hold(self, modes: Modes | None) -> None:
        """Set the modes of a smooth segment; None follows from each evaluated state."""
        self.held: Modes = modes or (None,) * len(self.chain.effects)
        self.following = any(e.mode.size and m is None for e, m in zip(self.chain.effects, self.held, strict=True))
        """Whether modes of effects follow from each evaluated state; a C caller can't set these"""
        set_modes(self.chain, self.held)

    def rates_at(self, t_s: float, y: Array) -> Array:
        """Time derivative of a state, both (size,) in the compiled order.

        Raises
        ------
        numpy.linalg.LinAlgError
            If the joint system is not positive definite in double precision.
        """
        if self.following:
            now = modes_at(self, t_s, y[self.order])
            set_modes(self.chain, tuple(n if m is None else m for m, n in zip(self.held, now, strict=True)))
        self.y[:] = y
        if not self.evaluation(t_s):
            raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
        return self.slopes.copy()


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
        self.data = layout.CvodeData(
            data_of, own.chain, own.work, model.left_m, model.right_m, model.weight, float(model.body_radius_m),
            self.counted,
        )  # fmt: skip
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
