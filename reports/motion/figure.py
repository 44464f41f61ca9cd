"""Figures of Matplotlib: charts of runs below each other, and their files, in the colours of both themes."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from markupsafe import escape

from reports.motion.charts import DrawingError, charts_of, fitting_unit, in_unit
from reports.plotting.palette import COLOURS, DASHES, MARKERS, PAPER, SERIES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType
    from numpy.typing import NDArray

    from reports.motion.charts import Chosen, Run, TimeChart

INCHES = (6.4, 2.2)
"""Width, and height of each chart"""
MOST_CHARTS = 24
"""Of one figure: more are no picture that anybody reads"""
DPI = 150
HUES = SERIES[2:]
"""Colours of bars, joints and runs: all but the neutral ones"""
MOST_LABELS = 8
WIDTH, BELOW = 1.2, 4.5
"""Widths of lines, and of those of the first of several runs: pale, so that runs that agree are seen on it"""
PALE = 0.5
UNIT_WORDS = {"s": "s", "min": "minutes", "h": "hours", "orbits": "orbits"}
"""Units on an axis of time"""


def style() -> dict[RcKeyType, Any]:
    """Settings of Matplotlib for files: paper and ink of the light theme, text as text in SVG."""
    ink, muted, rule, grid = (COLOURS[name].light for name in ("ink", "muted", "rule", "grid"))
    return {
        "figure.facecolor": PAPER[0], "axes.facecolor": PAPER[0], "savefig.facecolor": PAPER[0],
        "text.color": ink, "axes.labelcolor": ink, "axes.edgecolor": rule, "xtick.color": muted, "ytick.color": muted,
        "axes.grid": True, "grid.color": grid, "axes.spines.top": False, "axes.spines.right": False,
        "svg.fonttype": "none", "svg.hashsalt": "barchain", "font.family": "sans-serif",
    }  # fmt: skip


def draw(made: Figure, runs: Sequence[Run], channels: Sequence[str], chosen: Chosen, unit: str) -> NDArray[np.object_]:
    """Draw charts of some runs below each other with one axis of time, and return their axes.

    Parameters
    ----------
    made : Figure
        Empty; its height is set.
    runs : sequence of Run
    channels : sequence of str
        The main quantities if empty.
    chosen : Chosen
        Bars and joints.
    unit : str
        Of :data:`reports.motion.charts.TIME_UNITS`; empty: one that fits.

    Raises
    ------
    DrawingError
        If there is nothing to draw, or too much of it.
    """
    charts, unit = charts_of(runs, channels, chosen), unit or fitting_unit(runs)
    if len(charts) > MOST_CHARTS:
        raise DrawingError(f"{len(charts)} charts asked for, allowed: {MOST_CHARTS} in one picture; choose --channel")
    times = [in_unit(run, unit) for run in runs]
    made.set_layout_engine("constrained")
    made.set_size_inches(INCHES[0], INCHES[1] * len(charts) + 0.4)
    axes: NDArray[np.object_] = made.subplots(len(charts), 1, sharex=True, squeeze=False)[:, 0]
    single = all(chart.values.shape[1] == 1 for own in charts.values() for chart in own.values())
    for ax, (label, own) in zip(axes, charts.items(), strict=True):
        draw_chart(ax, own, times, runs_in_colour=single)
        alone = next(iter(own.values())).names if single and len(runs) > 1 else []
        ax.set_title(", ".join([label, *alone]), loc="left", fontsize="medium")
    axes[-1].set_xlabel(f"time, {UNIT_WORDS[unit]}")
    if len(runs) > 1:
        label_runs(made, runs, in_colour=single)
    return axes


def draw_chart(ax: Axes, own: Mapping[int, TimeChart], times: Sequence[Any], *, runs_in_colour: bool) -> None:
    """Draw one quantity of all runs: a colour for each bar or joint, dashes for each run, and the names of the bars."""
    named: dict[str, Any] = {}
    several = len(times) > 1
    for k, chart in own.items():
        for column, values in enumerate(chart.values.T):
            if chart.values.shape[1] > 1 or not several:
                colour = HUES[column % len(HUES)]
            else:
                colour = HUES[k % len(HUES)] if runs_in_colour else COLOURS["ink"]
            (line,) = ax.plot(times[k], values, color=colour.light, **line_style(k, several=several))
            for name in chart.names[column : column + 1]:
                named.setdefault(name, line)
    if named and len(named) <= MOST_LABELS and not (several and runs_in_colour):
        place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.98), "borderaxespad": 0.0}
        labels = ax.legend(
            list(named.values()), list(named), ncols=len(named), fontsize="small", frameon=False, handlelength=1.2,
            columnspacing=1.0, **place,
        )  # fmt: skip
        for key in filter(None, labels.legend_handles):
            key.set(linestyle="-", marker="", linewidth=1.5, alpha=1.0)


def line_style(k: int, *, several: bool) -> dict[str, Any]:
    """Width, dashes and markers of the k-th run."""
    if not several:
        return {"linewidth": WIDTH}
    if k == 0:
        return {"linewidth": BELOW, "alpha": PALE}
    dash, round_ = DASHES[(k - 1) % len(DASHES)], (k - 1) // len(DASHES)
    marked = {"marker": MARKERS[(round_ - 1) % len(MARKERS)], "markersize": 4.0, "markevery": 0.1} if round_ else {}
    return {"linewidth": WIDTH, "linestyle": (0, dash) if dash else "-"} | marked


def label_runs(made: Figure, runs: Sequence[Run], *, in_colour: bool) -> None:
    """Name the runs above all charts."""
    from matplotlib.lines import Line2D  # noqa: PLC0415  # a report has no need of it

    colours = [HUES[k % len(HUES)] if in_colour else COLOURS["ink"] for k in range(len(runs))]
    keys = [
        Line2D([], [], color=colour.light, **line_style(k, several=True) | {"markevery": None})
        for k, colour in enumerate(colours)
    ]
    across = min(len(runs), 3 if max(len(run.name) for run in runs) < 24 else 1)
    made.legend(
        keys, [run.name for run in runs], loc="outside upper left", ncols=across, fontsize="small", frameon=False,
        handlelength=3.2,
    )  # fmt: skip


def picture(runs: Sequence[Run], channels: Sequence[str], chosen: Chosen, unit: str, form: str) -> bytes:
    """Charts of some runs as a file, ``svg`` or ``png``.

    Raises
    ------
    DrawingError
        If there is nothing to draw, or too much of it.
    """
    from matplotlib import rc_context  # noqa: PLC0415  # a report has no need of it
    from matplotlib.figure import Figure  # noqa: PLC0415

    content = io.BytesIO()
    with rc_context(style()):
        made = Figure()
        axes = draw(made, runs, channels, chosen, unit)
        if len(runs) == 1:
            made.suptitle(runs[0].name, fontsize="medium")
        made.savefig(content, format=form, dpi=DPI, metadata={"Date": None} if form == "svg" else {})
    if form != "svg":
        return content.getvalue()
    quantities = "; ".join(ax.get_title(loc="left") for ax in axes)
    alt = f"{', '.join(run.name for run in runs)}: {quantities}; horizontal axis: {axes[-1].get_xlabel()}"
    return in_both_themes(content.getvalue().decode(), alt).encode()


def in_both_themes(svg: str, alt: str) -> str:
    """SVG of Matplotlib with its description, and with rules that turn its light colours into dark ones.

    Programs that know no such rules show the light theme.
    """
    rules = "".join(rule(colour) for colour in dark_of(svg))
    dark = f"<style>@media (prefers-color-scheme:dark){{{rules}}}</style>"
    head, opened, rest = svg.partition("<svg ")
    tag, closed, body = rest.partition(">")
    return (
        f'{head}{opened}role="img" aria-label="{escape(alt)}" {tag}{closed}\n<title>{escape(alt)}</title>{dark}{body}'
    )


def dark_of(svg: str) -> Iterator[tuple[str, str]]:
    """Light and dark form of each colour that an SVG has."""
    pairs = [PAPER, *((colour.light, colour.dark) for colour in COLOURS.values())]
    return ((light, dark) for light, dark in pairs if light in svg)


def rule(pair: tuple[str, str]) -> str:
    """Rules of CSS that replace a colour in the style attributes of Matplotlib."""
    light, dark = pair
    return "".join(f'[style*="{what}: {light}"]{{{what}:{dark}!important}}' for what in ("fill", "stroke"))
