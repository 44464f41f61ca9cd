"""Bars that turn their other face to the wind or to the Sun: equal steps pass over that instant.

Forces of air and light have a jump or a kink there. Whether a bar does so is known from the motion alone: engines of
equal steps look for it in their own run, and the harness in the reference solution at close samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import chain_model
from reference_impl.model.effect import EDGE_ON
from reference_impl.model.kinematics import directions, relative_positions, relative_velocities

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from scenarios import Drag, Scene, SolarPressure

FEWEST = 2  # samples that there is something between


@dataclass(frozen=True)
class Incidence:
    """How the bars meet what they face, at n samples of N bars."""

    towards: str
    """What it is, in words"""
    normal_component: Array
    """(n, N) its component across each bar, of the air's speed in m/s or of the unit vector to the Sun: the sign is the
    face that meets it"""
    slope: Array
    """(n, N) time derivative of `across`"""
    edge_on_limit: Array
    """(n, N) a bar with no more than that `across` is edge-on: the sign is a matter of rounding"""

    @property
    def face(self) -> Array:
        """(n, N) +1 or -1; 0 for a bar that is edge-on."""
        return np.where(np.abs(self.normal_component) <= self.edge_on_limit, 0.0, np.sign(self.normal_component))


def unsupported_motion(scene: Scene, motion: Trajectory) -> str | None:
    """Why equal steps can't follow a motion, seen at close samples; None if they can.

    A face that turns over and back between two samples is found too: in the cubic through both ends' values and slopes.
    """
    return first_reversal(scene, motion, between=True)


def first_reversal(scene: Scene, motion: Trajectory, *, between: bool = False) -> str | None:
    """Say which bar turns its other face to the wind or the Sun, and between which samples; None if none does.

    Parameters
    ----------
    scene : Scene
    motion : Trajectory
        With angles and rates.
    between : bool
        Whether also a face counts that turns over and back between two samples: they must lie close for that.
    """
    t_s = motion.t_s
    for incidence in incidences(scene, motion):
        face = incidence.face
        turned = face[1:] != face[:-1]
        if between:
            turned |= smooth_intervals(scene, t_s)[:, None] & reverses_twice(incidence, t_s)
        found = np.argwhere(turned)
        if len(found):
            k, bar = found[0]
            return (
                f"bar {bar + 1} turns its other face to {incidence.towards} between t = {t_s[k]:.6g} s and "
                f"{t_s[k + 1]:.6g} s: equal steps pass over that instant"
            )
    return None


def incidences(scene: Scene, motion: Trajectory) -> Iterator[Incidence]:
    """What the bars of a scene face; nothing where the motion is too short or knows no angles."""
    if motion.angle_rad is None or motion.rate_rad_s is None or len(motion.t_s) < FEWEST:
        return
    if scene.effects.drag:
        yield wind(scene, scene.effects.drag, motion, motion.angle_rad, motion.rate_rad_s)
    if scene.effects.solar_pressure:
        yield sunlight(scene.effects.solar_pressure, motion.t_s, motion.angle_rad, motion.rate_rad_s)


def wind(scene: Scene, drag: Drag, motion: Trajectory, angle: Array, rate: Array) -> Incidence:
    """Velocity of each bar's centre against the air that turns with the body."""
    model, (along, normal) = chain_model(scene), directions(angle)
    place = motion.com_m[:, None] + relative_positions(model, angle)
    velocity = motion.com_velocity_m_s[:, None] + relative_velocities(model, angle, rate)
    acceleration = np.gradient(velocity, motion.t_s, axis=0)
    against = velocity - drag.rotation_rad_s * turned_left(place)
    gains = acceleration - drag.rotation_rad_s * turned_left(velocity)
    normal_component: Array = np.sum(normal * against, axis=-1)
    slope: Array = np.sum(normal * gains, axis=-1) - rate * np.sum(along * against, axis=-1)
    return Incidence("the wind", normal_component, slope, EDGE_ON * np.linalg.norm(against, axis=-1))


def sunlight(light: SolarPressure, t_s: Array, angle: Array, rate: Array) -> Incidence:
    """Unit vector to the Sun."""
    ahead = (light.sun_longitude_rad + light.sun_rate_rad_s * t_s)[:, None] - angle
    normal_component: Array = np.sin(ahead)
    slope: Array = np.cos(ahead) * (light.sun_rate_rad_s - rate)
    return Incidence("the Sun", normal_component, slope, np.full_like(normal_component, EDGE_ON))


def turned_left(vector: Array) -> Array:
    """Plane vectors (..., 2) turned by +90 degrees."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def reverses_twice(incidence: Incidence, t_s: Array) -> NDArray[np.bool_]:
    """Whether each bar shows the other face inside each interval, which neither end of it does: (n-1, N).

    In s = 0..1 the cubic through both ends is a s³ + b s² + c s + d; its lowest point, for a face that is positive at
    both ends, is where 3 a s² + 2 b s + c is zero and rises.
    """
    step, face = np.diff(t_s)[:, None], incidence.face
    start, end = (face[:-1] * values for values in (incidence.normal_component[:-1], incidence.normal_component[1:]))
    c, last = (face[:-1] * step * values for values in (incidence.slope[:-1], incidence.slope[1:]))
    a, b = 2.0 * (start - end) + c + last, 3.0 * (end - start) - 2.0 * c - last
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(b * b - 3.0 * a * c)  # not a number where the cubic has no lowest point
        s = np.where(b > 0.0, -c / (b + root), (root - b) / (3.0 * a))
        lowest = start + s * (c + s * (b + s * a))
    same = (face[:-1] == face[1:]) & (face[:-1] != 0.0)
    found: NDArray[np.bool_] = same & (s > 0.0) & (s < 1.0) & (lowest < 0.0)
    return found


def smooth_intervals(scene: Scene, t_s: Array) -> NDArray[np.bool_]:
    """Whether slopes are to be relied on in each interval, (n-1,): not beside a blow, or the end of a thrust."""
    known, effects = np.ones(len(t_s) - 1, dtype=bool), scene.effects
    for at_s in [t for thrust in effects.thrust for t in thrust.breaks_s] + [blow.at_s for blow in effects.impulse]:
        k = int(np.searchsorted(t_s, at_s))  # the interval that ends at the break or after it
        known[max(k - 2, 0) : k + 2] = False
    return known
