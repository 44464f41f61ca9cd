"""The one writer of stored files: whole or not at all, and known to the record beforehand."""

from __future__ import annotations

import contextlib
import errno
import hashlib
import io
import json
import os
import stat
from pathlib import Path, PurePath
from typing import IO, TYPE_CHECKING, Any

from reports.tables.reading import DIGITS, TABLES, digest, file_digest, read_bytes

if TYPE_CHECKING:
    from collections.abc import Iterator

    import pandas as pd
    from typing_extensions import Buffer

PART = ".part"
"""Ending of a file that is being written"""
NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL
MORE = os.O_RDWR | os.O_APPEND


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


def append_whole(path: Path, content: bytes) -> None:
    """Append to a file; a failure leaves it as it was. Errors as :func:`write_atomically`."""
    with named(path):
        handle = os.open(path, MORE)
        try:
            before = os.fstat(handle).st_size
            try:
                written = os.write(handle, content)
                while written < len(content):
                    written += os.write(handle, content[written:])
            except BaseException:
                os.ftruncate(handle, before)
                raise
        finally:
            os.close(handle)


def parquet(frame: pd.DataFrame) -> bytes:
    """Contents of a Parquet file."""
    sink = io.BytesIO()
    frame.to_parquet(sink, index=False)
    return sink.getvalue()


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


class RecordedFolder:
    """Folder with a record and its tables.

    The record holds the digest of each of its tables. The digest of a table's next state joins that of its present
    state in the record before the table is written: at every instant each table in place is known to the record, and a
    table of another run is not.
    """

    def __init__(self, folder: Path, name: str, record: dict[str, Any]) -> None:
        """Open a folder that exists; nothing is written yet."""
        self.folder, self.name, self.record = folder, name, record

    @property
    def tables(self) -> dict[str, list[str]]:
        """Digests of each table: of its next state, then of its present one."""
        found: dict[str, list[str]] = self.record.setdefault(TABLES, {})
        return found

    def write_record(self) -> None:
        """Write the record as it stands."""
        write_atomically(self.folder / self.name, json.dumps(self.record, indent=1))

    def write(self, table: str, content: bytes) -> None:
        """Write a table whole, and the record."""
        with self.replacing(table) as file:
            file.write(content)

    @contextlib.contextmanager
    def replacing(self, table: str) -> Iterator[DigestedFile]:
        """File that becomes the table when the context ends; the record then describes it."""
        make_folder(self.folder, PurePath(table).parent)
        with replaced(self.folder / table) as file:
            yield file
            self.announce(table, file.digest)

    def append(self, table: str, content: bytes) -> None:
        """Add to the end of a table that is there."""
        path = self.folder / table
        with named(path):
            whole = read_bytes(path) + content
        self.announce(table, digest(whole))
        append_whole(path, content)

    def announce(self, table: str, following: str) -> None:
        """Write the record with the digest of a table's next state."""
        known, path = self.tables.get(table, []), self.folder / table
        present = file_digest(path) if known and path.is_file() else None
        self.tables[table] = list(dict.fromkeys([following, *(found for found in known if found == present)]))
        self.write_record()

    def remove(self, table: str) -> None:
        """Delete a table if it is there."""
        path = self.folder / table
        with named(path):
            path.unlink(missing_ok=True)
        self.tables.pop(table, None)
