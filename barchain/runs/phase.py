"""Phase of an engine's run, noted in a file: a process that is ended at its time limit can't tell where it was."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

QUESTION = "BARCHAIN_QUESTION"
"""Variable that holds the folder of a question, in the engine's process and its children"""
PHASE = "phase.txt"
MOST_LENGTH = 40


def enter(phase: str) -> None:
    """Note the phase that begins, in the process of a question; nothing elsewhere."""
    folder = os.environ.get(QUESTION)
    if folder:
        with suppress(OSError):  # an engine may have removed the folder
            Path(folder, PHASE).write_text(phase, encoding="ascii")


def late_words(folder: Path, time_s: float) -> str:
    """Words on a process that was ended at its time limit: ``no result within 40 s, ended in build``."""
    try:
        path = Path(folder, PHASE)
        phase = path.read_text(encoding="ascii")[:MOST_LENGTH] if path.is_file() else ""  # no pipe of an engine's
    except (OSError, ValueError):
        phase = ""
    known = phase if phase.replace(" ", "").isalpha() else ""
    return f"no result within {time_s:g} s{f', ended in {known}' if known else ''}"
