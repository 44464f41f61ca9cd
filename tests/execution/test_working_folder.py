"""What lies in the folder where a command is started: it runs, or takes the place of a module, only if it is named."""

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

import barchain
from adapters.registry import ENGINES, engines
from barchain.cli.main import run
from barchain.runs.choices import chosen_engines, programs_here

NEEDED = ("random", "json", "numpy", "psutil", "click")
"""Modules that a command, or its worker, imports"""
PROGRAM = """
[[engine]]
name = "mine"
command = {command}
effects = ["gravity.none", "gravity.point"]
rtol = [1e-8, 1e-10]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Working folder with files in it that tell when they run."""
    for name in NEEDED:
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'a').write({name!r})\n")
    command = f"sh -c {shlex.quote(f'touch {tmp_path}/ran')} {{request}} {{samples}}"
    (tmp_path / "engines.toml").write_text(PROGRAM.format(command=f'"""{command}"""'))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_modules_of_the_working_folder_are_not_imported(folder: Path) -> None:
    command = [sys.executable, "-m", "barchain", "-q", "compare", "basics/two_bars_free", "--engine", "pymunk"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not (folder / "ran").exists()


def test_an_interpreter_that_looks_in_the_working_folder_first_hands_it_to_its_workers_last(folder: Path) -> None:
    code = f"""
import sys
sys.path.pop(0)
import barchain, {", ".join(NEEDED)}
sys.path.insert(0, "")
assert barchain.compare(["basics/two_bars_free"], engines=["pymunk"]).passed
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not (folder / "ran").exists()


@pytest.mark.slow
def test_a_program_of_the_working_folder_runs_only_where_it_is_named(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ENGINES.keys() - {"pymunk"}:  # a comparison with one of the engines that run by default
        monkeypatch.delitem(ENGINES, name)
    assert "mine" in engines()
    assert programs_here() == ["mine"]
    assert "mine" not in chosen_engines(None)
    assert "mine" in chosen_engines(["all"])
    assert set(chosen_engines(None)) < set(chosen_engines(["all"]))
    assert run(["compare", "basics/two_bars_free", "--out", "out"]) == 0
    said = capsys.readouterr().out
    assert not (folder / "ran").exists()
    assert "1 program" in said
    assert "mine" in said
    assert run(["compare", "basics/two_bars_free", "--engine", "mine"]) == 1
    assert (folder / "ran").exists()


@pytest.mark.usefixtures("folder")
def test_what_a_program_declares_is_read_without_a_process(monkeypatch: pytest.MonkeyPatch) -> None:
    from barchain.runs import asking

    def no_process(*_: object, **__: object) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr(asking, "ask", no_process)
    found = asking.declarations_of(engines()["mine"])
    assert found.title == "mine, a program"
    assert found.effects == ("gravity.none", "gravity.point")
    assert barchain.engines()["mine"].by_default is False
