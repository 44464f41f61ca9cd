"""Folder of compiled code that can be written into: where the usual one can't, a temporary one for this command."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from reference_impl.machine_code import store

if TYPE_CHECKING:
    from collections.abc import Callable


def why_not_writable(folder: Path) -> str:
    """Reason why files can't be kept in a folder; empty if they can."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return ""
    except OSError as error:
        return error.strerror or str(error)


@cache
def temporary_place() -> Path:
    """Private folder that is removed when this process ends."""
    found = Path(tempfile.mkdtemp(prefix="barchain-compiled-"))
    owner = os.getpid()
    atexit.register(lambda: shutil.rmtree(found, ignore_errors=True) if os.getpid() == owner else None)
    return found


def keep_compiled(note: Callable[[str], None]) -> None:
    """Make sure that compiled code can be kept for this command at least, and note where it can't be kept longer."""
    place = store.folder()
    reason = why_not_writable(place)
    if not reason:
        return
    os.environ[store.PLACE] = str(temporary_place())  # worker processes inherit it
    note(f"{place}: {reason}; compiled code is kept for this command only")
