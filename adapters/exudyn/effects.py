"""Loads of the effects on a bar in Exudyn, for its symbolic numbers and for NumPy arrays: laws as in docs/effects.

Each load is a function of the bar's inertial motion in the frame's axes, and of inputs that depend on time alone. It is
an addition to gravity in :mod:`adapters.exudyn.loads`. All are small relative to gravity, so that none needs a
difference of large numbers.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, final

import numpy as np

from adapters.common.step_alignment import half_interval_s
from adapters.exudyn.frames import Number, directions_of
from scenarios import Axes, End

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.exudyn.frames import BarMotion, ReferenceFrame
    from adapters.exudyn.time_inputs import Steps
    from adapters.trajectory import Array
    from scenarios import Gravity, JointTorque, Scene, ThirdBody, Thrust

Vector = tuple[Number, Number]
BarForce = tuple[Number, Number, Number | None]
"""Force along x and y of the frame's axes (N); torque (N m), None where there is none"""
WHOLE = 1e-9  # of half a sample interval: a break this near to a step's end is at it


class ExudynLoad(ABC):
    """Load of one effect."""

    time_input_count = 0
    """Number of inputs of the load that depend on time alone"""

    def __init__(self, scene: Scene, frame: ReferenceFrame) -> None:
        """Load of a scene's effect, in a frame."""
        self.chain, self.called, self.body, self.frame = scene.chain, scene.effects, scene.central_body, frame

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Values of the time inputs, (k, time_input_count), see :data:`adapters.exudyn.time_inputs.TimeInputs`."""
        del inside_s
        return np.empty((len(at_s), 0))

    def acts_on(self, bar: int) -> bool:
        """Whether the effect acts on `bar`, counted from 0."""
        del bar
        return True

    @abstractmethod
    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Load on a bar.

        Parameters
        ----------
        bar : int
            Counted from 0.
        view : BarMotion
            From the centre of the body, inertial, in the frame's axes.
        inputs : sequence of `time_input_count` numbers
        xp : module
            Functions of these numbers: numpy, or Exudyn's symbolic.
        """


def encke(q: Number, xp: Any) -> tuple[Number, Number]:
    """(1+q)^(-3/2) - 1 without cancellation, and (1+q)^(3/2).

    The symbolic form contains q once: with z = -(3/4) log(1+q), the first number is exp(2z) - 1 = 2/(coth(z) - 1), and
    log(1+q) = 2 artanh(1/(1 + 2/q)). Exudyn's numbers follow IEEE 754, so that q = 0 gives 0.
    """
    cube = (1.0 + q) * xp.sqrt(1.0 + q)
    if xp is np:
        return -1.0 * q * (3.0 + q * (3.0 + q)) / (cube * (1.0 + cube)), cube
    return 2.0 / (1.0 / xp.tanh(-1.5 * xp.atanh(1.0 / (1.0 + 2.0 / q))) - 1.0), cube


def fifth_power(square: Number, xp: Any) -> Number:
    """Fifth power r⁵ from r²."""
    return square * square * xp.sqrt(square)


def moment_force(strength: Number, power: float, view: BarMotion) -> Vector:
    """Force `strength` times (2 p u + Z - power (p/r)² Z), with p = u·Z."""
    p = view.along_m
    radial = 1.0 - power * (p * p) / view.square_m2
    return strength * (2.0 * p * view.cosine + radial * view.x_m), strength * (2.0 * p * view.sine + radial * view.y_m)


def has_second_moment_force(gravity: Gravity) -> bool:
    """Whether a field exerts a force on a bar's second moment besides a torque."""
    return gravity.turns and gravity.has_potential


@final
class ExudynQuadrupole(ExudynLoad):
    """Force of a bar's second moment in the central field; its torque is the gradient's."""

    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force (3 mu J/2r⁵) (2 p u + Z - 5 (p/r)² Z), with p = u·Z."""
        del inputs
        strength = 1.5 * self.body.mu_m3_s2 * self.chain.inertia_kg_m2[bar]
        return *moment_force(strength / fifth_power(view.square_m2, xp), 5.0, view), None


@final
class ExudynSlender(ExudynLoad):
    """Exact gravity on a uniform bar, less that on a point: force and torque in closed form."""

    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force (mu m e/r³) (p b u + q g n) and torque (mu m e/r³) p q/(D E T).

        Here h is half the length, p = u·Z, q = n·Z, e = (h/r)², X = 2 + e - 4 p²/r², D = sqrt(1 + e X),
        E = sqrt((1 + e + D)/2) and T = (1 - e + D)/2 = E² - e. The coefficients B and C of docs/effects/gravity.md are
        B = 1 - 1/(D E) = e b and C = 1 - E/(T D) = e g. The factor e is extracted by hand: b and g are of order 1, no
        small number is a difference, and each expression occurs in few places:

            b = (X + D² (1 + X/(1+D))/2)/(D E (D E + 1)),   g = (T (X/(1+D)/2 - 1/2 + X T) - 1)/(T D (T D + E)).
        """
        del inputs
        h, r2, p = 0.5 * self.chain.length_m[bar], view.square_m2, view.along_m
        e = (h * h) / r2
        x = 2.0 + e - 4.0 * (p * p) / r2
        d2 = 1.0 + e * x
        d = xp.sqrt(d2)
        square = 0.5 * (1.0 + e + d)
        t = 0.5 * (1.0 - e + d)
        root = xp.sqrt(square)
        half = 0.5 * x / (1.0 + d)
        b = (x + d2 * (0.5 + half)) / (d2 * square + d * root)
        g = (t * (half - 0.5 + x * t) - 1.0) / (d2 * t * t + t * d * root)
        strength = self.body.mu_m3_s2 * self.chain.mass_kg[bar] * e / (r2 * xp.sqrt(r2))
        q = view.across_m
        fx, fy = view.to_frame(p * b, q * g)
        return strength * fx, strength * fy, strength * p * q / (d * root * t)


