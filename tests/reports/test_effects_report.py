"""The chapter on effects: its rule, its words and its charts, from tables alone."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import pytest

from barchain.cli.main import run
from barchain.cli.studies import show_effects
from reports.chapters.effects import LINE, Relevance, classify, spaced, view_effects
from reports.plotting.svg import TOP
from reports.render import render_study
from reports.results.effects import TABLE
from tests.reports.effects_tables import ROWS, row, write

if TYPE_CHECKING:
    from pathlib import Path


def effects(folder: Path, rows: list[dict[str, Any]], **changes: Any) -> list[dict[str, Any]]:
    """What the chapter says of each row."""
    found: list[dict[str, Any]] = view_effects(write(folder, rows, **changes)).effects
    return found


@pytest.mark.parametrize(
    ("changes", "relevance"),
    [
        ({"com_m": 7.1e3}, Relevance.RELEVANT),
        ({"com_m": 6.9e3}, Relevance.NEGLIGIBLE),
        ({"attitude": 1.01e-3}, Relevance.RELEVANT),
        ({"reaction": 2.02e-3}, Relevance.RELEVANT),
        ({"reaction": 1.98e-3}, Relevance.NEGLIGIBLE),
        ({"attitude": 1e-5, "attitude_noise_rad": 0.02}, Relevance.UNDECIDED),
        ({"attitude": 0.1, "reaction_noise_N": 1.0}, Relevance.RELEVANT),
        ({"com_m": 0.01, "attitude": 1e-9, "reaction": 1e-9}, Relevance.UNRESOLVED),
        ({"reason": "its process died"}, Relevance.NOT_SWITCHED),
    ],
)
def test_the_rule_counts_in_radians_the_largest_reaction_and_the_distance(
    changes: dict[str, Any], relevance: Relevance, tmp_path: Path
) -> None:
    assert effects(tmp_path, [row("drag", **changes)])[0]["relevance"] is relevance


def test_advice_says_what_to_do(tmp_path: Path) -> None:
    assert [e["advice"] for e in effects(tmp_path, ROWS)] == [
        "keep gradient", "gradient suffices", "switch it on", "can be switched off", "leave it off",
        "its process <died>",
    ]  # fmt: skip
    view = view_effects(tmp_path)
    assert view.groups["Relevant"] == ["Oblateness"]
    assert view.groups["Negligible"] == ["Third_Body.Moon", "Drag"]
    oblateness = next(cells for cells in view.tables[0].rows if cells[0] == "Oblateness")
    assert oblateness == ("Oblateness", "off", "relevant: switch it on", "612 km", "0.11 rad", "0.13 %")
    thrust, idle = effects(
        tmp_path, [row("thrust", attitude=0.1, kind="design", on=True), row("springs", kind="design", on=True)]
    )
    assert (thrust["relevance"], thrust["advice"]) == (Relevance.RELEVANT, ""), "nobody is advised to keep a design"
    assert idle["advice"] == "can be switched off"


def test_drag_and_light_are_named_with_the_width_of_the_bars(tmp_path: Path) -> None:
    same = row("drag", width_least_m=2e-3, width_largest_m=2e-3)
    several = row("solar_pressure", attitude=0.1, width_least_m=0.05, width_largest_m=1.0)
    assert [e["widths"] for e in effects(tmp_path, [same, several])] == [["2.0 mm"], ["50 mm", "1.0 m"]]
    assert "on bars 50 mm to 1.0 m wide" in render_study("effects", tmp_path).page.read_text()


def test_what_evaluations_do_not_explain_of_a_runs_time_is_its_remainder(tmp_path: Path) -> None:
    dear = {"time_ratio": 30.0, "time_ratio_low": 28.0, "time_ratio_high": 33.0, "evaluations_ratio": 1.5}
    below = {"time_ratio": 0.99, "time_ratio_low": 0.9, "time_ratio_high": 1.1}
    rows = [row("drag", **dear), row("oblateness", **below), row("thrust", rounds=2)]
    prices = view_effects(write(tmp_path, rows)).tables[1].rows
    assert prices[0][1:] == ("30.0 (28.0\N{EN DASH}33.0)", "2.00 (1.90\N{EN DASH}2.10)", "1.50", "10.0")
    assert prices[1][4] == "", "a ratio that is not resolved has no factors"
    assert prices[2][1] == "2.00", "an interval takes three rounds"


def test_names_in_a_chart_stand_below_each_other() -> None:
    found = spaced([30.0, 31.0, 32.0, 90.0, 180.0, 180.0])
    assert found[0] >= TOP
    assert all(low - high >= LINE for high, low in itertools.pairwise(found))


def test_the_console_shows_tables_of_at_most_120_columns(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "240")
    show_effects(view_effects(write(tmp_path, ROWS)))
    shown = capsys.readouterr().out
    lines = shown[: shown.index("Relevant:")].splitlines()
    assert max(map(len, map(str.rstrip, lines))) <= 120
    assert "Times with the effect / without it" in shown


def test_zero_is_never_reported_as_zero(tmp_path: Path) -> None:
    write(tmp_path, [row("drag", 0.0, 0.0, 1e-3), row("third_body.sun", 0.0, 0.0, 0.0)])
    first, second = view_effects(tmp_path).tables[0].rows
    assert [c.startswith("unresolved, <") for c in first[3:]] == [True, True, False]
    assert all(c.startswith("unresolved, <") for c in second[3:])


def test_a_comparison_that_chaos_or_a_landing_ends_says_so(tmp_path: Path) -> None:
    landed = row("oblateness", compared_s=10_000.0, ended="a bar reached the surface at t = 10000 s")
    parted, _ = effects(tmp_path, [row("drag", compared_s=13_800.0), landed], limit_s=13_800.0)
    assert parted["compared"] == "2.76 orbits"
    view = view_effects(tmp_path)
    assert (view.predictability_limit, view.duration) == ("2.76 orbits", "5 orbits")
    page = render_study("effects", tmp_path).page.read_text()
    assert "compared over the first 2.76 orbits of 5 orbits" in page
    assert "With it on, a bar reached the surface at t = 10000 s." in page


def test_the_page_shows_all_of_it_and_is_rendered_again_alike(tmp_path: Path) -> None:
    rows = [*ROWS, row("tides", caveat="One exponential does not tell all.")]
    page = render_study("effects", write(tmp_path, rows)).page
    html = page.read_text()
    assert "its process &lt;died&gt;" in html
    assert "One exponential does not tell all." in html
    assert "nan" not in html.lower().replace("finance", "")
    assert html.count("<svg role=") == 3
    assert run(["report", str(tmp_path)]) == 0
    assert page.read_text() == html


def test_a_budget_that_was_cut_off_renders_what_it_had(tmp_path: Path) -> None:
    bare = {name: None for name in TABLE.columns if name not in ("effect", "title", "kind", "on", "said", "reason")}
    folder = write(tmp_path, [row("drag") | bare, row("oblateness")], largest_reaction_N=None)
    assert "not switched" in render_study("effects", folder).page.read_text()


def test_unknown_scales_make_nothing_matter_that_is_not_there(tmp_path: Path) -> None:
    """A single bar has no reactions; the other two quantities judge it."""
    (alone,) = effects(tmp_path, [row("drag", reaction=None, reaction_noise_N=None)], largest_reaction_N=None)
    assert alone["relevance"] is Relevance.NEGLIGIBLE
    assert classify(alone["changes"], 1e-9) is Relevance.RELEVANT
