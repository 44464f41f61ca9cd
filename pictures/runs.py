"""Runs of barchain's own commands in the work folder."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

FINISHED = (0, 1)
"""Exit codes of a study that ended: 1 tells that an engine failed a check, which the record shows"""


class StudyFailedError(RuntimeError):
    """A study that did not end."""


def run_barchain(work: Path, *arguments: str) -> None:
    """Run a command of barchain in a folder, going on from its earlier results there.

    Raises
    ------
    StudyFailedError
        If it ends before it has results.
    """
    work.mkdir(parents=True, exist_ok=True)
    code = subprocess.run([sys.executable, "-m", "barchain", *arguments, "--resume"], cwd=work, check=False).returncode
    if code not in FINISHED:
        raise StudyFailedError(f"barchain {' '.join(arguments)} ended with {code}")


def engine_options(names: Sequence[str]) -> list[str]:
    """Options that select engines."""
    return [word for name in names for word in ("--engine", name)]
