"""Text of a table as others write it: where its header and its rows are, and what separates the cells.

``line`` is a line of the file as an editor counts it, ``row`` a row of numbers, from 1.
"""

from __future__ import annotations

import csv
import gzip
import io
import re
import zlib
from collections import Counter
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from barchain.result_files.numbers import CellError, is_number
from barchain.result_files.units import is_unit
from scenarios.named_file import UnreadableError, decoded, read_named
from scenarios.plural import plural
from scenarios.text import cut, shorten, visible

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

MOST_BYTES = 1 << 27
"""A quarter of a million rows of twenty columns in full"""
MOST_LINES, MOST_CELLS = 1_000_000, 20_000_000
"""Of a table: a cell takes some 60 bytes in memory"""
JSON = re.compile(r'\s*(\{\s*"|\[\s*[\[{])')
ARCHIVE = b"PK\x03\x04"
SEPARATORS = ("\t", ";", ",", "|")
BLANKS = " \t,;\x1a"
"""Characters of lines that hold nothing; Ctrl-Z ends files of old programs"""
COMMENTS = ("#", "%", "!", "//")
LINE_END, UNICODE_END = re.compile(r"\r\n|\n|\r"), re.compile("[\u2028\u2029]")
"""Ends of lines, and those of files without these"""
SEPARATOR_LINE = re.compile(r'"?sep=(.)"?', re.IGNORECASE)
"""First line by which Excel is told the separator"""
HEADER_END = "endheader"
"""Last line of the block before the header, of OpenSim"""
MOST_BEFORE = 1000
"""Lines among which the block before a table is sought"""
BRACKETED = r"\([^()]{0,60}\)|\[[^\[\]]{0,60}\]|\{[^{}]{0,60}\}"
WORD = re.compile(rf'"[^"]*"|[^\s(\[{{]+(?:\s*(?:{BRACKETED}))*|{BRACKETED}|\S')
"""Name in a header of columns between blanks; none ends inside brackets"""
LETTER = re.compile(r"[^\W\d_]|°")
TOUCHING = re.compile(r"[0-9.][-+][0-9.]+[.][0-9]")
DATE_AND_TIME = re.compile(
    r"\b([0-9]{4}-[0-9]{2}-[0-9]{2}|[0-9]{4}/[0-9]{2}/[0-9]{2}|[0-9]{1,2}[ -][A-Z][a-z]{2}[ -][0-9]{4}) +"
    r"([0-9]{1,2}:[0-9]{2})"
)
MOST_NAMES, MOST_NAME = 20, 60
"""Names of columns in a message, and characters of each"""


class TableError(ValueError):
    """A file that is no table of samples; the message is one line."""


@dataclass(frozen=True)
class Table:
    """Cells of a table, n rows."""

    file: str
    names: list[str]
    """Of all columns; a column without a name has its number, from 1"""
    units: list[str]
    """Of a row of units below the header; empty without one"""
    columns: list[Sequence[str]]
    """(n,) texts each"""
    lines: list[int]
    """(n,) lines of the rows"""
    degrees: bool = False
    """Whether a block before the header says that rotations are in degrees"""
    named: bool = True
    """Whether there is a header"""

    def where(self, row: int) -> str:
        """``line 4 (row 3)`` of a row from 0."""
        return f"line {self.lines[row]} (row {row + 1})"

    def fault(self, column: int, error: CellError) -> TableError:
        """Error of a cell."""
        name = shorten(self.names[column])
        return TableError(f"{self.file}, {self.where(error.row)}, column {name}: {error.reason}")


def read_table(path: Path) -> Table:
    """Cells of a table in text.

    Raises
    ------
    TableError
        If the file can't be read, or is no such table; the message names the line.
    """
    file = visible(path.name, MOST_NAME)
    try:
        content = unpacked(read_named(path, MOST_BYTES))
        text = decoded(content, "latin-1").lstrip("\ufeff")
    except UnreadableError as error:
        raise TableError(f"{file}: {error}") from None
    archive = "a spreadsheet or an archive" if content.startswith(ARCHIVE) else ""
    if kind := archive or ("JSON" if JSON.match(text) else "no text" if "\0" in text else ""):
        raise TableError(f"{file} is {kind}; write the table as CSV")
    whole = (LINE_END if LINE_END.search(text) else UNICODE_END).split(text)
    if len(whole) > MOST_LINES:
        raise TableError(f"{file} has {len(whole)} lines, allowed: {MOST_LINES}")
    lines = [(k, line) for k, line in enumerate(whole, 1) if line.strip(BLANKS)]
    ended = [i for i, (_, line) in enumerate(lines[:MOST_BEFORE]) if line.strip(BLANKS).lower() == HEADER_END]
    block, lines = (lines[: ended[0]], lines[ended[0] + 1 :]) if ended else ([], lines)
    told = {re.sub(r"\s", "", line).lower() for _, line in block}
    given = SEPARATOR_LINE.match(lines[0][1]) if lines else None
    lines = lines[1:] if given else lines
    body = [(k, line) for k, line in lines if not line.lstrip().startswith(COMMENTS)]
    if not body:
        raise TableError(f"{file} has no rows")
    separator = given[1] if given else separator_of(most_digits(line for _, line in body[-5:]).strip(BLANKS))
    if separator is not None and text.count(separator) > MOST_CELLS:
        raise TableError(f"{file} has {text.count(separator)} cells, allowed: {MOST_CELLS}")
    try:
        rows = [(k, cells(line, separator)) for k, line in body]
        return table_of(file, lines, rows, separator, degrees="indegrees=yes" in told)
    except TableError:
        fixed = fixed_width(lines) if separator is None else None
        if fixed is None:
            raise
    return Table(file, *fixed)


