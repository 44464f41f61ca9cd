"""Matplotlib figures as SVG elements with the colours and the font of the page."""

from __future__ import annotations

import io
import re
from typing import Any

import matplotlib as mpl
from markupsafe import Markup, escape
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from reports.plotting.palette import COLOURS

UNITS_PER_INCH = 72  # of the SVG backend: one user unit is then one CSS pixel at natural size
TEXT_SIZE = 11.0
STYLE: dict[str, Any] = {
    "svg.fonttype": "none",
    "font.size": TEXT_SIZE,
    "path.simplify": True,
    "path.simplify_threshold": 0.3,
    "axes.linewidth": 0.8,
    "axes.unicode_minus": True,
    "text.parse_math": False,  # a $ in an engine's name is a dollar
    "xtick.major.size": 3.5,
    "ytick.major.size": 3.5,
    "xtick.major.width": 0.8,
    "ytick.major.width": 0.8,
}


def figure(width: float, height: float) -> Figure:
    """Empty transparent figure of a size in CSS pixels."""
    made = Figure(figsize=(width / UNITS_PER_INCH, height / UNITS_PER_INCH), dpi=UNITS_PER_INCH)
    made.patch.set_visible(False)
    return made


def inline(drawn: Figure, name: str, label: str) -> Markup:
    """SVG element of a figure.

    Parameters
    ----------
    drawn : Figure
    name : str
        Unique in the page: every id inside is derived from it, so that equal tables give equal bytes.
    label : str
        Description of the picture, for screen readers.
    """
    out = io.StringIO()
    style: Any = {**STYLE, "svg.hashsalt": name}
    with mpl.rc_context(style):
        canvas: Any = FigureCanvasSVG(drawn)
        canvas.print_svg(out, metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
    return Markup(themed(bare(out.getvalue()), label))


def bare(svg: str) -> str:
    """Remove prologue, metadata, names of groups and excess digits."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->", "", svg, flags=re.S)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)
    svg = re.sub(r' (?:xmlns(?::\w+)?|version)="[^"]*"', "", svg)
    svg = re.sub(r' d="([^"]*)"', lambda m: f' d="{short_path(m[1])}"', svg)
    svg = re.sub(r'( (?:x|y|width|height)="-?\d+\.\d)\d+"', r'\1"', svg)
    svg = re.sub(r' transform="rotate\(-0 [^"]*"', "", svg).replace("xlink:href=", "href=")
    svg = re.sub(r">\s+<", "><", svg)
    while (shorter := re.sub(r"<g>\s*</g>", "", svg)) != svg:
        svg = shorter
    return svg


def short_path(path: str) -> str:
    """Path data to a tenth of a pixel, without redundant blanks."""
    path = re.sub(r"-?\d+\.\d+", lambda m: f"{float(m[0]):.1f}".removesuffix(".0"), path)
    return re.sub(r"\s*([A-Za-z])\s*", r"\1", path.strip())


def themed(svg: str, label: str) -> str:
    """Replace stand-in colours and Matplotlib's font by those of the page."""
    for colour in COLOURS.values():
        svg = svg.replace(colour.stand_in, colour.css)
    svg = re.sub(r"font(?:-family)?: [^;\"]*'[^;\"]*;? ?", "", svg)
    _, rest = svg.split(">", 1)
    size = re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg)
    width, height = (size[1], size[2]) if size else ("400", "250")
    head = f'<svg role="img" aria-label="{escape(label)}" viewBox="0 0 {float(width):g} {float(height):g}">'
    return head + rest
