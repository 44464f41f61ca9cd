"""Interface of an effect's load on a bar in Exudyn: a function of the bar's view and of inputs of time alone."""

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

    BarForce = tuple[Number, Number, Number | None]
    """Force along x and y of the frame's axes (N); torque (N m), None where there is none"""


class ExudynLoad(ABC):
    """Load of one effect."""

    time_input_count = 0
    """Number of inputs of the load that depend on time alone"""

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Values of the time inputs, (k, time_input_count), see :data:`adapters.exudyn.timetable.TimeInputs`."""
        del inside_s
        return np.empty((len(at_s), 0))

    def acts_on(self, bar: int) -> bool:
        """Whether the effect acts on `bar`, counted from 0."""
        del bar
        return True

    @abstractmethod
    def load(self, bar: int, view: InertialView, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Load on a bar.

        Parameters
        ----------
        bar : int
            Counted from 0.
        view : InertialView
        inputs : sequence of `time_input_count` numbers
        xp : module
            Functions of these numbers: numpy, or Exudyn's symbolic.
        """


def directions_of(frame: ReferenceFrame, at_s: Array, angle_rad: Array) -> Array:
    """Unit vectors (k, 2) in the frame's axes at angles (k,) from the z1 axis."""
    angle = angle_rad - frame.at(at_s).turn_rad
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
