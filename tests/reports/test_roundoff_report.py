"""The round-off chapter: verdicts that turn with the numbers, charts and tables of whatever was stored."""

import html
import re

import numpy as np
import pytest

from barchain.studies.roundoff.objects import objects
from reports.chapters.roundoff.axes import box, free, place, staggered, width
from reports.chapters.roundoff.charts import evaluation_panels
from reports.chapters.roundoff.rows import growth_words
from reports.chapters.roundoff.run_charts import run_panels
from reports.chapters.roundoff.series import FittedExponent, Key, RoundoffData, Spread
from reports.chapters.roundoff.verdict import verdict
from reports.chapters.roundoff.view import view_roundoff
from reports.chapters.roundoff.words import length, listed, spelled
from reports.render import render, render_study
from reports.tables.roundoff import COLUMNS, read_roundoff
from tests.reports.roundoff_tables import (
    EARTH_M,
    LAWS,
    U,
    fitted,
    spread,
    tables,
    write,
)
from tests.support.page_policy import check_policy
from tests.support.report_fixture import build
from tests.support.slow import one_in, slow_but


def study(folder, rows=None, **more):
    return RoundoffData(read_roundoff(write(folder, rows, **more)))


def said(folder, rows=None, **more):
    """Headline and paragraphs by their heads, blanks plain."""
    found = verdict(study(folder, rows, **more))
    text = {p.head: " ".join(p.sentences).replace("\N{NO-BREAK SPACE}", " ") for p in found.paragraphs}
    return found.headline.replace("\N{NO-BREAK SPACE}", " "), text


def shown(folder, rows=None, **more):
    """Page as text without markup."""
    page = render_study("roundoff", write(folder, rows, **more)).page.read_text()
    return html.unescape(re.sub(r"<svg.*?</svg>|<style.*?</style>|<[^>]*>", " ", page, flags=re.S))


def changed(key, constant, exponent):
    return LAWS | {key: (constant, exponent)}


@pytest.mark.slow
def test_the_page_has_all_numbers_and_sentences(tmp_path):
    page = shown(tmp_path)
    view = view_roundoff(tmp_path)
    numbers = [d.text for r in view.digits for d in r.cells] + [r.fit.text for r in view.laws]
    numbers += [r.constant for r in (*view.laws, *view.best_laws)] + [r.last_digit for r in view.laws]
    numbers += [r.medians for r in view.longitudes] + [row[-1] for row in view.times]
    assert len(numbers) > 100
    assert not re.search(r"\bnan\b|\binf\b|None", page)
    assert all(n in page for n in numbers)
    assert "generic, 9 bars" in page
    assert "2.3 m" not in page  # what a sentence does not get from these tables it does not say
    sentences = [s for p in view.verdict.paragraphs for s in p.sentences]
    assert all(" ".join(s.split()) in " ".join(page.split()) for s in sentences)
    assert "<flat> tyre" in page


@pytest.mark.slow
def test_equal_tables_give_equal_bytes(tmp_path):
    first, second = (render_study("roundoff", write(tmp_path / name)).page.read_bytes() for name in "ab")
    assert first == second


@pytest.mark.parametrize("names", slow_but([
    ("evaluation",), ("laws",), ("trajectories",), ("best", "best_laws"), ("growth", "growth_laws", "longitudes"),
    ("engines", "engine_laws", "times"),
], [("laws",)]))  # fmt: skip
def test_missing_tables_cost_only_their_own(tmp_path, names):
    page = shown(tmp_path, without=names)
    assert not re.search(r"\bnan\b", page)
    assert "could be impossible" in page or "laws" in names
    assert ("The inertial frame costs" in page) == ("engines" not in names)
    assert "Runs of one orbit." in page or "best" in names


def test_a_study_that_was_cut_off_at_once_has_a_page(tmp_path):
    page = shown(tmp_path, without=tuple(COLUMNS), finished=False, objects=[], unit_roundoff={}, failed=[])
    assert "cut off" in page
    assert not re.search(r"\bnan\b", page)


