"""Builds of a gate: each form of a build names the Python that runs it, and a whole gate tells them apart."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

import pytest

from barchain.cli.main import run
from barchain.engine.new_program import write_program
from barchain.nightly.errors import PinnedEnvironmentError
from barchain.nightly.gate import measuring
from barchain.nightly.gate.run import build_of, wheel_requirement
from scenarios import load

SCENE = "basics/two_bars_free"


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Few rounds, in an empty folder."""
    monkeypatch.setattr(measuring, "MOST_ROUNDS", 1)
    monkeypatch.chdir(tmp_path)


def test_a_wheel_is_known_by_its_content(tmp_path: Path) -> None:
    wheel = tmp_path / "mine_engine-0.1-py3-none-any.whl"
    wheel.write_bytes(b"one")
    first = wheel_requirement(wheel)
    assert re.fullmatch(rf"mine-engine @ {wheel.as_uri()}#sha256=[0-9a-f]{{64}}", first)
    wheel.write_bytes(b"other")
    assert wheel_requirement(wheel) != first


def test_a_python_runs_as_it_is_and_a_file_of_programs_in_this_one(tmp_path: Path) -> None:
    assert build_of(sys.executable, "reference").python == Path(sys.executable)
    file = tmp_path / "engines.toml"
    file.write_text("", "utf-8")
    made = build_of(str(file), "mine")
    assert (made.python, made.variables) == (Path(sys.executable), {"BARCHAIN_ENGINES": str(file)})


@pytest.mark.parametrize("spec", ["no.whl", "no.toml", "pymunk=7", "a b"])
def test_what_is_no_build_is_told_with_what_is_allowed(spec: str) -> None:
    with pytest.raises(PinnedEnvironmentError, match="allowed: a requirement such as"):
        build_of(spec, "pymunk")


@pytest.mark.slow
def test_one_build_beside_itself_opens_the_gate(quick: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["-q", "gate", "reference-fast", SCENE, "--base", sys.executable, "--head", sys.executable]) == 0
    said = capsys.readouterr().out
    assert said.startswith("### Nothing is worse, among ")
    assert "had no time" not in said
    assert "Trajectories have other bits in 0 of 1 scenes." in said


@pytest.mark.slow
def test_a_program_that_became_wrong_closes_the_gate_until_it_is_known(
    quick: None, capsys: pytest.CaptureFixture[str]
) -> None:
    write_program("mine", "python-program", Path("base"))
    entries = Path("base/engines.toml")
    lines = entries.read_text("utf-8").splitlines()
    entries.write_text("\n".join(line for line in lines if not line.startswith("requirements")), "utf-8")
    shutil.copytree("base", "head")
    source = Path("head/engine.py").read_text("utf-8")
    assert "+ 2 * k2" in source
    Path("head/engine.py").write_text(source.replace("+ 2 * k2", "+ 2.001 * k2"), "utf-8")
    shipped = (Path(load.__file__).parent / f"{SCENE}.toml").read_text("utf-8")
    short = shipped.replace("duration_s = 2000.0", "duration_s = 200.0").replace("samples = 201", "samples = 21")
    assert short != shipped
    Path("short.toml").write_text(short, "utf-8")
    line = ["-q", "gate", "mine", "short.toml", "--base", str(entries), "--head", "head/engines.toml",
            "--out", "gate.md", "--minutes", "1"]  # fmt: skip
    assert run(line) == 1
    said = capsys.readouterr().out
    assert said == Path("gate.md").read_text("utf-8")
    assert re.match(r"### \S+ figures are worse in one scene, among \d+ figures.\n", said)
    assert re.search(r"\| short:mine::verdict and \d+ more of this scene \| pass \| inconsistent", said)
    Path("known_failures.toml").write_text('[[failure]]\npattern = "short"\nreason = "a bet"\n', "utf-8")
    assert run(line) == 0
    assert capsys.readouterr().out.startswith("### Nothing is worse but ")


@pytest.mark.slow
def test_a_base_without_a_pass_ends_with_2(quick: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["-q", "gate", "pymunk", "paper/fig17", "--base", sys.executable, "--head", sys.executable]) == 2
    assert "passes no scene, so that nothing can be worse; paper/fig17: unsupported, " in capsys.readouterr().err


def test_bad_input_ends_with_2(quick: None, capsys: pytest.CaptureFixture[str]) -> None:
    def ends(*words: str) -> str:
        assert run(["-q", "gate", *words]) == 2
        return capsys.readouterr().err

    here = ("--base", sys.executable, "--head", sys.executable)
    assert "no such scene" in ends("reference", "basics/two_bars_fre", *here)
    assert "no such engine" in ends("referenc", SCENE, *here)
    assert "no such file" in ends("reference", *here, "--known", "nowhere.toml")
