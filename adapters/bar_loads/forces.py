"""Forces on bars besides gravity, the same in every frame: drag, sunlight, springs, motors, thrusts; and impulses.

Laws and symbols as in docs/effects.
"""

from __future__ import annotations

from itertools import pairwise
from math import copysign, cos, exp, hypot, sin
from typing import TYPE_CHECKING

from adapters.bar_loads.interface import BarLoad, FaceDependentLoad
from scenarios import Axes, End

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, FrameState, Load
    from scenarios import Drag, Impulse, JointSpringDamper, JointTorque, SolarPressure, Thrust


class DragLoad(FaceDependentLoad):
    """Force and torque of the air on each bar: free-molecular flow on a flat bar."""

    of_rates = True

    def __init__(self, bars: list[BarProperties], drag: Drag, radius_m: float) -> None:
        """Drag about a body of `radius_m`."""
        self.bars, self.drag = list(zip(bars, drag.width_m, strict=True)), drag
        self.reference_m = radius_m + drag.altitude_m

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        r0 = hypot(frame.x, frame.y)
        faces = self.held or [0.0] * len(self.bars)
        return [
            self.load(frame, r0, position, rate, bar, width, face)
            for position, rate, (bar, width), face in zip(positions, rates, self.bars, faces, strict=True)
        ]

    def load(
        self,
        frame: FrameState,
        r0: float,
        position: BarPosition,
        rate: BarRate,
        bar: BarProperties,
        width: float,
        face: float,
    ) -> Load:
        """Load of one bar; the frame's origin is `r0` m from the body's centre, a `face` of 0 that of the state."""
        (x, y, angle), (vx, vy, w), drag = position, rate, self.drag
        px, py, c, s = frame.x + x, frame.y + y, cos(angle), sin(angle)
        r = hypot(px, py)
        higher = ((frame.x + px) * x + (frame.y + py) * y) / (r + r0)  # r - r0
        density = drag.density_kg_m3 * exp((self.reference_m - r0 - higher) / drag.scale_height_m)
        kappa = (c * px + s * py) / (r * drag.scale_height_m)
        turn = drag.rotation_rad_s
        wx, wy, w = frame.vx + vx + turn * py, frame.vy + vy - turn * px, w - turn
        across, along, length = c * wy - s * wx, c * wx + s * wy, 2.0 * bar.half_length_m
        i2, i4 = length**3 / 12.0, length**5 / 80.0
        k = -0.5 * width * density * (face or copysign(1.0, across))
        normal = k * drag.normal_coefficient * (across * (length * across - 2.0 * kappa * i2 * w) + i2 * w * w)
        tangent = k * drag.tangential_coefficient * along * (length * across - kappa * i2 * w)
        square = i2 * across * across + i4 * w * w
        torque = k * drag.normal_coefficient * (2.0 * i2 * across * w - kappa * square)
        return (
            (tangent * c - normal * s) / bar.mass_kg,
            (tangent * s + normal * c) / bar.mass_kg,
            torque / bar.inertia_kg_m2,
        )

    def incidence(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[float]:
        """Sine of the angle between each bar and its velocity relative to the air."""
        turn, found = self.drag.rotation_rad_s, []
        for (x, y, a), (vx, vy, _) in zip(positions, rates, strict=True):
            wx, wy = frame.vx + vx + turn * (frame.y + y), frame.vy + vy - turn * (frame.x + x)
            found.append((cos(a) * wy - sin(a) * wx) / hypot(wx, wy))
        return found


class SunlightLoad(FaceDependentLoad):
    """Force of the light on each flat bar, without shadow."""

    def __init__(self, bars: list[BarProperties], light: SolarPressure) -> None:
        """Light of a scene."""
        self.light = light
        areas = zip(bars, light.width_m, strict=True)
        self.weight = [light.pressure_Pa * width * 2.0 * bar.half_length_m / bar.mass_kg for bar, width in areas]

    def sun(self, t_s: float) -> tuple[float, float]:
        """Unit vector to the Sun."""
        longitude = self.light.sun_longitude_rad + self.light.sun_rate_rad_s * t_s
        return cos(longitude), sin(longitude)

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        del rates
        sx, sy = self.sun(frame.t_s)
        faces = self.held or [0.0] * len(self.weight)
        return [
            self.load(sx, sy, angle, weight, face)
            for (_, _, angle), weight, face in zip(positions, self.weight, faces, strict=True)
        ]

    def load(self, sx: float, sy: float, angle: float, weight: float, face: float) -> Load:
        """Load of one bar.

        `weight` is the acceleration in m/s² of a black bar normal to the light; a `face` of 0 is that of the state.
        """
        c, s, mirrored = cos(angle), sin(angle), self.light.reflectivity
        facing = c * sy - s * sx
        side = 2.0 * mirrored * facing  # 2 rho k n' = 2 rho (n·s) n
        k = -weight * facing * (face or copysign(1.0, facing))
        return k * ((1.0 - mirrored) * sx - side * s), k * ((1.0 - mirrored) * sy + side * c), 0.0

    def incidence(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[float]:
        """Sine of the angle between each bar and the direction of the Sun."""
        del rates
        sx, sy = self.sun(frame.t_s)
        return [cos(a) * sy - sin(a) * sx for _, _, a in positions]


class SpringLoad(BarLoad):
    """Joint springs and dampers as torques on bars."""

    def __init__(self, bars: list[BarProperties], springs: JointSpringDamper) -> None:
        """Springs and dampers of a scene."""
        self.inertia = [bar.inertia_kg_m2 for bar in bars]
        self.stiff = list(zip(springs.stiffness_N_m_rad, springs.rest_rad, strict=True))
        self.damping = springs.damping_N_m_s_rad
        self.of_rates = any(self.damping)

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar: the torque of each joint on the bar behind it, and the opposite one on the bar before."""
        del frame
        bent = [b - a for (*_, a), (*_, b) in pairwise(positions)]
        found = [-k * (bend - rest) for (k, rest), bend in zip(self.stiff, bent, strict=True)]
        if self.of_rates:
            turning = [b - a for (*_, a), (*_, b) in pairwise(rates)]
            found = [torque - c * w for torque, c, w in zip(found, self.damping, turning, strict=True)]
        before, after = [0.0, *found], [*found, 0.0]
        return [(0.0, 0.0, (a - b) / J) for a, b, J in zip(before, after, self.inertia, strict=True)]


class MotorLoad(BarLoad):
    """Torques of motors in joints."""

    def __init__(self, bars: list[BarProperties], motors: tuple[JointTorque, ...]) -> None:
        """Motors of a scene."""
        self.inertia, self.motors = [bar.inertia_kg_m2 for bar in bars], motors

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        del positions, rates
        torque = [0.0] * len(self.inertia)
        for motor in self.motors:
            size = size_on_segment(motor, frame.t_s, frame.inside_s)
            torque[motor.joint - 1] -= size
            torque[motor.joint] += size
        return [(0.0, 0.0, one / J) for one, J in zip(torque, self.inertia, strict=True)]


class ThrustLoad(BarLoad):
    """Thrusts on bars' ends."""

    def __init__(self, bars: list[BarProperties], thrusts: tuple[Thrust, ...]) -> None:
        """Thrusts of a scene."""
        self.bars, self.thrusts = bars, thrusts

    def __call__(self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate]) -> list[Load]:
        """Load of each bar."""
        del rates
        found = [(0.0, 0.0, 0.0)] * len(self.bars)
        for thrust in self.thrusts:
            j, size = thrust.bar - 1, size_on_segment(thrust, frame.t_s, frame.inside_s)
            if size:
                found[j] = sum_of_loads(found[j], end_force_load(thrust, size, positions[j][2], self.bars[j]))
        return found


def size_on_segment(table: Thrust | JointTorque, t_s: float, inside_s: float) -> float:
    """Force, N, or torque, N m, at `t_s` on the straight segment of the table around `inside_s`."""
    for (t0, f0), (t1, f1) in pairwise(zip(table.times_s, table.sizes, strict=True)):
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
    arm = bar.right_m if where.end is End.RIGHT else -bar.left_m
    torque = arm * (cos(angle) * fy - sin(angle) * fx)
    return fx / bar.mass_kg, fy / bar.mass_kg, torque / bar.inertia_kg_m2


def sum_of_loads(a: Load, b: Load) -> Load:
    """Sum of two loads."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]
