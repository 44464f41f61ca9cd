"""The report opens with pictures, its matrix folds and leads to the runs, and its chains move without a script."""

from __future__ import annotations

import dataclasses
import math
import re
from typing import TYPE_CHECKING

import numpy as np
import pytest

from reports import render as reports
from reports.chapters.comparison.overview import FEW_COLUMNS, agreement_panel, digits, engine_groups, shade
from reports.chapters.comparison.report import METRIC_HEADS
from reports.chapters.comparison.summary import RunCell, Summary, show_first_orbit, summarise
from reports.plotting.chain import MOST_BYTES, MOST_FRAMES, frame_count, moving_chain
from reports.plotting.svg import Chart, Scale
from reports.results.comparison import read_results
from reports.results.outcome import Outcome
from reports.text.words import engine_anchor, run_anchor
from tests.support.browser import chromium, in_browser
from tests.support.report_fixture import ENGINES, build

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from playwright.sync_api import Page as Tab

SCENES = ["paper/fig13", "basics/two_bars_free"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = build(tmp_path_factory.mktemp("results"), SCENES, samples=61)
    reports.render(made)
    return made


@pytest.fixture(scope="module")
def page(folder: Path) -> str:
    return (folder / "index.html").read_text()


@pytest.fixture(scope="module")
def summary(folder: Path) -> Summary:
    return summarise(read_results(folder))


def test_the_report_opens_with_the_verdict_and_the_judge(page: str) -> None:
    top = page[: page.index('<div class="scroll matrix runs"')]
    assert 'id="verdict">2 of 16 comparisons failed.' in top
    assert "Judged by: reference, rtol=1e-13." in top


def test_a_cell_is_shaded_by_its_digits_and_one_that_failed_is_not(summary: Summary) -> None:
    scene = next(s for s in summary.scenes if s.name == SCENES[0])
    for cell in summary.of_scene(scene.name):
        found, row = digits(cell, scene), next(iter(cell.shown), None)
        if row is None or not cell.outcome.ok:
            assert found is None
        else:
            size = scene.value("radius0_m") if row.quantity == "com" else 1.0
            assert found == pytest.approx(max(0.0, math.log10((size or math.nan) / (row.largest or math.nan))))
    cell = next(c for c in summary.of_scene(scene.name) if c.outcome.ok and c.row("attitude"))
    for error, expected in ((0.0, 16.0), (3.0, 0.0), (1e-9, 9.0)):
        rows = tuple(dataclasses.replace(r, largest=error, first_orbit=error) for r in cell.rows)
        assert digits(dataclasses.replace(cell, rows=rows), scene) == pytest.approx(expected)
    assert [shade(d) for d in (0.0, 1.9, 2.0, 11.9, 12.0, 16.0)] == [0, 0, 1, 5, 6, 6]


def test_every_cell_leads_to_its_run_and_every_column_to_its_engine(page: str, summary: Summary) -> None:
    anchors = [run_anchor(cell.scene, cell.engine) for cell in summary.all]
    for place in [*anchors, *map(engine_anchor, ENGINES)]:
        assert page.count(f'href="#{place}"') == page.count(f'id="{place}"') == 1


def test_columns_stand_by_kind(summary: Summary) -> None:
    kinds = engine_groups(summary)
    assert [g.key for g in kinds] == ["independent", "own"]
    assert all(summary.external(e) for e in kinds[0].engines)
    assert not any(summary.external(e) for e in kinds[1].engines)
    [group] = engine_groups(dataclasses.replace(summary, outside=frozenset(), outside_known=False))
    assert group.engines == summary.engines


@pytest.mark.parametrize(("outcome", "unfolded"), [(Outcome.PASS, False), (Outcome.INCONSISTENT, True)])
def test_of_many_engines_those_on_barchains_equations_are_folded_unless_one_of_them_failed(
    summary: Summary, outcome: Outcome, unfolded: bool
) -> None:
    scene = summary.scenes[0].name
    more = tuple(f"own-{k}" for k in range(FEW_COLUMNS))
    cells = {(scene, e): RunCell(scene, e, "", outcome, "", (), None) for e in more}
    many = dataclasses.replace(summary, engines=(*summary.engines, *more), cells=summary.cells | cells)
    assert [g.unfolded for g in engine_groups(many)] == [True, unfolded]


def test_the_overview_has_one_line_for_each_engine_and_one_mark_for_each_normalised_error(summary: Summary) -> None:
    drawn = str(agreement_panel(summary, engine_groups(summary)).svg)
    assert [drawn.count(f">{engine}</text>") for engine in ENGINES] == [1] * len(ENGINES)
    errors = [c for c in summary.all if c.worst_ratio]
    marks = re.findall(r'<path d="((?:M\d+ \d+m-[^M]+)+)"', drawn)
    assert sum(path.count("M") for path in marks) == len(errors)


@pytest.mark.parametrize(("early", "shown"), [(3, False), (5, True)])
def test_a_scene_shows_its_first_orbit_if_most_comparisons_end_early(summary: Summary, early: int, shown: bool) -> None:
    scene = next(s for s in summary.scenes if s.name == SCENES[0])
    compared = [c for c in summary.of_scene(scene.name) if c.shown][:8]
    cells = {}
    for k, cell in enumerate(compared):
        limit_s = (1.5 if k < early else 2.0) * scene.period_s
        rows = tuple(dataclasses.replace(r, limit_s=limit_s, first_orbit=1e-9) for r in cell.rows)
        given = dataclasses.replace(cell, rows=rows, duration_s=2.0 * scene.period_s, shows_first_orbit=False)
        cells[scene.name, cell.engine] = given
    assert 3 < len(cells) < 10
    show_first_orbit(cells, scene)
    assert all(c.shows_first_orbit is shown for c in cells.values())


def moving(angle_rad: np.ndarray) -> str:
    bars = angle_rad.shape[1]
    chart = Chart(Scale(0.0, 100.0, 0.0, 100.0), Scale(0.0, 100.0, 100.0, 0.0))
    return moving_chain("some", chart, np.full((len(angle_rad), 2), 50.0), angle_rad, np.full(bars, 10.0))


def test_a_chain_moves_through_the_angles_of_its_bars_each_relative_to_the_bar_before() -> None:
    angle = np.linspace([0.0, 0.5], [1.0, -0.5], 5)
    made = moving(angle)
    turns = re.findall(r"rotate\((-?[\d.]+)deg\)}", made)
    first, second = (np.array([float(t) for t in turns[k : k + 5]]) for k in (0, 5))
    np.testing.assert_allclose(first, -np.degrees(angle[:, 0]), atol=0.05)
    np.testing.assert_allclose(first + second, -np.degrees(angle[:, 1]), atol=0.1)


def test_faster_bars_have_more_frames_and_bars_too_fast_or_too_many_to_be_seen_have_none() -> None:
    frames = [frame_count(np.linspace([0.0], [2.0 * np.pi * turns], 2001)) for turns in (0.1, 3.0, 20.0, 1000.0)]
    assert frames[0] < frames[1] <= frames[2] == MOST_FRAMES
    assert frames[3] == 0
    few, many_bars = (moving(np.zeros((33, bars))) for bars in (5, 200))
    assert 0 < len(few) <= MOST_BYTES
    assert not many_bars


def test_each_moving_picture_has_a_control(page: str) -> None:
    assert page.count('class="play" type="checkbox"') == page.count('<g class="moving">') == len(SCENES)


MOVING = """() => [...document.querySelectorAll('.scene .moving')].map(
    g => [getComputedStyle(g).visibility, getComputedStyle(g.firstElementChild).animationPlayState])"""


@pytest.fixture
def tab(folder: Path) -> Iterator[Tab]:
    """The page in a browser of somebody who accepts motion; the page's policy is in force."""
    with chromium() as browser:
        made = browser.new_context(reduced_motion="no-preference", viewport={"width": 1200, "height": 800}).new_page()
        made.goto((folder / "index.html").as_uri())
        yield made


@pytest.mark.slow
@in_browser
def test_nothing_moves_until_the_control_is_operated_from_the_keyboard(tab: Tab) -> None:
    assert tab.evaluate(MOVING) == [["hidden", "paused"]] * len(SCENES)
    tab.locator(".play").nth(1).focus()
    tab.keyboard.press("Space")
    assert tab.evaluate(MOVING).count(["visible", "running"]) == 1
    place = "() => getComputedStyle(document.querySelectorAll('.moving > g')[1]).transform"
    before = tab.evaluate(place)
    tab.wait_for_function(f"before => ({place})() !== before", arg=before, timeout=5000)
    tab.keyboard.press("Space")
    assert tab.evaluate(MOVING) == [["hidden", "paused"]] * len(SCENES)


@pytest.mark.exhaustive
@in_browser
def test_columns_of_a_kind_fold_and_unfold_by_a_checkbox(tab: Tab) -> None:
    own = tab.locator(".runs td.own")
    assert own.first.is_visible()
    tab.locator("#show-own").uncheck()
    assert not own.first.is_visible()
    assert tab.locator(".runs td.independent").first.is_visible()
    tab.locator("#show-own").check()
    assert own.first.is_visible()


@pytest.mark.slow
@in_browser
def test_a_cells_link_unfolds_the_run_below_the_heads_with_its_outcome(tab: Tab) -> None:
    place = run_anchor(SCENES[0], "exudyn")
    run, scroller = tab.locator(f"[id='{place}']"), tab.locator(f".metrics:has([id='{place}'])")
    assert not run.is_visible()
    tab.locator(f".runs a[href='#{place}']").click()
    shown = (scroller.locator("thead th").first, run.locator("tr").first, run.locator(".tag").first)
    head, first, outcome = (found.bounding_box() for found in shown)
    assert 0.0 <= head["y"] <= head["y"] + head["height"] <= first["y"] + 1.0
    assert first["y"] + first["height"] <= 800
    assert outcome["x"] + outcome["width"] < 600


@pytest.mark.slow
@in_browser
@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
def test_the_first_screen_shows_the_matrix(tab: Tab, width: int, height: int) -> None:
    tab.set_viewport_size({"width": width, "height": height})
    rows = tab.eval_on_selector_all(".runs tbody tr", "rows => rows.map(r => r.getBoundingClientRect())")
    assert rows[0]["top"] < 0.45 * height
    least = min(row["height"] for row in rows)
    assert rows[0]["top"] + 15 * least < height, "the core suite's fifteen scenes have room"


@pytest.mark.slow
@in_browser
def test_a_phone_shows_every_cell_without_scrolling_sideways(tab: Tab) -> None:
    tab.set_viewport_size({"width": 390, "height": 800})
    edges = tab.eval_on_selector_all(".runs tbody td", "cells => cells.map(c => c.getBoundingClientRect().right)")
    assert len(edges) == len(SCENES) * len(ENGINES)
    assert max(edges) <= 390


@pytest.mark.slow
@in_browser
def test_a_phone_shows_every_number_of_a_run_with_its_name(tab: Tab) -> None:
    tab.set_viewport_size({"width": 390, "height": 800})
    tab.evaluate("for (const d of document.querySelectorAll('details')) d.open = true")
    cells = "cells => cells.filter(c => c.textContent.trim()).map(c => [c.getBoundingClientRect().right, "
    cells += "getComputedStyle(c, '::before').content])"
    found = tab.eval_on_selector_all(".metrics td + td", cells)
    assert found
    assert max(right for right, _ in found) <= 390
    assert {name.strip('"').rstrip(": ") for _, name in found} <= set(METRIC_HEADS)
