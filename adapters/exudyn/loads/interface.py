"""Interface of an effect's load on a bar in Exudyn: a function of the bar's view and of numbers of time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.exudyn.frames.axes import ReferenceFrame
    from adapters.exudyn.frames.inertial_view import InertialView
    from adapters.exudyn.frames.numbers import Number
    from adapters.trajectory import Array

    Extra = tuple[Number, Number, Number | None]
    """Force along x and y of the frame's axes (N); torque (N m), None where there is none"""


class ExudynLoad(ABC):
    """Load of one effect."""

    width = 0
    """Number of time-dependent numbers of the load"""

    def given(self, at_s: Array, inside_s: Array) -> Array:
        """Values of these numbers, (k, width), see :data:`adapters.exudyn.timetable.Given`."""
        del inside_s
        return np.empty((len(at_s), 0))

    def acts_on(self, bar: int) -> bool:
        """Whether the effect acts on `bar`, counted from 0."""
        del bar
        return True

    @abstractmethod
    def load(self, bar: int, view: InertialView, numbers: Sequence[Number], math: Any) -> Extra:
        """Load on a bar.

        Parameters
        ----------
        bar : int
            Counted from 0.
        view : InertialView
        numbers : sequence of `width` numbers
        math : module
            With sqrt, exp, sign and abs for these numbers: numpy, or Exudyn's symbolic.
        """


def directions_of(frame: ReferenceFrame, at_s: Array, angle_rad: Array) -> Array:
    """Unit vectors (k, 2) in the frame's axes at angles (k,) from the z1 axis."""
    angle = angle_rad - frame.at(at_s).turn_rad
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
