"""Scenes, trajectories and comparisons show themselves in notebooks: pictures and numbers, of no foreign origin."""

from __future__ import annotations

import dataclasses
import html
import json
import subprocess
import sys
from html.parser import HTMLParser

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest

import barchain
from barchain.studies.comparison.run import ComparisonResult
from reports.notebook.scene import osculating
from reports.results.comparison import ALL_SCENES, METRIC_COLUMNS
from reports.results.outcome import Outcome
from scenarios import scene_names
from tests.support.page_policy import LOADING
from tests.support.slow import one_in

LABELS = ["attitude, rad", "magnitude of reactions, N", "change of the CM's radius, m", "centre-of-mass residual, m"]
OPEN = {"p", "br", "path", "circle", "use", "wbr", "rect", "line"}  # elements without an end, or closed at once


class Balanced(HTMLParser):
    """Names of all elements; every one that is opened is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.open: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert not [name for name, _ in attrs if name.startswith("on")]
        self.names.add(tag)
        self.open += [] if tag in OPEN else [tag]

    def handle_endtag(self, tag: str) -> None:
        if tag not in OPEN:
            assert self.open.pop() == tag


def shown(thing: object) -> str:
    """HTML of an object as a notebook asks for it: whole, with a picture, with nothing to load, with fixed colours."""
    found = thing._repr_html_()  # type: ignore[attr-defined]
    assert not Balanced(found).names & LOADING
    assert found.count('<svg style="width:') >= 1
    assert "var(--" not in found
    return str(found)


@pytest.fixture(scope="module")
def trajectory() -> barchain.Trajectory:
    t = np.linspace(0.0, 100.0, 21)
    angle = np.stack([0.1 * t, 0.2 * t], axis=1)
    com = 7e6 * np.stack([np.cos(1e-3 * t), np.sin(1e-3 * t)], axis=1)
    return barchain.Trajectory(
        t, com, np.zeros((21, 2)), angle, reaction_N=np.full((21, 1, 2), [3.0, 4.0]), com_residual_m=np.full(21, 1e-14)
    )


@pytest.mark.parametrize("name", one_in(20, [n for n in scene_names() if not n.startswith("hard/bars_")]))
def test_every_scene_has_a_picture_and_its_physics(name: str) -> None:
    found = shown(barchain.load_scene(name))
    assert name in found
    assert "Gravity" in found


def test_the_drawn_orbit_is_the_scenes_own_and_an_open_path_is_drawn_up_to_some_radii() -> None:
    scene = barchain.load_scene("basics/kepler_elliptic")
    radius = np.linalg.norm(osculating(scene), axis=1)
    major = (scene.central_body.mu_m3_s2 * (scene.period_s / (2.0 * np.pi)) ** 2) ** (1.0 / 3.0)
    assert radius.min() + radius.max() == pytest.approx(2.0 * major)  # Kepler's third law
    assert scene.radius0_m in (pytest.approx(radius.min()), pytest.approx(radius.max()))
    scene = barchain.load_scene("basics/kepler_hyperbolic")
    radius = np.linalg.norm(osculating(scene), axis=1) / scene.radius0_m
    assert radius.min() == pytest.approx(1.0)
    assert 3.0 < radius.max() <= 4.0


def test_a_hostile_title_stays_text_and_hides_nothing() -> None:
    scene = dataclasses.replace(barchain.load_scene("paper/fig05"), title="<script>alert(1)</script>\u202e")
    found = shown(scene)
    assert "<script" not in found
    assert "\u202e" not in found


def test_a_trajectory_shows_each_quantity_with_its_unit_and_why_it_ended(trajectory: barchain.Trajectory) -> None:
    found = html.unescape(shown(dataclasses.replace(trajectory, ended="a bar reached the surface")))
    assert all(label in found for label in LABELS)
    assert "21, from 0 to 100 s" in found
    assert "5.00" in found, "size of the reaction of 3 N and 4 N"
    assert "a bar reached the surface" in found


def test_a_card_is_titled_by_scene_and_engine_where_they_are_known(trajectory: barchain.Trajectory) -> None:
    assert "<strong>Trajectory</strong>" in shown(trajectory)
    found = shown(barchain.simulate("basics/libration", "reference", rtol=1e-6))
    assert "<strong>basics/libration in reference</strong>" in found
    assert "rtol=1e-06" in found


def test_a_plot_has_one_axes_for_each_quantity_and_draws_what_was_simulated(trajectory: barchain.Trajectory) -> None:
    with mpl.rc_context({"backend": "agg"}):
        figure, axes = trajectory.plot()
    assert [ax.get_title(loc="left") for ax in axes] == LABELS
    assert axes[-1].get_xlabel() == "time, s"
    np.testing.assert_array_equal(axes[0].lines[1].get_ydata(), trajectory.angle_rad[:, 1])
    np.testing.assert_allclose(axes[1].lines[0].get_ydata(), 5.0)
    np.testing.assert_allclose(axes[2].lines[0].get_ydata(), 0.0, atol=1e-8)
    mpl.pyplot.close(figure)


def test_a_plot_has_no_axes_for_a_quantity_that_the_engine_lacks(trajectory: barchain.Trajectory) -> None:
    track = barchain.Trajectory(trajectory.t_s, trajectory.com_m, trajectory.com_velocity_m_s)
    with mpl.rc_context({"backend": "agg"}):
        figure, axes = track.plot()
    assert [ax.get_title(loc="left") for ax in axes] == LABELS[2:3]
    mpl.pyplot.close(figure)


def test_a_comparison_shows_its_verdict_and_outcomes_by_scene_and_engine() -> None:
    row = dict.fromkeys(METRIC_COLUMNS, "") | {"scene": "s", "setting": "x=1", "quantity": "attitude", "unit": "rad"}
    rows = [
        row | {"engine": engine, "metric": "normalised_error", "value": value, "tolerance": 1.0, "outcome": outcome}
        for engine, value, outcome in (("reference", 0.1, "pass"), ("exudyn", 7.0, "inconsistent"))
    ]
    outcomes = {("s", "reference"): Outcome.PASS, ("s", "exudyn"): Outcome.INCONSISTENT}
    outcomes |= {("s", "(any independent engine)"): Outcome.PASS, (ALL_SCENES, "rebound"): Outcome.NOTHING_COMPARED}
    comparison = ComparisonResult(pd.DataFrame(rows, columns=list(METRIC_COLUMNS)), outcomes)
    found = shown(comparison)
    assert "1 of 2 comparisons failed." in found
    assert "≠ inconsistent" in found
    table = comparison.to_frame()
    assert table.loc["s", "exudyn"] == "inconsistent"
    assert list(table.index) == ["s"]
    assert "(any independent engine)" not in table.columns


def test_objects_without_barchain_show_their_text_and_say_what_a_plot_needs() -> None:
    code = (
        "import json, numpy as np; from adapters.trajectory import Trajectory; from scenarios import load_scene\n"
        "t = Trajectory(np.zeros(2), np.ones((2, 2)), np.ones((2, 2)))\n"
        "try: t.plot()\n"
        "except RuntimeError as error: said = str(error).split(': ')[1].split(',')[0]\n"
        "print(json.dumps([t._repr_html_(), load_scene('paper/fig05')._repr_html_(), said]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == [None, None, "use a public name of barchain first"]


def test_a_scene_is_text_where_there_is_no_notebook() -> None:
    assert repr(barchain.load_scene("paper/fig05")).startswith("<Scene paper/fig05: 5 bars")
