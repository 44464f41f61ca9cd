"""The gallery, the pages of engines and the generated tables of pages are made from scenes, engines and record."""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING

import pandas as pd
import pytest
from click.testing import CliRunner

from adapters.registry import COMPILED, built_in, find_engine
from pictures import write
from pictures.__main__ import main
from pictures.pages.docstrings import paragraphs
from pictures.pages.engine_page import page_file
from pictures.pages.generated_tables import BLOCK, FRAGMENTS, filled, pages_with_tables
from pictures.pages.libraries import LIBRARIES, library_of
from pictures.pages.record import MeasuredRecord
from pictures.pages.words import cell
from pictures.paths import RECORD
from pictures.record.certified import certified_rows
from pictures.record.comparison import row_of
from pictures.record.files import COLUMNS, DIGITS, read_runs, read_table
from pictures.record.releases import releases_rows
from pictures.stages import STAGES
from pictures.write import library_files, site_files
from reports.results.comparison import METRIC_COLUMNS
from scenarios import load_scene
from tests.reports.study_pages import releases_page

if TYPE_CHECKING:
    from pathlib import Path
rendered, tables, measured = cache(site_files), cache(pages_with_tables), cache(MeasuredRecord)

pytestmark = pytest.mark.skipif(bool(find_engine(COMPILED).missing), reason="pictures need the compiled reference")


def test_the_generated_tables_of_committed_pages_are_those_that_the_code_makes() -> None:
    stale = [path.name for path, text in tables().items() if path.read_text(encoding="utf-8") != text]
    assert not stale, "python -m pictures --only tables"
    named = [found["name"] for path in tables() for found in BLOCK.finditer(path.read_text("utf-8"))]
    assert sorted(named) == sorted(FRAGMENTS)


def test_an_edited_table_is_written_anew_and_the_text_around_it_stays() -> None:
    page = "Before.\n\n<!-- generated: exit-codes -->\nedited\n<!-- end: exit-codes -->\n\nAfter.\n"
    made = filled(page)
    assert "edited" not in made
    assert "| 130 |" in made
    assert (made[:8], made[-7:]) == ("Before.\n", "After.\n")
    assert filled(made) == made
    with pytest.raises(KeyError, match="no-such"):
        filled("<!-- generated: no-such -->\n<!-- end: no-such -->")


def test_files_of_scenes_that_are_gone_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(write, "GENERATED", tmp_path)
    monkeypatch.setattr(write, "site_files", lambda: {tmp_path / "kept.md": "text"})
    (tmp_path / "gone.md").write_text("old", encoding="utf-8")
    assert write.write_site_files() == 1
    assert write.write_site_files() == 0
    assert [p.name for p in tmp_path.iterdir()] == ["kept.md"]


@pytest.mark.slow
@pytest.mark.parametrize("engine", built_in())
def test_every_engine_has_a_page_that_names_it(engine: str) -> None:
    library = library_of(engine)
    assert f"`{engine}`" in library_files(library, measured())[page_file(library)]


def test_no_two_libraries_share_an_engine() -> None:
    named = [name for library in LIBRARIES for name in library.engines]
    assert sorted(named) == sorted(built_in())


@pytest.mark.parametrize("library", LIBRARIES, ids=lambda library: library.page)
def test_every_library_tells_formulation_integrator_and_traps(library: object) -> None:
    labels = {p.label for p in paragraphs(library.package)}  # type: ignore[attr-defined]
    assert any(label.startswith("Integrator") for label in labels)
    assert labels & {"Trap", "Traps"}
    assert any(label.startswith("Formulation") for label in labels)


def test_the_record_of_certified_solutions_is_that_of_the_files_that_come_with_barchain() -> None:
    names = ["paper/fig09", "effects/slews", "hard/tip_mass", "hard/whip"]
    there = read_table("certified").set_index("scene")
    for row in certified_rows(load_scene(name) for name in names):
        for column in COLUMNS["certified"][2:]:
            value = row.get(column, float("nan"))
            assert there.loc[row["scene"], column] == pytest.approx(float(DIGITS % value), nan_ok=True)


@pytest.mark.parametrize("name", COLUMNS)
def test_a_table_of_the_record_names_known_engines_and_scenes_once(name: str) -> None:
    table = read_table(name)
    if "engine" in table:
        assert set(table.engine) <= set(built_in())
    if "scene" in table:
        assert {load_scene(scene).name for scene in table.scene.unique()} == set(table.scene)
    if name in ("comparison", "stability"):
        assert not table.duplicated(["scene", "engine"]).any()


def test_the_record_tells_where_each_table_is_from() -> None:
    for facts in read_runs().values():
        assert re.fullmatch(r"\d{4}-\d\d-\d\d", facts["created"])
        assert facts["barchain"]
        assert facts["command"].startswith("barchain")
    assert not [p.name for p in RECORD.iterdir() if "/tmp" in p.read_text(encoding="utf-8")]


def test_a_pair_is_recorded_with_its_most_severe_outcome_and_the_largest_difference() -> None:
    lines = [
        ("paper/fig05", "drake", "rtol=1e-10", "attitude", "max", 2e-7, "rad", 1e-3, "pass", "", 5000.0),
        ("paper/fig05", "drake", "rtol=1e-10", "attitude", "detection_limit", 3e-6, "1", None, "reported", "", None),
        ("paper/fig05", "drake", "rtol=1e-10", "reaction", "max", 4e-3, "N", 1e-3, "inconsistent", "wrong", 5000.0),
    ]
    row = row_of("paper/fig05", "drake", pd.DataFrame(lines, columns=list(METRIC_COLUMNS)))
    assert (row["outcome"], row["reason"]) == ("inconsistent", "wrong")
    assert (row["attitude_rad"], row["reaction_N"], row["limit_s"]) == (2e-7, 4e-3, 5000.0)
    assert row["detection_limit"] == 3e-6


def test_a_bar_in_a_reason_does_not_end_a_cell() -> None:
    assert cell("|r| is large\nhere") == "\\|r\\| is large here"


def test_the_command_names_its_stages() -> None:
    said = CliRunner().invoke(main, ["--help"]).output
    assert all(stage.name in said for stage in STAGES)
    assert CliRunner().invoke(main, ["--only", "no-such"]).exit_code == 2


def test_the_record_of_releases_has_the_time_at_the_finest_error_of_each(tmp_path: Path) -> None:
    releases_page(tmp_path)
    rows, record = releases_rows(tmp_path)
    assert [(row["version"], row["state"], row["at"]) for row in rows] == [
        ("1.0", "runs", "attitude<=1e-06"),
        ("1.1", "does not run", ""),
    ]
    assert rows[0]["ratio"] == 3.0
    assert record["engine"] == "box"
