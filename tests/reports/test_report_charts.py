"""Charts and numbers of the report: nothing is drawn that is not there, and everything can be told apart."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

import numpy as np
import pytest

from reports.chapters.comparison.charts import Reactions, nearest, spread
from reports.plotting.chain import SIZE, DrawnMotion, Geometry, joints, orbit_panels
from reports.plotting.palette import COLOURS, DIGITS, PAPER, SERIES, engine_pen
from reports.plotting.panels import ChartFrame, Line, log_panel
from reports.plotting.series import decade_range, thin
from reports.plotting.svg import FINE, Chart, Scale, even_ticks, path
from reports.text.numerals import as_given, powers_in, prefixed, significant, typeset, unpadded
from tests.support.slow import one_in

if TYPE_CHECKING:
    from reports.plotting.panels import Panel

LEAST_CONTRAST = 3.0  # WCAG 2 for graphical objects
LEAST_TEXT_CONTRAST = 4.5


def test_thinning_keeps_every_spike() -> None:
    x = np.arange(20000.0)
    y = np.ones_like(x)
    y[[777, 13131]] = 5.0, -3.0
    tx, ty = thin(x, y)
    assert len(tx) <= 340
    assert ty.max() == 5.0
    assert ty.min() == -3.0
    assert (np.diff(tx) > 0).all()


def test_a_path_leaves_out_points_on_straight_lines_and_no_corner() -> None:
    x = np.linspace(0.0, 100.0, 201)
    y = np.where(x == 50.0, 40.0, 0.0)
    steps = np.array([float(v) for v in re.findall(r"-?\d+", path(x, y))]).reshape(-1, 2)
    assert len(steps) < 0.2 * len(x)
    assert np.cumsum(steps, axis=0)[:, 1].max() == 40.0 * FINE


def test_nan_breaks_a_line_and_is_never_drawn_as_zero_and_infinity_is_drawn_outside() -> None:
    x = np.linspace(0.0, 1.0, 5000)
    y = np.where((x > 0.4) & (x < 0.6), np.nan, 1.0)
    _, thinned = thin(x, y)
    assert np.isnan(thinned).any()
    assert np.nanmin(thinned) == 1.0
    assert path(np.arange(5.0), np.array([1.0, 1.0, np.nan, 1.0, 1.0])).count("M") == 2
    assert decade_range([np.array([np.nan, 0.0, -1.0])]) is None
    line = Line(x, np.full_like(x, np.nan), engine_pen(0))
    assert log_panel(ChartFrame("t", "x", "y", (0.0, 1.0), [line])) is None
    chart = Chart(Scale(1.0, 10.0, 0.0, 100.0, log=True), Scale(1.0, 10.0, 100.0, 0.0, log=True))
    assert np.isnan(chart.y(-1.0))
    assert chart.y(1e30) < -1000.0


@pytest.mark.parametrize("ends", [(0.0, 5.0), (-1.2e-7, 3.4e-7), (0.98, 1.02), (2e8, 9e8)])
def test_ticks_are_round_lie_inside_and_have_different_words(ends: tuple[float, float]) -> None:
    ticks = even_ticks(*ends)
    assert 3 <= len(ticks) <= 8
    assert all(ends[0] - 1e-9 * abs(ends[0]) <= v <= ends[1] * (1 + 1e-9) for v, _ in ticks)
    assert len({words for _, words in ticks}) == len(ticks)


def test_a_log_panel_says_what_it_leaves_out() -> None:
    y = np.array([0.0, 1e-3, 0.0, 1e-2, 1e-30, 1.0])
    panel = log_panel(ChartFrame("t", "x", "y", (0.0, 5.0), [Line(np.arange(6.0), y, engine_pen(0))]))
    assert "exactly zero, left out: 1." in panel.note
    assert "on the lower edge: 1." in panel.note


def test_the_chain_is_rebuilt_with_joints_in_line_about_its_centre_of_mass() -> None:
    length, mass = np.array([10.0, 20.0, 5.0]), np.array([1.0, 7.0, 2.0])
    ends = joints(Geometry(length, mass, 0.0, 1.0, True), np.array([[0.3, 1.1, -2.0]]))[0]
    np.testing.assert_allclose(np.linalg.norm(np.diff(ends, axis=0), axis=1), length)
    centres = 0.5 * (ends[1:] + ends[:-1])
    np.testing.assert_allclose(mass @ centres, 0.0, atol=1e-12 * length.sum() * mass.sum())


def drawing(angle_rad: float, end_s: float, masses_kg: list[float], radius_m: float = 6.4e6) -> Panel:
    """First drawing of a chain of a fixed angle to the vertical on a circular orbit of 7000 km and 6000 s."""
    t = np.linspace(0.0, end_s, 301)
    turned = 2.0 * np.pi * t / 6000.0
    com = 7e6 * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    bars = len(masses_kg)
    geometry = Geometry(np.full(bars, 1000.0), np.array(masses_kg), radius_m, 6000.0, True)
    return orbit_panels("n", geometry, DrawnMotion(t, com, np.repeat(turned[:, None] + angle_rad, bars, axis=1)))[0]


def drawn_points_px(panel: Panel) -> np.ndarray:
    """Points (k, 2) of all straight lines of a drawing."""
    found = []
    for start, steps in re.findall(r"M(-?\d+ -?\d+)l([-\d ]+)", re.sub(r"<g class=.moving.*", "", str(panel.svg))):
        moves = [float(v) for v in [*start.split(), *re.findall(r"-?\d+", steps)]]
        found.append(np.cumsum(np.reshape(moves, (-1, 2)), axis=0) / FINE)
    return np.concatenate(found)


@pytest.mark.parametrize("angle_rad", one_in(4, [0.0, 0.4, 1.6, 3.1]))
@pytest.mark.parametrize("end_s", [6000.0, 2500.0, 200.0])
@pytest.mark.parametrize("masses_kg", [[500.0, *[1.0] * 18, 50.0], [1.0, 1000.0], [5.0] * 4])
def test_no_chain_is_cut_off_at_the_edge(angle_rad: float, end_s: float, masses_kg: list[float]) -> None:
    points = drawn_points_px(drawing(angle_rad, end_s, masses_kg))
    assert len(points) > 9 * len(masses_kg)
    assert points.min() >= 0.0
    assert points.max() <= SIZE


def test_a_short_part_of_an_orbit_shows_the_chain_about_its_centre_of_mass_at_times_in_seconds() -> None:
    short, long = (drawing(0.0, end_s, [500.0, 50.0]) for end_s in (300.0, 2500.0))
    assert ">300 s</text>" in str(short.svg)
    assert ">0.42 orbits</text>" in str(long.svg)
    x, y = drawn_points_px(short).T
    assert np.ptp(x[:3]) < 0.2, "a radial chain is upright at every instant"
    assert np.ptp(y) > 0.5 * SIZE


def test_marks_reach_a_peak_and_stop_at_the_horizon() -> None:
    t = np.linspace(0.0, 100.0, 1001)
    y = np.exp(-((t - 50.0) ** 2))
    instants = spread(t, y, 0.5)
    assert (np.diff(instants) > 0).all()
    assert np.interp(instants, t, y).max() > 0.5
    run = Reactions(t, {}, limit_s=50.5)
    assert t[nearest(run, instants)].max() <= 50.5
    assert not len(nearest(Reactions(t, {}, limit_s=-1.0), instants))


def luminance(colour: str) -> float:
    """Relative luminance of WCAG 2."""
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: float, other: float) -> float:
    """Contrast of two luminances by WCAG 2."""
    low, high = sorted((one, other))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("theme", [0, 1])
def test_lines_and_text_stand_out_from_what_they_are_drawn_on(theme: int) -> None:
    paper = luminance(PAPER[theme])
    for colour in SERIES:
        assert contrast(paper, luminance((colour.light, colour.dark)[theme])) >= LEAST_CONTRAST, colour.name
    ink = luminance((COLOURS["ink"].light, COLOURS["ink"].dark)[theme])
    shades = [luminance(shade[theme]) for shade in DIGITS]
    assert all(contrast(ink, shade) >= LEAST_TEXT_CONTRAST for shade in shades)
    assert shades == sorted(shades, reverse=theme == 0), "each shade is deeper than the one before"


def test_engines_are_told_apart_without_colour() -> None:
    assert len({engine_pen(k).marker for k in range(9)}) == 9


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (None, ""),
        (math.nan, "NaN"),
        (0.0, "0"),
        (5.4e-07, "5.40×10⁻⁷"),
        (0.0112, "0.0112"),
        (999.6, "1.00×10³"),
        (math.inf, "inf"),
    ],
)
def test_numbers_have_three_significant_digits(value: float | None, shown: str) -> None:
    assert significant(value) == shown


def test_numbers_are_typeset() -> None:
    assert typeset(-5.4e-7, 2) == "−5.4×10⁻⁷"
    assert powers_in("by 1.7e-08 <rad>, with rtol=1e-08") == "by 1.7×10⁻⁸ <rad>, with rtol=10⁻⁸"
    assert unpadded("rtol=1e-08, 2.5e+03, v1e-02") == "rtol=1e-8, 2.5e3, v1e-02"
    assert as_given(10000.0) == "10000"
    assert prefixed(0.036, "N") == (1000.0, "mN")
