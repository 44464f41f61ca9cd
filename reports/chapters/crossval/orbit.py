"""Drawing of the chain along its orbit as in the paper: the chain enlarged, the orbit and the body to scale.

On a short part of an orbit the chain would be a few pixels long: it is drawn about its centre of mass instead, as an
observer there sees it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from reports.chapters.crossval.motion import DrawnChain, frame_count, moving_chain
from reports.plotting.palette import COLOURS
from reports.plotting.panels import Panel
from reports.plotting.svg import FINE, Chart, Scale, relative
from reports.text.record import LEAST_ORBITS

if TYPE_CHECKING:
    from reports.plotting.series import Array

SIZE = 400.0
INSTANTS = 16  # a multiple of 4, so that quarters of the orbit are among them
LEAST_PX = 15.0  # length of the enlarged chain: it has this length on a quarter of an orbit
ROWS = 3  # of chains about their centre of mass, and chains in each
CELL = SIZE / ROWS
TIME_PX = 20.0  # height of a time below a chain
TRACK_POINTS = 181
ASLANT = 0.5  # sine of the angle from the vertical beyond which a label lies beside its instant, not above or below
SHARE = 0.88  # of the distance between two instants that the straight chain covers


@dataclass(frozen=True)
class Geometry:
    """Geometry of a scene's drawing."""

    length_m: Array
    """(N,)"""
    mass_kg: Array
    """(N,)"""
    body_radius_m: float
    """0 without gravity: no disc is drawn"""
    period_s: float
    closed: bool
    """Whether the orbit returns, so that a panel is one revolution"""


@dataclass(frozen=True)
class DrawnMotion:
    """Trajectory of a drawing."""

    t_s: Array
    """(n,)"""
    com_m: Array
    """(n, 2)"""
    angle_rad: Array
    """(n, N)"""
    limit_s: float = np.inf
    """Predictability limit of the judging solution; infinite where it covers the run"""

    @property
    def drawable(self) -> bool:
        """Whether there are two samples or more, and all of them are numbers."""
        return len(self.t_s) > 1 and bool(np.isfinite(self.com_m).all() and np.isfinite(self.angle_rad).all())


def joints(geometry: Geometry, angle_rad: Array) -> Array:
    """Place the ends and joints of the chain about its own centre of mass.

    Parameters
    ----------
    geometry : Geometry
    angle_rad : ndarray, shape (n, N)

    Returns
    -------
    ndarray, shape (n, N+1, 2), m
        From the left end of bar 1 to the right end of bar N: joints in line, weighted mean zero.
    """
    u = np.stack([np.cos(angle_rad), np.sin(angle_rad)], axis=-1) * geometry.length_m[:, None]
    ends = np.concatenate([np.zeros((len(u), 1, 2)), np.cumsum(u, axis=1)], axis=1)
    centres = 0.5 * (ends[:, 1:] + ends[:, :-1])
    centre = np.einsum("j,njk->nk", geometry.mass_kg / geometry.mass_kg.sum(), centres)
    around: Array = ends - centre[:, None, :]
    return around


def orbit_panels(name: str, geometry: Geometry, motion: DrawnMotion) -> list[Panel]:
    """One panel for each of the first two revolutions, or one for the whole run of an open orbit; the last moves.

    A run of a short part of an orbit has one panel of the chain about its centre of mass.
    """
    if not motion.drawable:
        return []
    end = float(motion.t_s[-1])
    windows = [(float(motion.t_s[0]), min(geometry.period_s, end) if geometry.closed else end)]
    if is_short(geometry, motion, windows[0]):
        return [centred_panel(f"{name}-centred", geometry, motion)]
    if not geometry.closed:
        return [orbit_panel(f"{name}-way", "Chain along its path", geometry, motion, windows[0])]
    if end > (1.0 + LEAST_ORBITS) * geometry.period_s:
        windows.append((geometry.period_s, min(2.0 * geometry.period_s, end)))
    titles = ("Chain along the first orbit", "Chain along the second orbit")
    return [
        orbit_panel(f"{name}-orbit{k + 1}", titles[k], geometry, motion, window, moves=window is windows[-1])
        for k, window in enumerate(windows)
    ]


def orbit_panel(
    name: str,
    title: str,
    geometry: Geometry,
    motion: DrawnMotion,
    window_s: tuple[float, float],
    *,
    moves: bool = True,
) -> Panel:
    """Draw one window of time, with an animation if it `moves`."""
    start, end = window_s
    instants = np.linspace(start, end, INSTANTS + 1)
    if geometry.closed and end - start > 0.99 * geometry.period_s:
        instants = instants[:-1]  # the last lies on the first
    place, track = (
        along(instants, motion.t_s, motion.com_m),
        along(np.linspace(start, end, TRACK_POINTS), motion.t_s, motion.com_m),
    )
    factor = enlargement(geometry, track)
    chain = place[:, None, :] + factor * joints(geometry, along(instants, motion.t_s, motion.angle_rad))
    reached = np.concatenate([swept(geometry, motion, window_s), chain.reshape(-1, 2)])
    drawn = square_chart(reached, geometry.body_radius_m)
    drawn.line(track[:, 0], track[:, 1], COLOURS["rule"], 1.0)
    draw_chains(drawn, chain)
    label_instants(drawn, geometry, instants, place, chain)
    size = f"{float(f'{factor:.2g}'):,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    note = f"Chain enlarged {size} times; bar 1 in colour.{beyond(geometry, motion, end)}"
    moving = motion_in(drawn, name, geometry, motion, window_s) if moves else Markup("")
    return Panel(title, drawn.svg(title, more=moving), note, moving=f"{name}-moves" if moving else "")


