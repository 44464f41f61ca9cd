"""Exit codes: the same table for every command, known before anything runs; closed streams cost the output alone."""

from __future__ import annotations

import os
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


@pytest.mark.parametrize("error", [ZeroDivisionError("inside"), SystemExit(0), GeneratorExit("inside")])
def test_a_fault_of_barchain_itself_exits_with_70_and_a_traceback(error, failing, monkeypatch, capsys):
    failing(error)
    monkeypatch.setattr(sys, "argv", ["barchain", "fails"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 70
    assert f"{type(error).__name__}: " in capsys.readouterr().err


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


BARCHAIN = f"{sys.executable} -m barchain"
COMPARE = f"{BARCHAIN} compare basics/kepler_circular --engine reference --workers 1 --out out"
posix = pytest.mark.skipif(os.name != "posix", reason="a shell of POSIX redirects the streams")
needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")


def shell(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["sh", "-c", line], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.slow
@posix
@pytest.mark.parametrize(
    "streams", ["<&- >&- 2>&-", pytest.param("2>/dev/full", marks=[needs_full, pytest.mark.exhaustive])]
)
def test_closed_streams_and_a_full_standard_error_cost_no_run(streams: str, tmp_path: Path) -> None:
    made = shell(f"{COMPARE} {streams}", tmp_path)
    assert made.returncode == 0, made.stderr
    assert (tmp_path / "out" / "index.html").is_file()


@pytest.mark.exhaustive
@posix
@needs_full
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_standard_output_that_is_full_is_told_after_the_work(unbuffered: str, tmp_path: Path) -> None:
    made = shell(f"PYTHONUNBUFFERED={unbuffered} {COMPARE} >/dev/full", tmp_path)
    assert made.returncode == 2
    assert made.stderr.splitlines()[-1].startswith("barchain: standard output is lost: ")
    assert (tmp_path / "out" / "index.html").is_file()


@posix
def test_a_current_folder_that_is_gone_is_one_line(tmp_path: Path) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    made = shell(f"rmdir {gone}; {BARCHAIN} simulate basics/kepler_circular --out {tmp_path}/x.csv", gone)
    assert (made.returncode, len(made.stderr.splitlines())) == (2, 1)
    assert "the current folder is gone" in made.stderr


@posix
@pytest.mark.timeout(60)
def test_a_scene_that_is_a_device_or_a_pipe_is_rejected_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe.toml")
    for path in ("/dev/zero", "pipe.toml"):
        assert run(["compare", path]) == 2
        said = f"barchain: {path}: a device, a pipe or a socket; a scene is an ordinary file that ends with .toml\n"
        assert capsys.readouterr().err == said
