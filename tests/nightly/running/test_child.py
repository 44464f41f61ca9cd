"""A job is a process of its own: a limit keeps its results, and a bad end costs the job alone."""

from __future__ import annotations

import signal
import sys
import time
from typing import TYPE_CHECKING

import pytest

from barchain.nightly import processes as child
from barchain.nightly.processes import reason_of, run_barchain

if TYPE_CHECKING:
    from pathlib import Path

SCRIPT = "import signal, sys, time\n"


@pytest.fixture
def instead(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Program that stands for `python -m barchain`."""
    program = tmp_path / "program.py"
    monkeypatch.setattr(child, "PROGRAM", (sys.executable, str(program)))
    return program


def test_a_command_that_ends_in_time_gives_its_exit_code_and_its_output(instead: Path, tmp_path: Path) -> None:
    instead.write_text(f"{SCRIPT}print('said', sys.argv[1]); sys.exit(1)", "utf-8")
    ended = run_barchain(("compare",), tmp_path / "logs" / "log.txt", 30.0)
    assert (ended.code, ended.failed, ended.reason) == (1, False, "")
    assert (tmp_path / "logs" / "log.txt").read_text("utf-8") == "said compare\n"


def test_the_reason_of_a_failure_is_the_last_line_that_the_command_said(instead: Path, tmp_path: Path) -> None:
    instead.write_text(f"{SCRIPT}print('work'); print('barchain: no such engine\\n\\n'); sys.exit(2)", "utf-8")
    ended = run_barchain((), tmp_path / "log.txt", 30.0)
    assert (ended.code, ended.failed, ended.reason) == (2, True, "no such engine")


def test_at_its_limit_a_command_is_interrupted_as_by_ctrl_c(instead: Path, tmp_path: Path) -> None:
    instead.write_text(
        f"{SCRIPT}\ntry:\n    print('ready', flush=True); time.sleep(60)\nexcept KeyboardInterrupt:\n    print('kept')",
        "utf-8",
    )
    ended = run_barchain((), tmp_path / "log.txt", 1.5)
    assert ended.interrupted
    assert (tmp_path / "log.txt").read_text("utf-8") == "ready\nkept\n"


def test_a_command_is_interrupted_at_its_limit_also_where_the_night_ignores_ctrl_c(
    instead: Path, tmp_path: Path
) -> None:
    instead.write_text(
        f"{SCRIPT}\ntry:\n    print('ready', flush=True); time.sleep(60)\nexcept KeyboardInterrupt:\n    print('kept')",
        "utf-8",
    )
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as a shell starts a command in the background
    try:
        run_barchain((), tmp_path / "log.txt", 1.5)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)
    assert (tmp_path / "log.txt").read_text("utf-8") == "ready\nkept\n"


def test_a_command_that_ignores_the_interruption_is_killed_with_its_processes(
    instead: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(child, "GRACE_S", 0.5)
    instead.write_text(
        f"{SCRIPT}import subprocess\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'], start_new_session=True)\n"
        "print('ready', flush=True); time.sleep(60)",
        "utf-8",
    )
    start = time.monotonic()
    assert run_barchain((), tmp_path / "log.txt", 1.5).interrupted
    assert time.monotonic() - start < 30.0


def test_a_process_that_a_signal_ended_says_which() -> None:
    assert reason_of(-9, "") == "ended by signal 9"
    assert reason_of(-11, "working") == "ended by signal 11: working"
    assert reason_of(70, "") == "ended with exit code 70"