@final
class ExudynOblateness(ExudynLoad):
    """Oblateness J2 of the central body, in its equatorial plane."""

    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force -3 B m Z/r⁵ + (15 B J/2r⁷) (Z + 2 p u - 7 (p/r)² Z) and torque 15 B J p q/r⁷.

        Here B = mu J2 R²/2, p = u·Z and q = n·Z.
        """
        del inputs
        flat, gravity = self.called.oblateness, self.called.gravity
        assert flat is not None
        b, r5 = 0.5 * self.body.mu_m3_s2 * flat.j2 * flat.radius_m**2, fifth_power(view.square_m2, xp)
        pull = -3.0 * b * self.chain.mass_kg[bar] / r5
        fx, fy = pull * view.x_m, pull * view.y_m
        if not gravity.turns:
            return fx, fy, None
        strength = 15.0 * b * self.chain.inertia_kg_m2[bar] / (r5 * view.square_m2)
        if has_second_moment_force(gravity):
            gx, gy = moment_force(0.5 * strength, 7.0, view)
            fx, fy = fx + gx, fy + gy
        return fx, fy, strength * view.along_m * view.across_m


@final
class ExudynThirdBody(ExudynLoad):
    """A body on a circle: its gravity on a bar less that on the central body, by Encke's q."""

    time_input_count = 2

    def __init__(self, scene: Scene, frame: ReferenceFrame, third: ThirdBody) -> None:
        """Load of one third body."""
        super().__init__(scene, frame)
        self.third = third

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Direction to the body in the frame's axes."""
        del inside_s
        return directions_of(self.frame, at_s, self.third.longitude_rad + self.third.rate_rad_s * at_s)

    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force -(mu_b m/a³) (Z + (Z - X) k), and the load on the bar's second moment.

        Here X is the place of the body, a = |X|, k = (1+q)^(-3/2) - 1 and q = Z·(Z - 2X)/a².
        """
        far, mu, gravity = self.third.distance_m, self.third.mu_m3_s2, self.called.gravity
        bx, by = (far * n for n in inputs)
        q = (view.x_m * (view.x_m - 2.0 * bx) + view.y_m * (view.y_m - 2.0 * by)) / far**2
        k, cube = encke(q, xp)
        pull = -mu * self.chain.mass_kg[bar] / far**3
        fx, fy = pull * (view.x_m + (view.x_m - bx) * k), pull * (view.y_m + (view.y_m - by) * k)
        if not gravity.turns:
            return fx, fy, None
        from_body = view.relative_to(bx, by)
        strength = 3.0 * mu * self.chain.inertia_kg_m2[bar] / far**5 / ((1.0 + q) * cube)
        if has_second_moment_force(gravity):
            gx, gy = moment_force(0.5 * strength, 5.0, from_body)
            fx, fy = fx + gx, fy + gy
        return fx, fy, strength * from_body.along_m * from_body.across_m


@final
class ExudynDrag(ExudynLoad):
    """Free-molecular drag in an exponential atmosphere that rotates."""

    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Integrals along the bar, as in docs/effects/drag.md; the altitude is a quotient without cancellation."""
        del inputs
        drag, length = self.called.drag, self.chain.length_m[bar]
        assert drag is not None
        second, fourth, turning = length**3 / 12.0, length**5 / 80.0, drag.rotation_rad_s
        t, v = view.to_bar(view.vx_m_s + turning * view.y_m, view.vy_m_s - turning * view.x_m)  # relative to the air
        w = view.rate_rad_s - turning
        square, radius = view.square_m2, self.body.radius_m + drag.altitude_m
        height = (square - radius**2) / (xp.sqrt(square) + radius)
        density = drag.density_kg_m3 * xp.exp(height * (-1.0 / drag.scale_height_m))
        slope = view.along_m / (xp.sqrt(square) * drag.scale_height_m)
        push = -0.5 * drag.width_m[bar] * density * xp.sign(v)
        normal = drag.normal_coefficient * push
        along = drag.tangential_coefficient * push * t * (length * v - slope * second * w)
        across = normal * (length * v * v + second * w * (w - 2.0 * slope * v))
        torque = normal * (2.0 * second * v * w - slope * (second * v * v + fourth * w * w))
        return *view.to_frame(along, across), torque


