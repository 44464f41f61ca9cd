"""Drawing of the chain along its orbit as in the paper: the chain enlarged, the orbit and the body to scale.

On a short part of an orbit the chain would be a few pixels long: it is drawn about its centre of mass instead, as an
observer there sees it. The last drawing of a scene moves: an animation in CSS, from stored samples, without a script.
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from markupsafe import Markup

from reports.plotting.palette import COLOURS
from reports.plotting.panels import Panel
from reports.plotting.svg import FINE, Chart, Scale, relative
from reports.text.record import LEAST_ORBITS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.plotting.series import Array

SIZE = 400.0
INSTANTS = 16  # a multiple of 4, so that quarters of the orbit are among them
BODY_PX = 9.0  # width of an end body
LEAST_PX = 15.0  # length of the enlarged chain: it has this length on a quarter of an orbit
ROWS = 3  # of chains about their centre of mass, and chains in each
CELL = SIZE / ROWS
TIME_PX = 20.0  # height of a time below a chain
TRACK_POINTS = 181
ASLANT = 0.5  # sine of the angle from the vertical beyond which a label lies beside its instant, not above or below
SHARE = 0.88  # of the distance between two instants that the straight chain covers
LEAST_FRAMES, MOST_FRAMES = 32, 96
TURN_RAD = 0.35
"""Rotation of a bar between two frames: halfway, the chain's end is off by 1.5 % of its distance from the centre of
mass, the height of the arc over its chord"""
MOST_TURN_RAD = 1.5
"""Rotation of a bar between two frames beyond which a motion is too fast to be shown"""
MOST_BYTES = 20_000


class Geometry(NamedTuple):
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
    bodies: tuple[int, ...] = ()
    """Bars that are end bodies, counted from 1"""
    com_share: tuple[float, ...] = ()
    """Shares of the lengths from the left ends to the centres of mass; empty: midway"""


class DrawnMotion(NamedTuple):
    """Trajectory of a drawing."""

    t_s: Array
    """(n,)"""
    com_m: Array
    """(n, 2)"""
    angle_rad: Array
    """(n, N)"""
    limit_s: float = np.inf
    """Predictability limit of the judging solution; infinite where it covers the run"""


class Enlarged(NamedTuple):
    """Chain in a window of time, enlarged so that chains at all drawn instants stay apart."""

    geometry: Geometry
    motion: DrawnMotion
    window_s: tuple[float, float]

    def track(self, count: int = TRACK_POINTS) -> Array:
        """Centre of mass at equal intervals of time, (k, 2) m."""
        return along(np.linspace(*self.window_s, count), self.motion.t_s, self.motion.com_m)

    @property
    def factor(self) -> float:
        """Factor of the chain's size; 0 of a chain at rest."""
        way = float(np.linalg.norm(np.diff(self.track(), axis=0), axis=1).sum())
        if way <= TRACK_POINTS * float(np.spacing(np.abs(self.motion.com_m).max())):  # rounding of a place at rest
            return 0.0
        return SHARE * way / INSTANTS / float(self.geometry.length_m.sum())

    def chain(self, instants_s: Array) -> Array:
        """Ends and joints of the enlarged chain, (k, N+1, 2) m."""
        place, angle = (along(instants_s, self.motion.t_s, v) for v in (self.motion.com_m, self.motion.angle_rad))
        chain: Array = place[:, None, :] + self.factor * joints(self.geometry, angle)
        return chain

    def swept(self) -> Array:
        """Points (k, 2), m, that the centre of mass, the ends and the joints reach."""
        chain = self.chain(np.linspace(*self.window_s, TRACK_POINTS)).reshape(-1, 2)
        points: Array = np.concatenate([self.track(), chain])
        return points


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
    share = np.array(geometry.com_share or 0.5)[..., None]
    centres = (1.0 - share) * ends[:, :-1] + share * ends[:, 1:]
    centre = np.einsum("j,njk->nk", geometry.mass_kg / geometry.mass_kg.sum(), centres)
    around: Array = ends - centre[:, None, :]
    return around


