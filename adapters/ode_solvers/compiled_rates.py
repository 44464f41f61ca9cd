"""The kernel's right-hand side for library solvers, with the memory that it uses.

The state is that of :mod:`reference_impl.kernel.layout`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.integrate.coordinate_sets import MinimalCoordinates
from reference_impl.kernel import layout
from reference_impl.kernel.library import Evaluation
from reference_impl.kernel.simulate import modes_at, reference_order
from reference_impl.model.joints import NOT_POSITIVE_DEFINITE

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import Modes


class RatesFunction:
    """Rates of a chain in machine code."""

    def __init__(self, model: ChainModel) -> None:
        """Load the kernel, and bind its rates to arrays."""
        self.order = reference_order(model.bars)
        """Indices of the NumPy reference's components in a compiled state, (size,)"""
        self.size, self.model = len(self.order), model
        self.coordinates = MinimalCoordinates(model)
        self.chain = layout.compiled_chain(model)
        self.work = layout.workspace_of(self.chain)
        self.state, self.slopes = np.zeros(self.size), np.zeros(self.size)
        self.evaluation = Evaluation(self.state, self.slopes, self.chain, self.work)
        self.hold(None)

    def hold(self, modes: Modes | None) -> None:
        """Set the modes of a smooth segment; None follows from each evaluated state."""
        self.modes: Modes = modes or (None,) * len(self.chain.effects)
        self.following = any(e.mode.size and m is None for e, m in zip(self.chain.effects, self.modes, strict=True))
        """Whether modes of effects follow from each evaluated state; a C caller can't set these"""
        self.set_modes(self.modes)

    def set_modes(self, modes: Modes) -> None:
        """Set the modes in the compiled chain."""
        for effect, mode in zip(self.chain.effects, modes, strict=True):
            if mode is not None:
                effect.mode[:] = mode

    def rates(self, t_s: float, y: Array) -> Array:
        """Time derivative of a state, both (size,) in the compiled order.

        Raises
        ------
        numpy.linalg.LinAlgError
            If the joint system is not positive definite in double precision.
        """
        if self.following:
            now = modes_at(self.coordinates, t_s, y[self.order])
            self.set_modes(tuple(n if m is None else m for m, n in zip(self.modes, now, strict=True)))
        self.state[:] = y
        if not self.evaluation(t_s):
            raise np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
        return self.slopes.copy()
