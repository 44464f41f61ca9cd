"""Rows: one relation for everything that a study measured or judged, in ``rows/<study>.parquet`` of a result folder.

Each row is one number, one outcome or one text. ``study`` to ``metric`` are its identity, which no two rows share:

``study``, ``scene``, ``engine``, ``setting``
    empty where a row belongs to none; a name in parentheses stands for several;
``tags``
    all else that tells rows apart, as sorted text such as ``bars=100;fault=mu``; :func:`spread` makes columns of it.
    The tag ``relative_to`` names what a ratio is relative to, ``role`` any but the main run;
``quantity``, ``metric``
    what was measured, and in which sense: ``reaction`` and ``max``, ``steps`` and ``count``;
``value``, ``low``, ``high``, ``unit``
    number and its interval, in SI units; NaN without one;
``limit``
    largest value that passes;
``outcome``, ``reason``
    word of a closed set, and why; :data:`NOT_RUN`, :class:`NotRun` and :data:`NOT_COMPARED` are outcomes;
``text``
    a digest of bits, a method, a name;
``until_s``
    time up to which samples were compared, s.
"""

from __future__ import annotations

import hashlib
import math
import re
from enum import StrEnum
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard

import numpy as np

from reports.results.reading import DIGITS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    import pandas as pd

FOLDER = "rows"
IDENTITY = ("study", "scene", "engine", "setting", "tags", "quantity", "metric")
NUMBERS = ("value", "low", "high", "limit", "until_s")
COLUMNS = (*IDENTITY, "value", "low", "high", "unit", "limit", "outcome", "reason", "text", "until_s")
NOT_RUN = "not run"
"""Outcome of what a study left out, for the row's reason, and begin of :class:`NotRun`"""
NOT_COMPARED = "not compared"
"""Outcome of a number that was measured and tells nothing, for the row's reason"""
RELATIVE_TO = "relative_to"
MOST_WHOLE = 1e15
"""Numbers below are whole without a point"""
TAG = re.compile(r"[a-z][a-z0-9_]*")
Row = dict[str, Any]


class NotRun(StrEnum):
    """Outcomes of what a study left out, where the cause decides on other runs."""

    LIMIT = "not run: time limit"
    """It would take longer than a run may, or a coarser one did"""
    BUDGET = "not run: budget"
    """The time of the study is used, or so much of it that a run may take less"""
    BLURRED = "not run: blurred"
    """Its error would be below that of the solution which it is compared with"""


def was_run(outcome: str) -> bool:
    """Whether an outcome is that of a run."""
    return not outcome.startswith(NOT_RUN)


class RowError(ValueError):
    """Raised for a row that breaks the rules of the relation; the message is one line."""


class Followed(NamedTuple):
    """Rule by which nights follow a metric, and the names of its figures there.

    Names are templates, filled with the columns and tags of a row: ``{bars:g}`` is a tag. Parts of a quantity's name
    between dots are left out where they are empty.
    """

    kind: str
    """Rule of change: bits, error, verdict, count, ratio, memory or value"""
    quantity: str = "{metric}"
    setting: str = "{setting}"
    within: str = ""
    """Metric of the same quantity: the largest change that rounding may cause"""
    trajectory: bool = False
    """Whether the figure follows from the main run's trajectory"""
    besides: tuple[str, ...] = ()
    """Engines and quantities that are not followed"""


MAIN, FINER = "main", "finer"
"""Roles of the runs whose bits are rows"""
BITS, COUNT = "trajectory", "count"
RUNS_FOLLOWED = {BITS: Followed("bits", "{metric}.{role}"), COUNT: Followed("count", "{level}.{quantity}")}
"""How nights follow the rows of runs"""


class Rows:
    """Rows of one study, collected in their order."""

    def __init__(self, study: str, scene: str = "") -> None:
        """Begin without rows; `scene` is that of all rows that name no other."""
        self.study, self.scene = study, scene
        self.found: list[Row] = []

    def add(
        self,
        metric: str,
        value: float | None = None,
        unit: str = "1",
        *,
        scene: str | None = None,
        engine: str = "",
        setting: str = "",
        quantity: str = "",
        low: float | None = None,
        high: float | None = None,
        limit: float | None = None,
        outcome: str = "",
        reason: str = "",
        text: str = "",
        until_s: float | None = None,
        **tags: Any,
    ) -> None:
        """Add a row; the unit of a row without a number is empty, and `tags` that are empty are left out."""
        place = self.scene if scene is None else scene
        numbers = {"value": value, "low": low, "high": high, "limit": limit, "until_s": until_s}
        self.found.append({
            "study": self.study, "scene": place, "engine": engine, "setting": setting, "tags": tag_text(tags),
            "quantity": quantity, "metric": metric, "unit": "" if value is None else unit, "outcome": outcome,
            "reason": reason, "text": text, **{name: number(found) for name, found in numbers.items()},
        })  # fmt: skip

    def frame(self) -> pd.DataFrame:
        """All rows as a table.

        Raises
        ------
        RowError
            If two rows have one identity.
        """
        import pandas as pd  # noqa: PLC0415

        frame = typed(pd.DataFrame(self.found, columns=list(COLUMNS)))
        twice = frame[frame.duplicated(list(IDENTITY))]
        if len(twice):
            raise RowError(f"two rows have one identity: {', '.join(map(str, twice[list(IDENTITY)].iloc[0]))}")
        return frame


