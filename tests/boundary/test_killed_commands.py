"""An engine whose run ends the process of its comparison leaves no process behind."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import psutil
import pytest

from tests.boundary.command_killers import SLEEP
from tests.support.slow import one_in

if TYPE_CHECKING:
    from pathlib import Path

MARK = "TEST_OF_KILLED_COMMANDS"
GONE_S = 10.0


def left(mark: str) -> list[list[str]]:
    """Command lines of processes of a comparison and of children of its engine."""
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            if process.environ().get(MARK) == mark or process.cmdline() == SLEEP:
                found.append(process.cmdline())
    return found


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are found by their environment in /proc")
@pytest.mark.parametrize("engine", one_in(3, ["KillsCommand", "KillsAllAbove", "KillsFromParentOn"]))
def test_an_engine_that_kills_its_comparison_leaves_no_process(engine: str, tmp_path: Path) -> None:
    mark = str(tmp_path)
    line = [sys.executable, "-m", "tests.boundary.command_killers", engine, str(tmp_path / "out")]
    made = subprocess.run(line, env=os.environ | {MARK: mark}, capture_output=True, check=False, timeout=100.0)
    assert made.returncode == -signal.SIGKILL or engine == "KillsFromParentOn"  # which may die with its parent
    until = time.monotonic() + GONE_S
    while left(mark) and time.monotonic() < until:
        time.sleep(0.2)
    assert left(mark) == []
