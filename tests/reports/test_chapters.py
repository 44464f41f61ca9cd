"""What the chapters of all studies have in common: each stands alone, or joins the report of a comparison."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import pytest

from reports.render import render, render_study
from reports.results.studies import STUDIES
from tests.reports import cost_tables, effects_tables, roundoff_tables
from tests.studies import scaling_tables
from tests.support.page_policy import check_policy
from tests.support.report_fixture import build
from tests.support.results import change_record
from tests.support.slow import slow_but

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

SLOW_PARTS = ("trajectories", "growth", "longitudes", "engines")
"""Tables whose charts take long"""
WRITERS: dict[str, Callable[[Path], Path]] = {
    "cost": lambda folder: cost_tables.write(folder, cost_tables.study()),
    "effects": lambda folder: effects_tables.write(folder, effects_tables.ROWS),
    "roundoff": lambda folder: roundoff_tables.write(folder, roundoff_tables.tables(roundoff_tables.FEW), SLOW_PARTS),
    "scaling": scaling_tables.write,
}
"""Function that writes synthetic tables of each study that joins a report"""


@pytest.fixture(scope="module")
def comparison(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a small comparison."""
    return build(tmp_path_factory.mktemp("results"), ["basics/two_bars_free"], samples=21)


@pytest.mark.parametrize("study", slow_but(WRITERS, ["cost", "effects", "scaling"]))
def test_a_chapter_stands_alone_alike_each_time_and_says_whether_it_was_cut_off(study: str, tmp_path: Path) -> None:
    folder = WRITERS[study](tmp_path / "first")
    page = render_study(study, folder).page
    check_policy(page)
    assert page == folder / f"{study}.html"
    text = page.read_text()
    assert "cut off" not in text
    again = shutil.copytree(folder, tmp_path / "again")
    assert render_study(study, again).page.read_text() == text
    change_record(folder, study, finished=False, complete=False)
    assert "cut off" in render_study(study, folder).page.read_text()


@pytest.mark.parametrize("study", slow_but(WRITERS, ["cost", "scaling"]))
def test_a_chapter_joins_the_report_of_a_comparison(study: str, comparison: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(comparison, tmp_path, dirs_exist_ok=True)
    render(folder)
    assert f'id="{study}"' not in (folder / "index.html").read_text()
    page = render_study(study, WRITERS[study](folder)).page
    assert page == folder / "index.html"
    assert page.read_text().count(f'id="{study}"') == 1
    assert not (folder / f"{study}.html").exists()


@pytest.mark.parametrize("study", [files.study for files in STUDIES if files.view])
def test_a_folder_without_results_of_a_study_is_named(study: str, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=f"no results of {study}"):
        render_study(study, tmp_path)
    with pytest.raises(FileNotFoundError, match="no comparison there"):
        render(tmp_path)
