"""The plugin of pytest: a test for each scene of an engine, known failures are expected, nothing is loaded unasked."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from barchain import load_scene
from barchain.conform.scenes import STAGES
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.reference import closely_sampled
from tests.structure.product import ROOT

Ends = Callable[..., pytest.RunResult]
WRONG = "tests.conform.wrong_engines:Degrees"


@pytest.fixture(scope="module", autouse=True)
def imported() -> None:
    """Import here what a run inside of pytest would import anew each time: Arrow permits that once."""
    assert shipped_solution(closely_sampled(load_scene("conform/one_bar_free")))


@pytest.fixture
def ends(pytester: pytest.Pytester) -> Ends:
    """Function that runs pytest with the plugin alone in an empty folder, inside of this process."""
    pytester.makeini("[pytest]\naddopts = --strict-markers\nfilterwarnings = error\n")
    options = ("-q", "--color=no", "-p", "barchain.pytest_plugin", "-p", "no:xdist", "-p", "no:cacheprovider")
    return lambda *words: pytester.runpytest_inprocess(*options, *words)


def summary(done: pytest.RunResult) -> str:
    return re.sub(r" in [\d.]+s.*", "", done.outlines[-1])


def test_without_the_option_nothing_else_of_barchain_is_imported(tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import sys\n\n\ndef test_own():\n"
        "    names = ('barchain.', 'adapters', 'scenarios', 'reports', 'reference_impl', 'numpy')\n"
        "    assert [m for m in sys.modules if m.startswith(names)] == ['barchain.pytest_plugin']\n", "utf-8"
    )  # fmt: skip
    words = f"-m pytest -q --rootdir {tmp_path} -p barchain.pytest_plugin {tmp_path}".split()
    done = subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.stdout.splitlines()[-1].startswith("1 passed")


def test_each_scene_of_conformance_is_a_test_that_a_mark_selects(ends: Ends) -> None:
    said = ends("--barchain-engine", "reference-fast", "--collect-only", "-m", "barchain").stdout.str()
    assert all(f"barchain::reference-fast::{scene}\n" in said for scenes in STAGES.values() for scene in scenes)


def test_right_scenes_pass_and_those_that_an_engine_rejects_are_skipped(ends: Ends) -> None:
    done = ends("--barchain-engine", "pymunk", "-k", "one_bar_free or prescribed_turns", "-rs")
    assert summary(done) == "1 passed, 1 skipped, 46 deselected"
    assert "pymunk in conform/prescribed_turns unsupported: " in done.stdout.str()


def test_a_wrong_scene_fails_with_its_mistake_and_known_failures_are_expected_until_they_end(ends: Ends) -> None:
    entries = {"conform/one_bar_free": "", "conform/one_bar_point:*": "until = 2020-01-01"}
    text = "".join(f'[[failure]]\npattern = "{p}"\nreason = "soft"\n{until}\n' for p, until in entries.items())
    Path("known_failures.toml").write_text(text, "utf-8")
    wrong = ends("--barchain-engine", WRONG, "-k", "one_bar_free or one_bar_point")
    assert summary(wrong) == "1 failed, 46 deselected, 1 xfailed"
    said = wrong.stdout.str()
    assert "a known failure has ended: conform/one_bar_point:*: soft (ended on 2020-01-01)" in said
    assert f"{WRONG} in conform/one_bar_point failed: " in said
    assert "Traceback" not in said
    assert "physics.py" not in said
    assert summary(ends("--barchain-engine", "rebound", "-k", "one_bar_free")) == "47 deselected, 1 xpassed"


def test_an_unknown_engine_and_a_broken_file_are_errors_of_usage(ends: Ends) -> None:
    assert "no such engine (did you mean rebound?)" in ends("--barchain-engine", "rebond").stderr.str()
    Path("known_failures.toml").write_text("[[failure", "utf-8")
    assert "not valid TOML" in ends("--barchain-engine", "rebound").stderr.str()
