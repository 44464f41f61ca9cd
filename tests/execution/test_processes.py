"""A program is a process of its own: a limit keeps its results, and a bad end costs the program alone."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
import time
from pathlib import Path

import psutil
import pytest

from barchain.runs import processes as child
from barchain.runs.environment import FOLDER, LEFT_S, PREFIX, locked, scratch_folder
from barchain.runs.processes import GitError, git, reason_of, run, run_barchain

ROOT = Path(child.__file__).parents[2]
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


@pytest.mark.slow
def test_a_command_is_interrupted_at_its_limit_also_where_the_night_ignores_ctrl_c(
    instead: Path, tmp_path: Path
) -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as a shell starts a command in the background
    try:
        test_at_its_limit_a_command_is_interrupted_as_by_ctrl_c(instead, tmp_path)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.slow
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


def running(pid: int) -> bool:
    """Whether a process is there, and no zombie that nobody has asked for its end."""
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.mark.slow
def test_at_its_limit_a_program_is_killed_with_its_processes() -> None:
    code = (
        "import subprocess, sys, time\n"
        "child = subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)'], start_new_session=True)\n"
        "print(child.pid, flush=True); time.sleep(60)"
    )
    done = run([sys.executable, "-c", code], limit_s=1.5)
    assert (done.code, done.reason) == (None, "did not end within 2 s")
    within = time.monotonic() + 20.0
    while running(int(done.output)) and time.monotonic() < within:
        time.sleep(0.05)
    assert not running(int(done.output))


def test_a_child_that_a_program_leaves_behind_delays_nothing() -> None:
    code = "import subprocess; print(subprocess.Popen(['sleep', '30']).pid)"
    done = run([sys.executable, "-c", code], limit_s=25.0)
    psutil.Process(int(done.output)).kill()
    assert done.code == 0
    assert done.duration_s < 20.0


def test_what_a_program_reads_and_says_comes_through_and_its_two_outputs_are_apart() -> None:
    code = "import sys; print(input()); print('careful', file=sys.stderr); sys.exit(3)"
    done = run([sys.executable, "-c", code], limit_s=30.0, given="pin==3.4.0")
    assert (done.code, done.reason, done.output) == (3, "careful", "pin==3.4.0\n")
    assert run(["no-such-program"], limit_s=5.0).reason.startswith("no-such-program does not start: ")


def test_git_answers_or_its_last_words_are_told(tmp_path: Path) -> None:
    with pytest.raises(GitError, match="not a git repository"):
        git(tmp_path, "rev-parse", "HEAD")


def test_one_package_starts_processes_beside_the_kernels_build_and_programs_as_engines() -> None:
    """The kernel is built while barchain is installed, and adapters know nothing of barchain."""
    packages = ("barchain", "adapters", "reference_impl", "reports", "scenarios")
    files = [path for name in packages for path in (ROOT / name).rglob("*.py")]
    modules = {"import subprocess", "import multiprocessing"}
    lines = {path.relative_to(ROOT).as_posix(): set(path.read_text("utf-8").splitlines()) for path in files}
    elsewhere = {name for name, own in lines.items() if own & modules and not name.startswith("barchain/runs/")}
    assert elsewhere == {f"adapters/command/{name}.py" for name in ("engine", "entries")} | {
        "reference_impl/kernel/build.py"
    }


def test_a_start_removes_folders_whose_owner_and_watchman_were_killed_and_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.delenv(FOLDER, raising=False)
    left, new, used, shared = (tmp_path / f"{PREFIX}{name}" for name in ("left", "new", "used", "shared"))
    for folder in (left, new, used, shared):
        folder.mkdir(mode=0o755 if folder is shared else 0o700)
        (folder / "file").touch()
        if folder is not new:
            os.utime(folder, (0.0, time.time() - 2.0 * LEFT_S))
    (tmp_path / f"{PREFIX}link").symlink_to(used)
    lock = locked(used)
    with scratch_folder() as own:
        there = {path.name for path in tmp_path.iterdir()}
    os.close(lock or 0)
    assert there == {own.name, new.name, used.name, shared.name, f"{PREFIX}link"}
    assert not own.exists()
