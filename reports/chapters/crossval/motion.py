"""The chain in motion over a drawing of its orbit: an animation in CSS, from stored samples, without a script."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

if TYPE_CHECKING:
    from collections.abc import Sequence

    from reports.plotting.series import Array

LEAST_FRAMES, MOST_FRAMES = 32, 96
TURN_RAD = 0.35
"""Rotation of a bar between two frames: halfway, the chain's end is off by 1.5 % of its distance from the centre of
mass, the height of the arc over its chord"""
MOST_TURN_RAD = 1.5
"""Rotation of a bar between two frames beyond which a motion is too fast to be shown"""
MOST_BYTES = 20_000


@dataclass(frozen=True)
class DrawnChain:
    """Chain at some instants in the coordinates of a drawing: CSS pixels, the second axis downwards."""

    end_px: Array
    """(k, 2) first end of bar 1"""
    angle_rad: Array
    """(k, N) unwrapped, clockwise"""
    length_px: Array
    """(N,)"""


def frame_count(angle_rad: Array) -> int:
    """Number of equal intervals of a motion whose bars turn by the angles (n, N); 0 if they turn too fast."""
    turned = float(np.abs(np.diff(angle_rad, axis=0)).sum(axis=0).max(initial=0.0))
    if turned > MOST_TURN_RAD * MOST_FRAMES:
        return 0
    return int(np.clip(np.ceil(turned / TURN_RAD), LEAST_FRAMES, MOST_FRAMES))


def moving_chain(name: str, chain: DrawnChain) -> Markup:
    """Group of SVG elements that moves while the page lets it; empty for a chain of too many bars.

    Each bar is a group inside the group of the bar before it, so that joints never open between two frames.

    Parameters
    ----------
    name : str
        Unique in the page: names of the animations are derived from it.
    chain : DrawnChain
        At equal intervals of time.
    """
    tag = "m" + hashlib.sha256(name.encode()).hexdigest()[:7]
    places = [f"translate({x:.1f}px,{y:.1f}px)" for x, y in chain.end_px]
    steps = np.degrees(np.diff(chain.angle_rad, axis=1, prepend=0.0))
    turns = [[f"rotate({a:.1f}deg)" for a in column] for column in steps.T]
    rules = [keyframes(f"{tag}-{k}", states) for k, states in enumerate([places, *turns])]
    bars = nested_bars(tag, turns, chain.length_px)
    group = f'<g class="moving"><g class="{tag}-0" style="transform:{places[0]}">{bars}</g></g>'
    made = f"<style>{''.join(rules)}</style>{group}"
    return Markup(made if len(made) <= MOST_BYTES else "")


def keyframes(name: str, states: Sequence[str]) -> str:
    """CSS rule of one animation through equally spaced states of a transform."""
    last = len(states) - 1
    frames = "".join(f"{percent(k / last)}{{transform:{state}}}" for k, state in enumerate(states))
    return f".{name}{{animation-name:{name}}}@keyframes {name}{{{frames}}}"


def percent(share: float) -> str:
    """``12.5%``."""
    return f"{100.0 * share:.2f}".rstrip("0").rstrip(".") + "%"


def nested_bars(tag: str, turns: Sequence[Sequence[str]], length_px: Array) -> str:
    """Groups of all bars, each at the far end of the bar before it."""
    made = ""
    for j in reversed(range(len(turns))):
        x = f"{length_px[j]:.1f}"
        further = f'<g transform="translate({x} 0)">{made}</g><circle cx="{x}" r="2.4"/>' if made else ""
        made = f'<g class="{tag}-{j + 1}" style="transform:{turns[j][0]}"><path d="M0 0H{x}"/>{further}</g>'
    return made