@pytest.mark.slow
def test_sizes_have_ratios_where_nothing_says_how_long_they_are(tmp_path):
    page = shown(tmp_path, objects=[])
    assert "ε = " in page
    assert not re.search(r"\bnan\b", page)


@pytest.mark.slow
def test_the_chapter_joins_the_report_of_a_comparison(tmp_path):
    folder = build(tmp_path, ["basics/two_bars_free"], samples=21)
    render(folder)
    assert 'id="roundoff"' not in (folder / "index.html").read_text()
    page = render_study("roundoff", write(folder)).page
    check_policy(page)
    assert page == folder / "index.html"
    assert page.read_text().count('id="roundoff"') == 1
    assert not (folder / "roundoff.html").exists()


def test_a_folder_without_a_study_is_rejected(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"roundoff/record\.json"):
        render_study("roundoff", tmp_path)


def test_the_verdict_says_where_the_paper_is_right_and_where_not(tmp_path):
    headline, text = said(tmp_path)
    last_m = 0.5 * U["float32"] / 0.1 * EARTH_M
    assert headline.startswith("In double precision absolute coordinates cost some digits")
    assert f"bars of {length(last_m)}".replace("\N{NO-BREAK SPACE}", " ") in headline
    assert "“could be impossible”" in text["Generic states."]
    assert "0.50 u/ε" in text["Generic states."]
    assert "exponent −1.00 [−1.01 to −0.99], theory −1" in text["Generic states."]
    assert "3.0 u at every size" in text["Generic states."]
    right = text["Losses that confirm the paper."]
    assert "no digit for a 10 cm CubeSat" in right
    assert "0.050 u" not in right  # against the vanishing reaction it is the size that counts
    horizontal_m = EARTH_M * (0.05 * U["float64"] / 0.1) ** (1 / 3)
    assert f"at bars of {length(horizontal_m)}".replace("\N{NO-BREAK SPACE}", " ") in right
    assert "0.60 u/ε in absolute and 5.0 u in relative coordinates, as in any state" in right
    digits = -np.log10(0.5 * U["float64"] * EARTH_M / 100.0)
    assert f"{digits:.1f} for a 100 m truss" in text["Losses that the paper overstates."]
    assert "by extrapolation" in text["Losses that the paper overstates."]
    losses = text["Losses in both sets of coordinates."]
    assert "masses that alternate as 1 : 10⁶ leave 9.5 digits in relative and in absolute coordinates" in losses
    assert "500 bars in a straight line leave 11.5 digits in relative and in absolute coordinates" in losses
    assert "a generic state leaves 15.5 digits in relative and 14.3 in absolute coordinates" in losses
    assert "1.50 (1.40 to 1.60) times as long with 5 bars (reference)" in text["Cost of relative coordinates."]


def test_a_slope_that_is_off_is_said_and_marked(tmp_path):
    rows = tables()
    for row in rows["laws"]:
        if (row["state"], row["formulation"], row["source"]) == ("generic", "absolute", "both") and row["bars"] == 5:
            row.update(fitted(-0.8, 0.05, expected=-1.0))
        if (row["state"], row["formulation"], row["yardstick"]) == ("horizontal", "absolute", "m n² l"):
            row.update(fitted(-1.3, 0.05, expected=-1.0))
    _, text = said(tmp_path / "a", rows)
    assert "exponent −0.80 [−0.85 to −0.75], not the −1 of theory" in text["Generic states."]
    assert "but exponent −1.30 [−1.35 to −1.25], not the −1 of theory" in text["Losses that confirm the paper."]
    assert "not as expected" in shown(tmp_path / "b", rows)
    assert not FittedExponent(-0.9, -0.96, -0.84, -1.0, 5, "").off  # 0.04 beside the interval: no fit tells so little
    assert not FittedExponent(-0.9, -0.96, -0.84, np.nan, 5, "").off  # nothing is expected


