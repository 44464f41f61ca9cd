"""Prescribed rotations in Exudyn: a constraint whose multiplier is a pure torque on the bar.

``ObjectConnectorCoordinate`` constrains a bar's angle to an offset from a user function. Its force acts on the two
constrained coordinates only. The offset may therefore depend on the motion. One such quantity is the longitude of the
bar's own centre of mass: the local horizontal moves with it, yet the torque must not act on it. The other is the
neighbour's angle, which makes a joint motor: the constraint

    theta_p - theta_k - (law - theta_k) = 0

is one on theta_p alone, yet its multiplier acts with opposite signs on p and k. Newton's matrix treats the offset as
constant. The neglected terms are of order l/r for the longitude, and reduce the convergence to linear for the motor,
but never enter the residual.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.exudyn.frames import perpendicular
from adapters.exudyn.library import exu, items
from scenarios import Actuator, Frame

if TYPE_CHECKING:
    from adapters.exudyn.frames import FrameAxes
    from adapters.exudyn.time_inputs import Steps
    from scenarios import PrescribedRotation

State = tuple[float, float, float]
"""x, y and angle of a bar in the frame's axes, or their rates"""


def neighbour(p: PrescribedRotation) -> int | None:
    """Bar (counted from 0) that takes the opposite torque; None for an external torque."""
    if p.actuator is Actuator.EXTERNAL:
        return None
    return p.bar - 2 if p.bar > 1 else 1


@dataclass(frozen=True)
class FrameHistory:
    """The frame's own motion at the end of every step, as plain lists for fast access in a callback."""

    origin: list[list[float]]
    """relative to the centre of the body, in the frame's axes"""
    drift: list[list[float]]
    """rate of `origin` in the frame"""
    bearing: list[float]
    """longitude of the orbit in the frame's axes; a bar's own is near it"""
    turn: list[float]
    spin: list[float]


def frame_history(axes: FrameAxes) -> FrameHistory:
    """History of tabulated axes."""
    origin = axes.to_frame(axes.origin_m[:, None])
    motion = axes.to_frame(axes.origin_velocity_m_s[:, None])
    drift = motion - axes.rate_rad_s[:, None, None] * perpendicular(origin)
    return FrameHistory(
        origin[:, 0].tolist(),
        drift[:, 0].tolist(),
        (axes.longitude_rad - axes.turn_rad).tolist(),
        axes.turn_rad.tolist(),
        axes.rate_rad_s.tolist(),
    )


class PrescribedAngle:
    """Offset of one prescribed bar's constraint, and its rate."""

    def __init__(
        self, p: PrescribedRotation, steps: Steps, track: FrameHistory, start: list[State], nodes: list[Any]
    ) -> None:
        """Tabulate the law over the steps.

        Parameters
        ----------
        p : PrescribedRotation
        steps : Steps
        track : Track
            The frame at the steps' ends.
        start : list of (x, y, angle)
            Initial coordinates of all bars.
        nodes : list of NodeIndex
        """
        self.steps, self.track = steps, track
        self.local = p.frame is Frame.LOCAL_HORIZONTAL
        law = np.array([p.law(t)[:2] for t in steps.ends_s.tolist()])
        self.law: list[float] = law[:, 0].tolist()
        self.law_rate: list[float] = law[:, 1].tolist()
        other = neighbour(p)
        self.node, self.other = nodes[p.bar - 1], None if other is None else nodes[other]
        self.start = start[p.bar - 1][2] - self._reference(0, start[p.bar - 1])

    def offset(self, mbs: Any, t_s: float, _item: int, _offset: float) -> float:
        """Prescribed angle, less the neighbour's: offsetUserFunction."""
        i = self.steps.index(t_s)
        prescribed = self.start + self.law[i] + self._reference(i, self._of(mbs, self.node) if self.local else None)
        return prescribed - (self._of(mbs, self.other)[2] if self.other is not None else 0.0)

    def offset_rate(self, mbs: Any, t_s: float, _item: int, _offset: float) -> float:
        """Rate of :meth:`offset`: offsetUserFunction_t."""
        i = self.steps.index(t_s)
        prescribed = self.law_rate[i] + self._reference_rate(i, mbs)
        return prescribed - (self._of(mbs, self.other, rates=True)[2] if self.other is not None else 0.0)

    def _reference(self, i: int, at: State | None) -> float:
        """Angle in the frame's axes of the law's reference direction: the z1 axis, or the bar's own radius."""
        if not self.local or at is None:
            return -self.track.turn[i]
        (ox, oy), bearing = self.track.origin[i], self.track.bearing[i]
        return bearing + math.remainder(math.atan2(oy + at[1], ox + at[0]) - bearing, 2.0 * math.pi)

    def _reference_rate(self, i: int, mbs: Any) -> float:
        if not self.local:
            return -self.track.spin[i]
        (ox, oy), (dx, dy) = self.track.origin[i], self.track.drift[i]
        at, motion = self._of(mbs, self.node), self._of(mbs, self.node, rates=True)
        x, y, vx, vy = ox + at[0], oy + at[1], dx + motion[0], dy + motion[1]
        return (x * vy - y * vx) / (x * x + y * y)

    @staticmethod
    def _of(mbs: Any, node: Any, *, rates: bool = False) -> State:
        output = exu().OutputVariableType
        x, y, angle = mbs.GetNodeOutput(node, output.Coordinates_t if rates else output.Coordinates)
        return float(x), float(y), float(angle)


def constrain(mbs: Any, angle: PrescribedAngle) -> Any:
    """Add the constraint to `mbs`; its multiplier is minus the torque on the bar.

    Returns
    -------
    ObjectIndex
    """
    if angle.other is None:
        ground = mbs.AddNode(items().NodePointGround())
        anchor = mbs.AddMarker(items().MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    else:
        anchor = mbs.AddMarker(items().MarkerNodeCoordinate(nodeNumber=angle.other, coordinate=2))
    marker = mbs.AddMarker(items().MarkerNodeCoordinate(nodeNumber=angle.node, coordinate=2))
    return mbs.AddObject(
        items().ObjectConnectorCoordinate(
            markerNumbers=[anchor, marker],
            offsetUserFunction=angle.offset,
            offsetUserFunction_t=angle.offset_rate,
        )
    )
