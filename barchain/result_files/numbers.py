"""Numbers as programs write them, and what their digits tell.

The digits that were written are an error bar: half a unit in the last place. Zeros at the end may have been left out.
The numbers of a column therefore have as many decimals, or as many digits, as the one that shows most of them: of both
places the larger one counts. A column of one value says nothing about that: beside numbers in full, it is in full too.
Numbers of single precision are known to half a unit in the last place of 24 bits, however many digits were written. The
digits of each number decide whether it is one: programs write as few as tell it from its neighbours.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from scenarios.text import code_point, shorten

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from adapters.trajectory import Array

NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:e[+-]?[0-9]+)?")
NO_NUMBER = re.compile(r"[+-]?(?:nan(?:\(\w*\))?|inf(?:inity)?|1\.#\w+)|", re.ASCII)
"""Words for what is not finite, of Microsoft's libraries too; and nothing at all"""
MOST_CHARACTERS = 100
"""Of a number: the longest double that any program writes has some 40, and columns are as wide as their longest cell"""
LETTER = re.compile(r"[dq](?<=[0-9.].)(?=[+-]?[0-9])")
"""Letter of an exponent in Fortran's double and quadruple precision"""
NO_LETTER = re.compile(r"[+-](?<=[0-9.].)[0-9]{3}$", re.MULTILINE)
"""Exponent of three digits in Fortran, whose field has no room for a letter"""
SIGNS = str.maketrans("−–", "--")
"""Minus signs of typesetting: U+2212, and the dash U+2013"""
THOUSANDS = re.compile(r"[+-]?[0-9]{1,3}(?:[\s'’_,.][0-9]{3})+(?:[.,][0-9]*)?")
MAYBE_THOUSANDS = re.compile(r"[+-]?[1-9][0-9]{0,2}(?:,[0-9]{3})+")
POINTS = "write numbers with a decimal point and without other separators"
SINGLE_EVIDENCE = 12.0
"""Decimal logarithm of the odds against single precision by chance, from which on it is told"""
SHOWN_BY_SINGLES = 7
"""Digits above which a number of single precision may show more than it has: 24 bits are 7.2 digits"""
LEAST_PLACE, MOST_PLACE = -300, 300
"""Decimal places of last digits that are told from others: singles end at 1e-45 and 1e38"""
FULL = 15
"""Digits that every double keeps: a table that shows as many holds doubles in full"""
DATE = re.compile(r"[0-9]{1,4}[-/ ][0-9A-Za-z]{2,3}([-/ ][0-9]{2,4})?[T ]+[0-9]{1,2}:[0-9]{2}")
MONTH = re.compile(r"^([0-9]{1,2})[- ]([A-Za-z]{3})[- ]([0-9]{4})[T ]+")
CLOCK = re.compile(r"[0-9]+:[0-9]{2}:[0-9]{2}(\.[0-9]+)?")
DATES = ("ISO8601", "%d %b %Y %H:%M:%S.%f", "%Y-%jT%H:%M:%S.%f")
"""Forms of dates: ISO 8601, GMAT and STK, days of the year of CCSDS"""
DATES_ALLOWED = "date such as 2026-03-01T12:00:00, 01 Mar 2026 12:00:00 or 2026-060T12:00:00"


class CellError(ValueError):
    """A cell that is no number: its row from 0, and why not."""

    def __init__(self, row: int, reason: str) -> None:
        super().__init__(reason)
        self.row, self.reason = row, reason


@dataclass(frozen=True)
class Numbers:
    """Numbers of one column, as they stand in the file."""

    values: Array
    """(n,)"""
    half_unit: Array
    """(n,) half a unit in the last place written"""
    digits: int = 0
    """Most significant digits of a number"""
    single: bool = False
    """Whether all are numbers of single precision that were written with the digits of double precision"""
    maybe_single: bool = False
    """Whether all may be numbers of single precision: too few tell, or have the digits that would"""
    started: str = ""
    """First date, of a column of dates; the numbers count seconds from it"""


