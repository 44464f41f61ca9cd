"""SVG pictures of a motion: both panels, and the thumbnail."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pictures.motion.geometry import SIZE, ChainPanel, OrbitPanel, chain_panel, orbit_panel
from pictures.motion.samples import is_free
from pictures.motion.wording import alt_text, duration, enlargement, length
from pictures.templating import render
from pictures.themes import theme_css

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from pictures.motion.samples import Motion

BODY_POINTS = {"first": slice(2), "last": slice(-2, None)}
"""Points of the drawn chain that are an end body's"""
LOOP_S = 9.0
"""Time that a picture in motion takes, s"""


@dataclass(frozen=True)
class Ghost:
    """Chain at one instant, as points of a polyline."""

    points: str
    first_bar: str
    opacity: float
    bodies: tuple[str, ...]


@dataclass(frozen=True)
class Mover:
    """Chain in motion: points of its polylines at every instant."""

    frames: str
    first_frames: str
    start: str
    first_start: str
    bodies: tuple[tuple[str, str], ...]
    """Start and frames of each end body"""


@dataclass(frozen=True)
class PanelView:
    """All that the template draws of a panel."""

    ghosts: tuple[Ghost, ...]
    mover: Mover | None
    track: str
    joints: bool


def scene_picture(motion: Motion, theme: str = "") -> str:
    """SVG of a scene, in both themes by the reader's preference, or in one of :data:`pictures.themes.THEMES`."""
    orbit, chain = orbit_panel(motion, body=not is_free(motion.scene)), chain_panel(motion)
    return render(
        "scene.svg.j2",
        alt=alt_text(motion, orbit.factor),
        size=SIZE,
        orbit=view(orbit, motion, track=True),
        body=orbit.body_px,
        chain=view(chain, motion, track=False),
        origin=point(chain.origin_px),
        free=is_free(motion.scene),
        scale_px=number(chain.scale_px),
        scale=length(chain.scale_m),
        factor=enlargement(orbit.factor),
        shown=duration(motion),
        loop_s=number(LOOP_S),
        themes=theme_css(theme),
    )


def thumbnail(motion: Motion) -> str:
    """Small SVG of the chain as the observer at its centre of mass sees it."""
    label = motion.scene.name.partition("/")[2].replace("_", " ")
    return render(
        "thumbnail.svg.j2",
        alt=motion.scene.title,
        label=label,
        letter_px=min(27, int(580 / len(label))),
        size=SIZE,
        chain=view(chain_panel(motion), motion, track=False),
        themes=theme_css(),
    )


def view(panel: OrbitPanel | ChainPanel, motion: Motion, *, track: bool) -> PanelView:
    """Polylines of a panel."""
    chains, ends = panel.chains_px, [BODY_POINTS[end] for end in motion.scene.chain.end_bodies]
    last = len(panel.shown) - 1
    ghosts = tuple(
        Ghost(
            polyline(chains[k]),
            polyline(chains[k][:2]),
            round(0.3 + 0.7 * i / last, 2) if last and not track else 1.0,
            tuple(polyline(chains[k][at]) for at in ends),
        )
        for i, k in enumerate(panel.shown)
    )
    moves = motion.shape_changes or track
    line = polyline(panel.track_px) if isinstance(panel, OrbitPanel) else ""
    return PanelView(ghosts, mover(chains, ends) if moves else None, line, chains.shape[1] <= 12)


def mover(chains_px: Array, ends: list[slice]) -> Mover:
    """Chain in motion."""
    return Mover(
        ";".join(polyline(c) for c in chains_px),
        ";".join(polyline(c[:2]) for c in chains_px),
        polyline(chains_px[0]),
        polyline(chains_px[0][:2]),
        tuple((polyline(chains_px[0][at]), ";".join(polyline(c[at]) for c in chains_px)) for at in ends),
    )


def polyline(points_px: Array) -> str:
    """Points of a polyline to a tenth of a pixel."""
    return " ".join(point(p) for p in points_px)


def point(at_px: Array) -> str:
    """One point."""
    return ",".join(number(float(x)) for x in at_px)


def number(value: float) -> str:
    """Number to a tenth, without a sign on zero."""
    return f"{np.round(value, 1) + 0.0:g}"
