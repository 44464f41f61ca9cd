"""The round-off chapter: numbers, charts and tables of whatever was stored."""

import html
import re

import numpy as np
import pytest

from barchain.studies.roundoff.study import OBJECTS
from reports.chapters.roundoff.study import Roundoff, length, spelled
from reports.chapters.roundoff.view import law, view_roundoff
from reports.plotting.errors import name_box, staggered
from reports.render import render_study
from reports.results.roundoff import FILES, TABLES
from tests.reports.roundoff_tables import (
    EARTH_M,
    FEW,
    U,
    fitted,
    tables,
    write,
)
from tests.support.slow import exhaustive_but, slow_but


def study(folder, rows=None, **more):
    return Roundoff(FILES.contents(write(folder, rows, **more)))


def shown(folder, rows=None, **more):
    """Page as text without markup."""
    page = render_study("roundoff", write(folder, rows, **more)).page.read_text()
    return html.unescape(re.sub(r"<svg.*?</svg>|<style.*?</style>|<[^>]*>", " ", page, flags=re.S))


@pytest.mark.slow
def test_the_page_has_all_numbers_and_sentences(tmp_path):
    page = shown(tmp_path)
    view = view_roundoff(tmp_path)
    numbers = [f"{d.median:.1f}" for _, cells in view.digits for d in cells if d and d.median >= 1.0]
    numbers += [r["text"] for r in view.laws]
    numbers += [r["constant"] for r in (*view.laws, *view.best_laws)] + [r["last_digit"] for r in view.laws]
    numbers += [r["medians"] for r in view.longitudes] + [row[-1] for row in view.times]
    assert len(numbers) > 100
    assert not re.search(r"\bnan\b|\binf\b|None", page)
    assert all(n in page for n in numbers)
    assert "generic, 9 bars" in page
    assert "2.3 m" not in page  # what a sentence does not get from these tables it does not say
    assert "<flat> tyre" in page


@pytest.mark.parametrize("names", slow_but([
    ("evaluation",), ("laws",), ("trajectories", "best", "best_laws"), ("growth", "growth_laws", "longitudes"),
    ("engines", "engine_laws", "times"),
], [("laws",)]))  # fmt: skip
def test_missing_tables_cost_only_their_own(tmp_path, names):
    page = shown(tmp_path, without=names)
    assert not re.search(r"\bnan\b", page)
    assert ("Errors of one evaluation in a generic state" in page) == ("laws" not in names)
    assert ("Skipped and failed runs" in page or "skipped and failed" in page) == ("engines" not in names)


def test_a_study_that_was_cut_off_at_once_has_a_page(tmp_path):
    page = shown(tmp_path, without=tuple(TABLES), finished=False, objects=[], unit_roundoff={}, failed=[])
    assert "cut off" in page
    assert not re.search(r"\bnan\b", page)


@pytest.mark.slow
@pytest.mark.parametrize("asked", exhaustive_but([(1e-6,), (1e-2, 1e-8)], [(1e-2, 1e-8)]))
def test_sizes_that_were_not_asked_for_leave_no_blank_rows_and_columns(tmp_path, asked):
    rows = tables()
    rows["evaluation"] = [r for r in rows["evaluation"] if r["ratio"] in asked]
    for row in rows["laws"]:
        row.update(dict.fromkeys(("exponent", "low", "high"), np.nan), points=len(asked), remark="too few sizes")
    folder = write(tmp_path, rows)
    view = view_roundoff(folder)
    assert all(any(cells) for _, cells in view.digits)
    assert all(any(cells[k] for _, cells in view.digits) for k in range(len(view.digit_columns)))
    measured = [name for name, _ in view.digits]
    assert measured == ([] if len(asked) == 1 else ["20 km tether", "100 m truss", "10 cm CubeSat"])
    assert view.laws == view.further_laws == []
    page = render_study("roundoff", folder).page.read_text()
    assert "Fitted error laws" not in page