def motion_in(
    drawn: Chart, name: str, geometry: Geometry, motion: DrawnMotion, window_s: tuple[float, float]
) -> Markup:
    """Animation of a window of time over a drawing, whose chains have the same size; empty for a motion too fast."""
    within = (motion.t_s >= window_s[0]) & (motion.t_s <= window_s[1])
    frames = frame_count(motion.angle_rad[within])
    if not frames:
        return Markup("")
    instants = np.linspace(*window_s, frames + 1)
    track = along(instants, motion.t_s, motion.com_m)
    angle = along(instants, motion.t_s, motion.angle_rad)
    factor = enlargement(geometry, along(np.linspace(*window_s, TRACK_POINTS), motion.t_s, motion.com_m))
    end = track + factor * joints(geometry, angle)[:, 0]
    end_px, per_m = np.stack([drawn.x(end[:, 0]), drawn.y(end[:, 1])], axis=-1), SIZE / (drawn.x.high - drawn.x.low)
    return moving_chain(name, DrawnChain(end_px, -angle, per_m * factor * geometry.length_m))


def enlargement(geometry: Geometry, track: Array) -> float:
    """Factor of the chain's size that keeps chains at all drawn instants of the `track` (k, 2) apart."""
    path = float(np.linalg.norm(np.diff(track, axis=0), axis=1).sum())
    return SHARE * path / INSTANTS / float(geometry.length_m.sum())


def beyond(geometry: Geometry, motion: DrawnMotion, end_s: float) -> str:
    """Note on configurations beyond the predictability limit in a panel that ends at `end_s`; empty without such."""
    if motion.limit_s >= end_s:
        return ""
    in_orbits = geometry.closed and motion.t_s[-1] >= LEAST_ORBITS * geometry.period_s
    predictability_limit = (
        f"{motion.limit_s / geometry.period_s:.2f} orbits" if in_orbits else f"{motion.limit_s:.4g} s"
    )
    return f" After {predictability_limit}: beyond the predictability limit of the judging solution."


def along(at_s: Array, t_s: Array, values: Array) -> Array:
    """Interpolate the columns of `values` (n, k) at other instants."""
    return np.stack([np.interp(at_s, t_s, column) for column in values.T], axis=-1)


def swept(geometry: Geometry, motion: DrawnMotion, window_s: tuple[float, float]) -> Array:
    """Points (k, 2), m, that the centre of mass, the ends and the joints of the enlarged chain reach in a window."""
    instants = np.linspace(*window_s, TRACK_POINTS)
    track = along(instants, motion.t_s, motion.com_m)
    chain = enlargement(geometry, track) * joints(geometry, along(instants, motion.t_s, motion.angle_rad))
    points: Array = np.concatenate([track, (track[:, None, :] + chain).reshape(-1, 2)])
    return points


def is_short(geometry: Geometry, motion: DrawnMotion, window_s: tuple[float, float]) -> bool:
    """Whether the enlarged chain is shorter than :data:`LEAST_PX` on a drawing of a window."""
    track = along(np.linspace(*window_s, TRACK_POINTS), motion.t_s, motion.com_m)
    chain_m = enlargement(geometry, track) * float(geometry.length_m.sum())
    extent_m = 2.0 * frame_of(swept(geometry, motion, window_s), geometry.body_radius_m)[1]
    return chain_m * SIZE < LEAST_PX * extent_m


def frame_of(points: Array, body_radius_m: float) -> tuple[Array, float]:
    """Middle (2,) and half the side of the square around all `points` (k, 2) and the body's disc, m."""
    low, high = points.min(axis=0), points.max(axis=0)
    if body_radius_m > 0.0:
        low, high = np.minimum(low, -body_radius_m), np.maximum(high, body_radius_m)
    half = 0.505 * float((high - low).max()) or 1.0  # a chain of no size at rest has no extent
    return 0.5 * (low + high), half


def square_chart(points: Array, body_radius_m: float = 0.0) -> Chart:
    """Chart of equal scales that shows all `points` (k, 2), and the body's disc."""
    middle, half = frame_of(points, body_radius_m)
    x, y = (Scale(m - half, m + half, *ends) for m, ends in zip(middle, ((0.0, SIZE), (SIZE, 0.0)), strict=True))
    drawn = Chart(x, y, (SIZE, SIZE))
    if body_radius_m > 0.0:
        drawn.marks(0.0, 0.0, "o", COLOURS["body"], body_radius_m * SIZE / half)
    return drawn


