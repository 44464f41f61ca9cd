"""The one writer of stored files: whole or not at all, and known to the record beforehand."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import io
import os
import stat
from pathlib import Path, PurePath
from typing import IO, TYPE_CHECKING, Any

from reports.results.reading import DIGITS

if TYPE_CHECKING:
    from collections.abc import Iterator

    import pandas as pd
    from typing_extensions import Buffer

PART = ".part"
"""Ending of a file that is being written"""
NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL


@contextlib.contextmanager
def named(path: Path) -> Iterator[None]:
    """Give the errors of the operating system the name of the file that they are about."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file whole, as :func:`replaced`."""
    with replaced(path) as file:
        file.write(content.encode("utf-8") if isinstance(content, str) else content)


@contextlib.contextmanager
def replaced(path: Path) -> Iterator[DigestedFile]:
    """File that takes its place when the context ends; a failure leaves the earlier file, and no partial one.

    Raises
    ------
    OSError
        If the file can't be written, or is a device, a pipe or a socket; the error names it.
    """
    half = path.with_name(path.name + PART)
    with named(path):
        need_ordinary(path)
        half.unlink(missing_ok=True)
        file = os.fdopen(os.open(half, NEW, 0o666), "wb")
    try:
        yield DigestedFile(path, file)
        with named(path):
            file.close()
            os.replace(half, path)  # noqa: PTH105
    except BaseException:
        for remove in (file.close, half.unlink):
            with contextlib.suppress(OSError):
                remove()
        raise


def need_ordinary(path: Path) -> None:
    """Make sure that no device, pipe or socket is replaced: root could delete ``/dev/null``.

    Raises
    ------
    OSError
        If it is one.
    """
    with contextlib.suppress(FileNotFoundError):
        mode = path.lstat().st_mode
        if not (stat.S_ISREG(mode) or stat.S_ISLNK(mode) or stat.S_ISDIR(mode)):
            raise OSError(errno.EINVAL, "not an ordinary file", str(path))


class DigestedFile(io.BufferedIOBase):
    """File that is written from its start to its end, and the digest of its contents so far."""

    def __init__(self, path: Path, file: IO[bytes]) -> None:
        """Begin before the first byte; errors name `path`."""
        self.path, self.file, self.hash = path, file, hashlib.sha256()

    def writable(self) -> bool:
        """Whether it is written: always."""
        return True

    def write(self, content: Buffer) -> int:
        """Write more."""
        self.hash.update(content)
        with named(self.path):
            return self.file.write(content)

    @property
    def digest(self) -> str:
        """Digest, as records hold it."""
        return self.hash.hexdigest()[:DIGITS]


def parquet(frame: pd.DataFrame, **options: Any) -> bytes:
    """Contents of a Parquet file; `options` are pandas'."""
    content: bytes = frame.to_parquet(index=False, **options)
    return content


def make_folder(root: Path, inside: PurePath | str) -> Path:
    """Make a folder inside a result folder."""
    place = root / inside
    with named(place):
        place.mkdir(parents=True, exist_ok=True)
    return place


def sweep(folder: Path) -> None:
    """Remove the partial files that a killed process left in a folder of results."""
    for place, _, names in os.walk(folder):
        for name in (n for n in names if n.endswith(PART)):
            with contextlib.suppress(OSError):
                Path(place, name).unlink()
