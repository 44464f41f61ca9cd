"""Structure of a scene's equations in heyoka, and their parameters.

Units are powers of two, near the initial radius and the fastest rate. The change of units rounds no number, and all
unknowns are of order one, as heyoka's tolerance relative to the largest unknown requires.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.heyoka.effects import EffectShapes, effect_parameters, perturbs_orbit, shapes_of
from scenarios import Actuator, Frame, Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.heyoka.units import HeyokaUnits
    from scenarios import Scene

PI = "3.14159265358979323846264338327950288419716939937510582097494459"
SCENE_PARAMETERS = 2  # mu, the surface's radius
LAW_PARAMETERS = 3  # amplitude over 16 (zero while the bar is held), rate pi/t_m, start
Numbers = Any
"""Array in the working precision"""


class BarParameter(IntEnum):
    """Parameters of a bar, behind those of the whole scene."""

    MASS = 0
    SHARE = 1
    """mu_j = m_j/M"""
    HALF = 2
    """l_j/2"""
    INERTIA = 3
    """About its centre"""
    END_INERTIA = 4
    """About an end"""
    SLENDER = 5
    """3 J_j/(l_j/2)²: a slender bar's mass"""


@dataclass(frozen=True)
class LawShape:
    """Form of a prescribed rotation in the equations."""

    bar: int
    """Counted from 0"""
    local_horizontal: bool
    joint: bool
    """Whether a motor in a joint exerts the torque"""


@dataclass(frozen=True)
class Structure:
    """Properties that two scenes must share to share one compiled code."""

    bars: int
    gravity: str
    laws: tuple[LawShape, ...] = ()
    lands: bool = False
    """Whether events watch the surface"""
    effects: EffectShapes = field(default_factory=EffectShapes)

    @property
    def surfaces(self) -> int:
        """Number of events of the surface: one for each end, and one for each bar between its ends."""
        return 2 * self.bars + 1 if self.lands else 0

    @property
    def law_offset(self) -> int:
        """Index of the laws' first parameter: behind mu, the surface's radius, and each bar's parameters."""
        return SCENE_PARAMETERS + len(BarParameter) * self.bars

    def bar_slot(self, part: BarParameter, bar: int) -> int:
        """Index of a bar's parameter."""
        return SCENE_PARAMETERS + part * self.bars + bar

    @property
    def effect_offset(self) -> int:
        """Index of the effects' first parameter, in the order of `EffectShapes.names`."""
        return self.law_offset + LAW_PARAMETERS * len(self.laws)

    def slot(self, name: str) -> int:
        """Index of an effect's parameter."""
        return self.effect_offset + self.effects.names.index(name)


def structure_of(scene: Scene) -> Structure:
    """Structure of `scene`."""
    laws = tuple(
        LawShape(p.bar - 1, p.frame is Frame.LOCAL_HORIZONTAL, p.actuator is Actuator.JOINT)
        for p in scene.effects.prescribed_rotation
    )
    return Structure(scene.bars, str(scene.effects.gravity), laws, may_land(scene), shapes_of(scene))


def may_land(scene: Scene) -> bool:
    """Whether a bar might reach the surface: perigee of the osculating orbit less twice the chain's length.

    The chain extends half of its length beyond its centre of mass, and its whole length if its masses are very unequal.
    The remainder allows for the departure from that orbit, of order (L/r)² r. Where other forces than the central
    body's gravity act on the centre of mass, its orbit at t = 0 gives no bound, and events watch the surface.
    """
    if scene.central_body.radius_m <= 0.0:
        return False
    if perturbs_orbit(scene):
        return True
    if scene.effects.gravity is Gravity.NONE:
        return False  # without gravity a horizontal injection leads away from the surface
    square = scene.orbit.speed_factor**2
    perigee_m = scene.radius0_m if square >= 1.0 else scene.radius0_m * square / (2.0 - square)
    return perigee_m - 2.0 * scene.size_m <= scene.central_body.radius_m


def parameters_of(scene: Scene, units: HeyokaUnits, number: Callable[[Any], Any]) -> Numbers:
    """Parameters of the equations in the working precision; `number` converts a float or a decimal string."""
    length, time = units.length_m, units.time_s
    chain = scene.chain
    mass = [number(m) for m in chain.mass_kg]
    total = sum(mass[1:], mass[0])
    found = [number(scene.central_body.mu_m3_s2 * time**2 / length**3), number(scene.central_body.radius_m / length)]
    found += mass
    found += [m / total for m in mass]
    half = [number(0.5 * x / length) for x in chain.length_m]
    inertia = [number(j / length**2) for j in chain.inertia_kg_m2]
    found += half + inertia
    found += [j + m * h * h for j, m, h in zip(inertia, mass, half, strict=True)]
    found += [number(3.0) * j / (h * h) for j, h in zip(inertia, half, strict=True)]
    for p in scene.effects.prescribed_rotation:
        found += [number(0.0), number(PI) / number(p.duration_s / time), number(p.start_s / time)]
    found += effect_parameters(scene, units, number).values()
    return np.array(found)


def start_of(scene: Scene, units: HeyokaUnits, number: Callable[[Any], Any]) -> Numbers:
    """State [Z0, Z0', theta, theta'] at t = 0 in the working precision: the initial state of every engine."""
    at = initial_state(scene)
    length, time = units.length_m, units.time_s
    parts = [at.com_m / length, at.com_velocity_m_s * time / length, at.angle_rad, at.rate_rad_s * time]
    return np.array([number(float(x)) for x in np.concatenate(parts)])
