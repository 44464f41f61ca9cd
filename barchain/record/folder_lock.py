"""One writer at a time: a lock on a result folder, which ends with its process however that ends."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

if TYPE_CHECKING:
    from collections.abc import Iterator
    from contextlib import AbstractContextManager
    from pathlib import Path

LOCK = ".barchain.lock"
"""Empty file in a result folder; the operating system's lock on it counts, and its presence does not"""


class FolderInUseError(ValueError):
    """Raised for a result folder that another process, or another thread, writes into; the message is one line."""


def locked_if_there(folder: Path) -> AbstractContextManager[None]:
    """Lock of a result folder that exists; nothing of one that does not."""
    return locked(folder) if folder.is_dir() else contextlib.nullcontext()


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a result folder, which is made if need be; the same thread may hold it several times.

    Raises
    ------
    FolderInUseError
        If somebody else holds it.
    OSError
        If the folder can't be made or written into.
    """
    folder.mkdir(parents=True, exist_ok=True)
    place = folder.resolve() / LOCK
    lock = FileLock(place, timeout=0, is_singleton=True, thread_local=True)
    try:
        lock.acquire()
    except Timeout:
        said = "another barchain writes into this folder; wait for its end, or give another --out"
        raise FolderInUseError(f"{folder}: {said}") from None
    try:
        yield
    finally:
        lock.release()
