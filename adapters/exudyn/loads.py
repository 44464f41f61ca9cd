"""Sum of the loads on a bar of a scene: gravity with the frame's own forces, and one load for each effect.

One form serves Exudyn's symbolic numbers and NumPy arrays. In the rotating frame on a Kepler orbit (radius r, rate w,
k = mu/r³), a bar at (x, y) has the acceleration

    2 w y' + w' y + k ((e cos f - c) x - c r),   -2 w x' - w' x + k (e cos f - c) y,

where c = (1+q)^(-3/2) - 1 with q = ((2r + x) x + y²)/r² is Encke's, and w² - k = k e cos f holds on Kepler's orbit. The
large terms (870 N a bar) cancel analytically. Exudyn evaluates a symbolic expression once for each occurrence, so `c`
occurs in as few places as possible, and `q` once in `c`.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.exudyn.effects import (
    ExudynDrag,
    ExudynMotor,
    ExudynOblateness,
    ExudynQuadrupole,
    ExudynSlender,
    ExudynSunlight,
    ExudynThirdBody,
    ExudynThrust,
    encke,
)
from adapters.exudyn.frames import FixedFrame, OrbitFrame
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.exudyn.effects import BarForce, ExudynLoad
    from adapters.exudyn.frames import BarMotion, Number, OrbitNumbers, ReferenceFrame
    from adapters.trajectory import Array
    from scenarios import Scene


class Loading:
    """Loads on bars in one frame."""

    def __init__(self, scene: Scene, frame: ReferenceFrame) -> None:
        """Assemble the loads of the scene."""
        self.mass, self.inertia, self.mu = scene.chain.mass_kg, scene.chain.inertia_kg_m2, scene.central_body.mu_m3_s2
        gravity = scene.effects.gravity
        self.gradient = gravity in (Gravity.GRADIENT, Gravity.QUADRUPOLE)  # both with the torque of eq. (17)
        self.framed = isinstance(frame, OrbitFrame) or (isinstance(frame, FixedFrame) and gravity is not Gravity.NONE)
        self.frame, self.effects = frame, effects_of(scene, frame)
        self.parts: list[ReferenceFrame | ExudynLoad] = [frame, *self.effects] if self.framed or self.effects else []
        self.input_counts = [part.time_input_count for part in self.parts]

    @property
    def time_input_count(self) -> int:
        """Number of inputs that depend on time alone."""
        return sum(self.input_counts)

    def time_inputs(self, at_s: Array, inside_s: Array) -> Array:
        """Values of the time inputs, (k, time_input_count)."""
        return np.concatenate([part.time_inputs(at_s, inside_s) for part in self.parts], axis=1)

    def acts_on(self, bar: int) -> bool:
        """Whether any load acts on `bar`."""
        return self.framed or any(effect.acts_on(bar) for effect in self.effects)

    def on(self, bar: int, m: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        """Sum of the loads on a bar with at least one load.

        Parameters
        ----------
        bar : int
            Counted from 0.
        m : BarMotion
            In the frame.
        inputs : sequence of `time_input_count` numbers
        xp : module
            numpy, or Exudyn's symbolic.
        """
        own, *others = split(inputs, self.input_counts)
        loads = [self._frame_load(bar, m, own, xp)] if self.framed else []
        if self.effects:
            view = self.frame.inertial(m, own)
            acting = [(e, given) for e, given in zip(self.effects, others, strict=True) if e.acts_on(bar)]
            loads += [effect.load(bar, view, given, xp) for effect, given in acting]
        total = loads[0]
        for load in loads[1:]:
            total = sum_of_loads(total, load)
        return total

    def _frame_load(self, bar: int, m: BarMotion, inputs: Sequence[Number], xp: Any) -> BarForce:
        if isinstance(self.frame, OrbitFrame):
            return self._orbit_load(bar, self.frame.numbers(inputs), m, xp)
        r2 = m.square_m2
        cube = r2 * xp.sqrt(r2)
        pull = -self.mu * self.mass[bar] / cube
        torque = 0.0 * m.x_m
        if self.gradient:
            torque = gradient_torque(3.0 * self.inertia[bar] * self.mu, m.x_m, m, r2 * cube)
        return pull * m.x_m, pull * m.y_m, torque

    def _orbit_load(self, bar: int, orbit: OrbitNumbers, m: BarMotion, xp: Any) -> BarForce:
        """Gravity and the rotating frame's forces."""
        r, w, k = orbit.radius_m, orbit.rate_rad_s, orbit.pull_s2
        q = ((2.0 * r + m.x_m) * m.x_m + m.y_m * m.y_m) / (r * r)
        c, cube = encke(q, xp)
        ax = 2.0 * w * m.vy_m_s + orbit.spin_up_rad_s2 * m.y_m + k * (orbit.shape * m.x_m - c * (r + m.x_m))
        ay = -2.0 * w * m.vx_m_s - orbit.spin_up_rad_s2 * m.x_m + k * (orbit.shape - c) * m.y_m
        # the frame turns faster: the bar falls behind
        torque = -self.inertia[bar] * orbit.spin_up_rad_s2 + 0.0 * m.x_m
        if self.gradient:
            strength = 3.0 * self.inertia[bar] * k / (r * r)
            torque = torque + gradient_torque(strength, r + m.x_m, m, (1.0 + q) * cube)
        return self.mass[bar] * ax, self.mass[bar] * ay, torque


def gradient_torque(strength: Number, across: Number, m: BarMotion, fifth: Number) -> Number:
    """Torque 3 mu J sin(phi) cos(phi)/rho³ by eq. (17) with its sign corrected: towards the radial direction.

    Parameters
    ----------
    strength : number
        3 mu J in the unit of `fifth`.
    across : number
        Radial component of the bar's position: its x from the centre of the body.
    m : BarMotion
    fifth : number
        rho⁵ in that unit.
    """
    sine = m.cosine * across + m.sine * m.y_m  # rho sin(phi)
    cosine = m.cosine * m.y_m - m.sine * across  # rho cos(phi)
    return strength * sine * cosine / fifth


def effects_of(scene: Scene, frame: ReferenceFrame) -> list[ExudynLoad]:
    """Effects on bars besides point-mass gravity, its gradient's torque and the frame's own forces."""
    effects = scene.effects
    found: list[ExudynLoad] = []
    if effects.gravity is Gravity.QUADRUPOLE:
        found.append(ExudynQuadrupole(scene, frame))
    if effects.gravity is Gravity.SLENDER:
        found.append(ExudynSlender(scene, frame))
    if effects.oblateness:
        found.append(ExudynOblateness(scene, frame))
    found += [ExudynThirdBody(scene, frame, body) for body in effects.third_body]
    if effects.drag:
        found.append(ExudynDrag(scene, frame))
    if effects.solar_pressure:
        found.append(ExudynSunlight(scene, frame))
    found += [ExudynMotor(scene, frame, motor) for motor in effects.joint_torque]
    return found + [ExudynThrust(scene, frame, thrust) for thrust in effects.thrust]


def sum_of_loads(a: BarForce, b: BarForce) -> BarForce:
    """Sum of two loads."""
    torque = b[2] if a[2] is None else a[2] if b[2] is None else a[2] + b[2]
    return a[0] + b[0], a[1] + b[1], torque


def split(inputs: Sequence[Number], counts: list[int]) -> list[Sequence[Number]]:
    """Split into parts of given lengths."""
    ends = np.cumsum([0, *counts]).tolist()
    return [inputs[a:b] for a, b in itertools.pairwise(ends)]
