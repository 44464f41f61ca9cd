"""Commands of barchain in a fresh environment."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from dataclasses import dataclass
from typing import TYPE_CHECKING

import psutil

from barchain.runs.environment import one_thread_each

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from barchain.nightly.environments.making import PinnedEnvironment

LONGEST = 300
REMOVED = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")


@dataclass(frozen=True)
class Finished:
    """End of a command."""

    code: int
    """Exit code; negative of a signal"""
    output: str
    reason: str = ""
    """Last line of a command that failed, or its time limit"""


def run_in(
    environment: PinnedEnvironment, tree: Path, arguments: Sequence[str], *, limit_s: float, folder: Path
) -> Finished:
    """Run Python with a tree of barchain's sources in an environment.

    Parameters
    ----------
    environment : PinnedEnvironment
    tree : Path
        Folder of barchain's packages.
    arguments : sequence of str
        Of Python, e.g. ``("-m", "barchain", "compare", ...)``.
    limit_s : float
        Wall time after which all processes of the command are killed, s.
    folder : Path
        Working folder.
    """
    variables = {name: value for name, value in os.environ.items() if name not in REMOVED}
    with one_thread_each():
        variables |= {k: v for k, v in os.environ.items() if k not in REMOVED} | {"PYTHONPATH": str(tree)}
        process = subprocess.Popen(
            [str(environment.python), *arguments], cwd=folder, env=variables, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip
        try:
            output = process.communicate(timeout=limit_s)[0].decode("utf-8", "replace")
        except subprocess.TimeoutExpired:
            end(process)
            return Finished(-signal.SIGKILL, "", f"did not end within {limit_s:.0f} s")
        except BaseException:
            end(process)
            raise
    code = process.returncode
    return Finished(code, output, last_line(output) if code else "")


def end(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and all that it has started."""
    with contextlib.suppress(psutil.Error):
        for child in psutil.Process(process.pid).children(recursive=True):
            with contextlib.suppress(psutil.Error):
                child.kill()
    process.kill()
    process.communicate()


def last_line(output: str) -> str:
    """Last line with text, without the command's name."""
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    return "".join(c for c in (lines[-1] if lines else "") if c.isprintable()).removeprefix("barchain: ")[:LONGEST]