def orbit_panels(name: str, geometry: Geometry, motion: DrawnMotion) -> list[Panel]:
    """One panel for each of the first two revolutions, or one for the whole run of an open orbit; the last moves.

    A run of a short part of an orbit has one panel of the chain about its centre of mass. Without two samples, or with
    one that is no number, there is none.
    """
    if len(motion.t_s) < 2 or not (np.isfinite(motion.com_m).all() and np.isfinite(motion.angle_rad).all()):
        return []
    start, end = float(motion.t_s[0]), float(motion.t_s[-1])
    first = Enlarged(geometry, motion, (start, min(geometry.period_s, end) if geometry.closed else end))
    chain_m = first.factor * float(geometry.length_m.sum())
    if chain_m * SIZE < LEAST_PX * 2.0 * frame_of(first.swept(), geometry.body_radius_m)[1]:
        return [centred_panel(f"{name}-centred", geometry, motion)]
    if not geometry.closed:
        return [orbit_panel(f"{name}-way", "Chain along its path", first)]
    if end <= (1.0 + LEAST_ORBITS) * geometry.period_s:
        return [orbit_panel(f"{name}-orbit1", "Chain along the first orbit", first)]
    second = first._replace(window_s=(geometry.period_s, min(2.0 * geometry.period_s, end)))
    return [
        orbit_panel(f"{name}-orbit1", "Chain along the first orbit", first, moves=False),
        orbit_panel(f"{name}-orbit2", "Chain along the second orbit", second),
    ]


def orbit_panel(name: str, title: str, shown: Enlarged, *, moves: bool = True) -> Panel:
    """Draw one window of time, with an animation if it `moves`."""
    geometry, motion, (start, end) = shown
    instants = np.linspace(start, end, INSTANTS + 1)
    if geometry.closed and end - start > 0.99 * geometry.period_s:
        instants = instants[:-1]  # the last lies on the first
    chain, track = shown.chain(instants), shown.track()
    drawn = square_chart(np.concatenate([shown.swept(), chain.reshape(-1, 2)]), geometry.body_radius_m)
    drawn.line(track[:, 0], track[:, 1], COLOURS["rule"], 1.0)
    draw_chains(drawn, chain, geometry.bodies)
    label_instants(drawn, geometry, instants, along(instants, motion.t_s, motion.com_m), chain)
    size = f"{float(f'{shown.factor:.2g}'):,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}")
    note = f"Chain enlarged {size} times; bar 1 in colour.{beyond(geometry, motion, end)}"
    within = (motion.t_s >= start) & (motion.t_s <= end)
    frames = frame_count(motion.angle_rad[within]) if moves else 0
    at = np.linspace(start, end, frames + 1)
    length_px = SIZE / (drawn.x.high - drawn.x.low) * shown.factor * geometry.length_m
    turned = along(at, motion.t_s, motion.angle_rad)
    moving = moving_chain(name, drawn, shown.chain(at)[:, 0], turned, length_px, geometry.bodies)
    return Panel(title, drawn.svg(title, more=moving), note, moving=f"{name}-moves" if moving else "")


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
    draw_chains(drawn, centre_px[:, None, :] + px_per_m * (chain - middle), geometry.bodies)
    for k, (at_s, at_px) in enumerate(zip(instants, centre_px, strict=True)):
        text = f"{'t = ' if k == 0 else ''}{at_s:.4g} s"
        drawn.text((at_px[0], SIZE - at_px[1] + 0.5 * (CELL - TIME_PX) + 10.0), text, "middle")
    title = "Chain about its centre of mass"
    upwards = "; vertical upwards" if geometry.body_radius_m > 0.0 else ""
    note = f"To scale; bar 1 in colour{upwards}.{beyond(geometry, motion, end)}"
    angles = along(np.linspace(start, end, frames + 1), motion.t_s, angle)
    ends = centre_px[0] + px_per_m * (joints(geometry, angles)[:, 0] - middle)
    moving = moving_chain(name, drawn, ends, angles, px_per_m * geometry.length_m, geometry.bodies)
    return Panel(title, drawn.svg(title, more=moving), note, moving=f"{name}-moves" if moving else "")


def beyond(geometry: Geometry, motion: DrawnMotion, end_s: float) -> str:
    """Note on configurations beyond the predictability limit in a panel that ends at `end_s`; empty without such."""
    if motion.limit_s >= end_s:
        return ""
    in_orbits = geometry.closed and motion.t_s[-1] >= LEAST_ORBITS * geometry.period_s
    at = f"{motion.limit_s / geometry.period_s:.2f} orbits" if in_orbits else f"{motion.limit_s:.4g} s"
    return f" After {at}: beyond the predictability limit of the judging solution."


def along(at_s: Array, t_s: Array, values: Array) -> Array:
    """Interpolate the columns of `values` (n, k) at other instants."""
    return np.stack([np.interp(at_s, t_s, column) for column in values.T], axis=-1)


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


def draw_chains(drawn: Chart, chain: Array, bodies: Sequence[int] = ()) -> None:
    """Chains (k, N+1, 2): bars as lines, end bodies as blocks, joints as dots, the first bar in the accent colour."""
    px = np.round(FINE * np.stack([drawn.x(chain[..., 0]), drawn.y(chain[..., 1])], axis=-1))
    drawn.stroke("".join(map(relative, px)), COLOURS["ink"], 1.3)
    for j in bodies:
        drawn.stroke("".join(map(relative, px[:, j - 1 : j + 1])), COLOURS["ink"], BODY_PX, ";stroke-linecap:round")
    drawn.stroke("".join(map(relative, px[:, :2])), COLOURS["accent"], 2.6)
    hinges = chain[:, 1:-1].reshape(-1, 2)
    drawn.marks(hinges[:, 0], hinges[:, 1], "o", COLOURS["ink"], 2.9)


