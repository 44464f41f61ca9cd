"""Colours: named, one value on white and one on near-black, and stand-ins for Matplotlib.

Matplotlib knows no CSS variables, so a chart is drawn in stand-in colours that are exchanged for
``var(--name)`` afterwards: the same SVG then reads in both themes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

PAPER = ("#fdfdfb", "#15171b")
"""Background of the page, light and dark."""


@dataclass(frozen=True)
class Colour:
    """A colour of the theme."""

    name: str
    light: str
    dark: str
    stand_in: str

    @property
    def css(self) -> str:
        """Reference to it from a style sheet."""
        return f"var(--{self.name})"


def _colours(*triples: tuple[str, str, str]) -> dict[str, Colour]:
    return {n: Colour(n, light, dark, f"#0102{k:02x}") for k, (n, light, dark) in enumerate(triples)}


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
SERIES = [c for n, c in COLOURS.items() if n[0] == "s" and n[1:].isdigit()]
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "p", "h", "<", ">")
# Marker shapes for legends set in HTML, as paths about the origin within a square of side 6.
MARKER_PATHS = {
    "o": "M3 0A3 3 0 1 1-3 0A3 3 0 1 1 3 0Z",
    "s": "M-2.7-2.7H2.7V2.7H-2.7Z",
    "^": "M0-3.4L3.2 2.6H-3.2Z",
    "D": "M0-3.6L3.6 0L0 3.6L-3.6 0Z",
    "v": "M0 3.4L3.2-2.6H-3.2Z",
    "P": "M-1.1-3.3H1.1V-1.1H3.3V1.1H1.1V3.3H-1.1V1.1H-3.3V-1.1H-1.1Z",
    "X": "M-3.3-2L-2-3.3L0-1.3L2-3.3L3.3-2L1.3 0L3.3 2L2 3.3L0 1.3L-2 3.3L-3.3 2L-1.3 0Z",
    "p": "M0-3.4L3.3-1L2 2.8H-2L-3.3-1Z",
    "h": "M0-3.4L3-1.7V1.7L0 3.4L-3 1.7V-1.7Z",
    "<": "M-3.4 0L2.6-3.2V3.2Z",
    ">": "M3.4 0L-2.6-3.2V3.2Z",
}
DASHES: tuple[tuple[float, ...], ...] = ((), (6, 2), (2, 1.6), (7, 2, 1.5, 2))


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
        """Path of the marker for a legend."""
        return MARKER_PATHS.get(self.marker, "")

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
    return ";".join([f"--paper:{PAPER[theme]}", *shown])