def unpacked(content: bytes) -> bytes:
    """Content of a file that gzip may have compressed.

    Raises
    ------
    UnreadableError
        If it is damaged, or too large.
    """
    if not content.startswith(b"\x1f\x8b"):
        return content
    try:
        with gzip.open(io.BytesIO(content)) as packed:
            found = packed.read(MOST_BYTES + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise UnreadableError(f"can't be unpacked: {error}") from None
    if len(found) > MOST_BYTES:
        raise UnreadableError(f"more than {MOST_BYTES:.2g} bytes unpacked, allowed: at most that")
    return found


def most_digits(lines: Iterable[str]) -> str:
    """Line of most digits, which is no line below a table."""
    return max(lines, key=lambda line: sum(map(str.isdigit, line)))


def separator_of(line: str) -> str | None:
    """Separator of a row; None for blanks. ``0,5 1,5`` has decimal commas between blanks."""
    found = next((each for each in SEPARATORS if each in line), None)
    words = line.split()
    return None if found == "," and len(words) > 1 and all(map(is_number, words)) else found


def cells(line: str, separator: str | None) -> list[str]:
    """Cells of a row."""
    if separator is None:
        line = (
            DATE_AND_TIME.sub(lambda date: re.sub(r"\s+", "-", date[1]) + "T" + date[2], line) if ":" in line else line
        )
        return line.replace('"', " ").rstrip(BLANKS).split()
    if '"' not in line:
        return line.split(separator)
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a cell that is longer than any number or name
        return line.split(separator)


def table_of(
    file: str, lines: list[tuple[int, str]], rows: list[tuple[int, list[str]]], separator: str | None, *, degrees: bool
) -> Table:
    """Table of split rows, whose header is among the lines before the first row of numbers.

    Parameters
    ----------
    file : str
    lines : list of (int, str)
        All lines with their numbers from 1, comments among them.
    rows : list of (int, list of str)
        Cells of the lines that are no comments.
    separator : str or None
        None for blanks.
    degrees : bool

    Raises
    ------
    TableError
    """
    later = [row for _, row in rows[len(rows) // 2 :]]
    width = Counter(map(len, later)).most_common(1)[0][0]
    typical = [row for row in later if len(row) == width]
    full = [row for _, row in rows if len(row) == width]  # its header too: a column with a name is one
    while width > 1 and not any(row[width - 1].strip() for row in full):  # separators at the ends of rows
        width -= 1
    filled = max(typical[-5:], key=lambda row: sum(map(is_number, row)))
    numeric = [c for c in range(width) if is_number(filled[c])]
    start = next((i for i, (_, row) in enumerate(rows) if is_row(row, width, numeric)), None)
    if start is None or not numeric:
        touching = separator is None and any(TOUCHING.search(cell) for cell in filled)
        raise TableError(f"{file} has no row of numbers" + (f"; {hint(None, '', more=False)}" if touching else ""))
    first = rows[start][0]
    before = [(k, line) for k, line in lines if k < first]
    if not before and not all(is_number(rows[0][1][c]) or not rows[0][1][c].strip() for c in numeric):
        names, units, start = rows[0][1][:width], list[str](), 1  # a header with numbers among its names
    else:
        names, units = header_of(file, before, rows[start:], width, separator)
    if not rows[start:]:
        raise TableError(f"{file} has a header and no rows")
    for k, row in rows[start:]:
        if len(row) < width or any(cell.strip() for cell in row[width:]):
            why = hint(separator, dict(lines)[k], more=len(row) > width)
            raise TableError(f"{file}, line {k} has {plural(len(row), 'value')} for {width} columns; {why}")
    columns = list(zip(*(row[:width] for _, row in rows[start:]), strict=True))
    return Table(
        file, names or [str(c + 1) for c in range(width)], units, [*columns], [k for k, _ in rows[start:]], degrees,
        bool(names),
    )  # fmt: skip


def is_row(row: list[str], width: int, numeric: list[int]) -> bool:
    """Whether a row has numbers where others have, or at least in half of these columns."""
    if len(row) < width or any(cell.strip() for cell in row[width:]):
        return False
    found = sum(is_number(row[c]) for c in numeric)
    return found > 0 and 2 * (found + sum(not row[c].strip() for c in numeric)) > len(numeric)


def hint(separator: str | None, line: str, *, more: bool) -> str:
    """What may be wrong with a line of more or fewer cells than others."""
    if line.count('"') % 2:
        return "a quotation mark is not closed"
    if separator == "," and more:
        return "if it has decimal commas, write numbers with a decimal point, or semicolons between the cells"
    if separator is None:
        return "where columns touch, or hold blanks, write commas between the cells"
    return "allowed: as many as in the other rows; a line that begins with # is left out"


def header_of(
    file: str, before: list[tuple[int, str]], rows: list[tuple[int, list[str]]], width: int, separator: str | None
) -> tuple[list[str], list[str]]:
    """Names of the columns, and their units where a row of them is below the names; empty without a header.

    Parameters
    ----------
    file : str
    before : list of (int, str)
        Lines before the first row, comments among them.
    rows : list of (int, list of str)
    width : int
        Number of columns.
    separator : str or None

    Raises
    ------
    TableError
        If the nearest line is no comment, and has another number of names.
    """
    numbered = [row[:1] for _, row in rows] == [[str(k)] for k in range(1, len(rows) + 1)]
    found = list[list[str]]()
    for k, line in reversed(before[-MOST_BEFORE:]):
        names = names_of(line, width, separator)
        if names is None and numbered:  # R writes the numbers of rows, and no name above these
            short = names_of(line, width - 1, separator)
            names = None if short is None else ["", *short]
        if names is not None:
            found.append(names)
        elif not found and LETTER.search(line) and not line.lstrip().startswith(COMMENTS):
            given = cells(line, separator)
            where = f"line {k} has {plural(len(given), 'name')}"
            raise TableError(f"{file}, {where} for {width} columns; {hint(separator, line, more=width > len(given))}")
        if len(found) == 2:
            break
    names, units = (*found, [], [])[:2]
    if any(map(is_unit, filter(str.strip, names))) and units and not any(map(is_unit, units)):
        names, units = units, names
    elif not all(map(is_unit, units)):
        units = []
    return [" ".join(name.split()).strip("'\"") or str(c) for c, name in enumerate(names, 1)], units


def names_of(line: str, width: int, separator: str | None) -> list[str] | None:
    """Names in a header of `width` columns, whatever separates them; None of another line."""
    if not LETTER.search(line):
        return None
    line = line.strip().lstrip("".join(COMMENTS)).strip(" ")
    for each in dict.fromkeys((separator, *SEPARATORS, None)):
        split = [word.strip('"') for word in WORD.findall(line)] if each is None else cells(line, each)
        while len(split) > width and not split[-1].strip():
            split.pop()
        if len(split) == width and any(map(str.strip, split)) and 2 * sum(map(is_number, split)) < width:
            return split
    apart = re.split(r"\s{2,}", line)
    return apart if len(apart) == width and not any(map(is_number, apart)) else None


def fixed_width(lines: list[tuple[int, str]]) -> tuple[list[str], list[str], list[Sequence[str]], list[int]] | None:
    """Names, units, columns and lines of a table whose columns stand where its names begin, or end; else None."""
    k = next((i for i, (_, line) in enumerate(lines) if not line.lstrip().startswith(COMMENTS)), 0)
    words = list(re.finditer(r"\S+", lines[k][1].lstrip("".join(COMMENTS)).rjust(len(lines[k][1]))))
    rows = [(n, line) for n, line in lines[k + 1 :] if not line.lstrip().startswith(COMMENTS)]
    begins = [0, *(word.start() for word in words[1:]), None]
    ends = [0, *(word.end() for word in words[:-1]), None]
    for cuts in (begins, ends):
        apart = [
            sum(line[:cut].endswith(" ") or line[cut:].startswith(("-", "+")) for _, line in rows) for cut in cuts[1:-1]
        ]
        if 2 * min(apart, default=0) < len(rows):  # it cuts through numbers
            continue
        spans = [slice(a, b) for a, b in pairwise(cuts)]
        found = [[line[span].strip() for span in spans] for _, line in rows]
        kinds = {tuple(map(is_number, row)) for row in found}
        if len(kinds) == 1 and sum(next(iter(kinds))) >= 2 and all(all(row) for row in found):
            return [word.group() for word in words], [], [*zip(*found, strict=True)], [n for n, _ in rows]
    return None


def listed(names: Sequence[str]) -> str:
    """Names of columns in a message: so many that they can be read, and the number of the others."""
    shown = ", ".join(cut(visible(name), MOST_NAME) for name in names[:MOST_NAMES])
    more = len(names) - MOST_NAMES
    return f"{shown} and {more} more" if more > 0 else shown