def words_of(texts: Sequence[str]) -> list[str]:
    """Texts of a column as Python writes numbers: in lower case, with ``-`` and with ``e`` before an exponent."""
    whole = "\n".join(map(str.strip, texts)).lower().translate(SIGNS)
    return NO_LETTER.sub(r"e\g<0>", LETTER.sub("e", whole)).split("\n")


def is_number(text: str) -> bool:
    """Whether a cell holds a number or a word for none; nothing is neither."""
    (word,) = words_of([text])
    return 0 < len(word) <= MOST_CHARACTERS and bool(NUMBER.fullmatch(word) or NO_NUMBER.fullmatch(word))


def decimal_comma(columns: Iterable[Sequence[str]]) -> bool:
    """Whether numbers have decimal commas.

    Raises
    ------
    ValueError
        If a comma may be either a decimal comma or a separator of thousands.
    """
    texts = [text.strip() for column in columns for text in column]
    with_comma = [text for text in texts if "," in text]
    if not with_comma:
        return False
    point = next((text for text in texts if "." in text and "," not in text and is_number(text)), None)
    if point is not None:
        raise ValueError(f"{shorten(with_comma[0])} has a comma, and {shorten(point)} a point; {POINTS}")
    if all(map(MAYBE_THOUSANDS.fullmatch, with_comma)):
        raise ValueError(f"{shorten(with_comma[0])} has a decimal comma, or separators of thousands; {POINTS}")
    return True


def numbers_of(texts: Sequence[str], *, decimal_comma: bool) -> Numbers:
    """Numbers of a column; an empty cell is not-a-number.

    Raises
    ------
    CellError
        With the first cell that is no number.
    """
    words = words_of(texts)
    for row, word in enumerate(words):
        if len(word) > MOST_CHARACTERS or not (NUMBER.fullmatch(word) or NO_NUMBER.fullmatch(word)):
            raise CellError(row, fault_of(texts[row]))
    if decimal_comma:
        words = [word.replace(",", ".") for word in words]
    there = np.array([word[-1:] in ".0123456789" and bool(word) for word in words])
    values = np.full(len(words), np.nan)
    written = np.array(words)[there]
    values[there] = written.astype(float)
    if not np.isfinite(values).any():
        return Numbers(values, np.zeros(len(values)))
    parts = np.char.partition(written, "e")
    bare = np.char.lstrip(parts[:, 0], "+-")
    point = np.char.find(bare, ".")
    decimals = np.where(point < 0, 0, np.char.str_len(bare) - point - 1)
    figures = np.char.lstrip(np.char.replace(bare, ".", ""), "0")
    most = int(np.char.str_len(figures).max())
    half = half_of(values, most)
    if not np.any(parts[:, 1] == "e"):
        half = np.maximum(half, 0.5 * 10.0 ** -float(decimals.max()))
    shown = np.char.str_len(np.char.rstrip(figures, "0")) > SHOWN_BY_SINGLES
    exponents = np.where(parts[:, 2] == "", "0", parts[:, 2]).astype(float)
    places = np.clip(exponents - decimals, LEAST_PLACE, MOST_PLACE)
    own_half = 0.5 * 10.0**places  # many programs write no more digits than a single needs
    maybe = may_be_single(values[there], own_half)
    single = maybe and is_single(values[there], own_half, shown)
    if single:
        values[there], half = as_singles(values[there]), np.maximum(half, half_single(values))
    return Numbers(values, half, most, single, maybe)


def half_of(values: Array, digits: int) -> Array:
    """Half a unit of a digit of each value, (n,), counted from its first; zero of a zero, and of what is no number."""
    seen = np.isfinite(values) & (values != 0.0)
    found = np.zeros(len(values))
    found[seen] = 0.5 * 10.0 ** (np.floor(np.log10(np.abs(values[seen]))) + 1.0 - digits)
    return found


def half_single(values: Array) -> Array:
    """Half a unit in the last place of single precision of each value, (n,)."""
    largest = float(np.finfo(np.float32).max)
    found: Array = 0.5 * np.spacing(np.minimum(np.abs(np.nan_to_num(values)), largest).astype(np.float32)).astype(float)
    return found


