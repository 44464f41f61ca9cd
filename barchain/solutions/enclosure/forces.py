"""Forces and torques on a bar besides its joints' reactions, for balls and series; the laws are those of docs/effects.

Numbers are the scene's, in double precision, each taken as exact. What cancels is paid with bits, but for the central
body's gravity, which all bars share: wide balls about a bar have its difference from that of the chain's centre.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from flint import arb

from scenarios import Axes, Gravity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.solutions.enclosure.series import Balls, Number, Tape
    from scenarios import Drag, Impulse, JointTorque, Oblateness, Scene, SolarPressure, Thrust

Pair = tuple[Any, Any]
Load = tuple[Pair, Any]
"""Force at a bar's centre, and torque about it"""


def number(x: float) -> arb:
    """Exactly this number."""
    return arb(float(x))


def dot(a: Pair, b: Pair) -> Number:
    """Dot product."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Pair, b: Pair) -> Number:
    """Component of the cross product normal to the plane."""
    return a[0] * b[1] - a[1] * b[0]


def along(outward: Number, z: Pair, inward: Number, u: Pair) -> Pair:
    """Sum of a part along z and one along u."""
    return z[0] * outward + u[0] * inward, z[1] * outward + u[1] * inward


@dataclass(frozen=True)
class BarState:
    """Where a bar is and how it moves, as balls or series."""

    index: int
    place: Pair
    """Z of its centre"""
    centre: Pair
    """Z0 of the chain's centre"""
    offset: Pair
    """d = Z - Z0"""
    velocity: Pair
    """Of its centre; of the chain's where no force needs it"""
    u: Pair
    """Along the bar"""
    n: Pair
    """Across it"""
    angle: Number
    rate: Number
    mass: arb
    inertia: arb
    length: arb
    left: arb
    """From its left end to its centre of mass"""
    right: arb