def label_instants(drawn: Chart, geometry: Geometry, instants_s: Array, place: Array, chain: Array) -> None:
    """Write the time beside every fourth instant: towards the body, clear of the chain."""
    for k in range(0, len(instants_s), 4):
        count = f"{instants_s[k] / geometry.period_s:.2f}".rstrip("0").rstrip(".")
        text = f"{count} orbit{'' if count == '1' else 's'}" if geometry.closed else f"{instants_s[k]:.0f} s"
        ahead = place[(k + 1) % len(place)] - place[k] if k + 1 < len(place) else place[k] - place[k - 1]
        normal = np.array([-ahead[1], ahead[0]])
        towards = normal / (float(np.linalg.norm(normal)) or 1.0) * (-1.0 if normal @ place[k] > 0.0 else 1.0)
        reach = float(((chain[k] - place[k]) @ towards).max())
        room = (0.04 if geometry.closed else 0.08) * (drawn.x.high - drawn.x.low)
        where = place[k] + towards * (reach + room)
        anchor = "start" if towards[0] > ASLANT else "end" if towards[0] < -ASLANT else "middle"
        at = float(drawn.x(where[0])), float(drawn.y(where[1])) + 4.0
        drawn.text(at, f"t = {text}" if k == 0 else text, anchor)


def frame_count(angle_rad: Array) -> int:
    """Number of equal intervals of a motion whose bars turn by the angles (n, N); 0 if they turn too fast."""
    turned = float(np.abs(np.diff(angle_rad, axis=0)).sum(axis=0).max(initial=0.0))
    if turned > MOST_TURN_RAD * MOST_FRAMES:
        return 0
    return int(np.clip(np.ceil(turned / TURN_RAD), LEAST_FRAMES, MOST_FRAMES))


def moving_chain(
    name: str,
    drawn: Chart,
    end: Array,
    angle_rad: Array,
    length_px: Array,
    bodies: Sequence[int] = (),
    most_bytes: int = MOST_BYTES,
) -> Markup:
    """Group of SVG elements that moves while the page lets it; empty for one frame, or a chain of too many bars.

    Each bar is a group inside the group of the bar before it, so that joints never open between two frames.

    Parameters
    ----------
    name : str
        Unique in the page: names of the animations are derived from it.
    drawn : Chart
    end : ndarray, shape (k, 2)
        First end of bar 1 at equal intervals of time, on the scales of `drawn`.
    angle_rad : ndarray, shape (k, N)
        Unwrapped.
    length_px : ndarray, shape (N,)
    bodies : sequence of int
        Bars that are end bodies, counted from 1.
    most_bytes : int
        Beyond which the group is empty.
    """
    if len(end) < 2:
        return Markup("")
    tag = "m" + hashlib.sha256(name.encode()).hexdigest()[:7]
    places = [f"translate({drawn.x(x):.1f}px,{drawn.y(y):.1f}px)" for x, y in end]
    steps = np.degrees(np.diff(-angle_rad, axis=1, prepend=0.0))
    turns = [[f"rotate({a:.1f}deg)" for a in column] for column in steps.T]
    rules = [keyframes(f"{tag}-{k}", states) for k, states in enumerate([places, *turns])]
    bars = ""
    for j in reversed(range(len(turns))):
        x = f"{length_px[j]:.1f}"
        further = f'<g transform="translate({x} 0)">{bars}</g><circle cx="{x}" r="2.4"/>' if bars else ""
        block = f' style="stroke-width:{BODY_PX:g}"' if j + 1 in bodies else ""
        bars = f'<g class="{tag}-{j + 1}" style="transform:{turns[j][0]}"><path d="M0 0H{x}"{block}/>{further}</g>'
    group = f'<g class="moving"><g class="{tag}-0" style="transform:{places[0]}">{bars}</g></g>'
    made = f"<style>{''.join(rules)}</style>{group}"
    return Markup(made if len(made) <= most_bytes else "")


def keyframes(name: str, states: Sequence[str]) -> str:
    """CSS rule of one animation through equally spaced states of a transform."""
    shares = (f"{100.0 * k / (len(states) - 1):.2f}".rstrip("0").rstrip(".") for k in range(len(states)))
    frames = "".join(f"{share}%{{transform:{state}}}" for share, state in zip(shares, states, strict=True))
    return f".{name}{{animation-name:{name}}}@keyframes {name}{{{frames}}}"
