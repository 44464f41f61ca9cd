"""Random damage of files, the same for a number in each session: to bytes, to values of JSON, to rows of a table."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import random
    from collections.abc import Callable

CONTENTS = (
    b"", b"\0", b"[]", b"{}", b"null", b"1", b'"x"', b"earlier results", b"[" * 100_000, b"9" * 5000, b"a = 1\n",
    bytes(range(256)) * 8, bytes(4096), b"\xef\xbb\xbf{}", "é,ü\n1,2\n".encode("latin-1"),
    "a,b\n1,2\n".encode("utf-16"),
)  # fmt: skip
"""Files of something else"""
VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 10**400, -1e308, 1e-308, float("nan"), float("inf"), "", "x", "٣", "\u2028", "\x1b[2J",
    "é" * 5000, "../x", [], {}, [[]], [1], {"a": 1}, "9" * 5000, "0001-01-01T00:00:00", "9999-12-31T23:59:59Z",
)  # fmt: skip
"""Values in place of another one"""
CELLS = (
    "", "nan", "inf", "-inf", "1e999", "1e-999", "9" * 400, "1" * 5000, "1,5", "1.5.2", "x", '"', "#", "=1+1", "1e5e5",
    "0x1f", "1d3", "--1", "1_000", "١٢", "１２", "½", "1\u2028", "\u202e1", "\0", "true", "2026-01-01", "12:30", "1+",
    "é" * 3000,
)  # fmt: skip
"""Cells in place of a number"""
UNITS = (
    "[deg]", "[rad]", "[km]", "[h]", "[furlong]", "[", "]", "[m/s]", "(rad)", "{deg}", " in deg", f"[{'k' * 5000}]",
)  # fmt: skip
"""Units behind the name of a column"""


def damaged_bytes(content: bytes, draw: random.Random) -> bytes:
    """Bytes with one damage."""
    at, other = sorted(draw.randrange(len(content) + 1) for _ in range(2))
    bit = bytearray(content or b"\0")
    bit[min(at, len(bit) - 1)] ^= 1 << draw.randrange(8)
    return draw.choice((
        bytes(bit), bytes(bit), content[:at], content[at:], content[:at] + content[other:],
        content[:other] + content[at:],
        content[:at] + draw.randbytes(draw.choice((1, 2, 8, 100))) + content[at:], content + content,
        draw.choice(CONTENTS),
    ))  # fmt: skip


def damaged_json(content: bytes, draw: random.Random) -> bytes:
    """JSON with another value, or without one, in a random place."""
    whole = json.loads(content)
    places: list[tuple[Any, Any]] = []
    waiting = [whole]
    while waiting:
        inside = waiting.pop()
        keys = inside.keys() if isinstance(inside, dict) else range(len(inside)) if isinstance(inside, list) else ()
        places += [(inside, key) for key in keys]
        waiting += [inside[key] for key in keys]
    if not places:
        return damaged_bytes(content, draw)
    inside, key = draw.choice(places)
    if draw.random() < 0.2:
        del inside[key]
    else:
        inside[key] = draw.choice(VALUES)
    return json.dumps(whole).encode("utf-8", "surrogatepass")


def damaged_table(content: bytes, draw: random.Random) -> bytes:
    """CSV with one to three damages."""
    rows = [line.split(",") for line in content.decode().splitlines()]
    for _ in range(draw.randint(1, 3)):
        draw.choice(TABLE)(rows, draw)
    text = draw.choice((",",) * 8 + (";", "\t", " ", "|", ", ")).join
    made = draw.choice(("\n",) * 8 + ("\r\n", "\r", "\u2028", "\n\n")).join(map(text, rows)) + "\n"
    whole = made.encode(draw.choice(("utf-8",) * 8 + ("utf-16", "utf-8-sig", "utf-32")), "replace")
    return damaged_bytes(whole, draw) if draw.random() < 0.3 else whole


def place(rows: list[list[str]], draw: random.Random, first: int = 0) -> tuple[int, int]:
    """Random row, from one on, and a column there."""
    row = draw.randrange(min(first, len(rows) - 1), len(rows))
    return row, draw.randrange(max(1, len(rows[row])))


def odd_cell(rows: list[list[str]], draw: random.Random) -> None:
    row, column = place(rows, draw, 1)
    rows[row][column : column + 1] = [draw.choice(CELLS)]


def odd_column(rows: list[list[str]], draw: random.Random) -> None:
    _, column = place(rows, draw)
    cell = draw.choice((*CELLS, "0", "1e200", "-1"))
    for row in rows[1:]:
        row[column : column + 1] = [cell]


def scaled_column(rows: list[list[str]], draw: random.Random) -> None:
    _, column = place(rows, draw)
    factor = draw.choice((0.0, -1.0, 1e-6, 57.29577951308232, 1e3, 1e200, 1e-300))
    for row in rows[1:]:
        try:
            row[column] = repr(float(row[column]) * factor)
        except (ValueError, IndexError):
            continue


def swapped_columns(rows: list[list[str]], draw: random.Random) -> None:
    (_, a), (_, b) = place(rows, draw), place(rows, draw)
    for row in rows[draw.choice((0, 1)) :]:
        if max(a, b) < len(row):
            row[a], row[b] = row[b], row[a]


def swapped_cells(rows: list[list[str]], draw: random.Random) -> None:
    (i, a), (j, b) = place(rows, draw, 1), place(rows, draw, 1)
    if rows[i][a:] and rows[j][b:]:
        rows[i][a], rows[j][b] = rows[j][b], rows[i][a]


def without_column(rows: list[list[str]], draw: random.Random) -> None:
    _, column = place(rows, draw)
    for row in rows:
        del row[column : column + 1]


def doubled_column(rows: list[list[str]], draw: random.Random) -> None:
    _, column = place(rows, draw)
    for row in rows:
        row.extend(row[column : column + 1])


def without_rows(rows: list[list[str]], draw: random.Random) -> None:
    first, last = sorted(draw.randrange(len(rows) + 1) for _ in range(2))
    if last - first < len(rows):
        del rows[first:last]


def doubled_rows(rows: list[list[str]], draw: random.Random) -> None:
    row, _ = place(rows, draw)
    rows[row:row] = [list(rows[row])] * draw.choice((1, 1, 2, 300))


def shuffled_rows(rows: list[list[str]], draw: random.Random) -> None:
    draw.shuffle(rows)


def odd_name(rows: list[list[str]], draw: random.Random) -> None:
    name = draw.choice(("t_s", "angle_1_rad", "angle_99999999999_rad", "reaction_0_x_N", "x" * 5000, *UNITS, *CELLS))
    if rows[0]:
        column = draw.randrange(len(rows[0]))
        rows[0][column] = draw.choice((name, rows[0][column].rpartition("_")[0] + name))


TABLE: tuple[Callable[[list[list[str]], random.Random], None], ...] = (
    odd_cell, odd_cell, odd_column, scaled_column, swapped_columns, swapped_cells, without_column, doubled_column,
    without_rows, doubled_rows, shuffled_rows, odd_name, odd_name,
)  # fmt: skip
"""Damages of the rows of a table, the names of the columns among them"""
