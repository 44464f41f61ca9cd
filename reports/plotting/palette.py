"""Colours: named, one value on white and one on near-black; pens and markers.

Charts name their colours as ``var(--name)``: the same SVG reads in both themes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise

PAPER = ("#fdfdfb", "#15171b")
"""Background of the page, light and dark."""


@dataclass(frozen=True)
class Colour:
    """A colour of the theme."""

    name: str
    light: str
    dark: str

    @property
    def css(self) -> str:
        """Reference to it from a style sheet."""
        return f"var(--{self.name})"


def _colours(*triples: tuple[str, str, str]) -> dict[str, Colour]:
    return {n: Colour(n, light, dark) for n, light, dark in triples}


# Okabe and Ito's hues, darkened on white and lightened on near-black until each has 3:1 against it;
# two neutrals first, for the engines that come first: the reference in its two forms.
COLOURS = _colours(
    ("ink", "#1d2127", "#e4e6ea"),
    ("muted", "#5d6570", "#9aa3af"),
    ("grid", "#e3e5e4", "#2c3037"),
    ("rule", "#b9bec4", "#4a515b"),
    ("body", "#e9edf0", "#23272e"),
    ("accent", "#0a64a4", "#62b0ec"),
    ("s0", "#2f343b", "#d3d7dd"),
    ("s1", "#80868f", "#8f97a3"),
    ("s2", "#0072b2", "#4fa9e6"),
    ("s3", "#c84e00", "#f07f3e"),
    ("s4", "#00805c", "#2fbf95"),
    ("s5", "#ad4f88", "#dd90bd"),
    ("s6", "#9a6a00", "#e3b341"),
    ("s7", "#5a49ae", "#a396f2"),
    ("s8", "#8c2231", "#ea7380"),
)
DIGITS = (
    ("#f0f5f9", "#1b232c"), ("#d9e7f2", "#1d2f41"), ("#c0d8ea", "#1f3b55"), ("#a4c8e2", "#20476a"),
    ("#88b7da", "#21537f"), ("#6ba6d2", "#225f93"), ("#4d95c9", "#2469a4"),
)  # fmt: skip
"""Shades of the digits of accuracy from few to many, light and dark: of one hue, each under the ink of its theme"""
SERIES = [c for n, c in COLOURS.items() if n[0] == "s" and n[1:].isdigit()]
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "p", "h", "<", ">")
SIDE = 6.0
"""Side of the square about the origin that markers fill"""
SHAPES: dict[str, tuple[tuple[float, float], ...]] = {
    "o": (),
    "s": ((-2.7, -2.7), (2.7, -2.7), (2.7, 2.7), (-2.7, 2.7)),
    "^": ((0, -3.4), (3.2, 2.6), (-3.2, 2.6)),
    "D": ((0, -3.6), (3.6, 0), (0, 3.6), (-3.6, 0)),
    "v": ((0, 3.4), (3.2, -2.6), (-3.2, -2.6)),
    "P": (
        (-1.1, -3.3), (1.1, -3.3), (1.1, -1.1), (3.3, -1.1), (3.3, 1.1), (1.1, 1.1),
        (1.1, 3.3), (-1.1, 3.3), (-1.1, 1.1), (-3.3, 1.1), (-3.3, -1.1), (-1.1, -1.1),
    ),
    "X": (
        (-3.3, -2), (-2, -3.3), (0, -1.3), (2, -3.3), (3.3, -2), (1.3, 0),
        (3.3, 2), (2, 3.3), (0, 1.3), (-2, 3.3), (-3.3, 2), (-1.3, 0),
    ),
    "p": ((0, -3.4), (3.3, -1), (2, 2.8), (-2, 2.8), (-3.3, -1)),
    "h": ((0, -3.4), (3, -1.7), (3, 1.7), (0, 3.4), (-3, 1.7), (-3, -1.7)),
    "<": ((-3.4, 0), (2.6, -3.2), (2.6, 3.2)),
    ">": ((3.4, 0), (-2.6, -3.2), (-2.6, 3.2)),
}  # fmt: skip
"""Corners of each marker; the first is a circle"""
DASHES: tuple[tuple[float, ...], ...] = ((), (6, 2), (2, 1.6), (7, 2, 1.5, 2))


@cache
def marker_path(marker: str, size: float) -> str:
    """Path of a marker about the current point."""
    scale = size / SIDE
    if marker == "o":
        r = float(f"{0.5 * SIDE * scale:.3g}")  # its double is written in full: both halves meet
        return f"m{-r:g} 0a{r:g} {r:g} 0 1 0 {2 * r:g} 0a{r:g} {r:g} 0 1 0{-2 * r:g} 0z"
    if marker == "x":
        return f"m{-0.5 * size:.3g}{-0.5 * size:.3g}l{size:.3g} {size:.3g}m0{-size:.3g}l{-size:.3g} {size:.3g}"
    if marker == "|":
        return f"m0{-0.5 * size:.3g}v{size:.3g}"
    points = [(scale * px, scale * py) for px, py in SHAPES[marker]]
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(points)]
    return f"m{points[0][0]:.3g} {points[0][1]:.3g}l{' '.join(f'{dx:.3g} {dy:.3g}' for dx, dy in steps)}z"


@dataclass(frozen=True)
class Pen:
    """Distinction of a line from others: by colour and by a marker or dashes."""

    colour: Colour
    marker: str = ""
    dash: tuple[float, ...] = ()
    hollow: bool = False
    """Whether only outlined markers are drawn, without a line"""

    @property
    def marker_path(self) -> str:
        """Path of the marker about the origin, for a legend; empty without a marker."""
        return marker_path(self.marker, SIDE) if self.marker else ""

    @property
    def dash_css(self) -> str:
        """Dashes as SVG writes them."""
        return " ".join(f"{d:g}" for d in self.dash)


def engine_pen(k: int) -> Pen:
    """Pen of the k-th engine: colour and marker; dashes are reserved for tolerances."""
    return Pen(SERIES[k % len(SERIES)], MARKERS[k % len(MARKERS)])


def hollow(pen: Pen) -> Pen:
    """Pen for outlined markers of `pen` without a line."""
    return replace(pen, hollow=True)


def joint_pen(k: int) -> Pen:
    """Pen of the k-th of four joints."""
    return Pen(SERIES[(2, 3, 4, 5)[k % 4]], "", DASHES[k % len(DASHES)])


def variables(theme: int) -> str:
    """CSS declarations of all colours; `theme` 0 is light, 1 dark."""
    shown = [f"--{c.name}:{(c.light, c.dark)[theme]}" for c in COLOURS.values()]
    shown += [f"--d{k}:{shade[theme]}" for k, shade in enumerate(DIGITS)]
    return ";".join([f"--paper:{PAPER[theme]}", *shown])
