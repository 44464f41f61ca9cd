"""Place of a history: a folder here, or at an address that fsspec knows. A file there is whole, or it is not there."""

from __future__ import annotations

import contextlib
import errno
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING

from barchain.nightly.errors import HistoryError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence


VARIABLE = "BARCHAIN_HISTORY"
DEFAULT = "nights"
PASSWORD = re.compile(r"(?<=://)[^/@]*:[^/@]*(?=@)")


def default_url() -> str:
    """Address of the history where none is given: by the environment variable, else the folder ``nights``."""
    return os.environ.get(VARIABLE) or DEFAULT


TRIED = ".writable"
"""File that is written and removed to try the folder"""


class Place:
    """Folder of a history."""

    def __init__(self, url: str) -> None:
        """Find the file system; nothing is read.

        Raises
        ------
        HistoryError
            If it is a file, or an address that fsspec does not know.
        """
        from fsspec.core import url_to_fs  # noqa: PLC0415  # an extra

        self.url = PASSWORD.sub("***", url)
        path = Path(url).expanduser()
        if not url.strip() or path.is_file():
            raise HistoryError(f"{url or 'history'}: is no folder; a history is a folder of nights")
        try:
            self.fs, self.root = url_to_fs(url if "://" in url else str(path.absolute()))
        except (ImportError, ValueError) as error:
            raise HistoryError(f"{self.url}: {error}; allowed: a folder, or an address that fsspec knows") from None
        self.local = Path(self.root) if "file" in self.fs.protocol else None

    def exists(self) -> bool:
        """Whether the folder is there."""
        with self.told():
            return bool(self.fs.isdir(self.root))

    def sizes(self, pattern: str) -> dict[str, int]:
        """Sizes of the files that fit a pattern, such as ``*/record.json``, by their names in the folder."""
        with self.told():
            if self.local is None:
                found = self.fs.glob(f"{self.root}/{pattern}", detail=True)
                return {name[len(self.root) :].strip("/"): int(facts["size"] or 0) for name, facts in found.items()}
            sizes = {}
            for path in self.local.glob(pattern):  # in a tenth of the time that fsspec takes
                with contextlib.suppress(FileNotFoundError):  # one that goes meanwhile is left out
                    sizes[path.relative_to(self.local).as_posix()] = path.stat().st_size
            return sizes

    def read(self, name: str) -> bytes | None:
        """Contents of a file; None if it is not there."""
        return self.read_all([name]).get(name)

    def read_all(self, names: Sequence[str]) -> dict[str, bytes]:
        """Contents of the files that are there; on a server they are read side by side."""
        if not names:
            return {}
        paths = {f"{self.root}/{name}": name for name in names}
        with self.told():
            if self.local is not None:
                return {name: Path(path).read_bytes() for path, name in paths.items() if Path(path).is_file()}
            found = self.fs.cat(list(paths), on_error="return")
        missing = (FileNotFoundError, NotADirectoryError)
        for content in found.values():
            if isinstance(content, Exception) and not isinstance(content, missing):
                with self.told():
                    raise content
        stripped = {self.fs._strip_protocol(path): name for path, name in paths.items()}
        return {stripped[path]: content for path, content in found.items() if isinstance(content, bytes)}

    def write(self, name: str, content: bytes) -> None:
        """Write a file: beside its place, then onto the disk, then into its place."""
        with self.told():
            if self.local is None:
                self.fs.makedirs(f"{self.root}/{name}".rpartition("/")[0], exist_ok=True)
                self.fs.pipe_file(f"{self.root}/{name}", content)
                return
            path = self.local / name
            path.parent.mkdir(parents=True, exist_ok=True)
            part = path.with_name(f"{path.name}.{os.getpid()}.part")  # two processes may write the same night
            try:
                with part.open("wb") as file:
                    file.write(content)
                    file.flush()
                    os.fsync(file.fileno())
                part.replace(path)
            finally:
                part.unlink(missing_ok=True)

    def need_writable(self) -> None:
        """Write a small file and remove it: that a night can't be stored is told before it runs."""
        self.write(TRIED, b"")
        self.remove(TRIED)

    def remove(self, name: str) -> None:
        """Remove a file or a folder that is there; a link goes itself, and nothing that it leads to."""
        with self.told(), contextlib.suppress(FileNotFoundError):
            if self.local is not None:
                inside = self.local
                for part in name.split("/"):
                    inside /= part
                    if inside.is_symlink():
                        inside.unlink()
                        return
            self.fs.rm(f"{self.root}/{name}", recursive=True)

    @contextlib.contextmanager
    def told(self) -> Iterator[None]:
        """Turn errors of the file system into one line."""
        try:
            yield
        except HistoryError:
            raise
        except OSError as error:
            reason = error.strerror or first_line(error)
            if error.errno in (errno.ENOSPC, errno.EFBIG, errno.EDQUOT):
                reason = f"the disk is full ({reason}); no night was changed"
            elif error.errno in (errno.EACCES, errno.EROFS, errno.EPERM):
                reason = f"can't be written or read ({reason}); no night was changed"
            raise HistoryError(f"{self.url}: {reason}") from error
        except Exception as error:  # of the many libraries behind fsspec
            raise HistoryError(f"{self.url}: {first_line(error)}") from error


def first_line(error: object) -> str:
    """First line of an error's message."""
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:300]
