"""The chapter of the cost study: rendered from tables alone, alone or in the comparison's report."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np
import pytest
from markupsafe import escape

from barchain.cli.studies import show_reach
from reports.chapters.cost import ALONE, share_text, view_cost
from reports.plotting.families import (
    EngineChart,
    EngineCurve,
    by_family,
    families,
    family_pens,
    overview,
)
from reports.render import render_study
from reports.results.cost import KINDS
from reports.text.numerals import decade, ratio_text, span_text
from tests.reports.cost_tables import study, write
from tests.studies.cost_points import engine_points, table

if TYPE_CHECKING:
    from pathlib import Path


def test_the_chapter_says_what_was_left_out_and_tells_kinds_of_engines_apart(tmp_path: Path) -> None:
    folder = write(tmp_path, study())
    html = render_study("cost", folder).page.read_text()
    assert "Scene &lt;s&gt;" in html
    assert "it is &lt;not&gt; installed" in html
    assert "× failed: bad (1)." in html
    assert "not reached" in html
    assert ">40 %</td>" in html
    assert "nan" not in html.lower().replace("nanmin", "")
    for heading in KINDS.values():
        # times for attitude, for reactions; evaluations; times relative to the baseline
        assert html.count(f">{escape(heading)}</th>") == 4
    view = view_cost(folder).scenes[0]
    dashes = {entry.label: bool(entry.pen.dash) for entry in view["overviews"][0].legend}
    assert dashes == {"slow": False, "slow-er": False, "bad": False, "reference-fast": True}


@pytest.mark.parametrize(
    ("share", "low", "high", "shown"),
    [
        (0.4, 0.38, 0.43, "40 %"),
        (0.4, -0.15, 0.97, "not resolved"),
        (0.4, 0.01, 0.97, "not resolved"),
        (0.95, 0.9, 1.05, "not resolved"),
    ],
)
def test_a_share_is_told_where_its_interval_is_narrow(share: float, low: float, high: float, shown: str) -> None:
    assert share_text({"share": share, "share_low": low, "share_high": high})[0] == shown


def test_the_terminal_marks_interpolated_times_and_those_of_a_coarsest_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At an order of 2 and 1 s a step, 1e-4 rad takes 1000 steps: between two runs."""
    points = table(engine_points("coarse", 2.0, 1.0, [20, 1500]), engine_points("fine", 8.0, 1.0, [40, 80]))
    show_reach(write(tmp_path, points, other_processors=2.0))
    head, coarse, fine, *notes = capsys.readouterr().out.splitlines()
    assert "10⁻⁴ rad" in head
    assert re.search(r"coarse +16 min 40 s +steps_per_orbit=1500", coarse)
    assert re.search(r"fine +≤ 40 s +steps_per_orbit=40", fine)
    assert "interpolated" in " ".join(notes)
    assert "The machine was busy: other processes used 2.0 processors" in " ".join(notes)


def chart(*curves: EngineCurve) -> EngineChart:
    """Chart of some curves, with fixed ends."""
    return EngineChart("n", "t", ("x", "y"), curves, ((1e-9, 1.0), (1.0, 1e9)) if curves else (None, None), alone=ALONE)


def test_many_engines_are_drawn_family_by_family() -> None:
    names = [*(f"exudyn-{k}" for k in range(4)), *(f"scipy-{k}" for k in range(4)), "cvode", "mujoco", "rebound"]
    assert set(families(names).values()) == {"exudyn", "scipy", "others"}
    x, no = np.array([1e-3, 1e-6]), np.zeros(2, bool)
    data = chart(*(EngineCurve(e, x, (k + 1) / x, no, no, dashed=e == "cvode") for k, e in enumerate(names)))
    assert [[e.label for e in p.legend] for p in by_family(data)] == [names[:4], names[4:8], ["cvode"], names[9:]]
    assert [e.label for e in overview(data).legend] == ["exudyn", "scipy", "mujoco", "rebound", "cvode"]
    assert overview(chart()) is None
    assert by_family(chart()) == []


def test_more_groups_than_colours_have_different_pens() -> None:
    pens = family_pens([f"{chr(97 + k)}-1" for k in range(11)])
    assert len({(p.colour.name, p.marker) for p in pens.values()}) == 11


def test_times_ratios_and_targets_read_well() -> None:
    assert span_text(3.4e-4) == "340 µs"
    assert ratio_text((12.3, 11.0, 13.4)) == "×12 (11–13)"
    assert ratio_text((1319.0, None, None)) == "×1320"
    assert decade(1e-4) == "10⁻⁴"