@final
class ExudynSunlight(ExudynLoad):
    """Sunlight without shadow: a force, uniform along the bar."""

    time_input_count = 2

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Direction to the Sun in the frame's axes."""
        del inside_s
        sun = self.called.solar_pressure
        assert sun is not None
        return directions_of(self.frame, at_s, sun.sun_longitude_rad + sun.sun_rate_rad_s * at_s)

    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force -P b l |n·s| ((1 - rho) s + 2 rho (n·s) n)."""
        sun, (x, y) = self.called.solar_pressure, inputs
        assert sun is not None
        _, facing = view.to_bar(x, y)
        even = -sun.pressure_Pa * sun.width_m[bar] * self.chain.length_m[bar] * xp.abs(facing)
        mirror = 2.0 * sun.reflectivity * facing
        matt = 1.0 - sun.reflectivity
        return even * (matt * x - mirror * view.sine), even * (matt * y + mirror * view.cosine), None


@final
class ExudynThrust(ExudynLoad):
    """One thruster: a force on a bar's end as a function of time."""

    def __init__(self, scene: Scene, frame: ReferenceFrame, thrust: Thrust) -> None:
        """Load of one thrust."""
        super().__init__(scene, frame)
        self.thrust = thrust
        bar, right = thrust.bar - 1, thrust.end is End.RIGHT
        self.arm = scene.chain.right_m[bar] if right else -scene.chain.left_m[bar]
        self.in_body = thrust.axes is Axes.BODY
        self.time_input_count = 1 if self.in_body else 2

    def acts_on(self, bar: int) -> bool:
        """Whether the thruster is on `bar`."""
        return bar == self.thrust.bar - 1

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Force along the bar's axes, or its components in the frame's axes."""
        size = sizes(self.thrust, at_s, inside_s)[:, None]
        if self.in_body:
            return size
        return size * directions_of(self.frame, at_s, np.full_like(at_s, self.thrust.direction_rad))

    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Force F and torque of its arm, h (u × F)."""
        del bar, xp
        if not self.in_body:
            x, y = inputs
            return x, y, self.arm * view.to_bar(x, y)[1]
        along, across = math.cos(self.thrust.direction_rad), math.sin(self.thrust.direction_rad)
        x, y = view.to_frame(along, across)
        return inputs[0] * x, inputs[0] * y, inputs[0] * (self.arm * across)


@final
class ExudynMotor(ExudynLoad):
    """Motor in a joint: a torque on its second bar and the opposite one on its first, as a function of time."""

    time_input_count = 1

    def __init__(self, scene: Scene, frame: ReferenceFrame, motor: JointTorque) -> None:
        """Load of one motor."""
        super().__init__(scene, frame)
        self.motor = motor

    def acts_on(self, bar: int) -> bool:
        """Whether the joint is at an end of `bar`."""
        return bar in (self.motor.joint - 1, self.motor.joint)

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Torque on the second bar."""
        return sizes(self.motor, at_s, inside_s)[:, None]

    def load(self, bar: int, view: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Torque alone."""
        del xp
        zero = 0.0 * view.x_m
        return zero, zero, inputs[0] if bar == self.motor.joint else -1.0 * inputs[0]


def sizes(table: Thrust | JointTorque, at_s: Array, inside_s: Array) -> Array:
    """Size at instants (k,) on the straight segment around other instants (k,), N or N m; 0 outside the table."""
    t, f = np.array(table.times_s), np.array(table.sizes)
    i = np.searchsorted(t, inside_s) - 1
    within = (i >= 0) & (i < len(t) - 1)
    i = np.clip(i, 0, len(t) - 2)
    within &= t[i + 1] > t[i]
    line: Array = f[i] + (f[i + 1] - f[i]) * ((at_s - t[i]) / np.where(within, t[i + 1] - t[i], 1.0))
    return np.where(within, line, 0.0)


def jumps_s(scene: Scene) -> list[float]:
    """Instants inside the run at which a force or a torque that is a table in time jumps."""
    found: set[float] = set()
    for table in scene.effects.tables:
        times, sizes = (table.times_s[0], *table.times_s, table.times_s[-1]), (0.0, *table.sizes, 0.0)
        pairs = itertools.pairwise(zip(times, sizes, strict=True))
        found |= {t1 for (t0, before), (t1, after) in pairs if t0 == t1 and before != after}
    return sorted(t for t in found if 0.0 < t < scene.run.duration_s)


def jump_steps(scene: Scene, steps: Steps) -> list[int]:
    """Steps that end where a force or a torque jumps, without the last step."""
    return sorted({steps.index(t) for t in jumps_s(scene)} - {0, steps.count})


def off_step_s(scene: Scene) -> float | None:
    """First instant of a table in time that some number of steps leaves inside a step; None if there is none."""
    half = half_interval_s(scene)
    inside = sorted(t for p in scene.effects.tables for t in p.times_s if 0.0 < t < scene.run.duration_s)
    return next((t for t in inside if abs(t / half - round(t / half)) > WHOLE), None)