def typed(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows whose columns have the types of the relation."""
    return frame.astype({c: "float64" if c in NUMBERS else object for c in COLUMNS})


def known(value: Any) -> TypeGuard[float]:
    """Whether a cell of a table holds a finite number."""
    return isinstance(value, (int, float)) and math.isfinite(value)


def number(value: Any) -> float:
    """Number of a cell; NaN of an empty one."""
    return math.nan if value is None else float(value)


def tag_text(tags: Mapping[str, Any]) -> str:
    """Tags as sorted text.

    Raises
    ------
    RowError
        If a name is no lower-case word, or a text holds ``;``, ``=``, a line break, or a blank at an end.
    """
    parts = []
    for name, value in sorted(tags.items()):
        text = value_text(value)
        if not TAG.fullmatch(name):
            raise RowError(f"tag {name!r} given, allowed: lower-case letters, digits and _")
        if text != text.strip() or any(sign in str(value) for sign in ';="\n\r'):
            raise RowError(
                f'{name}: {text!r} given, allowed: a text without ; = " or line breaks, no blank at its ends'
            )
        if text:
            parts.append(f"{name}={text}")
    return ";".join(parts)


def value_text(value: Any) -> str:
    """Value of a tag as text; empty of None and NaN.

    A whole number has no point, any other is written by repr; a text that reads as a number stands in quotes.
    """
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, float):
        return repr(int(value)) if value.is_integer() and abs(value) < MOST_WHOLE else repr(float(value))
    text = str(value)
    return f'"{text}"' if isinstance(value, str) and as_number(text) is not None else text


def parsed_tags(text: str) -> dict[str, str | float]:
    """Tags of a row by name: numbers as float, all else as text."""
    pairs = (part.partition("=") for part in text.split(";")) if text else ()
    return {name: value.strip('"') if (found := as_number(value)) is None else found for name, _, value in pairs}


def as_number(text: str) -> float | None:
    """Number that a text is; None of any other text."""
    try:
        return float(text)
    except ValueError:
        return None


def spread(frame: pd.DataFrame) -> pd.DataFrame:
    """Rows with a column for each tag in place of ``tags``: numbers where all values are numbers, else text.

    Parameters
    ----------
    frame : DataFrame
        Rows, with the column ``tags``.

    Returns
    -------
    DataFrame
        Empty text, or NaN in a column of numbers, where a row lacks the tag. A tag of the name of a column gets the
        name ``tag_<name>``.
    """
    import pandas as pd  # noqa: PLC0415

    each = [parsed_tags(text) for text in frame["tags"]]
    found = frame.drop(columns="tags")
    for name in sorted({name for tags in each for name in tags}):
        column = pd.Series([tags.get(name) for tags in each], index=frame.index, dtype=object)
        numeric = all(isinstance(value, float) for value in column.dropna())
        found[f"tag_{name}" if name in frame else name] = (
            column.astype(float) if numeric else column.fillna("").astype(str)
        )
    return found


def records(rows: pd.DataFrame | Iterable[Row]) -> list[Row]:
    """Rows of a table as plain Python values; rows that are such already, as they are."""
    import pandas as pd  # noqa: PLC0415

    if not isinstance(rows, pd.DataFrame):
        return list(rows)
    names = list(map(str, rows.columns))
    return [dict(zip(names, values, strict=True)) for values in rows.itertuples(index=False, name=None)]


def plain(frame: pd.DataFrame) -> list[Row]:
    """Rows of a table as plain Python values, None for NaN."""
    return [
        {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in row.items()} for row in records(frame)
    ]


def add_runs(found: Rows, record: Mapping[str, Any]) -> None:
    """Add the rows of all runs in a record: seconds of each phase, digests of bits, and what the engine tells."""
    named = {tuple(run[k] for k in ("scene", "engine", "setting", "role")): run for run in record.get("runs") or ()}
    for (scene, engine, setting, role), run in named.items():
        place: dict[str, Any] = {"scene": scene, "engine": engine, "setting": setting}
        where = place if role == MAIN else place | {"role": role}
        for phase, seconds in run.get("seconds", {}).items():
            found.add("seconds", seconds, "s", quantity=phase, **where)
        if role in (MAIN, FINER):
            found.add(BITS, text=run["bits"], outcome=run["outcome"], reason=run.get("reason", ""), **where)
        if role == MAIN:
            add_info(found, run.get("info", {}), **where)


def add_info(found: Rows, info: Mapping[str, Any], **where: Any) -> None:
    """Add what an engine tells of a run: whole numbers as counts, other numbers as values, words as texts."""
    for name, value in info.items():
        if isinstance(value, str):
            found.add(name, text=value, **where)
        elif known(value) and not isinstance(value, bool):
            whole = is_count(value) and not name.endswith("_s")
            found.add(COUNT if whole else "value", value, "s" if name.endswith("_s") else "1", quantity=name, **where)


def is_count(value: float) -> bool:
    """Whether a number is whole and not negative."""
    return math.isfinite(value) and value == int(value) and value >= 0.0


def frame_digest(frame: pd.DataFrame) -> str:
    """Digest of a trajectory's numbers, bit for bit; how they are stored does not count."""
    found = hashlib.sha256()
    for name in sorted(map(str, frame.columns)):
        values = np.ascontiguousarray(frame[name].to_numpy(np.float64), dtype="<f8")
        found.update(f"{name}\0{len(values)}\0".encode() + values.tobytes())
    return found.hexdigest()[:DIGITS]
