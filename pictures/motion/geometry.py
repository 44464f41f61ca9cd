"""Places of the drawn chain on the picture, in pixels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from pictures.motion.samples import Motion

SIZE = 360.0
"""Side of each of the two square panels, pixels"""
MARGIN = 26.0
INSTANTS = 16  # chains that a whole orbit shows
SHARE = 0.88  # of the distance between two of them that the straight chain covers
GHOSTS = 9
"""Instants at which the observer's panel shows the chain"""


@dataclass(frozen=True)
class Placement:
    """Map from metres to pixels of one panel: y points down on the picture."""

    middle_m: Array
    """(2,)"""
    px_per_m: float

    def pixels(self, points_m: Array) -> Array:
        """Places on the panel, same shape as `points_m` (..., 2)."""
        placed: Array = (points_m - self.middle_m) * np.array([self.px_per_m, -self.px_per_m]) + 0.5 * SIZE
        return placed


@dataclass(frozen=True)
class OrbitPanel:
    """Chain along its orbit, enlarged."""

    track_px: Array
    """(k, 2)"""
    chains_px: Array
    """(n, v, 2) at every instant of the motion"""
    shown: tuple[int, ...]
    """Instants that are drawn at rest"""
    body_px: tuple[float, float, float] | None
    """Centre and radius of the body; None without one"""
    factor: float
    """Enlargement of the chain relative to the orbit"""


@dataclass(frozen=True)
class ChainPanel:
    """Chain as the observer at its centre of mass sees it."""

    chains_px: Array
    """(n, v, 2)"""
    shown: tuple[int, ...]
    scale_px: float
    """Length of the scale bar"""
    scale_m: float
    origin_px: Array
    """(2,) centre of mass"""


def fitted(points_m: Array, margin_px: float = MARGIN) -> Placement:
    """Placement that shows all `points_m` (k, 2)."""
    low, high = points_m.min(axis=0), points_m.max(axis=0)
    extent = float((high - low).max()) or 1.0
    return Placement(0.5 * (low + high), (SIZE - 2.0 * margin_px) / extent)


def orbit_panel(motion: Motion, *, body: bool) -> OrbitPanel:
    """Place the chain along its track; its size follows from the length of the path or of a whole orbit."""
    track = motion.com_m
    radius = motion.scene.central_body.radius_m
    path = path_lengths(track)
    orbits = float(motion.t_s[-1]) / motion.scene.period_s if motion.scene.bound else 1.0
    whole = float(path[-1]) / max(1.0, orbits)
    if body:  # a short part of an orbit shows the chain as large as a whole orbit does
        whole = max(whole, 2.0 * np.pi * float(np.linalg.norm(track, axis=1).min()))
    drawn_m = SHARE * whole / INSTANTS
    factor = drawn_m / motion.scene.size_m
    chains = track[:, None, :] + factor * motion.chain_m
    points = chains.reshape(-1, 2)
    if body:
        points = np.concatenate([points, [[-radius, -radius], [radius, radius]]])
    place = fitted(points)
    centre = place.pixels(np.zeros(2))
    disc = (float(centre[0]), float(centre[1]), radius * place.px_per_m) if body else None
    chains_px = place.pixels(chains)
    return OrbitPanel(
        place.pixels(track), chains_px, apart(place.pixels(track), drawn_m * place.px_per_m), disc, factor
    )


def path_lengths(track: Array) -> Array:
    """Length of the path up to each point of `track` (n, 2)."""
    steps = np.linalg.norm(np.diff(track, axis=0), axis=1)
    lengths: Array = np.concatenate([[0.0], np.cumsum(steps)])
    return lengths


def apart(track_px: Array, chain_px: float) -> tuple[int, ...]:
    """Instants at which the centre of mass is a chain's length apart, up to the first return to the start."""
    path = path_lengths(track_px)
    gap = chain_px / SHARE
    taken = [0]
    for k in range(1, len(path)):
        returned = path[k] > 3.0 * gap and np.linalg.norm(track_px[k] - track_px[0]) < 0.8 * gap
        if returned:
            break
        if path[k] - path[taken[-1]] >= 0.97 * gap:
            taken.append(k)
    return tuple(taken)


def chain_panel(motion: Motion) -> ChainPanel:
    """Place the chain about its centre of mass, in true proportions."""
    reach = float(np.linalg.norm(motion.riding_m, axis=-1).max())
    place = fitted(np.array([[-reach, -reach], [reach, reach]]))
    n = len(motion.t_s)
    shown = tuple(np.unique(np.linspace(0, n - 1, GHOSTS).astype(int)).tolist()) if motion.shape_changes else (0,)
    scale_m = round_length(0.3 * SIZE / place.px_per_m)
    return ChainPanel(
        place.pixels(motion.riding_m), shown, scale_m * place.px_per_m, scale_m, place.pixels(np.zeros(2))
    )


def round_length(most_m: float) -> float:
    """Largest of 1, 2 and 5 times a power of ten up to `most_m`."""
    power = 10.0 ** np.floor(np.log10(most_m))
    return float(max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= most_m * (1.0 + 1e-9)))
