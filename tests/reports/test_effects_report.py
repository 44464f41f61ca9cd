"""The chapter on effects: its rule, its words and its charts, from tables alone."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import pytest

from barchain.cli.main import run
from barchain.cli.studies import show_effects
from reports.chapters.effects import LINE, Relevance, classify, length_text, share_text, spaced, view_effects
from reports.plotting.svg import TOP
from reports.render import render_study
from reports.results.effects import TABLE
from tests.reports.effects_tables import ROWS, row, write
from tests.support.page_policy import check_policy
from tests.support.report_fixture import build
from tests.support.results import change_record

if TYPE_CHECKING:
    from pathlib import Path


def effects(folder: Path, rows: list[dict[str, Any]], **changes: Any) -> list[dict[str, Any]]:
    """What the chapter says of each row."""
    found: list[dict[str, Any]] = view_effects(write(folder, rows, **changes)).effects
    return found


def test_each_effect_is_judged_by_one_rule(tmp_path: Path) -> None:
    assert [e["relevance"] for e in effects(tmp_path, ROWS)] == [
        Relevance.RELEVANT, Relevance.NEGLIGIBLE, Relevance.RELEVANT, Relevance.UNRESOLVED, Relevance.NEGLIGIBLE,
        Relevance.NOT_SWITCHED,
    ]  # fmt: skip


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
    ],
)
def test_the_rule_counts_in_radians_the_largest_reaction_and_the_distance(
    changes: dict[str, float], relevance: Relevance, tmp_path: Path
) -> None:
    assert effects(tmp_path, [row("drag", **changes)])[0]["relevance"] is relevance


def test_advice_says_what_to_do(tmp_path: Path) -> None:
    assert [e["advice"] for e in effects(tmp_path, ROWS)] == [
        "keep gradient", "gradient suffices", "switch it on", "can be switched off", "leave it off",
        "its process <died>",
    ]  # fmt: skip
    view = view_effects(tmp_path)
    assert view.groups == {
        "Relevant": ["Oblateness"],
        "Negligible": ["Third_Body.Moon", "Drag"],
        "No conclusion": ["Solar_Pressure"],
        "Gravity models that differ from gradient": ["point"],
        "Gravity models that agree with gradient": ["slender"],
    }
    oblateness = next(cells for cells in view.tables[0].rows if cells[0] == "Oblateness")
    assert oblateness == ("Oblateness", "off", "relevant: switch it on", "612 km", "0.11 rad", "0.13 %")


def test_drag_and_light_are_named_with_the_width_of_the_bars(tmp_path: Path) -> None:
    same = row("drag", width_least_m=2e-3, width_largest_m=2e-3)
    several = row("solar_pressure", attitude=0.1, width_least_m=0.05, width_largest_m=1.0)
    assert [e["widths"] for e in effects(tmp_path, [same, several])] == [["2.0 mm"], ["50 mm", "1.0 m"]]
    assert "on bars 50 mm to 1.0 m wide" in render_study("effects", tmp_path).page.read_text()


def test_nobody_is_advised_to_keep_a_part_of_the_design(tmp_path: Path) -> None:
    thrust, idle = effects(
        tmp_path, [row("thrust", attitude=0.1, kind="design", on=True), row("springs", kind="design", on=True)]
    )
    assert (thrust["relevance"], thrust["advice"]) == (Relevance.RELEVANT, "")
    assert idle["advice"] == "can be switched off"


def test_an_interval_takes_three_rounds(tmp_path: Path) -> None:
    effects(tmp_path, [row("drag", rounds=2), row("oblateness", rounds=3)])
    assert [cells[1] for cells in view_effects(tmp_path).tables[1].rows] == ["2.00", "2.00 (1.90\N{EN DASH}2.10)"]


def test_what_evaluations_do_not_explain_of_a_runs_time_is_its_remainder(tmp_path: Path) -> None:
    dear = {"time_ratio": 30.0, "time_ratio_low": 28.0, "time_ratio_high": 33.0, "evaluations_ratio": 1.5}
    below = {"time_ratio": 0.99, "time_ratio_low": 0.9, "time_ratio_high": 1.1}
    prices = view_effects(write(tmp_path, [row("drag", **dear), row("oblateness", **below)])).tables[1].rows
    assert prices[0][1:] == ("30.0 (28.0\N{EN DASH}33.0)", "2.00 (1.90\N{EN DASH}2.10)", "1.50", "10.0")
    assert prices[1][4] == "", "a ratio that is not resolved has no factors"


def test_names_in_a_chart_stand_below_each_other() -> None:
    heights = [30.0, 31.0, 32.0, 90.0, 180.0, 180.0]
    found = spaced(heights)
    assert found[0] >= TOP
    assert all(low - high >= LINE for high, low in itertools.pairwise(found))
    assert found[3:5] == [90.0, 169.0]


def test_the_console_shows_tables_of_at_most_120_columns(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "240")
    show_effects(view_effects(write(tmp_path, ROWS)))
    shown = capsys.readouterr().out
    lines = shown[: shown.index("Relevant:")].splitlines()
    assert max(map(len, map(str.rstrip, lines))) <= 120
    assert "Times with the effect / without it" in shown


def test_what_a_default_can_not_tell_is_on_the_page(tmp_path: Path) -> None:
    write(tmp_path, [row("drag"), row("third_body.sun", caveat="One exponential does not tell all.")])
    (remark,) = view_effects(tmp_path).remarks
    assert remark == "Third_Body.Sun. One exponential does not tell all."
    assert remark in render_study("effects", tmp_path).page.read_text()


def test_zero_is_never_reported_as_zero(tmp_path: Path) -> None:
    write(tmp_path, [row("drag", 0.0, 0.0, 1e-3), row("third_body.sun", 0.0, 0.0, 0.0)])
    first, second = view_effects(tmp_path).tables[0].rows
    assert [c.startswith("unresolved, <") for c in first[3:]] == [True, True, False]
    assert all(c.startswith("unresolved, <") for c in second[3:])


def test_a_comparison_that_chaos_ends_says_so(tmp_path: Path) -> None:
    (found,) = effects(tmp_path, [row("drag", compared_s=13_800.0)], limit_s=13_800.0)
    assert found["compared"] == "2.76 orbits"
    view = view_effects(tmp_path)
    assert (view.predictability_limit, view.duration) == ("2.76 orbits", "5 orbits")
    page = render_study("effects", tmp_path).page.read_text()
    assert "compared over the first 2.76 orbits of 5 orbits. That is the predictability limit." in page


def test_a_switched_run_that_lands_says_so(tmp_path: Path) -> None:
    landed = row("drag", compared_s=10_000.0, ended="a bar reached the surface at t = 10000 s")
    page = render_study("effects", write(tmp_path, [landed])).page.read_text()
    assert "With it on, a bar reached the surface at t = 10000 s." in page


def test_the_page_shows_all_of_it_and_is_rendered_again_alike(tmp_path: Path) -> None:
    page = render_study("effects", write(tmp_path, ROWS)).page
    check_policy(page)
    html = page.read_text()
    assert page == tmp_path / "effects.html"
    assert "its process &lt;died&gt;" in html
    assert "nan" not in html.lower().replace("finance", "")
    assert html.count("<svg role=") == 3
    assert "Outlined, with an arrow" in html
    assert html.count('<ul class="keys">') == 1
    assert html.count("<table>") == 3
    assert run(["report", str(tmp_path)]) == 0
    assert page.read_text() == html


@pytest.mark.slow
def test_a_comparisons_report_gets_the_chapter(tmp_path: Path) -> None:
    build(tmp_path, ["paper/fig05"], samples=11)
    page = render_study("effects", write(tmp_path, ROWS)).page
    assert page == tmp_path / "index.html"
    assert '<h2 id="effects">' in page.read_text()


def test_a_budget_that_was_cut_off_renders_what_it_had(tmp_path: Path) -> None:
    bare = {name: None for name in TABLE.columns if name not in ("effect", "title", "kind", "on", "said", "reason")}
    folder = write(tmp_path, [row("drag") | bare, row("oblateness")], largest_reaction_N=None)
    change_record(folder, "effects", finished=False, complete=False)
    html = render_study("effects", folder).page.read_text()
    assert "cut off" in html
    assert "not switched" in html


def test_a_folder_without_a_budget_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="no results of effects"):
        render_study("effects", tmp_path)


def test_unknown_scales_make_nothing_matter_that_is_not_there(tmp_path: Path) -> None:
    """A single bar has no reactions; the other two quantities judge it."""
    (alone,) = effects(tmp_path, [row("drag", reaction=None, reaction_noise_N=None)], largest_reaction_N=None)
    assert alone["relevance"] is Relevance.NEGLIGIBLE
    assert classify(alone["changes"], 1e-9) is Relevance.RELEVANT


@pytest.mark.parametrize(
    ("metres", "text"), [(612e3, "612 km"), (1.2e3, "1.2 km"), (269.0, "269 m"), (0.0591, "59 mm"), (5.9e-4, "590 µm")]
)
def test_lengths_read_as_people_write_them(metres: float, text: str) -> None:
    assert length_text(metres) == text


def test_shares_are_percent_until_they_are_too_small() -> None:
    assert share_text(0.0013) == "0.13 %"
    assert share_text(3.1e-8) == "3.1×10⁻⁸"
