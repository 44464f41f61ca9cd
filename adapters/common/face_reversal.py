"""Bars that turn their other face to the wind or to the Sun, within one of the equal steps.

Forces of air and light jump, or their slope does, at the reversal. Only the motion tells whether one occurs. Engines of
equal steps look for reversals in their own run, and the harness in the judging solution at close samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.reference_model import chain_model
from reference_impl.model.effect import EDGE_ON
from reference_impl.model.kinematics import directions, relative_positions, relative_velocities

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from scenarios import Drag, Scene, SolarPressure

FEWEST = 2  # samples


@dataclass(frozen=True)
class Incidence:
    """Incidence of the wind or of sunlight on the bars, at n samples of N bars."""

    towards: str
    """Source, in words"""
    normal_component: Array
    """(n, N) component normal to each bar, of the air's velocity in m/s or of the unit vector to the Sun; its sign
    is the exposed face"""
    slope: Array
    """(n, N) time derivative of `normal_component`"""
    edge_on_limit: Array
    """(n, N) magnitude of `normal_component` up to which a bar is edge-on: rounding decides the sign there"""

    @property
    def face(self) -> Array:
        """(n, N) +1 or -1; 0 for a bar that is edge-on."""
        return np.where(np.abs(self.normal_component) <= self.edge_on_limit, 0.0, np.sign(self.normal_component))


def unsupported_motion(scene: Scene, motion: Trajectory) -> str | None:
    """Reason why equal steps do not support a motion given at close samples; None if they do.

    Two reversals between two samples are found too, in the cubic through values and slopes at both samples.

    Parameters
    ----------
    scene : Scene
    motion : Trajectory
        With angles and rates.

    Returns
    -------
    str or None
    """
    return first_reversal(scene, motion, between=True)


def first_reversal(scene: Scene, motion: Trajectory, *, between: bool = False) -> str | None:
    """First bar that turns its other face to the wind or the Sun, and the interval in words; None if none does.

    Parameters
    ----------
    scene : Scene
    motion : Trajectory
        With angles and rates.
    between : bool
        Whether two reversals between two samples count as well; the samples must be close for that.
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
                f"{t_s[k + 1]:.6g} s, within one of the equal steps"
            )
    return None


def incidences(scene: Scene, motion: Trajectory) -> Iterator[Incidence]:
    """Incidences on the bars of a scene; none where the motion is too short or has no angles."""
    if motion.angle_rad is None or motion.rate_rad_s is None or len(motion.t_s) < FEWEST:
        return
    if scene.effects.drag:
        yield wind(scene, scene.effects.drag, motion, motion.angle_rad, motion.rate_rad_s)
    if scene.effects.solar_pressure:
        yield sunlight(scene.effects.solar_pressure, motion.t_s, motion.angle_rad, motion.rate_rad_s)


def wind(scene: Scene, drag: Drag, motion: Trajectory, angle: Array, rate: Array) -> Incidence:
    """Velocity of each bar's centre relative to the air, which rotates with the central body."""
    model, (along, normal) = chain_model(scene), directions(angle)
    position = motion.com_m[:, None] + relative_positions(model, angle)
    velocity = motion.com_velocity_m_s[:, None] + relative_velocities(model, angle, rate)
    acceleration = np.gradient(velocity, motion.t_s, axis=0)
    against = velocity - drag.rotation_rad_s * turned_left(position)
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
    """Rotate plane vectors (..., 2) by +90 degrees."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def reverses_twice(incidence: Incidence, t_s: Array) -> NDArray[np.bool_]:
    """Whether each bar shows its other face inside an interval and at neither end of it, (n-1, N).

    In s = 0..1 the cubic through both ends is a s³ + b s² + c s + d. For a face that is positive at both ends its
    minimum is where 3 a s² + 2 b s + c is zero and rises.
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
    """Intervals (n-1,) in which slopes are reliable: none beside an impulse or the end of a thrust."""
    known, effects = np.ones(len(t_s) - 1, dtype=bool), scene.effects
    for at_s in [t for thrust in effects.thrust for t in thrust.breaks_s] + [
        impulse.at_s for impulse in effects.impulse
    ]:
        k = int(np.searchsorted(t_s, at_s))  # the interval that ends at that instant or after it
        known[max(k - 2, 0) : k + 2] = False
    return known
