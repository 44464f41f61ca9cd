"""Runs that a busy machine had no time for: no change, unless they stay away."""

from __future__ import annotations

import shutil
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest

from barchain.cli.main import run
from barchain.nightly.figures.changes import PATIENCE, Direction
from barchain.nightly.figures.figure import Figure, FigureKind, NightPart
from barchain.nightly.figures.results import figures_of
from barchain.nightly.figures.suspects import suspects_of
from reports.results.cost import BUSY, FILES, FOLLOWED
from reports.results.reading import TABLES
from reports.results.rows import NOT_RUN, NotRun
from tests.nightly.history.histories import history_of, judged_last, news_of
from tests.nightly.history.synthetic import NAMES, PARTS, count, identity, verdict
from tests.support.results import write_results

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import pandas as pd

NO_TIME = f"{NOT_RUN}: past the time limit, 2 s: about 2.1 s expected"


def left_out() -> Figure:
    return verdict("", reason=NO_TIME)


def test_a_run_without_time_is_no_change_and_neither_is_its_return() -> None:
    nights = history_of(*[[verdict()], [left_out()], [verdict()], [left_out()], [left_out()], [verdict()]])
    assert news_of(nights) == []


@pytest.mark.parametrize("gap", [1, PATIENCE - 1])
def test_an_engine_that_was_exchanged_while_its_run_had_no_time_is_the_suspect(gap: int) -> None:
    nights = history_of([verdict()], [verdict()], *[[left_out()]] * gap, [verdict("inconsistent")])
    newer = (NightPart("engine:mujoco", "4.0.0", "zz"), *PARTS[1:])
    nights = [night if k < 2 else replace(night, parts=newer) for k, night in enumerate(nights)]
    judged = judged_last(nights)
    (change,) = judged.tonight
    assert change.last == nights[1].name
    assert [s.words for s in suspects_of(change, judged.by_name)] == ["engine:mujoco 3.3.0 → 4.0.0"]


def test_a_run_that_stays_without_time_is_told_once() -> None:
    nights = history_of([verdict()], *[[left_out()] for _ in range(PATIENCE + 3)])
    (change,) = news_of(nights)
    assert (change.direction, change.since) == (Direction.WORSE, nights[PATIENCE].name)
    assert NO_TIME in change.reason


def test_counts_of_a_run_without_time_have_not_vanished() -> None:
    outcome, steps = identity("cost.outcome", FigureKind.VERDICT), count(quantity="cost.steps")
    there, away = Figure(outcome, word="pass", depends=NAMES), Figure(outcome, reason=NO_TIME, depends=NAMES)
    nights = history_of([there, steps], [there, steps], [away])
    assert judged_last(nights).tonight == ()
    gone = history_of([there, steps], [there, steps], [there])
    assert len(judged_last(gone).tonight) == 1


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cost") / "out"
    words = "cost basics/two_bars_free --engine reference-fast --engine pymunk --orbits 0.02 --repeats 1"
    assert run(["-q", *words.split(), "--out", str(folder)]) == 0
    return folder


@pytest.fixture
def study(measured: Path, tmp_path: Path) -> Path:
    return shutil.copytree(measured, tmp_path / "out")


def change(
    folder: Path, points: Callable[[pd.DataFrame], pd.DataFrame] = lambda points: points, **entries: Any
) -> None:
    """Change the points and the record of a study, as if they had been measured so."""
    found = FILES.contents(folder)
    tables = {name: found.tables[name] for name in FILES.tables}
    record = {name: value for name, value in found.record.items() if name != TABLES}
    write_results(folder, FILES, tables | {"points": points(tables["points"])}, record | entries)


def named(folder: Path) -> dict[str, Figure]:
    return {figure.identity.name: figure for figure in cost_figures(folder)}


def cost_figures(folder: Path) -> tuple[Figure, ...]:
    return figures_of(FILES.rows(folder), FOLLOWED)


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("others", "judged"),
    [(BUSY + 0.1, False), (BUSY, True), (0.0, True), (None, True)],
)
def test_ratios_of_a_busy_machine_are_missing_with_the_reason(others: float | None, judged: bool, study: Path) -> None:
    assert FILES.sound_record(study)["other_processors"] >= 0.0
    change(study, other_processors=others)
    ratios = [figure for figure in cost_figures(study) if figure.identity.kind is FigureKind.RATIO]
    assert ratios
    assert all(figure.missing is not judged for figure in ratios)
    assert judged or all(f"{others:.1f} processors" in figure.reason for figure in ratios)


@pytest.mark.slow
def test_a_point_without_time_has_no_verdict_and_its_engine_no_word_on_finer_errors(study: Path) -> None:
    def without_time(points: pd.DataFrame) -> pd.DataFrame:
        last = points.index[(points["engine"] == "pymunk") & (points["outcome"] == "pass")][-1]
        points.loc[last, ["outcome", "reason"]] = [NotRun.LIMIT, "past the time limit, 2 s: about 2.1 s expected"]
        return points

    before = named(study)
    change(study, without_time)
    after = named(study)
    missing = {name for name, figure in after.items() if figure.not_run and not before[name].not_run}
    assert any(name.endswith("cost.outcome") for name in missing)
    assert all(":pymunk:" in name and name.endswith(("cost.outcome", "cost.reach")) for name in missing)
