"""Results of another schema version are rejected with one readable line, by every reader of a record."""

import shutil
from pathlib import Path

import pytest

from barchain.cli.main import run
from barchain.record.environment import provenance
from barchain.record.study_store import StudyStore
from reports.render import render_all
from reports.results.comparison import FILES, read_results
from reports.results.files import StudyFiles
from reports.results.schema import KEY, SCHEMA_VERSION, SchemaVersionError, read_record
from reports.results.studies import STUDIES
from tests.support.report_fixture import build
from tests.support.results import read_record as record_of
from tests.support.results import record_file, write_record


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("results"), ["basics/radial_equilibrium"], faults=False, samples=11)


def with_version(results: Path, folder: Path, version: object) -> Path:
    """Copy of a result folder whose record says another schema version; of None it has none."""
    shutil.copytree(results, folder, dirs_exist_ok=True)
    write_record(folder, record_of(folder) | {KEY: version})
    return folder


def test_every_record_begins_with_the_schema_version(results: Path) -> None:
    assert next(iter(provenance("barchain cost").items())) == (KEY, SCHEMA_VERSION)
    assert read_results(results).record[KEY] == SCHEMA_VERSION


@pytest.mark.parametrize("version", [None, SCHEMA_VERSION + 1, str(SCHEMA_VERSION), True])
def test_a_report_of_another_version_is_one_readable_line(
    version: object, results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = with_version(results, tmp_path, version)
    assert run(["report", str(folder)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert str(record_file(folder)) in error
    assert ("no schema version" if version is None else f"schema version {version!r}") in error
    assert f"reads version {SCHEMA_VERSION}" in error


@pytest.mark.parametrize(("command", "inside"), [("report", ""), ("show", "cost")])
def test_a_folder_of_an_earlier_form_is_told_as_such(
    command: str, inside: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Up to 0.6.0 a record stood beside CSV tables: a comparison's in the folder, a study's in a folder of its name."""
    earlier = tmp_path / inside / "record.json"
    earlier.parent.mkdir(exist_ok=True)
    earlier.write_text('{"schema_version": 2, "barchain": "0.6.0"}')
    assert run([command, str(tmp_path)]) == 2
    assert f"{tmp_path}: results of barchain 0.6 or earlier" in capsys.readouterr().err


def test_a_comparison_does_not_resume_from_another_version(results: Path, tmp_path: Path) -> None:
    with pytest.raises(SchemaVersionError, match="no schema version"):
        StudyStore(FILES, with_version(results, tmp_path, None), {}, resume=True)


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.study)
def test_every_study_rejects_another_version(study: StudyFiles, tmp_path: Path) -> None:
    write_record(tmp_path, {KEY: SCHEMA_VERSION + 1}, study.study)
    with pytest.raises(SchemaVersionError, match=f"schema version {SCHEMA_VERSION + 1}"):
        study.contents(tmp_path)
    with pytest.raises(SchemaVersionError):
        render_all(tmp_path)


def test_a_file_that_is_no_record_has_no_version(tmp_path: Path) -> None:
    path = tmp_path / "record.json"
    path.write_text("[1]")
    with pytest.raises(SchemaVersionError, match="no schema version"):
        read_record(path)