def centred_panel(name: str, geometry: Geometry, motion: DrawnMotion) -> Panel:
    """Draw the chain about its centre of mass at equal intervals, each with its time; the first one moves.

    The second axis points away from the body, where there is one.
    """
    angle = motion.angle_rad
    if geometry.body_radius_m > 0.0:
        longitude = np.unwrap(np.arctan2(motion.com_m[:, 1], motion.com_m[:, 0]))
        angle = angle - longitude[:, None] + 0.5 * np.pi
    start, end = float(motion.t_s[0]), float(motion.t_s[-1])
    instants = np.linspace(start, end, ROWS * ROWS)
    frames = frame_count(angle)
    moved = along(np.linspace(start, end, max(frames, TRACK_POINTS) + 1), motion.t_s, angle)
    chain = joints(geometry, along(instants, motion.t_s, angle))
    points = np.concatenate([joints(geometry, moved).reshape(-1, 2), chain.reshape(-1, 2)])
    middle, half = frame_of(points, 0.0)
    px_per_m = 0.5 * (CELL - 1.5 * TIME_PX) / half
    column, row = np.arange(len(instants)) % ROWS, np.arange(len(instants)) // ROWS
    centre_px = np.stack([(column + 0.5) * CELL, SIZE - row * CELL - 0.5 * (CELL - TIME_PX)], axis=-1)
    drawn = Chart(Scale(0.0, SIZE, 0.0, SIZE), Scale(0.0, SIZE, SIZE, 0.0), (SIZE, SIZE))
    draw_chains(drawn, centre_px[:, None, :] + px_per_m * (chain - middle))
    for k, (at_s, at_px) in enumerate(zip(instants, centre_px, strict=True)):
        text = f"{'t = ' if k == 0 else ''}{at_s:.4g} s"
        drawn.text((at_px[0], SIZE - at_px[1] + 0.5 * (CELL - TIME_PX) + 10.0), text, "middle")
    title = "Chain about its centre of mass"
    upwards = "; vertical upwards" if geometry.body_radius_m > 0.0 else ""
    note = f"To scale; bar 1 in colour{upwards}.{beyond(geometry, motion, end)}"
    moving = Markup("")
    if frames:
        angles = along(np.linspace(start, end, frames + 1), motion.t_s, angle)
        end_px = centre_px[0] + px_per_m * (joints(geometry, angles)[:, 0] - middle)
        end_px[:, 1] = SIZE - end_px[:, 1]
        moving = moving_chain(name, DrawnChain(end_px, -angles, px_per_m * geometry.length_m))
    return Panel(title, drawn.svg(title, more=moving), note, moving=f"{name}-moves" if moving else "")


def draw_chains(drawn: Chart, chain: Array) -> None:
    """Chains (k, N+1, 2): bars as lines, joints as dots, the first bar in the accent colour."""
    px = np.round(FINE * np.stack([drawn.x(chain[..., 0]), drawn.y(chain[..., 1])], axis=-1))
    drawn.stroke("".join(map(relative, px)), COLOURS["ink"], 1.3)
    drawn.stroke("".join(map(relative, px[:, :2])), COLOURS["accent"], 2.6)
    hinges = chain[:, 1:-1].reshape(-1, 2)
    drawn.marks(hinges[:, 0], hinges[:, 1], "o", COLOURS["ink"], 2.9)


def label_instants(drawn: Chart, geometry: Geometry, instants_s: Array, place: Array, chain: Array) -> None:
    """Write the time beside every fourth instant: towards the body, clear of the chain."""
    for k in range(0, len(instants_s), 4):
        orbits = instants_s[k] / geometry.period_s
        count = f"{orbits:.2f}".rstrip("0").rstrip(".")
        text = f"{count} orbit{'' if count == '1' else 's'}" if geometry.closed else f"{instants_s[k]:.0f} s"
        if k == 0:
            text = f"t = {text}"
        towards = inward(place, k)
        reach = float(((chain[k] - place[k]) @ towards).max())
        room = (0.04 if geometry.closed else 0.08) * (drawn.x.high - drawn.x.low)
        where = place[k] + towards * (reach + room)
        anchor = "start" if towards[0] > ASLANT else "end" if towards[0] < -ASLANT else "middle"
        drawn.text((float(drawn.x(where[0])), float(drawn.y(where[1])) + 4.0), text, anchor)


def inward(place: Array, k: int) -> Array:
    """Unit normal of the path through `place` (n, 2) at the k-th instant, towards the body."""
    ahead = place[(k + 1) % len(place)] - place[k] if k + 1 < len(place) else place[k] - place[k - 1]
    normal = np.array([-ahead[1], ahead[0]])
    if normal @ place[k] > 0.0:
        normal = -normal
    unit: Array = normal / (float(np.linalg.norm(normal)) or 1.0)
    return unit