def test_no_digits_lost_is_another_verdict(tmp_path):
    headline, text = said(tmp_path, tables(changed(("generic", 5, "absolute", "reaction"), 4.0, 0.0)))
    assert headline == "In double precision absolute coordinates cost no digit of reactions in generic states"
    assert "In single precision the last digit" not in text["Losses that confirm the paper."]
    assert "The last digit would be lost" not in text["Losses that the paper overstates."]


def test_all_digits_lost_is_another_verdict(tmp_path):
    headline, text = said(tmp_path, tables(changed(("generic", 5, "absolute", "reaction"), 1e8, -1.0)))
    assert headline.endswith("absolute coordinates lose the reactions of a 10 cm CubeSat and a 5 mm hinge")
    assert text["Losses that confirm the paper."].startswith("In double precision absolute coordinates leave no digit")
    assert "CubeSat" not in text["Losses that the paper overstates."].partition("Even computed")[0]


def test_losses_that_only_absolute_coordinates_have_are_not_shared(tmp_path):
    _, text = said(tmp_path / "a", tables(changed(("unequal masses", 5, "absolute", "reaction"), 3e8, 0.0)))
    losses = text["Losses in both sets of coordinates."]
    assert "leave 9.5 digits in relative and 7.5 in absolute coordinates" in losses
    _, text = said(tmp_path / "b", tables(changed(("unequal masses", 5, "relative", "reaction"), 4.0, 0.0)))
    assert "masses" not in text["Losses in both sets of coordinates."]


@pytest.mark.parametrize("asked", one_in(2, [(1e-6,), (1e-2, 1e-8)]))
def test_sizes_that_were_not_asked_for_leave_no_blank_rows_and_columns(tmp_path, asked):
    rows = tables()
    rows["evaluation"] = [r for r in rows["evaluation"] if r["ratio"] in asked]
    for law in rows["laws"]:
        law.update(dict.fromkeys(("exponent", "low", "high"), np.nan), points=len(asked), remark="too few sizes")
    folder = write(tmp_path, rows)
    view = view_roundoff(folder)
    assert all(any(row.cells) for row in view.digits)
    assert all(any(row.cells[k] for row in view.digits) for k in range(len(view.digit_columns)))
    measured = [o.name for o in (row.thing for row in view.digits)]
    assert measured == ([] if len(asked) == 1 else ["20 km tether", "100 m truss", "10 cm CubeSat"])
    assert view.laws == view.further_laws == ()
    page = render_study("roundoff", folder).page.read_text()
    assert "Fitted error laws" not in page
    assert "Nothing was measured" not in page


def test_runs_are_judged_by_the_least_error_and_where_it_lies(tmp_path):
    _, text = said(tmp_path / "a")
    orbit = text["Runs of one orbit."]
    assert "is 1.0×10⁻¹² rad for bars of 6.4 km and 1.0×10⁻⁸ rad for bars of 638 mm in absolute coordinates" in orbit
    assert "3.0×10⁻¹⁴ to 4.0×10⁻¹⁴ rad or less in relative ones at each of 2 sizes" in orbit
    assert "falls from 2048 per orbit for bars of 6.4 km to 512" in orbit
    assert "in agreement with the 3/2 of independent roundings" in orbit
    rows = tables()
    for row in rows["growth_laws"]:
        row.update(fitted(1.9, 0.05, expected=1.5))
    rows["best"] = [r | {"steps_per_orbit": 512} for r in rows["best"]]
    _, text = said(tmp_path / "b", rows)
    assert "above the 3/2 of independent roundings" in text["Runs of one orbit."]
    assert "does not fall with the size" in text["Runs of one orbit."]


