"""Charts as SVG in the colours and the font of the page: scales, lines, marks, areas, ticks and text.

Shapes are written in tenths of a pixel, as whole numbers relative to the point before: two thirds of the bytes of a
path in pixels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup, escape

from reports.plotting.palette import COLOURS, SHAPES, marker_path
from reports.text.numerals import power_of_ten, significant

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from reports.plotting.palette import Colour
    from reports.plotting.series import Array

WIDTH, HEIGHT = 400.0, 250.0  # about a phone's width, so that letters are not shrunk on it
LEFT, RIGHT, TOP, BOTTOM = 50.0, 10.0, 24.0, 34.0
MOST_TICKS = 6
FINE = 10
"""Units of a path in a pixel"""
STRAIGHT = 3.0
"""Tenths of a pixel by which a point may leave the line of its neighbours and yet be left out"""
PASSES = 4
STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
OUTSIDE = 1e5
"""Pixels: points farther away are drawn there, beyond any clip"""


@dataclass(frozen=True)
class Scale:
    """Places of values along an axis, px."""

    low: float
    high: float
    start: float
    """Place of `low`, px"""
    end: float
    log: bool = False

    def __call__(self, values: Any) -> Any:
        """Places of values, px; NaN of what has none."""
        v = np.asarray(values, float)
        if not self.log:
            return self.start + (v - self.low) / (self.high - self.low) * (self.end - self.start)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.log(v / self.low) / math.log(self.high / self.low)
        return self.start + share * (self.end - self.start)

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Round values, each with its words."""
        low, high = sorted((self.low, self.high))
        return decade_ticks(low, high) if self.log else even_ticks(low, high)


def across(low: float, high: float, *, log: bool = False) -> Scale:
    """Horizontal scale of a chart of the usual size."""
    return Scale(low, high, LEFT, WIDTH - RIGHT, log)


def upwards(low: float, high: float, *, log: bool = False) -> Scale:
    """Vertical scale of a chart of the usual size."""
    return Scale(low, high, HEIGHT - BOTTOM, TOP, log)


