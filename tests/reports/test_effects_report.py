"""The chapter on effects: its rule, its words and its charts, from tables alone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import pandas as pd
import pytest

from barchain.cli.effects import show_view
from barchain.cli.main import run
from reports.chapters.effects.advice import Relevance, advise, classify
from reports.chapters.effects.labels import Anchor, placed
from reports.chapters.effects.rows import rows_of, scope_of
from reports.chapters.effects.view import view_effects
from reports.chapters.effects.words import NOT_RESOLVED, length_text, share_text
from reports.render import render_study
from reports.tables.effects import COLUMNS, read_effects
from reports.tables.reading import DamagedResultsError
from tests.reports.effects_tables import ROWS, row, write
from tests.support.page_policy import check_policy
from tests.support.report_fixture import build

if TYPE_CHECKING:
    from pathlib import Path

    from reports.chapters.effects.advice import Advice


def advice(folder: Path, rows: list[dict[str, Any]], **changes: Any) -> list[Advice]:
    """Advice on each row."""
    tables = read_effects(write(folder, rows, **changes))
    scope = scope_of(tables.record)
    return [advise(r, scope) for r in rows_of(tables, scope)]


def test_each_effect_is_judged_by_one_rule(tmp_path: Path) -> None:
    assert [a.relevance for a in advice(tmp_path, ROWS)] == [
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
    assert advice(tmp_path, [row("drag", **changes)])[0].relevance is relevance


def test_advice_says_what_it_does_over_what_and_what_to_do(tmp_path: Path) -> None:
    point, slender, j2, moon, drag, light = (a.text for a in advice(tmp_path, ROWS))
    assert j2 == (
        "Oblateness moves the centre of mass by 612 km, rotates bars by 0.11 rad and changes the reactions by 0.13 % "
        "in 5 orbits: switch it on; with it the run takes 2.00 times as long."
    )
    assert "is negligible in 5 orbits (centre of mass 3.0 m, attitude 4.0×10⁻⁷ rad, react" in drag
    assert "leave it off; its cost in time is too small to measure" in drag
    assert "is below the numerical resolution in 5 orbits (centre of mass 70 mm, att" in moon
    assert "it can be switched off; it takes 50 % of the run time" in moon
    assert "keep gradient" in point
    assert "gradient suffices" in slender
    assert light == "Solar_Pressure is not switched: its process <died>."


def test_advice_on_drag_and_light_names_the_width_of_the_bars(tmp_path: Path) -> None:
    same = row("drag", width_least_m=2e-3, width_largest_m=2e-3)
    several = row("solar_pressure", attitude=0.1, width_least_m=0.05, width_largest_m=1.0)
    said = [a.text for a in advice(tmp_path, [same, several])]
    assert said[0].startswith("Drag on bars 2.0 mm wide is negligible")
    assert said[1].startswith(
        "Solar_Pressure on bars 50 mm to 1.0 m wide moves the centre of mass by 1.0 m, rotates bars by 0.10 rad"
    )


def test_nobody_is_advised_to_keep_a_part_of_the_design(tmp_path: Path) -> None:
    thrust, idle = advice(
        tmp_path, [row("thrust", attitude=0.1, kind="design", on=True), row("springs", kind="design", on=True)]
    )
    assert thrust.relevance is Relevance.RELEVANT
    assert "keep" not in thrust.text
    assert "it can be switched off" in idle.text


def test_a_price_is_told_only_where_it_was_measured(tmp_path: Path) -> None:
    once = row("drag", time_ratio=1.4, time_ratio_low=None, time_ratio_high=None)
    twice = row("drag", rounds=2)
    below = row("oblateness", time_ratio=0.99, time_ratio_low=0.9, time_ratio_high=1.1)
    on = row("third_body.moon", on=True)
    dear = row("solar_pressure", on=True, time_ratio=30.0, time_ratio_low=28.0, time_ratio_high=33.0)
    said = [a.text for a in advice(tmp_path, [once, twice, below, on, dear])]
    assert said[0].endswith("leave it off.")
    assert said[1].endswith("leave it off.")
    assert said[2].endswith("leave it off; its cost in time is too small to measure.")
    assert "it takes 50 % of the run time." in said[3]
    assert "with it the run takes 30.0 times as long" in said[4]


def test_a_run_that_takes_longer_than_its_evaluations_says_what_takes_it(tmp_path: Path) -> None:
    dear = row("drag", time_ratio=30.0, time_ratio_low=28.0, time_ratio_high=33.0, evaluations_ratio=1.5)
    found = advice(tmp_path, [dear])[0]
    assert found.row.rest == pytest.approx(10.0)
    assert (
        "with it the run takes 30.0 times as long (factors: 2.0 per evaluation, 1.5 in their number and 10 for "
        "the search for instants at which a bar turns its other face to the wind)."
    ) in found.text
    view = view_effects(tmp_path)
    assert view is not None
    assert view.price.rows[0][1:] == ("30.0 (28.0\N{EN DASH}33.0)", "2.00 (1.90\N{EN DASH}2.10)", "1.50", "10.0")


def test_names_in_a_chart_stand_on_nothing() -> None:
    points = [Anchor(f"effect {k}", 100.0 + 0.3 * k, 60.0 + 4.0 * k, (98.0, 103.0)) for k in range(8)]
    boxes = placed(points, 340.0, 192.0)
    assert all(boxes)
    for box, k in zip(boxes, range(8), strict=True):
        assert box
        others = [b for b in boxes if b and b is not box] + [p.box for p in points]
        assert not any(box.meets(b) for b in others), k
    assert placed([Anchor("a name wider than its plot", 5.0, 5.0, (5.0, 5.0))], 20.0, 20.0) == [None]


def test_the_console_shows_tables_of_at_most_120_columns(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "240")
    view = view_effects(write(tmp_path, ROWS))
    assert view is not None
    show_view(view)
    shown = capsys.readouterr().out
    lines = shown[: shown.index("Relevant:")].splitlines()
    assert max(map(len, map(str.rstrip, lines))) <= 120
    assert "Times with the effect / without it" in shown


def test_what_a_default_can_not_tell_follows_its_advice(tmp_path: Path) -> None:
    plain, limited = (
        a.text for a in advice(tmp_path, [row("drag"), row("drag", caveat="One exponential can't tell all.")])
    )
    assert limited == f"{plain} One exponential can't tell all."


def test_a_budget_without_a_declared_column_is_refused(tmp_path: Path) -> None:
    table = write(tmp_path, ROWS) / "effects" / "effects.csv"
    pd.read_csv(table).drop(columns="caveat").to_csv(table, index=False)
    with pytest.raises(DamagedResultsError, match="lacks caveat"):
        view_effects(tmp_path)


def test_zero_is_never_reported_as_zero(tmp_path: Path) -> None:
    found = advice(tmp_path, [row("drag", 0.0, 0.0, 1e-3), row("third_body.sun", 0.0, 0.0, 0.0)])
    assert found[0].text.count(NOT_RESOLVED) == 2
    assert NOT_RESOLVED in found[1].text
    view = view_effects(tmp_path)
    assert view is not None
    cells = view.consequences.rows[1]
    assert [c for c in cells if "unresolved, <" in c] == list(cells[3:6])
    assert all(" 0 " not in a.text for a in found)


def test_a_comparison_that_chaos_ends_says_so(tmp_path: Path) -> None:
    changes = {"limit_s": 13_800.0}
    found = advice(tmp_path, [row("drag", compared_s=13_800.0)], **changes)[0].text
    assert "in the first 2.76 orbits of 5 orbits" in found
    assert "beyond it numerical errors alone exceed 0.01 rad" in found
    view = view_effects(tmp_path)
    assert view is not None
    assert view.predictability_limit == "2.76 orbits"


def test_a_switched_run_that_lands_says_so(tmp_path: Path) -> None:
    landed = row("drag", compared_s=10_000.0, ended="a bar reached the surface at t = 10000 s")
    assert "With it on, a bar reached the surface at t = 10000 s." in advice(tmp_path, [landed])[0].text


def test_the_page_shows_all_of_it_and_is_rendered_again_alike(tmp_path: Path) -> None:
    page = render_study("effects", write(tmp_path, ROWS)).page
    check_policy(page)
    html = page.read_text()
    assert page == tmp_path / "effects.html"
    assert "Relevant: Oblateness." in html
    assert "Of the gravity models, point differs from gradient; slender agrees with gradient." in html
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
    bare = {name: None for name in COLUMNS if name not in ("effect", "title", "kind", "on", "said", "reason")}
    folder = write(tmp_path, [row("drag") | bare, row("oblateness")], largest_reaction_N=None)
    record = folder / "effects" / "record.json"
    record.write_text(record.read_text().replace('"finished": true', '"finished": false'))
    html = render_study("effects", folder).page.read_text()
    assert "cut off" in html
    assert "not switched" in html


def test_a_folder_without_a_budget_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"effects.csv"):
        render_study("effects", tmp_path)


def test_unknown_scales_make_nothing_matter_that_is_not_there(tmp_path: Path) -> None:
    """A single bar has no reactions; the other two quantities judge it."""
    alone = advice(tmp_path, [row("drag", reaction=None, reaction_noise_N=None)], largest_reaction_N=None)[0]
    assert alone.relevance is Relevance.NEGLIGIBLE
    assert classify(alone.row, 1e-9) is Relevance.RELEVANT


@pytest.mark.parametrize(
    ("metres", "text"), [(612e3, "612 km"), (1.2e3, "1.2 km"), (269.0, "269 m"), (0.0591, "59 mm"), (5.9e-4, "590 µm")]
)
def test_lengths_read_as_people_write_them(metres: float, text: str) -> None:
    assert length_text(metres) == text


def test_shares_are_percent_until_they_are_too_small() -> None:
    assert share_text(0.0013) == "0.13 %"
    assert share_text(3.1e-8) == "3.1×10⁻⁸ of the largest"
    assert share_text(math.inf) == ""
