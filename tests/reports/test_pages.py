"""Pages of a result folder: each is rendered once, has one heading for each chapter, and explains each term once."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pandas as pd
import pytest

from reports.render import render_all
from reports.results import comparison, effects, ensemble, stability
from reports.results.studies import STUDIES
from tests.support.results import MADE, write_results

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Folder of a comparison, an effect budget and an ensemble, all without rows."""
    write_results(tmp_path, comparison.FILES, {"metrics": ()}, MADE)
    scene = {"scene": {"name": "some/scene", "title": "Some scene"}}
    write_results(tmp_path, effects.FILES, {"effects": ()}, MADE | scene)
    spent = {"phases_s": {"run": 1.0, "reduce": 0.1}, "outcomes": {"finished": 4}}
    drawn = {"runs": 4, "rtol": 1e-10, "vary": ["mass"], "seed": 1, "evaluations": 1000}
    series = {"quantiles": pd.DataFrame(columns=list(ensemble.QUANTILE_COLUMNS))}
    return write_results(tmp_path, ensemble.FILES, {}, MADE | scene | spent | drawn, series)


def test_the_report_links_to_its_chapters_by_their_titles(folder: Path) -> None:
    render_all(folder)
    page = (folder / "index.html").read_text()
    for chapter in (files for files in STUDIES if files.view):
        included = chapter.study == "effects"
        assert (f'<a href="#{chapter.study}">{chapter.title}</a>' in page) is included
        assert (f'<h2 id="{chapter.study}">{chapter.title}</h2>' in page) is included


def test_a_page_explains_each_term_once(folder: Path) -> None:
    made = render_all(folder)
    assert {path.name for path in made} == {"index.html", "summary.md", "ensemble.html"}
    for name in ("index.html", "ensemble.html"):
        explained = re.findall(r"<dfn>([^<]+)</dfn>", (folder / name).read_text())
        assert explained
        assert len(explained) == len(set(explained))


def test_a_pair_whose_finer_runs_would_take_too_long_is_shown_as_timed_out(tmp_path: Path) -> None:
    reason = "not run: the coarse setting already took longer than 5 s"
    late = {"scene": "hard/some", "engine": "slow", "stability": "failed", "reason": reason, "slow": True}
    about: dict[str, Any] = {"scenes": {"hard/some": {"title": "Some", "description": ""}}, "engines": {"slow": ""}}
    record = MADE | about | {"left_out": [], "time_limit_s": 5.0}
    [page] = render_all(write_results(tmp_path, stability.FILES, {"outcomes": [late]}, record))
    assert re.search(f'title="{reason}">.*timed out', page.read_text())