class Chart:
    """Drawing about two scales; what is drawn first lies below."""

    def __init__(self, x: Scale, y: Scale, size: tuple[float, float] = (WIDTH, HEIGHT)) -> None:
        """Begin without anything drawn; `size` is the drawing's, px, and the scales' ends enclose the plot."""
        self.x, self.y, self.size = x, y, size
        self.axes_in_words = ""
        self.shapes: list[str] = []
        self.texts: list[str] = []

    def axes(self, x_label: str, y_label: str, ticks: Sequence[tuple[float, str]] | None = None) -> None:
        """Draw both axes; `ticks` of the horizontal one are at round values by default."""
        self.ticks_up(self.y.ticks, y_label)
        self.ticks_across(self.x.ticks if ticks is None else ticks, x_label)

    def line(
        self, x: Array, y: Array, colour: Colour, width: float = 1.4, dash: Sequence[float] = (), opacity: float = 1.0
    ) -> None:
        """Draw a curve; NaN breaks it."""
        drawn = path(self.x(x), self.y(y))
        if drawn:
            dashed = f";stroke-dasharray:{' '.join(f'{FINE * d:g}' for d in dash)}" if dash else ""
            self.stroke(drawn, colour, width, f"{dashed}{'' if opacity == 1.0 else f';opacity:{opacity:g}'}")

    def stroke(self, drawn: str, colour: Colour, width: float, more: str = "") -> None:
        """Draw the outline of a path in tenths of a pixel."""
        self.shapes.append(
            f'<path d="{drawn}" style="fill:none;stroke:{colour.css};stroke-width:{FINE * width:g}{more}"/>'
        )

    def fill(self, drawn: str, colour: Colour, opacity: float = 1.0) -> None:
        """Fill a path in tenths of a pixel."""
        faint = "" if opacity == 1.0 else f";opacity:{opacity:g}"
        self.shapes.append(f'<path d="{drawn}" style="fill:{colour.css}{faint}"/>')

    def marks(
        self, x: Any, y: Any, marker: str, colour: Colour, size: float = 5.6, *, hollow: bool = False, edge: float = 0.9
    ) -> None:
        """Draw a marker at each point that has a place."""
        places = np.stack([np.atleast_1d(self.x(x)), np.atleast_1d(self.y(y))], axis=-1)
        places = places[np.isfinite(places).all(axis=1)]
        shape = marker_path(marker, FINE * size)
        drawn = "".join(f"M{px:.0f} {py:.0f}{shape}" for px, py in FINE * np.clip(places, -OUTSIDE, OUTSIDE))
        if drawn and (hollow or marker not in SHAPES):
            self.stroke(drawn, colour, edge)
        elif drawn:
            self.fill(drawn, colour)

    def band(self, x: Array, low: Array, high: Array, colour: Colour, opacity: float) -> None:
        """Fill the area between two curves, which NaN leaves open."""
        edges = np.concatenate([np.stack([x, low], 1), np.stack([x, high], 1)[::-1]])
        edges = edges[np.isfinite(edges).all(axis=1)]
        self.fill(f"{path(self.x(edges[:, 0]), self.y(edges[:, 1]))}z", colour, opacity)

    def area(self, x: tuple[float, float], y: tuple[float, float], colour: Colour) -> None:
        """Fill a rectangle between two places on each axis, px."""
        left, right, high, low = (round(FINE * v) for v in (*sorted(x), *sorted(y)))
        self.fill(f"M{left} {high}H{right}V{low}H{left}z", colour)

    def straight(
        self, start: tuple[float, float], end: tuple[float, float], colour: Colour, width: float = 0.8, dash: str = ""
    ) -> None:
        """Draw a straight line between two places, px."""
        (a, b), (c, d) = ((round(FINE * v) for v in point) for point in (start, end))
        self.stroke(f"M{a} {b}L{c} {d}", colour, width, f";stroke-dasharray:{dash}" if dash else "")

    def across_at(self, value: float, colour: Colour, width: float = 0.8, dash: str = "") -> None:
        """Draw a horizontal line over the whole plot."""
        at = float(self.y(value))
        self.straight((self.x.start, at), (self.x.end, at), colour, width, dash)

    def up_at(self, value: float, colour: Colour, width: float = 0.8, dash: str = "") -> None:
        """Draw a vertical line over the whole plot."""
        at = float(self.x(value))
        self.straight((at, self.y.start), (at, self.y.end), colour, width, dash)

    def text(
        self, at: tuple[float, float], words: str, anchor: str = "start", colour: str = "muted", more: str = ""
    ) -> None:
        """Write at a place, px: the start, middle or end of the base line."""
        placed = "" if anchor == "start" else f' text-anchor="{anchor}"'
        tinted = "" if colour == "muted" else f"fill:{COLOURS[colour].css};"
        styled = f' style="{tinted}{more}"' if tinted or more else ""
        self.texts.append(f'<text x="{at[0]:.4g}" y="{at[1]:.4g}"{placed}{styled}>{escape(words)}</text>')

    def ticks_across(self, ticks: Iterable[tuple[float, str]], label: str) -> None:
        """Draw the horizontal axis with ticks, and its label."""
        low, rule = max(self.y.start, self.y.end), COLOURS["rule"]
        left, right = sorted((self.x.start, self.x.end))
        drawn = f"M{FINE * left:.0f} {FINE * low:.0f}H{FINE * right:.0f}"
        for value, words in ticks:
            at = float(self.x(value))
            if left - 0.5 <= at <= right + 0.5:
                drawn += f"M{FINE * at:.0f} {FINE * low:.0f}v{FINE * 3.5:.0f}"
                self.text((at, low + 14.0), words, "middle")
        self.stroke(drawn, rule, 0.8)
        self.axes_in_words += f"; horizontal axis: {label}"
        self.text((0.5 * (left + right), low + 29.0), label, "middle")

    def ticks_up(self, ticks: Iterable[tuple[float, str]], label: str, above: float = 9.0) -> None:
        """Draw a light grid with the values of the vertical axis, and its unit `above` the plot, px."""
        drawn, left, right = "", self.x.start, self.x.end
        high, low = sorted((self.y.start, self.y.end))
        for value, words in ticks:
            at = float(self.y(value))
            if high - 0.5 <= at <= low + 0.5:
                drawn += f"M{FINE * min(left, right):.0f} {FINE * at:.0f}H{FINE * max(left, right):.0f}"
                self.text((min(left, right) - 4.0, at + 4.0), words, "end")
        self.stroke(drawn, COLOURS["grid"], 0.8)
        self.text((4.0, high - above), label)
        self.axes_in_words += f"; vertical axis: {label}"

    def svg(self, label: str, name: str = "", more: str = "") -> Markup:
        """SVG element.

        Parameters
        ----------
        label : str
            Description of the picture, for screen readers; the axes' labels follow.
        name : str
            Unique in the page; with one, nothing is drawn outside the plot.
        more : str
            Further elements on top.
        """
        width, height = self.size
        clip, inside = "", ""
        if name:
            (left, right), (high, low) = sorted((self.x.start, self.x.end)), sorted((self.y.start, self.y.end))
            box = f"M{FINE * left - 40:.0f} {FINE * high - 40:.0f}H{FINE * right + 40:.0f}V{FINE * low + 40:.0f}"
            clip = f'<clipPath id="{escape(name)}"><path d="{box}H{FINE * left - 40:.0f}z"/></clipPath>'
            inside = f' clip-path="url(#{escape(name)})"'
        label = escape(label + self.axes_in_words)
        return Markup(
            f'<svg role="img" aria-label="{label}" viewBox="0 0 {width:g} {height:g}">{clip}'
            f'<g transform="scale({1 / FINE:g})" stroke-linejoin="round"{inside}>{"".join(self.shapes)}</g>'
            f'<g style="fill:{COLOURS["muted"].css}">{"".join(self.texts)}</g>{more}</svg>'
        )


