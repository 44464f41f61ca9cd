"""`barchain show`: the rows of a result folder, and what differs between two."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd
import pytest

import barchain
from barchain.cli.main import run
from barchain.cli.show import differing, show_differences
from reports.results.rows import IDENTITY, spread
from tests.support.results import rows_file

if TYPE_CHECKING:
    from pathlib import Path

WORDS = "compare basics/two_bars_free --engine reference --engine rebound --workers 1"


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("compared") / "out"
    assert run(["-q", *WORDS.split(), "--out", str(folder)]) == 0
    return folder


def test_a_comparison_ends_with_its_rows(compared: Path) -> None:
    stored, found = pd.read_parquet(rows_file(compared)), barchain.rows(compared)
    pd.testing.assert_frame_equal(stored, found, check_dtype=False)
    assert not found.duplicated(list(IDENTITY)).any()
    verdicts = found[found.metric == "verdict"]
    assert dict(zip(verdicts.engine, verdicts.outcome, strict=True)) == {"reference": "pass", "rebound": "pass"}


def test_only_the_rows_asked_for_are_shown(compared: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    asked, file = ["--where", "engine=reference,quantity=attitude", "--where", "metric=max"], tmp_path / "rows.csv"
    assert run(["show", str(compared), *asked]) == 0
    assert " rad" in capsys.readouterr().out
    assert run(["show", str(compared), *asked, "--csv", str(file)]) == 0
    assert len(pd.read_csv(file)) == 1


@pytest.mark.exhaustive
def test_two_folders_side_by_side_show_what_differs(
    compared: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    other, file = tmp_path / "other", tmp_path / "changes.csv"
    words = WORDS.replace("rebound", "pymunk") + " --set reference:rtol=1e-7"
    assert run(["-q", *words.split(), "--out", str(other)]) == 0
    assert run(["show", str(compared), str(other), "--csv", str(file)]) == 0
    found = pd.read_csv(file)
    assert set(found[found.engine == "rebound"].change) == {"gone"}
    assert set(found[found.engine == "pymunk"].change) == {"new"}
    capsys.readouterr()
    assert run(["show", str(compared), str(compared)]) == 0
    assert capsys.readouterr().out.strip() == "no difference"
    assert run(["show", str(compared), str(other), "--judge"]) == 1
    said = capsys.readouterr().out
    assert "  worse  basics/two_bars_free:reference:rtol=1e-07:attitude.max" in said
    assert "the setting rtol=1e-10 of reference became rtol=1e-07" in said
    assert said.count("is missing: ") == 0
    assert run(["show", str(other), str(compared), "--judge"]) == 0  # the other way round all is better
    assert "  better  basics/two_bars_free:reference:rtol=1e-10:attitude.max" in capsys.readouterr().out
    assert run(["show", str(compared), str(compared), "--judge"]) == 0
    assert run(["show", str(compared), "--judge"]) == 2


@pytest.mark.parametrize(
    ("condition", "said"),
    [("engin=rebound", "did you mean engine"), ("engine=rebond", "did you mean rebound"), ("value=x", "number")],
)
def test_a_wrong_condition_is_one_line_with_what_is_allowed(
    condition: str, said: str, compared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["show", str(compared), "--where", condition]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert condition in line
    assert said in line


def test_a_folder_without_results_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["show", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "no results there; give a folder with results of: comparison, cost" in line


def test_without_a_folder_the_result_folders_here_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for place in ("", ", e.g. mine"):
        assert run(["show"]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert f"give its name{place}" in line
        (tmp_path / "mine" / "rows").mkdir(parents=True, exist_ok=True)


def test_what_differs_is_shown_with_both_sides_and_wall_times_are_counted(
    compared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = spread(barchain.rows(compared))
    after = before.copy()
    after.loc[after.metric == "seconds", "value"] *= 2.0
    one = (after.engine == "rebound") & (after.metric == "max") & (after.quantity == "com")
    after.loc[one, ["value", "outcome"]] = [3.5, "exceeds_bound"]
    after = after[after.engine != "reference"]
    show_differences(differing(before, after), timed=False)
    said = capsys.readouterr().out
    assert "wall times differ, by 2 in the median" in said
    assert said.count("gone: comparison, basics/two_bars_free, reference, rtol=1e-10 (") == 1
    (line,) = [line for line in said.splitlines() if "exceeds_bound" in line]
    assert line.split()[-2:] == ["pass", "exceeds_bound"]
    after = before.copy()
    after.loc[one, "limit"] *= 2.0
    show_differences(differing(before, after), timed=False)
    assert "limit" in capsys.readouterr().out
