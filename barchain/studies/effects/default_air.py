"""Standard air, and the heights at which a run meets it, for scenes that name no atmosphere of their own.

Vallado, Fundamentals of Astrodynamics and Applications, 4th ed., table 8-4: US Standard Atmosphere 1976 up to 25 km,
CIRA-72 above. Each entry holds from its own height to that of the next.
"""

from __future__ import annotations

import bisect
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from scenarios import Gravity

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

SOURCE = "Vallado, table 8-4"
HIGHEST_M = 2000e3  # nearly four scale heights beyond the last entry: what the table says there is a guess
MOST_SCALE_HEIGHTS = 2.0  # that a run may rise above an entry whose exponential is taken for all of it
DIGITS = 0.02  # by which the table's entries do not meet


class Heights(NamedTuple):
    """Least and largest height of the centre of mass above the surface, m."""

    lowest_m: float
    highest_m: float


def expected_heights(scene: Scene) -> Heights:
    """Heights on the orbit of the start, before anything has run: both apsides from half a period on."""
    start = scene.orbit.altitude_m
    if not scene.bound or scene.run.duration_s < 0.5 * scene.period_s:
        return Heights(start, start)
    surface = scene.central_body.radius_m
    return Heights(max(scene.lowest_radius_m - surface, 0.0), max(start, scene.highest_radius_m - surface))


def heights_of(scene: Scene, run: Trajectory) -> Heights:
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


class Layer(NamedTuple):
    """One entry of the table."""

    base_km: float
    density_kg_m3: float
    """At the base"""
    scale_height_km: float


LAYERS = (
    Layer(0, 1.225, 7.249),
    Layer(25, 3.899e-2, 6.349),
    Layer(30, 1.774e-2, 6.682),
    Layer(40, 3.972e-3, 7.554),
    Layer(50, 1.057e-3, 8.382),
    Layer(60, 3.206e-4, 7.714),
    Layer(70, 8.770e-5, 6.549),
    Layer(80, 1.905e-5, 5.799),
    Layer(90, 3.396e-6, 5.382),
    Layer(100, 5.297e-7, 5.877),
    Layer(110, 9.661e-8, 7.263),
    Layer(120, 2.438e-8, 9.473),
    Layer(130, 8.484e-9, 12.636),
    Layer(140, 3.845e-9, 16.149),
    Layer(150, 2.070e-9, 22.523),
    Layer(180, 5.464e-10, 29.740),
    Layer(200, 2.789e-10, 37.105),
    Layer(250, 7.248e-11, 45.546),
    Layer(300, 2.418e-11, 53.628),
    Layer(350, 9.518e-12, 53.298),
    Layer(400, 3.725e-12, 58.515),
    Layer(450, 1.585e-12, 60.828),
    Layer(500, 6.967e-13, 63.822),
    Layer(600, 1.454e-13, 71.835),
    Layer(700, 3.614e-14, 88.667),
    Layer(800, 1.170e-14, 124.64),
    Layer(900, 5.245e-15, 181.05),
    Layer(1000, 3.019e-15, 268.00),
)


def layer_at(altitude_m: float) -> Layer:
    """Entry that holds at a height above the surface."""
    after = bisect.bisect_right([entry.base_km for entry in LAYERS], altitude_m / 1e3)
    return LAYERS[max(after - 1, 0)]


def density_kg_m3(altitude_m: float, layer: Layer | None = None) -> float:
    """Density of the standard table at an altitude, or of one entry's exponential there."""
    entry = layer or layer_at(altitude_m)
    return entry.density_kg_m3 * math.exp(-(altitude_m / 1e3 - entry.base_km) / entry.scale_height_km)


def caveat(layer: Layer, heights: Heights) -> str:
    """Warning that one entry's exponential does not hold over a run's altitudes; empty where it holds.

    Above 100 km the table's scale height rises with height (but for 0.6 % at 350 km), so that one entry's exponential
    has ever less air than the table, above it and below it too; lower down it may have more.
    """
    lowest_km, highest_km = (h / 1e3 for h in heights)
    rise = (highest_km - lowest_km) / layer.scale_height_km
    if rise <= MOST_SCALE_HEIGHTS:
        return ""
    top_km = min(highest_km, HIGHEST_M / 1e3)
    known_km = [lowest_km, *(e.base_km for e in LAYERS if lowest_km < e.base_km < top_km), top_km]
    ratios = [density_kg_m3(1e3 * h) / density_kg_m3(1e3 * h, layer) for h in known_km]
    return (
        f"One exponential can't tell all of the air from {lowest_km:.1f} km to {highest_km:.1f} km, {rise:.3g} scale "
        f"heights: {bound_words(min(ratios), max(ratios))}."
    )


def bound_words(least: float, most: float) -> str:
    """Direction of the error of the drag; `least` and `most` are the table's density over the exponential's."""
    if most <= 1.0 + DIGITS:
        return f"it has up to {1.0 / least:.2g} times the table's, and its drag is an upper bound"
    if least >= 1.0 - DIGITS:
        return f"the table has up to {most:.2g} times as much, and this drag is a lower bound"
    return f"the table has {least:.2g} to {most:.2g} times as much, and this drag is no bound"
