"""Lowest and highest altitude of the centre of mass, for the air density of the default drag."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from scenarios import Gravity

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene


class Heights(NamedTuple):
    """Least and largest height of the centre of mass above the surface, m."""

    lowest_m: float
    highest_m: float


def expected(scene: Scene) -> Heights:
    """Heights on the orbit of the start, before anything has run: both apsides from half a period on."""
    start = scene.orbit.altitude_m
    if not scene.bound or scene.run.duration_s < 0.5 * scene.period_s:
        return Heights(start, start)
    beta2 = scene.orbit.speed_factor**2
    other = scene.radius0_m * beta2 / (2.0 - beta2) - scene.central_body.radius_m
    return Heights(max(min(start, other), 0.0), max(start, other))


def seen(scene: Scene, run: Trajectory) -> Heights:
    """Heights of a run at its samples, and at the perigees between two of them."""
    radius = np.linalg.norm(run.com_m, axis=1)
    below: list[float] | Array = (
        [] if scene.effects.gravity is Gravity.NONE else perigees_m(scene, run)[passes(scene, run)]
    )
    least, most = min([radius.min(), *below]), radius.max()
    surface = scene.central_body.radius_m
    return Heights(max(float(least) - surface, 0.0), float(most) - surface)


def passes(scene: Scene, run: Trajectory) -> NDArray[np.bool_]:
    """(n,) of each sample, whether a perigee lies between it and the next: from falling to rising, or half a period."""
    rising = np.sum(run.com_m * run.com_velocity_m_s, axis=1)
    turned = (rising[:-1] < 0.0) & (rising[1:] > 0.0)
    long = scene.bound & (np.diff(run.t_s) >= 0.5 * scene.period_s)
    return np.append(turned | long, False)


def perigees_m(scene: Scene, run: Trajectory) -> Array:
    """(n,) m, perigee's distance from the centre on the orbit of two bodies through each sample: p/(1 + e)."""
    mu, v = scene.central_body.mu_m3_s2, run.com_velocity_m_s
    momentum2 = (run.com_m[:, 0] * v[:, 1] - run.com_m[:, 1] * v[:, 0]) ** 2
    energy = 0.5 * np.sum(v * v, axis=1) - mu / np.linalg.norm(run.com_m, axis=1)
    eccentricity = np.sqrt(np.maximum(0.0, 1.0 + 2.0 * energy * momentum2 / mu**2))
    perigee: Array = momentum2 / mu / (1.0 + eccentricity)
    return perigee