def test_other_engines_are_judged_by_what_they_lose(tmp_path):
    _, text = said(tmp_path / "a")
    assert "costs a digit or more in 1 of 1 engines that run in both" in text["Other engines."]
    assert "0.10 and 1.0×10⁻⁶ by box" in text["Other engines."]
    assert "with these exponents: box 2.00 in the inertial frame" in text["Other engines."]
    assert "0.70 u/ε² by tree (last digit at bars of 178 mm" in text["Other engines."]
    rows = tables()
    rows["engines"] = [r | (spread(1e-6) if r["engine"] == "box" else {}) for r in rows["engines"]]
    rows["engine_laws"] = [r | fitted(-2.0) for r in rows["engine_laws"]]
    rows["laws"] = [r for r in rows["laws"] if not r["formulation"].startswith("tree")]
    _, text = said(tmp_path / "b", rows)
    assert "costs no digit" in text["Other engines."]
    assert "Beyond the optimum" not in text["Other engines."]
    assert "root" not in text["Other engines."]


def test_longitudes_are_told_apart_by_source(tmp_path):
    view = view_roundoff(write(tmp_path))
    formula, of_input = view.longitudes_sentences
    assert "0 of 1 tests have p below 0.05" in formula
    assert "inside the range of a typical sector" in formula
    assert "1 of 1 in relative coordinates" in of_input


def test_digits_lie_on_lines_between_measured_sizes(tmp_path):
    found = study(tmp_path)
    for ratio in (1e-2, 3e-7, 1e-12):
        assert found.error(Key("absolute"), ratio).median == pytest.approx(0.5 * U["float64"] / ratio)
    assert found.error(Key("absolute"), 1e-13) is None
    assert found.error(Key("nothing"), 1e-6) is None
    assert Spread(0.2, 0.5, np.inf).digits.lost
    assert Spread(0.01, 0.05, np.inf).digits.spread == "0.0 to 2.0"


def test_every_line_of_a_chart_has_a_sign_besides_its_colour(tmp_path):
    found = study(tmp_path)
    charts = [*evaluation_panels(found), *run_panels(found, "float64", ("attitude", "reaction"))]
    charts += [p for s in view_roundoff(tmp_path).sections for p in (*s.panels, *s.folded)]
    assert len(charts) > 10
    for chart in charts:
        signs = [(e.pen.marker, e.pen.dash, e.pen.hollow) for e in chart.legend]
        assert len(set(signs)) == len(signs), chart.title


def test_names_on_the_axis_hide_neither_each_other_nor_their_lines():
    ends = 6e-13, 2e-2
    names = [(place(float(o["ratio"]), ends), width(str(o["name"]))) for o in objects()]
    rows = staggered(names)
    for k, (at, wide) in enumerate(names):
        others = [(names[j][0], box(*names[j]), rows[j]) for j in range(len(names)) if j != k]
        assert free(rows[k], at, box(at, wide), others)


def test_names_of_things_of_one_size_stand_above_each_other():
    assert staggered([(100.0, 60.0)] * 3) == [0, 1, 2]
    assert staggered([]) == []


def test_numbers_read_well():
    assert [spelled(v) for v in (5.69e-12, 0.569, 5.69, 350.0, 1.47e7, 1891.0)] == [
        "5.7×10⁻¹²", "0.57", "5.7", "350", "1.5×10⁷", "1900",
    ]  # fmt: skip
    assert spelled(None) == ""
    assert length(0.104).split() == ["104", "mm"]
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"


@pytest.mark.parametrize(
    ("exponent", "expected", "words"),
    [(1.55, 1.5, ""), (1.8, 1.5, "slower than their drift"), (2.4, 1.5, "faster than a random walk"),
     (1.2, 1.5, "slower than a random walk"), (0.2, 0.0, "steady noise")],
)  # fmt: skip
def test_growth_that_is_not_as_expected_is_placed(exponent, expected, words):
    found = growth_words(FittedExponent(exponent, exponent - 0.02, exponent + 0.02, expected, 9, ""))
    assert words in found
    assert bool(found) == bool(words)


def test_least_errors_have_a_last_digit_too(tmp_path):
    rows = view_roundoff(write(tmp_path)).best_laws
    metres = EARTH_M * 8.0 * U["float64"] / 0.1
    assert [r.last_digit for r in rows] == [f"{length(metres)}†", ""]
