"""Damaged folders end in one line that names a file, whatever the damage, and nothing is written outside."""

from __future__ import annotations

import math
import os
import shutil
from pathlib import Path

import pytest

from barchain.cli.main import run
from barchain.record.environment import provenance
from barchain.record.study_store import StudyStore
from reports.results.reading import TABLES, digest
from reports.results.schema import KEY
from reports.results.selftest import FILES
from tests.support.report_fixture import build
from tests.support.results import change_record, change_rows, read_record, write_record

FAULT = {"fault": "scale-rate", "scene": "s"}
TABLES_OF_SELFTEST: dict[str, dict[str, object]] = {
    "fates": FAULT | {"fate": "killed"},
    "readings": FAULT | {"quantity": "rate", "check": "bound", "ratio": 3.0, "killed": "killed", "reason": "too large"},
}
RECORD, ROWS = "record/comparison.json", "rows/comparison.parquet"
SAMPLES = "series/comparison/differences/basics/radial_equilibrium/reference.parquet"
CONTENTS = {
    "text": b"earlier results", "latin": "é,ü\n1,2\n".encode("latin-1"), "deep": b"[" * 100_000,
    "parquet": b"PAR1" + bytes(60) + b"PAR1",
}  # fmt: skip
PLACES = (RECORD, ROWS, SAMPLES, "rows/selftest.parquet", "record/selftest.json")
ENTRIES = {
    "runs": ({}, [1], "x", [{"scene": 1}], [{"outcome": "great"}]), "finished": ("yes", 1, []),
    "seconds": ("1", [], {}),
    "scenes": ([], "x", {"a": 1}), "engines": ([], 3, {"a": "b"}), "tolerances": ({}, [1]), "limitations": ([1], "x"),
    "misprints": ("x", [None]), "tables": ([], {"a": 1}, {ROWS: ["0"]}), KEY: (None, True, "3", 99, 3.0),
    "environment": ([], {"a": []}), "packages": ([], {"a": 1}),
}  # fmt: skip


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a comparison and a self-test."""
    folder = build(tmp_path_factory.mktemp("sound"), ["basics/radial_equilibrium"], faults=False, samples=11)
    tables = folder.rglob("*.parquet")
    change_record(folder, **{TABLES: {p.relative_to(folder).as_posix(): [digest(p.read_bytes())] for p in tables}})
    fault = {"words": "w", "stands_for": "s", "group": "g", "natural": 1.0, "none": 0.0, "unit": "1", "invisible": ""}
    entries = {"host": "reference", "scenes": {"s": {}}, "faults": {"scale-rate": fault}, "finished": True}
    store = StudyStore(FILES, folder, provenance("barchain selftest") | entries)
    for table, row in TABLES_OF_SELFTEST.items():
        store.write(table, [row])
    store.end(1.0, complete=True)
    return folder


def copied(sound: Path, folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(sound, folder / "results")
    (folder / "outside").write_text("untouched")
    return folder / "results"


def check_one_line_naming(place: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """Message of a report that is rejected."""
    capsys.readouterr()
    assert run(["report", str(folder)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1, error
    assert "Traceback" not in error
    assert Path(place).name in error, error
    assert (folder.parent / "outside").read_text() == "untouched"
    assert not list(folder.parent.rglob("*.part"))
    return error


def test_a_sound_folder_is_rendered(sound: Path, tmp_path: Path) -> None:
    folder = copied(sound, tmp_path)
    assert run(["report", str(folder)]) == 0
    assert (folder / "index.html").is_file()


@pytest.mark.parametrize("content", CONTENTS)
@pytest.mark.parametrize("place", PLACES)
def test_a_file_of_other_contents_is_named(
    place: str, content: str, sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = copied(sound, tmp_path)
    (folder / place).write_bytes(CONTENTS[content])
    check_one_line_naming(place, folder, capsys)


@pytest.mark.parametrize("place", [RECORD, ROWS, SAMPLES])
@pytest.mark.parametrize("kind", ["folder", "pipe"])
def test_a_folder_or_a_pipe_in_place_of_a_file_is_named(
    place: str, kind: str, sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = copied(sound, tmp_path)
    (folder / place).unlink()
    make = os.mkdir if kind == "folder" else os.mkfifo
    make(folder / place)
    check_one_line_naming(place, folder, capsys)


@pytest.mark.parametrize(("key", "value"), [(k, v) for k, values in ENTRIES.items() for v in values])
def test_an_entry_of_a_wrong_type_is_named(
    key: str, value: object, sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = copied(sound, tmp_path)
    change_record(folder, **{key: value})
    check_one_line_naming(ROWS if value == {ROWS: ["0"]} else RECORD, folder, capsys)


def without_digests(folder: Path) -> None:
    """Change the record into one that takes its tables at their word."""
    write_record(folder, {key: value for key, value in read_record(folder).items() if key != TABLES})


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_no_report_says_passed_of_a_value_that_is_no_number(
    number: float, sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = copied(sound, tmp_path)
    without_digests(folder)
    change_rows(folder, lambda rows: rows.assign(value=rows["value"].mask(rows["outcome"] == "pass", number)))
    assert "passed without a number" in check_one_line_naming(ROWS, folder, capsys)


def test_rows_without_a_column_are_named(sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = copied(sound, tmp_path)
    without_digests(folder)
    change_rows(folder, lambda rows: rows.drop(columns="outcome"))
    assert "lacks outcome" in check_one_line_naming(ROWS, folder, capsys)


def test_a_report_does_not_mix_a_record_with_the_rows_of_another_run(
    sound: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = copied(sound, tmp_path)
    change_rows(folder, lambda rows: rows.iloc[:-1])
    assert "of another run" in check_one_line_naming(ROWS, folder, capsys)
