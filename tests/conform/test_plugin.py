"""The plugin of pytest: a test for each scene of an engine, known failures are expected, nothing is loaded unasked."""

from __future__ import annotations

import re
import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

from barchain.conform.scenes import STAGES
from tests.structure.product import ROOT

if TYPE_CHECKING:
    from pathlib import Path

WRONG = "tests.conform.wrong_engines:Degrees"


def ends(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """End of pytest with the plugin alone, where modules of this repository can be imported."""
    (folder / "pytest.ini").write_text("[pytest]\naddopts = --strict-markers\nfilterwarnings = error\n", "utf-8")
    options = ("-q", "--color=no", "-p", "barchain.pytest_plugin", "-p", "no:xdist", "-p", "no:cacheprovider")
    line = [sys.executable, "-m", "pytest", "--rootdir", str(folder), *options, *words, str(folder)]
    return subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)


def summary(done: subprocess.CompletedProcess[str]) -> str:
    return re.sub(r" in [\d.]+s.*", "", done.stdout.splitlines()[-1])


def test_without_the_option_nothing_else_of_barchain_is_imported(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import sys\n\n\ndef test_own():\n"
        "    names = ('barchain.', 'adapters', 'scenarios', 'reports', 'reference_impl', 'numpy')\n"
        "    assert [m for m in sys.modules if m.startswith(names)] == ['barchain.pytest_plugin']\n", "utf-8"
    )  # fmt: skip
    assert summary(ends(tmp_path)) == "1 passed"


def test_each_scene_of_conformance_is_a_test_that_a_mark_selects(tmp_path: Path) -> None:
    done = ends(tmp_path, "--barchain-engine", "reference-fast", "--collect-only", "-m", "barchain")
    for scene in (scene for scenes in STAGES.values() for scene in scenes):
        assert f"barchain::reference-fast::{scene}\n" in done.stdout
    assert ends(tmp_path, "--barchain-engine", "reference-fast", "-m", "not barchain").returncode == (
        pytest.ExitCode.NO_TESTS_COLLECTED
    )


def test_right_scenes_pass_and_those_that_an_engine_rejects_are_skipped(tmp_path: Path) -> None:
    done = ends(tmp_path, "--barchain-engine", "pymunk", "-k", "one_bar_free or prescribed_turns", "-rs")
    assert summary(done) == "1 passed, 1 skipped, 46 deselected"
    assert "pymunk in conform/prescribed_turns unsupported: " in done.stdout


def test_a_wrong_scene_fails_with_its_mistake_and_no_traceback(tmp_path: Path) -> None:
    done = ends(tmp_path, "--barchain-engine", WRONG, "-k", "one_bar_free")
    assert done.returncode == 1
    assert f"{WRONG} in conform/one_bar_free failed: " in done.stdout
    assert "Traceback" not in done.stdout
    assert "physics.py" not in done.stdout


def test_known_failures_are_expected_and_those_that_ended_fail(tmp_path: Path) -> None:
    entries = {"conform/one_bar_free": "", "conform/one_bar_point:*": "until = 2020-01-01"}
    text = "".join(f'[[failure]]\npattern = "{p}"\nreason = "soft"\n{until}\n' for p, until in entries.items())
    (tmp_path / "known_failures.toml").write_text(text, "utf-8")
    chosen = ("-k", "one_bar_free or one_bar_point")
    wrong = ends(tmp_path, "--barchain-engine", WRONG, *chosen)
    assert summary(wrong) == "1 failed, 46 deselected, 1 xfailed"
    assert "a known failure has ended: conform/one_bar_point:*: soft (ended on 2020-01-01)" in wrong.stdout
    assert summary(ends(tmp_path, "--barchain-engine", "rebound", *chosen)) == "1 failed, 46 deselected, 1 xpassed"


def test_an_unknown_engine_and_a_broken_file_are_errors_of_usage(tmp_path: Path) -> None:
    assert "no such engine (did you mean rebound?)" in ends(tmp_path, "--barchain-engine", "rebond").stderr
    (tmp_path / "known_failures.toml").write_text("[[failure", "utf-8")
    assert "not valid TOML" in ends(tmp_path, "--barchain-engine", "rebound").stderr
