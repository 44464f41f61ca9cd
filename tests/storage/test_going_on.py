"""A command that goes on, joins or replaces loses no earlier result, and says finished after its report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from barchain.record.claim import ResultsInPlaceError, claim_results
from barchain.record.study_store import StudyStore
from barchain.runs.pool import LocalSession
from barchain.studies.comparison.run import run_comparison
from reports.results import comparison, cost, roundoff, stability
from reports.results.reading import DamagedResultsError
from reports.results.schema import KEY, SCHEMA_VERSION, SchemaVersionError
from tests.support.results import (
    FILES,
    change_record,
    read_record,
    read_table,
    record_file,
    series_folder,
    write_record,
    write_results,
)

if TYPE_CHECKING:
    from collections.abc import Hashable
    from pathlib import Path

    from barchain.runs.call import Call
    from barchain.runs.cases import Case

SCENE = "basics/kepler_circular"


def record(**entries: Any) -> dict[str, Any]:
    return {KEY: SCHEMA_VERSION} | entries


@pytest.mark.slow
def test_a_comparison_goes_on_with_other_engines_and_makes_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def pairs(names: list[str]) -> set[tuple[str, str]]:
        found = run_comparison([SCENE], names, tmp_path, resume=True)
        return {pair for pair in found.outcomes if comparison.is_engine(pair[1])}

    made: list[str] = []
    start = LocalSession.start

    def noted(session: LocalSession, key: Hashable, call: Call) -> None:
        made.append(call.given[0].engine)
        start(session, key, call)

    monkeypatch.setattr(LocalSession, "start", noted)
    for names, missing in ((["rebound"], {"rebound"}), (["reference", "rebound"], {"reference"}), (["rebound"], set())):
        assert pairs(names) == {(SCENE, name) for name in names}
        assert set(made) == missing
        assert {p.stem for p in (series_folder(tmp_path) / "differences" / SCENE).glob("re*.parquet")} == set(names)
        made.clear()


ROWS = {
    "times": {"code": "reference", "arithmetic": "float64", "bars": 2.0, "ratio": 1.0},
    "engines": {"engine": "reference", "frame": "inertial", "ratio": 0.1, "quantity": "com", "median": 1e-9},
}
"""Row of each part's table of the same name"""


def part(tmp_path: Path, name: str, **entries: Any) -> StudyStore:
    store = StudyStore(roundoff.FILES, tmp_path, record(parts={name: {}}, command=name, failed=[], **entries))
    store.write_record()
    store.write(name, [ROWS[name]])
    return store


def test_parts_of_a_round_off_study_keep_their_tables_and_provenance(tmp_path: Path) -> None:
    first = part(tmp_path, "times", full=True)
    first.record["failed"] = [{"table": "times", "task": "t", "reason": "r"}]
    first.end(1.0, complete=True)
    part(tmp_path, "engines", full=False).end(2.0, complete=False)
    found = read_record(tmp_path, "roundoff")
    times, engines = found["parts"]["times"], found["parts"]["engines"]
    assert (times["command"], times["full"], times["complete"], len(times["failed"])) == ("times", True, True, 1)
    assert (engines["command"], engines["full"], engines["complete"]) == ("engines", False, False)
    assert engines["failed"] == []
    assert len(read_table(tmp_path, "roundoff", "times")) == len(read_table(tmp_path, "roundoff", "engines")) == 1


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_part_does_not_join_a_record_of_another_version(overwrite: bool, tmp_path: Path) -> None:
    part(tmp_path, "times").end(1.0, complete=True)
    path = record_file(tmp_path, "roundoff")
    change_record(tmp_path, "roundoff", **{KEY: SCHEMA_VERSION - 1})
    before = path.read_bytes()
    with pytest.raises(SchemaVersionError):
        claim_results(roundoff.FILES, tmp_path, ["engines"], overwrite=overwrite)
    with pytest.raises(SchemaVersionError):
        part(tmp_path, "engines")
    assert path.read_bytes() == before
    claim_results(roundoff.FILES, tmp_path, roundoff.PARTS, overwrite=True)  # nothing is to be kept
    assert not path.exists()


def test_parts_are_replaced_one_by_one(tmp_path: Path) -> None:
    for name in ("times", "engines"):
        part(tmp_path, name).end(1.0, complete=True)
    with pytest.raises(
        ResultsInPlaceError, match="results of these parts of roundoff; --resume goes on from there, --overwrite"
    ):
        claim_results(roundoff.FILES, tmp_path, ["times"])
    claim_results(roundoff.FILES, tmp_path, ["evaluation"])
    claim_results(roundoff.FILES, tmp_path, ["times"], overwrite=True)
    part(tmp_path, "times").end(1.0, complete=True)
    assert len(read_table(tmp_path, "roundoff", "times")) == len(read_table(tmp_path, "roundoff", "engines")) == 1


def test_results_of_other_studies_are_neither_read_nor_replaced(tmp_path: Path) -> None:
    for name in ("cost", "stability"):
        write_results(tmp_path, FILES[name], {}, {})
    claim_results(cost.FILES, tmp_path, overwrite=True)
    assert not cost.FILES.has_record(tmp_path)
    assert stability.FILES.rows(tmp_path).empty
    write_record(tmp_path, {"study": "stability"}, "cost")
    with pytest.raises(DamagedResultsError, match="record of another study, stability"):
        cost.FILES.read_record(tmp_path)


@pytest.mark.slow
def test_the_record_says_finished_only_after_the_report(tmp_path: Path) -> None:
    def fails(folder: Path) -> Path:
        assert read_record(folder)["complete"]
        raise OSError(28, "No space left on device", "index.html")

    with pytest.raises(OSError, match="No space left"):
        run_comparison([SCENE], ["rebound"], tmp_path, render=fails)
    found = read_record(tmp_path)
    assert found["complete"]
    assert not found["finished"]


def test_a_pair_without_a_verdict_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(*_: object) -> Case[None]:
        yield []

    monkeypatch.setattr("barchain.studies.comparison.suite.Suite.pair", nothing)
    result = run_comparison([SCENE], ["rebound"], tmp_path)
    assert not result.passed
    assert set(result.metrics.reason) == {"no verdict was given: a fault of barchain"}
