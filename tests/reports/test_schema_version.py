"""Results of another schema version are rejected with one readable line, by every reader of a record."""

import json
import shutil
from pathlib import Path

import pytest

from barchain.cli.main import run
from barchain.record.environment import provenance
from barchain.record.study_store import StudyStore
from reports.render import CHAPTERS, render_all
from reports.tables.cost import read_cost
from reports.tables.crossval import FILES, read_results
from reports.tables.effects import read_effects
from reports.tables.ensemble import read_ensemble
from reports.tables.faults.campaign import read_campaign
from reports.tables.faults.selftest import read_selftest
from reports.tables.nights.releases import read_releases
from reports.tables.roundoff import read_roundoff
from reports.tables.scaling import scaling_rows
from reports.tables.schema import KEY, SCHEMA_VERSION, SchemaVersionError, read_record
from reports.tables.stability import read_stability
from tests.support.report_fixture import build

READERS = {
    "campaign": read_campaign,
    "cost": read_cost, "effects": read_effects, "ensemble": read_ensemble, "releases": read_releases,
    "roundoff": read_roundoff, "scaling": scaling_rows, "selftest": read_selftest, "stability": read_stability,
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("results"), ["basics/radial_equilibrium"], faults=False, samples=11)


def with_version(results: Path, folder: Path, version: object) -> Path:
    """Copy of a result folder whose record says another schema version, or none."""
    shutil.copytree(results, folder, dirs_exist_ok=True)
    record = json.loads((folder / "record.json").read_text())
    del record[KEY]
    (folder / "record.json").write_text(json.dumps(record if version is None else record | {KEY: version}))
    return folder


def test_every_record_begins_with_the_schema_version() -> None:
    assert next(iter(provenance("barchain cost").items())) == (KEY, SCHEMA_VERSION)


def test_a_record_of_this_version_is_read(results: Path) -> None:
    assert read_results(results).record[KEY] == SCHEMA_VERSION


@pytest.mark.parametrize("version", [None, 0, SCHEMA_VERSION + 1, str(SCHEMA_VERSION), True, [1]])
def test_a_report_of_another_version_is_one_readable_line(
    version: object, results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = with_version(results, tmp_path, version)
    assert run(["report", str(folder)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert str(folder / "record.json") in error
    assert ("no schema version" if version is None else f"schema version {version!r}") in error
    assert f"reads version {SCHEMA_VERSION}" in error
    assert "Run the study again" in error


def test_a_comparison_does_not_resume_from_another_version(results: Path, tmp_path: Path) -> None:
    with pytest.raises(SchemaVersionError, match="no schema version"):
        StudyStore(FILES, with_version(results, tmp_path, None), {}, resume=True)


@pytest.mark.parametrize("chapter", CHAPTERS, ids=lambda chapter: chapter.name)
def test_every_study_rejects_another_version(chapter, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    inside = tmp_path / chapter.name
    inside.mkdir()
    for name in chapter.tables:
        text = json.dumps({KEY: SCHEMA_VERSION + 1}) if name.endswith(".json") else "scene\n"
        (inside / name).write_text(text)
    for table in ("orders", "reach", "price"):  # a cost study writes more tables than its chapter needs
        (inside / f"{table}.csv").write_text("scene\n")
    with pytest.raises(SchemaVersionError, match=f"schema version {SCHEMA_VERSION + 1}"):
        READERS[chapter.name](tmp_path)
    with pytest.raises(SchemaVersionError):
        render_all(tmp_path)


def test_a_file_that_is_no_record_has_no_version(tmp_path: Path) -> None:
    (tmp_path / "record.json").write_text("[1]")
    with pytest.raises(SchemaVersionError, match="no schema version"):
        read_record(tmp_path / "record.json")