def may_be_single(values: Array, half: Array) -> bool:
    """Whether each of some finite numbers is one of single precision to `half` a unit in its own last place, (n,)."""
    if not np.abs(values).max() <= np.finfo(np.float32).max:
        return False
    return bool(np.all(np.abs(values - as_singles(values)) <= half + np.spacing(np.abs(values))))  # of ties, too


def as_singles(values: Array) -> Array:
    """Nearest numbers of single precision, (n,)."""
    found: Array = values.astype(np.float32).astype(float)
    return found


def is_single(values: Array, half: Array, shown: NDArray[np.bool_]) -> bool:
    """Whether numbers that may be of single precision show digits that it has not, beyond chance.

    Parameters
    ----------
    values, half : ndarray, shape (n,)
        Finite numbers, and half a unit in the last place of each as it stands there.
    shown : ndarray of bool, shape (n,)
        Which show more digits than single precision has, zeros at the end not counted.
    """
    _, first = np.unique(values, return_index=True)
    told = first[shown[first]]
    room = half_single(values[told]) / np.maximum(half[told], np.spacing(np.abs(values[told])))
    return bool(np.log10(np.maximum(room, 1.0)).sum() >= SINGLE_EVIDENCE)


def seconds_of_dates(texts: Sequence[str]) -> Numbers | None:
    """Seconds of dates from the first one, or of clocks ``h:mm:ss``; None of other texts.

    Raises
    ------
    CellError
        If some are no dates of the first one's form.
    """
    plain = pd.Series([text.strip().removesuffix("Z").replace(",", ".") for text in texts])
    first, clock = plain.iloc[0], CLOCK.fullmatch(plain.iloc[0])
    if not clock and not DATE.match(first):
        return None
    decimals = int(plain.str.extract(r":[0-9]+\.([0-9]+)$")[0].str.len().fillna(0).max())
    if clock:
        seconds = pd.to_timedelta(plain, errors="coerce").dt.total_seconds()
    else:
        whole = plain.str.replace(r"(:[0-9]{2}:[0-9]{2})$", r"\1.0", regex=True)
        whole = whole.str.replace(MONTH, r"\1 \2 \3 ", regex=True)
        read = (pd.to_datetime(whole, format=form, utc=True, errors="coerce") for form in DATES)
        dates = min(read, key=lambda each: int(each.isna().sum()))
        seconds = (dates - dates.iloc[0]).dt.total_seconds()
    values: Array = np.asarray(seconds, dtype=float)
    bad = np.flatnonzero(np.isnan(values))
    if len(bad):
        row = int(bad[0])
        raise CellError(row, f"{shorten(texts[row].strip())} is no {'time h:mm:ss' if clock else DATES_ALLOWED}")
    return Numbers(values, np.full(len(values), 0.5 * 10.0**-decimals), started="" if clock else first)


def fault_of(text: str) -> str:
    """Why a cell is no number: the character, or the convention."""
    cell = text.strip()
    shown = shorten(cell)
    if len(cell) > MOST_CHARACTERS:
        return f"a cell of {len(cell)} characters, {shorten(cell, 20)}, is no number"
    if cell.strip("*") == "":
        return f"{shown} is no number: Fortran writes * where a number does not fit its field"
    if THOUSANDS.fullmatch(cell):
        return f"{shown} has thousands separators; {POINTS}"
    if re.fullmatch(r"[+-]?[0-9.]+(e[+-]?[0-9]+)?[+-][0-9.]+(e[+-]?[0-9]+)?\*?[ij]", cell, re.IGNORECASE):
        return f"{shown} is a complex number"
    strange = next((c for c in cell if not c.isascii() and not c.isalpha()), None)
    if strange is not None:
        digit = "a digit of another script, " if unicodedata.decimal(strange, None) is not None else "the character "
        return f"{shown} is no number: it has {digit}{code_point(strange)}"
    return f"{shown} is no number"
