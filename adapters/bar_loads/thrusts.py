"""Forces and impulses on the ends of bars, in plain floats: docs/effects/thrust.md."""

from __future__ import annotations

from itertools import pairwise
from math import cos, sin
from typing import TYPE_CHECKING, ClassVar

from scenarios import Axes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, FrameState, Load
    from scenarios import Impulse, Thrust


class ThrustLoad:
    """Thrusts on bars' ends."""

    of_rates: ClassVar[bool] = False

    def __init__(self, bars: list[BarProperties], thrusts: tuple[Thrust, ...]) -> None:
        """Thrusts of a scene."""
        self.bars, self.thrusts = bars, thrusts

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        del rates
        found = [(0.0, 0.0, 0.0)] * len(self.bars)
        for thrust in self.thrusts:
            j, size = thrust.bar - 1, size_N(thrust, frame.t_s, frame.inside_s)
            if size:
                found[j] = sum_of_loads(found[j], end_force_load(thrust, size, positions[j][2], self.bars[j]))
        return found


def size_N(thrust: Thrust, t_s: float, inside_s: float) -> float:
    """Force at `t_s` on the straight segment of the table around `inside_s`, N."""
    for (t0, f0), (t1, f1) in pairwise(zip(thrust.times_s, thrust.force_N, strict=True)):
        if t0 < inside_s < t1:
            return f0 + (f1 - f0) * ((t_s - t0) / (t1 - t0))
    return 0.0


def impulse_jumps(bars: list[BarProperties], impulses: Sequence[Impulse], angles: Sequence[float]) -> list[Load]:
    """Jumps of each bar's velocities by simultaneous impulses on free bars.

    In the joint system they take the place of accelerations by forces, with all rates zero.

    Parameters
    ----------
    bars : list of BarProperties
    impulses : sequence of Impulse
    angles : sequence of float
        Absolute angles of all bars, rad.

    Returns
    -------
    list of tuple
        Jumps of the centre's velocity (m/s, m/s) and of the rate (rad/s), for each bar.
    """
    found = [(0.0, 0.0, 0.0)] * len(bars)
    for impulse in impulses:
        j = impulse.bar - 1
        found[j] = sum_of_loads(found[j], end_force_load(impulse, impulse.impulse_N_s, angles[j], bars[j]))
    return found


def end_force_load(where: Thrust | Impulse, size: float, angle: float, bar: BarProperties) -> Load:
    """Accelerations by a force of `size` (or jumps by an impulse) on the end of a bar at `angle`."""
    aim = where.direction_rad + (angle if where.axes is Axes.BODY else 0.0)
    fx, fy = size * cos(aim), size * sin(aim)
    torque = where.end.sign * bar.half_length_m * (cos(angle) * fy - sin(angle) * fx)
    return fx / bar.mass_kg, fy / bar.mass_kg, torque / bar.inertia_kg_m2


def sum_of_loads(a: Load, b: Load) -> Load:
    """Sum of two loads."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]
