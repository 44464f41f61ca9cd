"""The one reader of stored files: JSON and Parquet of the declared form, or one line on the damaged file."""

from __future__ import annotations

import hashlib
import io
import json
import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping
    from pathlib import Path

    import pandas as pd

REMEDY = "restore the file, or run again with --overwrite or into another folder"
TABLES = "tables"
"""Key of a record: the digests of each table that belongs to it, the one in place among them"""
DIGITS = 32


class DamagedResultsError(ValueError):
    """Raised for a result folder with damaged files; the message is one line: file, damage, remedy."""


def damaged(path: Path, what: object) -> DamagedResultsError:
    """Error of a damaged file."""
    return DamagedResultsError(f"{path}: {brief(what)}; {REMEDY}")


def brief(what: object) -> str:
    """Text on one short line, safe to print."""
    text = str(what) if not isinstance(what, Exception) else str(what) or type(what).__name__
    return " ".join(text.encode("utf-8", "backslashreplace").decode("utf-8").split())[:300]


def read_bytes(path: Path) -> bytes:
    """Contents of a regular file.

    Raises
    ------
    OSError
        If it is missing or can't be read.
    DamagedResultsError
        If it is a folder, a pipe or a device.
    """
    need_regular(path)
    return path.read_bytes()


def need_regular(path: Path) -> None:
    """Check that a path is a regular file, as :func:`read_bytes`."""
    path.stat()
    if not path.is_file():
        raise damaged(path, "is no regular file")


def decoded(path: Path, content: bytes) -> str:
    """Text of the contents of a UTF-8 file."""
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise damaged(path, f"is no UTF-8 text ({error.reason} at byte {error.start})") from None


def read_json(path: Path) -> Any:
    """Value of a JSON file.

    Raises
    ------
    OSError
        If it is missing or can't be read.
    DamagedResultsError
        If it is no JSON.
    """
    text = decoded(path, read_bytes(path))
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise damaged(path, f"is no JSON: {error}") from None


def need_numbers(path: Path, column: pd.Series[Any]) -> None:
    """Check that a column holds numbers and empty cells only."""
    import pandas as pd

    if not pd.api.types.is_numeric_dtype(column) or pd.api.types.is_bool_dtype(column):
        other = column.notna() & pd.to_numeric(column.astype(object), errors="coerce").isna()
        wrong = column[other] if other.any() else column.dropna()
        need_none(path, wrong, f"column {column.name} holds no numbers")


def need_none(path: Path, cells: pd.Series[Any], what: str) -> None:
    """Check that there are no such cells; the message shows the first."""
    if len(cells):
        raise damaged(path, f"{what}: {brief(cells.iloc[0])[:40]!r} in row {int(cells.index[0]) + 1}")


def parquet_frame(path: Path, content: bytes, needed: Collection[str]) -> pd.DataFrame:
    """Table of a Parquet file's contents with some needed columns.

    Raises
    ------
    DamagedResultsError
        If it is no such table.
    """
    import pandas as pd

    try:
        found = pd.read_parquet(io.BytesIO(content))
    except Exception as error:  # Arrow's errors have several bases
        raise damaged(path, f"is no Parquet table: {brief(error)}") from None
    lacking = [name for name in needed if name not in found]
    if lacking:
        raise damaged(path, f"lacks {', '.join(lacking)}")
    return found


def read_parquet(path: Path, content: bytes | None = None) -> pd.DataFrame:
    """Table of numbers over time ``t_s`` of a Parquet file; errors as :func:`parquet_frame`."""
    found = parquet_frame(path, read_bytes(path) if content is None else content, ("t_s",))
    for name in found.columns:
        need_numbers(path, found[name])
    return found


def digest(content: bytes) -> str:
    """Hash of a file's contents, as records hold it."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def file_digest(path: Path) -> str:
    """Hash of a file's contents, which are not held at once."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:DIGITS]


def recorded_content(folder: Path, name: str, record: Mapping[str, Any], *, needed: bool = False) -> bytes | None:
    """Contents of a table that belongs to a record.

    Parameters
    ----------
    folder : Path
        Folder of the record.
    name : str
        Table, relative to it.
    record : mapping
        A record without digests, from an earlier barchain, is taken at its word.
    needed : bool
        Whether a table that does not belong to the record is an error.

    Returns
    -------
    bytes or None
        None if there is no such file, or the record does not know it: it is left from another run.

    Raises
    ------
    FileNotFoundError
        If it is needed, and there is no such file.
    DamagedResultsError
        If the contents differ from those that the record describes, or a complete record lists a missing file.
    """
    path = recorded_path(folder, name, record)
    if path is not None:
        content = read_bytes(path)
        need_digest(path, digest(content), record.get(TABLES), name)
        return content
    if needed and not os.path.lexists(folder / name):
        raise FileNotFoundError(f"{folder}: no {name} there; give a folder with results")
    if needed:
        raise damaged(folder / name, "is left from another run than the record's")
    return None


def recorded_parquet(folder: Path, name: str, record: Mapping[str, Any]) -> pd.DataFrame | None:
    """Table over time that belongs to a record; None without a file. Errors as :func:`recorded_content`."""
    content = recorded_content(folder, name, record)
    return None if content is None else read_parquet(folder / name, content)


def check_recorded(folder: Path, name: str, record: Mapping[str, Any]) -> None:
    """Check a table that belongs to a record, without holding its contents; errors as :func:`recorded_content`."""
    path = recorded_path(folder, name, record)
    if path is not None:
        need_regular(path)
        need_digest(path, file_digest(path), record.get(TABLES), name)


def recorded_path(folder: Path, name: str, record: Mapping[str, Any]) -> Path | None:
    """File of a table that belongs to a record; None if there is no such file, or the record does not know it.

    Raises
    ------
    DamagedResultsError
        If a complete record lists a missing file.
    """
    known, path = record.get(TABLES), folder / name
    if known is not None and name not in known:
        return None
    if os.path.lexists(path):
        return path
    if known is not None and record.get("complete"):
        raise damaged(path, "is missing, and the record lists it")
    return None


def need_digest(path: Path, found: str, known: Mapping[str, list[str]] | None, name: str) -> None:
    """Check that a table has a digest that its record lists."""
    if known is not None and found not in known[name]:
        raise damaged(path, "is not the table that the record describes: damaged, changed, or of another run")