def digits_of(folder, **changes):
    """Digits of the named objects in a generic state in double precision, relative and absolute; of a changed law."""
    found = study(folder, tables(FEW | {("generic", 5, name, "reaction"): law for name, law in changes.items()}))
    return {name: [found.digits(ratio, formulation=f) for f in ("relative", "absolute")] for name, ratio in found.named}


def test_digits_are_those_of_the_law_and_lost_where_the_error_leaves_none(tmp_path):
    relative, absolute = digits_of(tmp_path / "a")["100 m truss"]
    assert absolute.median == pytest.approx(-np.log10(0.5 * U["float64"] * EARTH_M / 100.0))
    assert relative.median == pytest.approx(-np.log10(3.0 * U["float64"]))
    none_lost = digits_of(tmp_path / "b", absolute=(4.0, 0.0))
    assert not any(d.median < 1.0 for _, d in none_lost.values() if d)
    lost = digits_of(tmp_path / "c", absolute=(1e8, -1.0))
    assert [name for name, (_, d) in lost.items() if d and d.median < 1.0] == ["10 cm CubeSat", "5 mm hinge"]


@pytest.mark.slow
def test_laws_tell_where_the_last_digit_goes(tmp_path):
    view = view_roundoff(write(tmp_path))
    laws = {found["of"]: found for found in view.laws}
    single = laws["generic", "absolute", "float32", "reaction"]
    assert single["last_digit"] == length(0.5 * U["float32"] / 0.1 * EARTH_M)
    horizontal = laws["horizontal", "absolute", "float64", "reaction"]
    assert horizontal["last_digit"] == length(EARTH_M * (0.05 * U["float64"] / 0.1) ** (1 / 3))
    double = laws["generic", "absolute", "float64", "reaction"]
    assert double["last_digit"].endswith("†")
    assert double["constant"].split() == ["0.50", "u/ε"]
    assert [r["last_digit"] for r in view.best_laws] == [f"{length(EARTH_M * 8.0 * U['float64'] / 0.1)}†", ""]


def test_a_slope_that_is_off_is_marked(tmp_path):
    near = fitted(-0.9, 0.06, expected=-1.0) | {"first": None, "last": None, "remark": ""}
    found = study(tmp_path, tables(FEW))
    assert law(found, near | fitted(-0.8, 0.05, expected=-1.0), ())["off"]
    assert not law(found, near, ())["off"], "0.04 beside the interval: no fit tells so little"
    assert not law(found, near | {"expected": None}, ())["off"], "nothing is expected"


def test_longitudes_are_told_apart_by_source(tmp_path):
    view = view_roundoff(write(tmp_path, tables(FEW)))
    formula, of_input = view.differing
    assert formula == (0, 1, 0.05)
    assert of_input[:2] == (1, 1)
    assert all(row["inside"] for row in view.longitudes if "formula" in row["of"])


def test_digits_lie_on_lines_between_measured_sizes(tmp_path):
    found = study(tmp_path, tables(FEW))
    for ratio in (1e-2, 3e-7, 1e-12):
        few, digits, many = found.digits(ratio, formulation="absolute")
        assert digits == pytest.approx(max(0.0, -np.log10(0.5 * U["float64"] / ratio)))
        assert few <= digits <= many
    assert found.digits(1e-13, formulation="absolute") is None
    assert found.digits(1e-6, formulation="nothing") is None


def test_names_on_the_axis_do_not_hide_each_other():
    boxes = [name_box(o["name"], o["ratio"], (6e-13, 2e-2))[1:] for o in OBJECTS]
    rows = staggered(boxes)
    for k, (left, right) in enumerate(boxes):
        for (other_left, other_right), level in zip(boxes[:k], rows[:k], strict=True):
            assert level != rows[k] or right < other_left or other_right < left
    assert staggered([(70.0, 130.0)] * 3) == [0, 1, 2]


def test_numbers_read_well():
    assert [spelled(v) for v in (5.69e-12, 0.569, 350.0, 1891.0, None)] == ["5.7×10⁻¹²", "0.57", "350", "1900", ""]
    assert length(0.104).split() == ["104", "mm"]
