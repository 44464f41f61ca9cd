"""Every stored file of every study, damaged in every way: `report` and `--resume` end in one line that names it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from barchain.cli.main import run
from reports.results.reading import TABLES
from tests.storage.small_plans import SMALL
from tests.support.kernel import skip_without_kernel
from tests.support.results import read_record, record_file, write_record
from tests.support.slow import exhaustive_but

DAMAGES = {
    "empty": lambda _: b"", "truncated": lambda whole: whole[: len(whole) // 2], "text": lambda _: b"earlier results",
    "junk": lambda _: bytes(range(256)) * 8, "list": lambda _: b"[]", "one byte more": lambda whole: whole + b"0",
}  # fmt: skip
QUICK = ("comparison", "cost")
"""Results that every test run damages; the others are slow"""


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


def check_line_on(path: Path, command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Check that a command ends with 2 and one line on a file, which may be missing."""
    capsys.readouterr()
    code, error = run(command), capsys.readouterr().err
    assert code == 2, (path, error)
    assert error.count("\n") == 1, error
    assert path.name in error


@pytest.mark.parametrize("damage", exhaustive_but(DAMAGES, list(DAMAGES)[:1]))
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
