"""The one reader of stored files: JSON and Parquet of the declared form, or one line on the damaged file."""

from __future__ import annotations

import hashlib
import io
import json
import os
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping
    from pathlib import Path

    import pandas as pd
    from pydantic import TypeAdapter

Form = TypeVar("Form")
FORMS: dict[type, TypeAdapter[Any]] = {}

REMEDY = "restore the file, or run again with --overwrite or into another folder"
TABLES = "tables"
"""Key of a record: the digests of each table that belongs to it, the one in place among them"""
DIGITS = 32
CELL_B, MOST_B = 8, 8 * 2**30
"""Bytes of a number, and of the largest table that is read: a small file may hold many equal numbers"""
MOST_TEXT = 300
"""Longest text on one line"""


class DamagedResultsError(ValueError):
    """Raised for a result folder with damaged files; the message is one line: file, damage, remedy."""


def damaged(path: Path, what: object) -> DamagedResultsError:
    """Error of a damaged file."""
    return DamagedResultsError(f"{path}: {brief(what)}; {REMEDY}")


def brief(what: object) -> str:
    """Text on one short line, safe to print."""
    text = str(what) if not isinstance(what, Exception) else str(what) or type(what).__name__
    line = " ".join(text.encode("utf-8", "backslashreplace").decode("utf-8").split())
    return line if len(line) <= MOST_TEXT else f"{line[:MOST_TEXT].rsplit(' ', 1)[0]} …"  # no number is cut


def need_regular(path: Path) -> None:
    """Check that a path is a regular file.

    Raises
    ------
    OSError
        If it is missing or can't be read.
    DamagedResultsError
        If it is a folder, a pipe or a device.
    """
    path.stat()
    if not path.is_file():
        raise damaged(path, "is no regular file")


def read_json(path: Path) -> Any:
    """Value of a JSON file; errors as :func:`need_regular`, or a DamagedResultsError if it is no JSON."""
    need_regular(path)
    try:
        return json.loads(path.read_bytes().decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise damaged(path, f"is no JSON: {error}") from None


def form_of(kind: type[Form]) -> TypeAdapter[Form]:
    """Form of a class as pydantic reads and writes it, made once."""
    from pydantic import TypeAdapter

    if kind not in FORMS:
        FORMS[kind] = TypeAdapter(kind)
    return FORMS[kind]


def formed(kind: type[Form], content: bytes) -> Form:
    """Value of JSON that has the form of a class.

    Raises
    ------
    ValueError
        If it is no JSON, or has another form; the message is one line on the first entry that differs.
    """
    from pydantic import ValidationError

    try:
        return form_of(kind).validate_json(content)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False, include_context=False)[0]
        raise ValueError(brief(f"{'.'.join(map(str, first['loc']))} {first['msg']}".strip())) from None


def read_parquet(path: Path, needed: Collection[str]) -> pd.DataFrame:
    """Table of a Parquet file with some needed columns; errors as :func:`need_regular`.

    Raises
    ------
    DamagedResultsError
        If it is no such table.
    """
    import pandas as pd
    from pyarrow.parquet import read_metadata

    need_regular(path)
    try:
        about = read_metadata(path)
        if (size := about.num_rows * about.num_columns * CELL_B) > MOST_B:
            raise ValueError(f"{about.num_rows} rows of {about.num_columns} columns, {size:.2g} bytes")
        found = pd.read_parquet(io.BytesIO(path.read_bytes()))
    except Exception as error:  # Arrow's errors have several bases
        raise damaged(path, f"is no Parquet table: {brief(error)}") from None
    lacking = [name for name in needed if name not in found]
    if lacking:
        raise damaged(path, f"lacks {', '.join(lacking)}")
    return found


def digest(content: bytes) -> str:
    """Hash of a file's contents, as records hold it."""
    return hashlib.sha256(content).hexdigest()[:DIGITS]


def file_digest(path: Path) -> str:
    """Hash of a file's contents, which are not held at once."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:DIGITS]


def recorded(folder: Path, name: str, record: Mapping[str, Any]) -> bool:
    """Whether a file is there and belongs to a record: else it is left from another run.

    A record without digests, from an earlier barchain, is taken at its word.
    """
    known = record.get(TABLES)
    return (known is None or name in known) and os.path.lexists(folder / name)


def check_recorded(folder: Path, record: Mapping[str, Any]) -> None:
    """Check that each file of a record is the one that it describes.

    Raises
    ------
    DamagedResultsError
        If the contents differ, or a complete record lists a missing file.
    """
    for name, digests in (record.get(TABLES) or {}).items():
        path = folder / name
        if os.path.lexists(path):
            need_regular(path)
            if file_digest(path) not in digests:
                what = "is not the table that the record describes: damaged, changed, or of another run"
                raise damaged(path, what)
        elif record.get("complete"):
            raise damaged(path, "is missing, and the record lists it")
