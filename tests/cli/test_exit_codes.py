"""Exit codes: the same table for every command, and known before anything runs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import click
import pytest

from adapters.engine import EngineError
from adapters.registry import ENGINES, Registration
from barchain.cli.common.exit_codes import ExitCode
from barchain.cli.main import cli, main, run
from tests.support.slow import one_in

QUICK = "basics/libration"
PAGE = Path(__file__).parents[2] / "docs" / "reference" / "command_line.md"
MISSING = Registration("nowhere:Nothing", "nowhere", install="pip install nowhere")


@pytest.fixture
def nothing(monkeypatch):
    monkeypatch.setitem(ENGINES, "nothing", MISSING)


@pytest.mark.parametrize("command", [
    f"simulate {QUICK} --engine nothing --out x.csv",
    f"compare {QUICK} --engine reference --engine nothing --out x",
    f"compare {QUICK} --engine reference --set nothing:rtol=1e-8 --out x",
    f"cost {QUICK} --engine nothing --out x",
    "scaling --bars 2 --engine nothing --out x",
    f"sweep {QUICK} --vary run.samples=3 --engine nothing --out x",
    "stability hard/whip --engine nothing --out x",
    "selftest --engine nothing --out x",
])  # fmt: skip
def test_a_missing_engine_asked_for_by_name_is_known_before_anything_runs_and_exits_with_3(
    command, nothing, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    assert run(command.split()) == 3
    assert capsys.readouterr().err == "barchain: nothing: nowhere is not installed; try: pip install nowhere\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("command", "engine"), [
    (f"ensemble {QUICK} --vary angle_deg=normal(0,1) --out x", "reference-fast"),
    (f"effects {QUICK} --engine reference-fast --out x", "reference-fast"),
    (f"certified {QUICK} --check", "heyoka-quad"),
])  # fmt: skip
def test_a_missing_engine_that_a_command_needs_exits_with_3(command, engine, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(ENGINES, engine, MISSING)
    assert run(command.split()) == 3
    assert f"{engine}: nowhere is not installed" in capsys.readouterr().err


@pytest.fixture
def failing(monkeypatch):
    """Give a command that raises what it is told to."""

    def install(error):
        @click.command("fails")
        @click.option("--resume", is_flag=True)
        def fails(resume):
            raise error

        monkeypatch.setitem(cli.commands, "fails", fails)

    return install


@pytest.mark.parametrize("line", one_in(4, ["scenes", "scenes show paper/fig05", "--help", "schema"]))
def test_a_reader_that_ends_first_ends_the_command_without_a_word(line: str) -> None:
    command = f"{sys.executable} -m barchain {line}; echo ended with $? >&2"
    made = subprocess.run(["sh", "-c", f"({command}) | true"], capture_output=True, text=True, check=False)
    assert made.stderr == "ended with 141\n"


def test_an_interrupt_exits_with_130_and_says_how_to_go_on(failing, capsys):
    failing(KeyboardInterrupt())
    assert run(["fails"]) == 130
    said = capsys.readouterr().err
    assert "interrupted; results so far are kept, `barchain report` shows them, and --resume goes on from them" in said


def test_a_failed_run_is_a_finding_and_its_traceback_is_printed_on_request(failing, capsys):
    failing(EngineError("exudyn on x: diverged"))
    assert run(["fails"]) == 1
    assert capsys.readouterr().err == "barchain: exudyn on x: diverged\n"
    assert run(["-v", "fails"]) == 1
    assert "Traceback" in capsys.readouterr().err


def test_a_fault_of_barchain_itself_exits_with_70_and_a_traceback(failing, monkeypatch, capsys):
    failing(ZeroDivisionError("inside"))
    monkeypatch.setattr(sys, "argv", ["barchain", "fails"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 70
    assert "ZeroDivisionError: inside" in capsys.readouterr().err


def test_python_m_barchain_is_the_command_line():
    made = subprocess.run([sys.executable, "-m", "barchain", "nonsense"], capture_output=True, text=True, check=False)
    assert (made.returncode, made.stderr) == (2, "barchain: No such command 'nonsense'.\n")


@pytest.mark.parametrize(
    "error",
    [MemoryError(), RuntimeError("can't start new thread"), ImportError("x.so: failed to map segment from ...")],
)
def test_too_little_memory_is_one_line_and_exit_code_2(error, monkeypatch, capsys):
    def scarce(*_, **__):
        raise error

    monkeypatch.setattr("scenarios.load_scene", scarce)
    assert run(["validate", QUICK]) == ExitCode.BAD_INPUT
    said = capsys.readouterr().err
    assert "not enough memory" in said
    assert said.count("\n") == 1
