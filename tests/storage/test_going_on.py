"""A command that goes on, joins or replaces loses no earlier result, and says finished after its report."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest

import barchain
from barchain.cli.main import run
from barchain.crossval.run import run_comparison
from barchain.record.claim import ResultsInPlaceError, claim_results
from barchain.record.study_store import StudyStore
from barchain.runs.pool import LocalSession
from reports.tables import crossval, roundoff, stability
from reports.tables.reading import DamagedResultsError
from reports.tables.schema import KEY, SCHEMA_VERSION, SchemaVersionError

if TYPE_CHECKING:
    from collections.abc import Hashable
    from pathlib import Path

    from barchain.runs.call import Call
    from barchain.runs.cases import Case
    from reports.tables.files import StudyFiles

SCENE = "basics/kepler_circular"


def record(**entries: Any) -> dict[str, Any]:
    return {KEY: SCHEMA_VERSION} | entries


def stored(files: StudyFiles, out: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(files.record_path(out).read_text())
    return found


def test_a_comparison_goes_on_with_other_engines_and_makes_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def pairs(names: list[str]) -> set[tuple[str, str]]:
        found = run_comparison([SCENE], names, tmp_path, resume=True)
        return {pair for pair in found.outcomes if crossval.is_engine(pair[1])}

    made: list[str] = []
    start = LocalSession.start

    def noted(session: LocalSession, key: Hashable, call: Call) -> None:
        made.append(call.given[0].engine)
        start(session, key, call)

    monkeypatch.setattr(LocalSession, "start", noted)
    for names, missing in ((["rebound"], {"rebound"}), (["reference", "rebound"], {"reference"}), (["rebound"], set())):
        assert pairs(names) == {(SCENE, name) for name in names}
        assert set(made) == missing
        assert {p.stem for p in (tmp_path / "differences" / SCENE).glob("re*.parquet")} == set(names)
        made.clear()


def part(tmp_path: Path, name: str, table: str, **entries: Any) -> StudyStore:
    store = StudyStore(roundoff.FILES, tmp_path, record(parts={name: {}}, command=name, failed=[], **entries))
    store.write_record()
    store.write(table, ())
    return store


def test_parts_of_a_round_off_study_keep_their_tables_and_provenance(tmp_path: Path) -> None:
    first = part(tmp_path, "times", "times", full=True)
    first.record["failed"] = [{"table": "times", "task": "t", "reason": "r"}]
    first.end(1.0, complete=True)
    part(tmp_path, "engines", "engines", full=False).end(2.0, complete=False)
    found = stored(roundoff.FILES, tmp_path)
    times, engines = found["parts"]["times"], found["parts"]["engines"]
    assert (times["command"], times["full"], times["complete"], len(times["failed"])) == ("times", True, True, 1)
    assert (engines["command"], engines["full"], engines["complete"], engines["failed"]) == (
        "engines",
        False,
        False,
        [],
    )
    assert set(found["tables"]) == {"times.csv", "engines.csv"}


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_part_does_not_join_a_record_of_another_version(overwrite: bool, tmp_path: Path) -> None:
    part(tmp_path, "times", "times").end(1.0, complete=True)
    path = roundoff.FILES.record_path(tmp_path)
    path.write_text(json.dumps(stored(roundoff.FILES, tmp_path) | {KEY: SCHEMA_VERSION - 1}))
    before = path.read_bytes()
    with pytest.raises(SchemaVersionError):
        claim_results(roundoff.FILES, tmp_path, ["engines"], overwrite=overwrite)
    with pytest.raises(SchemaVersionError):
        part(tmp_path, "engines", "engines")
    assert path.read_bytes() == before
    claim_results(roundoff.FILES, tmp_path, roundoff.PARTS, overwrite=True)  # nothing is to be kept
    assert not path.exists()


def test_parts_are_replaced_one_by_one(tmp_path: Path) -> None:
    for name in ("times", "engines"):
        part(tmp_path, name, name).end(1.0, complete=True)
    with pytest.raises(ResultsInPlaceError, match="results of these parts; --resume goes on from there, --overwrite"):
        claim_results(roundoff.FILES, tmp_path, ["times"])
    claim_results(roundoff.FILES, tmp_path, ["evaluation"])
    claim_results(roundoff.FILES, tmp_path, ["times"], overwrite=True)
    assert not (tmp_path / "roundoff" / "times.csv").exists()
    assert (tmp_path / "roundoff" / "engines.csv").exists()


def test_results_of_another_kind_are_neither_read_nor_replaced(tmp_path: Path) -> None:
    StudyStore(stability.FILES, tmp_path, record(runs=[])).write_record()
    inside = tmp_path / "stability"
    for options in ({}, {"resume": True}, {"overwrite": True}):
        with pytest.raises(ResultsInPlaceError, match="belongs to results of another kind, 'stability'"):
            claim_results(crossval.FILES, inside, **options)
    with pytest.raises(DamagedResultsError, match="record of another study, stability"):
        crossval.FILES.read_record(inside)
    assert (inside / "record.json").exists()


def test_from_python_nothing_is_overwritten_unasked(tmp_path: Path) -> None:
    barchain.compare([SCENE], ["rebound"], tmp_path)
    with pytest.raises(ResultsInPlaceError, match="holds a comparison"):
        barchain.compare([SCENE], ["rebound"], tmp_path)
    assert barchain.compare([SCENE], ["rebound"], tmp_path, resume=True).passed
    assert barchain.compare([SCENE], ["reference"], tmp_path, overwrite=True).passed
    assert set(stored(crossval.FILES, tmp_path)["engines"]) == {"reference"}
    assert run(["compare", SCENE, "--engine", "rebound", "--out", str(tmp_path)]) == 2


@pytest.mark.slow
def test_the_record_says_finished_only_after_the_report(tmp_path: Path) -> None:
    def fails(folder: Path) -> Path:
        assert stored(crossval.FILES, folder)["complete"]
        raise OSError(28, "No space left on device", "index.html")

    with pytest.raises(OSError, match="No space left"):
        run_comparison([SCENE], ["rebound"], tmp_path, render=fails)
    found = stored(crossval.FILES, tmp_path)
    assert found["complete"]
    assert not found["finished"]


def test_a_pair_without_a_verdict_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing(*_: object) -> Case[None]:
        yield []

    monkeypatch.setattr("barchain.crossval.suite.Suite.pair", nothing)
    result = run_comparison([SCENE], ["rebound"], tmp_path)
    assert not result.passed
    assert set(result.metrics.reason) == {"no verdict was given: a fault of barchain"}
