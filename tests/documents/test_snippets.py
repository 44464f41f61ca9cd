"""Every command and snippet of the documents is carried out, or stands in a table with the reason why not."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import tomllib
from typing import TYPE_CHECKING

import pytest

from barchain import load_scene, simulate
from barchain.nightly.running.plan import PlanFile
from tests.documents import snippets as found
from tests.documents.running import command, run
from tests.support.slow import exhaustive_but, one_in

if TYPE_CHECKING:
    from pathlib import Path

    from _pytest.mark import ParameterSet

    from tests.documents.snippets import Snippet

SHELLS = ("bash", "zsh", "fish")
HOST = """title = "A chain that takes any effect"
source = "test"
[orbit]
altitude_m = 350e3
[chain]
bars = {bars}
mass_kg = 100.0
length_m = 100.0
angle_deg = 80.0
[run]
orbits = 0.2
samples = 3
"""
SPRINGS = "joint_spring_damper"
"""Effect whose fragment lists three joints"""
SCRIPTS = found.of_kind("python")


def name(snippet: Snippet) -> str:
    return str(snippet)


def marked(snippet: Snippet) -> ParameterSet:
    """Parameter of a command."""
    by_night = snippet.text in found.ways()["by_night"]
    return pytest.param(snippet, marks=pytest.mark.exhaustive if by_night else pytest.mark.slow)


def test_each_snippet_is_carried_out_in_one_way() -> None:
    left = [str(s) for s in found.snippets() if not found.kind(s) and found.reason_not_run(s) is None]
    assert not left, "no test carries these out"


def test_the_table_of_ways_names_nothing_that_is_gone() -> None:
    texts = [s.text for s in found.snippets()]
    ways = found.ways()
    gone = [each for each in (*ways["by_night"], *ways["with_less"]) if each not in texts]
    gone += [start for start in ways["not_run"] if not any(text.startswith(start) for text in texts)]
    assert not gone


@pytest.mark.parametrize("snippet", one_in(9, found.of_kind("effect")), ids=name)
def test_an_effect_of_the_documents_belongs_into_a_scene(snippet: Snippet, tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    bars = 2 if "engine_conventions" in snippet.document.name else 4 if SPRINGS in snippet.text else 5
    scene.write_text(HOST.format(bars=bars) + snippet.text, encoding="utf-8")
    assert len(simulate(load_scene(scene)).t_s) == 3


@pytest.mark.parametrize("snippet", found.of_kind("scene"), ids=name)
@pytest.mark.slow
def test_a_scene_of_the_documents_can_be_simulated(snippet: Snippet, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(snippet.text, encoding="utf-8")
    scene = load_scene(tmp_path / "scene.toml")
    assert len(simulate(scene).t_s) == scene.run.samples


@pytest.mark.parametrize("snippet", found.of_kind("plan"), ids=name)
def test_a_plan_of_the_documents_has_known_keys(snippet: Snippet) -> None:
    assert PlanFile.model_validate(tomllib.loads(snippet.text)).minutes > 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "snippet", exhaustive_but(SCRIPTS, [s for s in SCRIPTS if "python.md" in s.document.name]), ids=name
)
def test_a_script_of_the_documents_runs(snippet: Snippet, tmp_path: Path) -> None:
    text = snippet.text.replace('assert_conforms("mine")', 'assert_conforms("reference-fast")')
    if "def test_" in text:
        text += "\ntest_my_engine_conforms()\n"
    script = tmp_path / "script.py"
    script.write_text(text, encoding="utf-8")
    run([sys.executable, str(script)], tmp_path, 0)


@pytest.mark.parametrize("snippet", [marked(s) for s in {s.text: s for s in found.of_kind("sh")}.values()], ids=name)
def test_a_command_of_the_documents_runs(snippet: Snippet, tmp_path: Path) -> None:
    words = f"{snippet.text} {found.ways()['with_less'].get(snippet.text, '')}"
    command(words, tmp_path)


@pytest.mark.parametrize("shell", SHELLS)
def test_completion_of_each_shell_is_printed(shell: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "barchain"],
        env={**os.environ, "_BARCHAIN_COMPLETE": f"{shell}_source"}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0
    assert "barchain" in done.stdout


def test_python_that_no_test_runs_can_be_parsed() -> None:
    for each in found.snippets():
        if each.language == "python":
            ast.parse(each.text)
