"""Every stored file of every study, damaged in every way: `report` and `--resume` end in one line that names it."""

from __future__ import annotations

import math
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from barchain.cli.main import run
from reports.results.reading import TABLES
from reports.results.schema import KEY
from tests.storage.small_plans import SMALL
from tests.support.kernel import skip_without_kernel
from tests.support.results import change_record, change_rows, read_record, record_file, write_record
from tests.support.slow import exhaustive_but

if TYPE_CHECKING:
    from collections.abc import Callable

    import pandas as pd

DAMAGES = {
    "empty": lambda _: b"", "truncated": lambda whole: whole[: len(whole) // 2], "text": lambda _: b"earlier results",
    "junk": lambda _: bytes(range(256)) * 8, "list": lambda _: b"[]", "one byte more": lambda whole: whole + b"0",
    "latin": lambda _: "é,ü\n1,2\n".encode("latin-1"), "deep": lambda _: b"[" * 100_000,
    "parquet": lambda _: b"PAR1" + bytes(60) + b"PAR1",
}  # fmt: skip
QUICK = ("comparison", "cost")
"""Results that every test run damages; the others are slow"""


ROWS = "rows/comparison.parquet"
STUDIES = [pytest.param(name, marks=() if name in QUICK else pytest.mark.exhaustive) for name in SMALL]


@pytest.fixture(scope="session")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders by study, made as they are asked for."""
    return {"": tmp_path_factory.mktemp("sound")}


def copied(name: str, sound: dict[str, Path], folder: Path) -> Path:
    """Folder with the results of a small plan."""
    if name == "ensemble":
        skip_without_kernel()
    if name not in sound:
        out = sound[""] / name
        assert run(["-q", *SMALL[name].command.split(), "--out", str(out)]) in {0, 1}
        sound[name] = out
    return Path(shutil.copytree(sound[name], folder / "results"))


def stored(name: str, out: Path) -> list[Path]:
    """Record of a study and its tables."""
    return [record_file(out, name), *(out / table for table in read_record(out, name)[TABLES])]


def check_named(path: Path, command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Check that a command ends with 2 and one line on a file, which stays as it is."""
    before = path.read_bytes()
    check_line_on(path, command, capsys)
    assert path.read_bytes() == before


def check_line_on(path: Path, command: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Check that a command ends with 2 and one line on a file, which may be missing, and give the line."""
    capsys.readouterr()
    code, error = run(command), capsys.readouterr().err
    assert code == 2, (path, error)
    assert error.count("\n") == 1, error
    assert path.name in error
    assert not list(path.parent.rglob("*.part"))
    return error


@pytest.mark.parametrize("damage", exhaustive_but(DAMAGES, ["empty", "deep"]))
@pytest.mark.parametrize("name", STUDIES)
def test_a_report_names_the_damaged_or_missing_file(
    name: str, damage: str, sound: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = copied(name, sound, tmp_path)
    for path in stored(name, out):
        whole = path.read_bytes()
        path.write_bytes(DAMAGES[damage](whole))
        check_named(path, ["report", str(out)], capsys)
        path.unlink()
        if path.suffix == ".parquet":  # without a record there are no results
            check_line_on(path, ["report", str(out)], capsys)
        path.write_bytes(whole)
    assert run(["report", str(out)]) == 0


@pytest.mark.parametrize("damage", exhaustive_but(DAMAGES, ["truncated", "one byte more"]))
@pytest.mark.parametrize("name", STUDIES)
def test_a_command_that_goes_on_names_the_damaged_file(
    name: str, damage: str, sound: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = copied(name, sound, tmp_path)
    path = stored(name, out)[0]  # tables follow from kept answers, and are made anew
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    check_named(path, ["-q", *SMALL[name].command.split(), "--out", str(out), "--resume"], capsys)


@pytest.mark.parametrize("value", [[], "x"])
@pytest.mark.parametrize("name", STUDIES)
def test_an_entry_of_any_type_is_read_or_named(
    name: str, value: object, sound: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = copied(name, sound, tmp_path)
    record = read_record(out, name)
    for key in record:
        write_record(out, record | {key: value}, name)
        capsys.readouterr()
        code, error = run(["report", str(out)]), capsys.readouterr().err
        assert code in {0, 2}, (key, error)
        assert error.count("\n") == (code == 2), (key, error)
        assert code == 0 or str(out) in error, (key, error)


ENTRIES = {
    "runs": ({}, [1], "x", [{"scene": 1}], [{"outcome": "great"}]), "finished": ("yes", 1, []),
    "seconds": ("1", [], {}),
    "scenes": ([], "x", {"a": 1}), "engines": ([], 3, {"a": "b"}), "tolerances": ({}, [1]), "limitations": ([1], "x"),
    "misprints": ("x", [None]), "tables": ([], {"a": 1}, {ROWS: ["0"]}), KEY: (None, True, "3", 99, 3.0),
    "environment": ([], {"a": []}), "packages": ([], {"a": 1}),
}  # fmt: skip
"""Entries of the record of a comparison with wrong types"""


@pytest.fixture
def compared(sound: dict[str, Path], tmp_path: Path) -> Path:
    """Folder with the results of a small comparison."""
    return copied("comparison", sound, tmp_path)


@pytest.mark.parametrize(("key", "value"), [(k, v) for k, values in ENTRIES.items() for v in values])
def test_an_entry_of_a_wrong_type_is_named(
    key: str, value: object, compared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change_record(compared, **{key: value})
    path = compared / ROWS if value == {ROWS: ["0"]} else record_file(compared)
    check_line_on(path, ["report", str(compared)], capsys)


@pytest.mark.parametrize("make", [os.mkdir, os.mkfifo])
def test_a_folder_or_a_pipe_in_place_of_a_file_is_named(
    make: Callable[[Path], None], compared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in (compared / ROWS, record_file(compared)):
        path.unlink()
        make(path)
        check_line_on(path, ["report", str(compared)], capsys)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda rows: rows.assign(value=rows["value"].mask(rows["outcome"] == "pass", math.nan)), "without a number"),
        (lambda rows: rows.assign(value=rows["value"].mask(rows["outcome"] == "pass", math.inf)), "without a number"),
        (lambda rows: rows.drop(columns="outcome"), "lacks outcome"),
    ],
)
def test_no_report_says_passed_of_a_value_that_is_no_number_or_without_a_column(
    change: Callable[[pd.DataFrame], pd.DataFrame], said: str, compared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where a record without digests takes its tables at their word."""
    write_record(compared, {key: value for key, value in read_record(compared).items() if key != TABLES})
    change_rows(compared, change)
    assert said in check_line_on(compared / ROWS, ["report", str(compared)], capsys)


def test_a_report_does_not_mix_a_record_with_the_rows_of_another_run(
    compared: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change_rows(compared, lambda rows: rows.iloc[:-1])
    assert "of another run" in check_line_on(compared / ROWS, ["report", str(compared)], capsys)