class Forces:
    """Forces of a scene between two breaks of its effects."""

    def __init__(self, scene: Scene, middle_s: float, *, gradient_sign: int = 1) -> None:
        """Take the numbers of a scene, and the pieces of its tables that hold at an instant.

        Parameters
        ----------
        scene : Scene
        middle_s : float
            Any instant between the two breaks, s.
        gradient_sign : int
            Sign of gravity's torque; -1 is a mistake, to be detected.
        """
        self.scene, self.effects, self.middle_s = scene, scene.effects, middle_s
        self.gradient_sign = gradient_sign
        self.mu = number(scene.central_body.mu_m3_s2)
        self.faces: list[int] = []
        """Signs of the watched speeds and cosines, in the order of their use; 1 until set"""
        self.watched: list[Number] = []
        """Those speeds and cosines, since the last evaluation began"""

    def common(self, ops: Balls | Tape, place: Pair) -> Pair:
        """Acceleration that all bars share: of a point mass at the chain's centre, for the models of a bar's centre."""
        if self.effects.gravity in (Gravity.NONE, Gravity.SLENDER):
            return 0, 0
        cube = ops.half_power(dot(place, place), -3) * -self.mu
        return place[0] * cube, place[1] * cube

    def load(self, ops: Balls | Tape, t: Number, bar: BarState) -> Load:
        """Sum of all forces on a bar at its centre but the common one, and of torques but those of joints."""
        e = self.effects
        found: list[Load] = []
        if e.gravity is Gravity.SLENDER:
            found.append(self.slender(ops, bar))
        elif e.gravity is not Gravity.NONE:
            found += [self.tide(ops, bar), self.extent(ops, bar, bar.place, self.mu, e.gravity)]
        if e.oblateness:
            found.append(self.flattening(ops, bar, e.oblateness))
        for body in e.third_body:
            sine, cosine = ops.sin_cos(t * number(body.rate_rad_s) + number(body.longitude_rad))
            mu, distance = number(body.mu_m3_s2), number(body.distance_m)
            y = (bar.place[0] - cosine * distance, bar.place[1] - sine * distance)
            model = Gravity.QUADRUPOLE if e.gravity is Gravity.SLENDER else e.gravity
            back = -bar.mass * mu / (distance * distance)
            outward = ops.half_power(dot(y, y), -3) * (-mu * bar.mass)
            point = (y[0] * outward + cosine * back, y[1] * outward + sine * back)
            found += [(point, 0), self.extent(ops, bar, y, mu, model)]
        if e.drag:
            found.append(self.drag(ops, bar, e.drag))
        if e.solar_pressure:
            found.append(self.light(ops, t, bar, e.solar_pressure))
        for push in e.thrust:
            size = self.size(push, t) if push.bar == bar.index + 1 else None
            if size is not None:
                found.append(self.push(ops, push, size, bar))
        parts = zip(*((f[0], f[1], torque) for f, torque in found), strict=True)
        x, y_, torque = (sum(part, 0) for part in parts) if found else (0, 0, 0)
        return (x, y_), torque

    def tide(self, ops: Balls | Tape, bar: BarState) -> Load:
        """Force of a point mass on a bar's centre, less the common one.

        With a = 1/|Z0|, b = 1/|Z| and q = (2 Z0 + d)·d, a³ - b³ = q a² b² (a² + a b + b²)/(a + b): the difference of
        balls would be as wide as gravity itself.
        """
        d, z = bar.offset, bar.place
        z0 = bar.centre
        a, b = ops.half_power(dot(z0, z0), -1), ops.half_power(dot(z, z), -1)
        both, square, total = a * b, b * b, a + b
        q = dot((z0[0] * 2 + d[0], z0[1] * 2 + d[1]), d)
        less = q * (both * both) * (a * a + both + square) * ops.half_power(total * total, -1) * (self.mu * bar.mass)
        return along(square * b * (-self.mu * bar.mass), d, less, z0), 0

    def extent(self, ops: Balls | Tape, bar: BarState, z: Pair, mu: arb, model: Gravity) -> Load:
        """Torque of a point mass at -z from the bar's centre, and force besides that on the centre, in a model.

        Of the potential's second moment, U = -(mu J/2r³)(3 (u·z)²/r² - 1): -dU/dtheta and -dU/dz.
        """
        if model is Gravity.POINT:
            return (0, 0), 0
        r2 = dot(z, z)
        p, fifth = dot(bar.u, z), ops.half_power(r2, -5) * (3 * mu * bar.inertia)
        torque = p * dot(bar.n, z) * fifth * self.gradient_sign
        if model is Gravity.GRADIENT:
            return (0, 0), torque
        outward = fifth / 2 - p * (p * ops.half_power(r2, -7)) * (15 * mu * bar.inertia / 2)
        return along(outward, z, p * fifth, bar.u), torque

    def slender(self, ops: Balls | Tape, bar: BarState) -> Load:
        """Gravity on a uniform bar: the integral of -mu (z + s u)/|z + s u|³ over its length.

        With p = u·z and q = n·z its part along the bar is the difference of 1/|z + s u| between the ends, that across
        it the difference of -(p + s)/(q |z + s u|). With the ends' distances a, b and S = a + b both become quotients
        without differences, by b² - a² = 2 l p and 4 q² S² = (S² - l²)(S² - (b - a)²).
        """
        z, length = bar.place, bar.length
        p, q = dot(bar.u, z), dot(bar.n, z)
        ends = [(z[0] + bar.u[0] * s, z[1] + bar.u[1] * s) for s in (-length / 2, length / 2)]
        squares = [dot(end, end) for end in ends]
        over_a, over_b = (ops.half_power(x, -1) for x in squares)
        total = squares[0] * over_a + squares[1] * over_b
        square = total * total
        weight = over_a * over_b * (-2 * self.mu * bar.mass)
        over_total = ops.half_power(square, -1)
        lengthwise = weight * (p * over_total)
        sideways = weight * (q * (total * ops.half_power(square - length * length, -2)))
        torque = sideways * (p * (over_total * over_total)) * (-length * length * self.gradient_sign)
        return along(lengthwise, bar.u, sideways, bar.n), torque

    def flattening(self, ops: Balls | Tape, bar: BarState, oblate: Oblateness) -> Load:
        """Force and torque of the potential -B/r³ per unit mass, B = mu J2 R²/2, to the order of the gravity model."""
        radius, z = number(oblate.radius_m), bar.place
        b = self.mu * number(oblate.j2) * radius * radius / 2
        r2 = dot(z, z)
        outward = ops.half_power(r2, -5) * (-3 * b * bar.mass)
        if not self.effects.gravity.turns:
            return along(outward, z, 0, bar.u), 0
        p, seventh = dot(bar.u, z), ops.half_power(r2, -7) * (15 * b * bar.inertia)
        torque = p * dot(bar.n, z) * seventh
        if self.effects.gravity is Gravity.GRADIENT:
            return along(outward, z, 0, bar.u), torque
        outward = outward + seventh / 2 - p * (p * ops.half_power(r2, -9)) * (105 * b * bar.inertia / 2)
        return along(outward, z, p * seventh, bar.u), torque

    def drag(self, ops: Balls | Tape, bar: BarState, drag: Drag) -> Load:
        """Drag on a bar one face of which meets the flow: the force per length, integrated over its length."""
        spin, over_height = number(drag.rotation_rad_s), 1 / number(drag.scale_height_m)
        z, half = bar.place, bar.length / 2
        wind = (bar.velocity[0] + z[1] * spin, bar.velocity[1] - z[0] * spin)
        v, t, w = dot(bar.n, wind), dot(bar.u, wind), bar.rate - spin
        r2 = dot(z, z)
        over_r = ops.half_power(r2, -1)
        reference = number(self.scene.central_body.radius_m) + number(drag.altitude_m)
        thinner = dot(bar.u, z) * over_r * over_height
        width = number(drag.width_m[bar.index])
        density = ops.exp((r2 * over_r - reference) * -over_height) * (-self.face(v) * number(drag.density_kg_m3) / 2)
        strength = density * width
        whole, second, fourth = 2 * half, 2 * half**3 / 3, 2 * half**5 / 5
        normal, tangential = number(drag.normal_coefficient), number(drag.tangential_coefficient)
        over = strength * (v * v * whole + w * w * second - thinner * (v * w) * (2 * second)) * normal
        down = strength * (t * (v * whole - thinner * w * second)) * tangential
        torque = strength * (v * w * (2 * second) - thinner * (v * v * second + w * w * fourth)) * normal
        return along(over, bar.n, down, bar.u), torque

    def light(self, ops: Balls | Tape, t: Number, bar: BarState, light: SolarPressure) -> Load:
        """Pressure of sunlight on a bar one face of which meets the Sun."""
        sine, cosine = ops.sin_cos(t * number(light.sun_rate_rad_s) + number(light.sun_longitude_rad))
        g = dot(bar.n, (cosine, sine))
        area = number(light.pressure_Pa) * number(light.width_m[bar.index]) * bar.length
        strength, share = g * (-area * self.face(g)), number(light.reflectivity)
        return along(strength * (1 - share), (cosine, sine), strength * g * (2 * share), bar.n), 0

    def face(self, value: Number) -> int:
        """Sign of a speed or cosine, which is watched as long as the evaluation's step lasts."""
        self.watched.append(value)
        return self.faces[len(self.watched) - 1] if self.faces else 1

    def push(self, ops: Balls | Tape, push: Thrust | Impulse, size: Number, bar: BarState) -> Load:
        """Force or impulse on a bar's end, and its moment about the bar's centre."""
        direction = number(push.direction_rad)
        sine, cosine = ops.sin_cos(bar.angle + direction if push.axes is Axes.BODY else direction)
        force = (cosine * size, sine * size)
        return force, cross(bar.u, force) * (bar.right if push.end.sign > 0 else -bar.left)

    def size(self, table: Thrust | JointTorque, t: Number) -> Number | None:
        """Size of a table on its present piece, linear in time; None outside the table."""
        for (t0, f0), (t1, f1) in itertools.pairwise(zip(table.times_s, table.sizes, strict=True)):
            if t0 < self.middle_s < t1:
                slope = (number(f1) - number(f0)) / (number(t1) - number(t0))
                return number(f0) if f0 == f1 else (t - number(t0)) * slope + number(f0)
        return None

    def joint_torques(self, t: Number, angle: Sequence[Number], rate: Sequence[Number]) -> list[Number]:
        """Torques of springs, dampers and motors in the joints, on each bar."""
        found: list[Number] = [0] * len(angle)
        springs = self.effects.joint_spring_damper
        for j in range(len(angle) - 1):
            torque: Number = 0
            if springs is not None:
                bend = angle[j + 1] - angle[j] - number(springs.rest_rad[j])
                turned = (rate[j + 1] - rate[j]) * number(springs.damping_N_m_s_rad[j])
                torque = -(bend * number(springs.stiffness_N_m_rad[j]) + turned)
            for motor in self.effects.joint_torque:
                size = self.size(motor, t) if motor.joint == j + 1 else None
                torque = torque if size is None else torque + size
            found[j], found[j + 1] = found[j] - torque, found[j + 1] + torque
        return found
