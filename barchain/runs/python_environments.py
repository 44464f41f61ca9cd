"""Environments of Python that are made by uv, for engines and releases that can't share this one."""

from __future__ import annotations

import re
import shutil
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from adapters.command.own_python import READY, environment_of, python_in
from barchain.runs.environment import OWN_PYTHON
from barchain.runs.processes import run

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

UV = (*OWN_PYTHON, "-m", "uv", "--quiet")
INSTALL_S = 900.0
"""Longest installation"""
LONGEST_REASON = 300
ADDRESS = re.compile(r"https?://\S+")


class EnvironmentFailedError(RuntimeError):
    """Raised for an environment that can't be made; the message is one line."""


def own_environment(requirements: Sequence[str]) -> Path:
    """Folder of an environment with some packages and what they need; made now, or earlier.

    Raises
    ------
    EnvironmentFailedError
        If uv is not installed, or the packages can't be had together; the message is the installer's reason.
    """
    folder = environment_of(requirements)
    if (folder / READY).is_file():
        return folder
    if find_spec("uv") is None:
        raise EnvironmentFailedError("environments are made by uv, which is not installed; try: pip install uv")

    def fill(new: Path) -> None:
        if failed := install(new, requirements, "--compile-bytecode"):  # Python starts anew for each run
            raise EnvironmentFailedError(failed)
        (new / READY).write_text("".join(f"{line}\n" for line in sorted(requirements)), "utf-8")

    put_in_place(folder, fill)
    return folder


def put_in_place(folder: Path, fill: Callable[[Path], None]) -> None:
    """Make an environment beside its place, and rename it when it is whole.

    If another command made the same one meanwhile, that one stays.

    Parameters
    ----------
    folder : Path
        Its place.
    fill : callable
        Makes the environment in a new folder, with :data:`READY` in it.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix="new-") as scratch:
        new = Path(scratch) / "new"
        fill(new)
        if not (folder / READY).is_file():
            shutil.rmtree(folder, ignore_errors=True)  # half removed, by a command that was ended
        try:
            new.rename(folder)  # an interpreter finds its packages by its own place
        except OSError:
            if not (folder / READY).is_file():
                raise


def install(folder: Path, wanted: Iterable[str], *options: str) -> str:
    """Make an environment in a folder, with options of the installer; the reason of a failure, or an empty text."""
    base = str(getattr(sys, "_base_executable", sys.executable))
    python = str(python_in(folder))
    for step in (
        ("--no-progress", "venv", "--python", base, str(folder)),
        ("--no-progress", "pip", "install", "--python", python, *options, *wanted),
    ):
        done = run([*UV, *step], limit_s=INSTALL_S)
        if done.reason:
            return brief(done.said or done.reason)
    return ""


def brief(said: str) -> str:
    """Reason of an installer in one line, without addresses."""
    lines = [line.strip(" ╰─▶│×") for line in said.splitlines() if line.strip()]
    text = ADDRESS.sub("(address)", " ".join(lines))
    text = "".join(c for c in text if c.isprintable())
    return text if len(text) <= LONGEST_REASON else f"{text[: LONGEST_REASON - 3]}..."
