"""Position from the centre of the body and inertial motion of a bar, in the frame's axes, for effects besides gravity.

The same code serves symbolic numbers and NumPy arrays, as in :mod:`adapters.exudyn.loads.gravity`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from adapters.exudyn.frames.axes import OrbitFrame, UniformFrame

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.exudyn.frames.axes import ReferenceFrame
    from adapters.exudyn.frames.numbers import BarMotion, Number, OrbitNumbers
    from adapters.exudyn.frames.orbit import KeplerOrbit
    from adapters.trajectory import Array


@dataclass(frozen=True)
class InertialView:
    """A bar's position relative to the centre of the body, and its inertial motion, all in the frame's axes."""

    x_m: Number
    y_m: Number
    vx_m_s: Number
    vy_m_s: Number
    cosine: Number
    """of the bar's angle from the frame's x axis"""
    sine: Number
    rate_rad_s: Number
    """relative to inertial axes"""

    @property
    def square_m2(self) -> Number:
        """|Z|²."""
        return self.x_m * self.x_m + self.y_m * self.y_m

    @property
    def along_m(self) -> Number:
        """P = u·Z."""
        return self.cosine * self.x_m + self.sine * self.y_m

    @property
    def across_m(self) -> Number:
        """Q = n·Z."""
        return self.cosine * self.y_m - self.sine * self.x_m

    def to_frame(self, along: Number, across: Number) -> tuple[Number, Number]:
        """Components in the frame's axes of a vector given along the bar and across it."""
        return self.cosine * along - self.sine * across, self.sine * along + self.cosine * across

    def to_bar(self, x: Number, y: Number) -> tuple[Number, Number]:
        """Components along the bar and across it of a vector given in the frame's axes."""
        return self.cosine * x + self.sine * y, self.cosine * y - self.sine * x


class FrameOrigin(ABC):
    """Position and motion of the frame's origin, as far as they depend on time."""

    time_input_count: int
    """Number of quantities in :meth:`view` that depend on time alone"""

    @abstractmethod
    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Values of the time inputs, see :data:`adapters.exudyn.timetable.TimeInputs`."""

    @abstractmethod
    def view(self, m: BarMotion, orbit: OrbitNumbers | None, inputs: Sequence[Number]) -> InertialView:
        """Inertial view of a bar from its motion in the frame."""


@final
class OrbitOrigin(FrameOrigin):
    """Origin on the Kepler orbit, with rotating axes."""

    def __init__(self, orbit: KeplerOrbit, *, moving: bool) -> None:
        """Prepare views; the radial velocity is tabulated only where a load needs it and it is not zero."""
        self.orbit = orbit
        self.time_input_count = 1 if moving and not orbit.circular else 0

    def time_inputs(self, at_s: Array, _inside_s: Array) -> Array:
        """Rate r' of the origin's distance."""
        return self.orbit.at(at_s).radial_velocity_m_s[:, None][:, : self.time_input_count]

    def view(self, m: BarMotion, orbit: OrbitNumbers | None, inputs: Sequence[Number]) -> InertialView:
        """Position (r + x, y), and its rate in rotating axes."""
        assert orbit is not None
        w, x, y = orbit.rate_rad_s, orbit.radius_m + m.x_m, m.y_m
        vx = m.vx_m_s - w * y
        return InertialView(
            x, y, inputs[0] + vx if inputs else vx, m.vy_m_s + w * x, m.cosine, m.sine, m.spin_rad_s + w
        )


@final
class UniformOrigin(FrameOrigin):
    """Origin in uniform motion, axes parallel to the inertial ones."""

    time_input_count = 2

    def __init__(self, frame: UniformFrame) -> None:
        self.frame = frame
        self.drift = frame.at(np.zeros(1)).origin_velocity_m_s[0].tolist()

    def time_inputs(self, at_s: Array, _inside_s: Array) -> Array:
        """Position of the frame's origin."""
        return self.frame.at(at_s).origin_m

    def view(self, m: BarMotion, _orbit: OrbitNumbers | None, inputs: Sequence[Number]) -> InertialView:
        """Sum of origin and offset."""
        (x, y), (vx, vy) = inputs, self.drift
        return InertialView(x + m.x_m, y + m.y_m, vx + m.vx_m_s, vy + m.vy_m_s, m.cosine, m.sine, m.spin_rad_s)


@final
class FixedOrigin(FrameOrigin):
    """Origin at the centre of the body."""

    time_input_count = 0

    def time_inputs(self, at_s: Array, _inside_s: Array) -> Array:
        """No inputs."""
        return np.empty((len(at_s), 0))

    def view(self, m: BarMotion, _orbit: OrbitNumbers | None, _inputs: Sequence[Number]) -> InertialView:
        """The bar's motion itself."""
        return InertialView(m.x_m, m.y_m, m.vx_m_s, m.vy_m_s, m.cosine, m.sine, m.spin_rad_s)


def frame_origin(frame: ReferenceFrame, *, moving: bool) -> FrameOrigin:
    """Origin of a frame; `moving` if a load needs velocities."""
    if isinstance(frame, OrbitFrame):
        return OrbitOrigin(frame.orbit, moving=moving)
    return UniformOrigin(frame) if isinstance(frame, UniformFrame) else FixedOrigin()
