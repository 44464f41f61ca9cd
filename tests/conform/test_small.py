"""Words and names around an examination: of parts, of one's own modules, of slow runs, of interruptions."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import pytest

from adapters.registry import Registration, UnknownEngineError
from barchain.cli.main import kept_words, run
from barchain.conform import conform
from barchain.conform.checks import Check, CheckState, ConformanceReport, Group
from barchain.conform.target import extent_of
from barchain.runs.choices import chosen_engines
from barchain.runs.examination import imported_libraries
from tests.support.kernel import needs_kernel

if TYPE_CHECKING:
    from pathlib import Path

HERE = "tests.conform.wrong_engines"


def report_of(*states: CheckState) -> ConformanceReport:
    """A part of an examination with checks of some states."""
    checks = tuple(Check("two bars free", state, group=Group.PHYSICS) for state in states)
    return ConformanceReport("mine", "1.0", checks, 1.0, whole=False)


def test_a_part_with_warnings_alone_passes_and_one_without_a_supported_scene_does_not() -> None:
    assert report_of(CheckState.WARNING).passed
    assert report_of(CheckState.WARNING).verdict == "passes a part of the examination"
    assert not report_of(CheckState.UNSUPPORTED).passed
    assert report_of(CheckState.UNSUPPORTED).verdict == "supports nothing of this part of the examination"


@pytest.mark.exhaustive
@needs_kernel
def test_compare_takes_a_class_that_no_package_registers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "report")
    assert run(["compare", "conform/two_bars_free", "--engine", f"{HERE}:Right", "--out", out]) == 0
    shown = capsys.readouterr().out
    assert "1 pass" in shown
    assert run(["compare", "conform/two_bars_free", "--engine", f"{HERE}:ReactionsReversed", "--out", f"{out}2"]) == 1
    assert "reactions have the opposite sign" in capsys.readouterr().out


def test_a_class_has_a_short_name_and_a_wrong_name_tells_how_a_class_is_given() -> None:
    assert chosen_engines([f"{HERE}:ReactionsReversed"]) == {
        "reactions-reversed": Registration(f"{HERE}:ReactionsReversed")
    }
    with pytest.raises(UnknownEngineError, match=r"did you mean mine:Engine\?"):
        chosen_engines(["mine.Engine"])


def test_a_base_module_of_an_author_is_no_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("base", "engines"):
        (tmp_path / folder).mkdir()
        monkeypatch.syspath_prepend(str(tmp_path / folder))
    (tmp_path / "base" / "base_of_mine.py").write_text("class Base:\n    pass\n", "utf-8")
    (tmp_path / "engines" / "engine_of_mine.py").write_text("import pytest\nfrom base_of_mine import Base\n", "utf-8")
    before = set(sys.modules) - {"pytest"}
    __import__("engine_of_mine")
    assert imported_libraries(Registration("engine_of_mine:Mine"), before) == ["pytest"]


@pytest.mark.slow
def test_a_solver_whose_steps_collapse_is_told_as_that_after_the_first_run() -> None:
    found = {c.name: c for c in conform(f"{HERE}:Slow", extent=extent_of(["conventions", "behaviour"])).checks}
    first = found["a first run"]
    assert first.state is CheckState.FAILED
    assert "though one at rtol=0.0001 takes " in first.words
    assert "steps collapse where the right-hand side jumps" in first.words
    assert found["behaviour"].state is CheckState.NOT_RUN


def test_an_interrupted_command_tells_of_kept_results_only_where_some_are_kept() -> None:
    assert kept_words(["conform", "mine"]) == ""
    assert "--resume" in kept_words(["compare", "paper/fig05"])
