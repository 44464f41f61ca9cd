"""What the README and the tutorials tell a reader to type works, and shows what the page shows."""

import sys
from pathlib import Path

import pytest

from tests.documents.running import blocks, carry_out, command, run
from tests.structure.product import ROOT

TUTORIALS = ROOT / "docs" / "tutorials"
ELSEWHERE = {"your_own_engine": "tests/authors/test_tutorial.py", "notebook": "tests/documents/test_site.py"}
BY_HAND = {"first_comparison", "nightly_for_your_project", "reading_roundoff", "your_own_scene"}
"""Tutorials whose commands other tests run smaller"""
PAGES = [
    pytest.param(path, id=path.stem, marks=pytest.mark.exhaustive if path.stem in BY_HAND else pytest.mark.slow)
    for path in sorted(TUTORIALS.glob("*.md"))
    if path.stem not in ELSEWHERE
]


@pytest.fixture(autouse=True)
def own_history(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("BARCHAIN_HISTORY", str(tmp_path / "history"))


@pytest.mark.parametrize("page", PAGES)
def test_a_tutorial_can_be_carried_out(page: Path, tmp_path: Path) -> None:
    assert carry_out(page, tmp_path) >= 2


@pytest.mark.slow
def test_the_script_of_the_readme_runs(tmp_path: Path) -> None:
    (script,) = (block.text for block in blocks(ROOT / "README.md") if block.language == "python")
    run([sys.executable, "-c", script], tmp_path, 0)


@pytest.mark.slow
def test_the_first_comparison_of_the_readme_shows_what_a_run_shows(tmp_path: Path) -> None:
    shown = next(block.text for block in blocks(ROOT / "README.md") if block.language == "text")
    page = tmp_path / "README.md"
    engines = "--engine reference --engine exudyn --engine rebound --engine pymunk"  # of an installation without extras
    page.write_text(f"```sh\nbarchain compare paper/fig05 {engines}\n```\n```text\n{shown}```\n", encoding="utf-8")
    assert carry_out(page, tmp_path) == 1


@pytest.mark.slow
def test_the_scene_of_the_readme_can_be_compared(tmp_path: Path) -> None:
    scene = next(block.text for block in blocks(ROOT / "README.md") if block.language == "toml")
    (tmp_path / "mine.toml").write_text(scene, encoding="utf-8")
    assert "2 pass" in command("barchain compare mine.toml --engine reference --engine rebound", tmp_path)
