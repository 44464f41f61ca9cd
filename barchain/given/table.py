"""Text of a table as others write it: separators, byte-order marks, comments, and the digits of each number.

The digits that were written are an error bar: half a unit in the last place. Zeros at the end may have been left out.
The numbers of a column therefore have as many decimals, or as many digits, as the one that shows most of them: of both
places the larger one counts. A column of one value says nothing about that: beside numbers in full, it is in full too.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from scenarios.plural import plural
from scenarios.text import shorten

if TYPE_CHECKING:
    from pathlib import Path

    from adapters.trajectory import Array

MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
SEPARATORS = ("\t", ";", ",")
COMMENTS = ("#", "%")
NUMBER = r"\s*[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?\s*|\s*[+-]?(nan|inf|infinity)\s*"
COMMA = r"\s*[+-]?\d+,\d+([eE][+-]?\d+)?\s*"
POINTS = "write numbers with a decimal point"
MOST_BYTES = 1 << 30
FULL = 15
"""Digits that every double keeps: a table that shows as many holds doubles in full"""


class TableError(ValueError):
    """A file that is no table of samples; the message is one line."""


@dataclass(frozen=True)
class Column:
    """Numbers of one column, as they stand in the file."""

    name: str
    values: Array
    """(n,)"""
    half_unit: Array
    """(n,) half a unit in the last place written"""
    digits: int = 0
    """Most significant digits of a number"""


def read_columns(path: Path) -> list[Column]:
    """Columns of a table in text; without a header their names are their numbers, from 1.

    Raises
    ------
    TableError
        If the file is no such table; the message names the line.
    OSError
        If it can't be read.
    """
    if path.stat().st_size > MOST_BYTES:
        raise TableError(f"{path.name} has {path.stat().st_size:.1e} bytes, allowed: {MOST_BYTES:.1e}")
    lines = [(k, line) for k, line in enumerate(text_of(path).splitlines(), 1) if line.strip(" \t,;")]
    remarks = [line.lstrip("#% ") for _, line in lines if line.lstrip().startswith(COMMENTS)]
    lines = [(k, line) for k, line in lines if not line.lstrip().startswith(COMMENTS)]
    if not lines:
        raise TableError(f"{path.name} has no rows")
    separator = next((s for s in SEPARATORS if s in lines[0][1]), None)
    rows = [(k, cells(line, separator)) for k, line in lines]
    names = rows[0][1]
    if any(re.fullmatch(NUMBER, cell, re.IGNORECASE) for cell in names):
        header = cells(remarks[-1], next((s for s in SEPARATORS if s in remarks[-1]), None)) if remarks else []
        names = header if len(header) == len(names) else [str(k + 1) for k in range(len(names))]
    else:
        rows = rows[1:]
    if not rows:
        raise TableError(f"{path.name} has a header and no rows")
    for k, row in rows:
        check_row(path.name, k, row, names, separator)
    texts = [[row[c] for _, row in rows] for c in range(len(names))]
    columns = [column(name.strip(), each) for name, each in zip(names, texts, strict=True) if any(map(str.strip, each))]
    if max(c.digits for c in columns) < FULL:
        return columns
    exact = 0.5 * 10.0**-FULL
    return [replace(c, half_unit=exact * np.abs(c.values)) if np.all(c.values == c.values[0]) else c for c in columns]


def text_of(path: Path) -> str:
    """Text of a file, in the encoding of its mark, else in UTF-8 or Latin 1.

    Raises
    ------
    TableError
        If it holds other things than text.
    """
    content = path.read_bytes()
    marked = next((encoding for mark, encoding in MARKS.items() if content.startswith(mark)), None)
    if marked is None and b"\0" in content:
        raise TableError(f"{path.name} is no text; write the table as CSV")
    try:
        return content.decode(marked or "utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def cells(line: str, separator: str | None) -> list[str]:
    """Cells of a line; without a separator those between blanks, but none inside brackets."""
    if separator is not None:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True))
    return [cell.strip('"') for cell in re.findall(r'"[^"]*"|[^\s(\[]+(?:\s*(?:\([^)]*\)|\[[^\]]*\]))?', line)]


def check_row(file: str, line: int, row: list[str], names: list[str], separator: str | None) -> None:
    """Check that a row has a number for each name, and a decimal point in each number.

    Raises
    ------
    TableError
        With the line, and the cell.
    """
    if any(re.fullmatch(COMMA, cell) for cell in row) or len(row) == 2 * len(names):
        shown = next((cell for cell in row if re.fullmatch(COMMA, cell)), ",".join(row[:2]))
        raise TableError(f"{file}, line {line}: {shorten(shown)} has a decimal comma; {POINTS}")
    if len(row) != len(names):
        comma = f"; if it has decimal commas, {POINTS}" if separator == "," and len(row) > len(names) else ""
        raise TableError(f"{file}, line {line} has {plural(len(row), 'value')} for {len(names)} columns{comma}")
    for name, cell in zip(names, row, strict=True):
        if cell.strip() and not re.fullmatch(NUMBER, cell, re.IGNORECASE):
            raise TableError(f"{file}, line {line}: {shorten(cell)} in the column {shorten(name)} is no number")


def column(name: str, texts: list[str]) -> Column:
    """Column of texts; an empty one is not-a-number."""
    words = [re.sub("[dD]", "e", text.strip().lower()) or "nan" for text in texts]
    values = np.array([float(word) for word in words])
    digits = [written(word) for word in words if word.strip("+-")[0] in ".0123456789"]
    if not digits:
        return Column(name, values, np.zeros(len(values)))
    most = max(significant for significant, *_ in digits)
    half = half_of(values, most)
    if not any(exponent for *_, exponent in digits):
        half = np.maximum(half, 0.5 * 10.0 ** -max(decimals for _, decimals, _ in digits))
    return Column(name, values, half, most)


def half_of(values: Array, digits: int) -> Array:
    """Half a unit of a digit of each value, (n,), counted from its first; zero of a zero, and of what is no number."""
    with np.errstate(divide="ignore"):
        leading = np.floor(np.log10(np.abs(values)))
    return np.where(np.isfinite(leading), 0.5 * 10.0 ** (np.nan_to_num(leading, neginf=0.0) + 1.0 - digits), 0.0)


def written(word: str) -> tuple[int, int, bool]:
    """Significant digits and decimals of a number as it is written, and whether it has an exponent."""
    mantissa, exponent, _ = word.partition("e")
    whole, _, fraction = mantissa.lstrip("+-").partition(".")
    return len((whole + fraction).lstrip("0")), len(fraction), bool(exponent)