def path(x: Array, y: Array) -> str:
    """Path through places (px), in tenths of a pixel; NaN breaks it, and points on straight lines are left out."""
    with np.errstate(invalid="ignore"):
        points: Array = np.stack([x, y], axis=-1) * FINE
        good = np.isfinite(points).all(axis=1)
        points = np.rint(np.clip(points, -FINE * OUTSIDE, FINE * OUTSIDE))
    parts = (part[np.isfinite(part).all(axis=1)] for part in np.split(points, np.flatnonzero(~good)))
    return "".join(relative(straightened(part)) for part in parts if len(part))


def straightened(points: Array) -> Array:
    """Points (n, 2) without those that lie on the line of their neighbours."""
    for _ in range(PASSES):
        if len(points) < 5:
            break
        before, at, after = points[:-2:2], points[1:-1:2], points[2::2]
        count = min(len(before), len(at), len(after))
        chord, way = after[:count] - before[:count], at[:count] - before[:count]
        length = np.hypot(*chord.T)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.abs(chord[:, 0] * way[:, 1] - chord[:, 1] * way[:, 0]) / length
            along = (chord * way).sum(axis=1) / length
        spare = (off <= STRAIGHT) & (along >= 0.0) & (along <= length)
        kept = np.ones(len(points), bool)
        kept[1 : 2 * count : 2] = ~spare
        points = points[kept] if spare.any() else points
    return points


def relative(points: Array) -> str:
    """Path through points (n, 2) of whole numbers, in steps."""
    whole = points.astype(int)
    steps = np.diff(whole, axis=0)
    words = "".join(str(v) if v < 0 else f" {v}" for v in steps[steps.any(axis=1)].ravel().tolist()).lstrip()
    return f"M{whole[0, 0]} {whole[0, 1]}{f'l{words}' if words else ''}"


def even_ticks(low: float, high: float, most: int = MOST_TICKS) -> list[tuple[float, str]]:
    """Round values between two ends, at most about `most`, each with its words."""
    width = (high - low) / most
    size = 10.0 ** math.floor(math.log10(width))
    step = next(s * size for s in STEPS if s * size >= width * (1.0 - 1e-9))
    count = range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)
    values = [k * step for k in count]
    largest = max((abs(v) for v in values), default=0.0)
    if largest and not 1e-4 <= largest < 1e5:
        told_apart = 3 if largest < 100.0 * step else 3 + math.floor(math.log10(largest / step))
        return [(v, significant(v, told_apart).replace("-", "−") if v else "0") for v in values]
    digits = next((d for d in range(9) if abs(round(step, d) - step) < 1e-6 * step), 9)
    return [(v, f"{v:.{digits}f}".replace("-", "−")) for v in values]


def decade_ticks(low: float, high: float, most: int = MOST_TICKS) -> list[tuple[float, str]]:
    """Powers of ten between two ends, at most about `most`, the largest among them."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    step = max(1, math.ceil((last - first) / most))
    return [(10.0**k, power_of_ten(k)) for k in range(last, first - 1, -step)]
