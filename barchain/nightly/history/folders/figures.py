"""Figures of a night from the rows of a result folder, by the rules that each study declares."""

from __future__ import annotations

import math
from string import Formatter
from typing import TYPE_CHECKING, Any

from barchain.nightly.history.changes.steps import LEAST_EFFECT
from barchain.nightly.history.folders.merging import standing
from barchain.nightly.history.model.figures import WORDED, Figure, FigureIdentity, FigureKind, FigureUnit
from barchain.nightly.history.model.parts import depends_on
from reports.tables.crossval import FILES as COMPARISON
from reports.tables.crossval import is_engine
from reports.tables.reading import brief
from reports.tables.rows import BITS, NOT_COMPARED, NOT_RUN, RELATIVE_TO, is_count, parsed_tags, records

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd

    from reports.tables.rows import Followed, Row

NO_NUMBER = "no number is stored"
STUDY_SEPARATOR = "."
PAGE_B = 4096
LEAST_MEMORY_B = PAGE_B / LEAST_EFFECT
"""Least peak memory that is followed: of a smaller one, a page more or less would be a step"""
Key = tuple[str, ...]


def figures_of(rows: pd.DataFrame, followed: Mapping[str, Followed]) -> tuple[Figure, ...]:
    """Figures of the rows of one study.

    Of two rows of one name, which differ in what the name leaves out, a rule of their kind says which stands.

    Parameters
    ----------
    rows : DataFrame
        Columns of :mod:`reports.tables.rows`.
    followed : mapping
        Rule of each metric that nights follow.
    """
    every = {key_of(row): row for row in records(rows)}
    depends: dict[tuple[str, str, FigureKind, str], Key] = {}
    found: dict[FigureIdentity, Figure] = {}
    for row in every.values():
        rule = followed.get(row["metric"])
        identity = None if rule is None else identity_of(row, rule)
        if rule is None or identity is None:
            continue
        parts = (identity.scene, identity.engine, identity.kind, identity.anchor)
        if parts not in depends:
            depends[parts] = depends_on(*parts)
        worded = identity.kind in WORDED
        figure = word(identity, row, depends[parts]) if worded else number(identity, row, rule, every, depends[parts])
        there = found.setdefault(identity, figure)
        if there is not figure and identity.kind is FigureKind.VERDICT:
            found[identity] = standing(there, figure)
    return tuple(found.values())


def key_of(row: Row, **other: str) -> Key:
    """Identity of a row, or that of a row that differs in some columns."""
    columns = ("scene", "engine", "setting", "tags", "quantity", "metric")
    return tuple(str(other.get(name, row[name])) for name in columns)


def identity_of(row: Row, rule: Followed) -> FigureIdentity | None:
    """Identity of a row's figure; None of a row that is not followed: about several engines, or not worth it."""
    kind, value = FigureKind(rule.kind), row["value"]
    several = row["scene"].startswith("(") or (row["study"] == COMPARISON.name and not is_engine(row["engine"]))
    unknown_unit = row["unit"] not in set(FigureUnit)
    small = kind is FigureKind.MEMORY and value < LEAST_MEMORY_B
    broken = kind is FigureKind.COUNT and not is_count(value)
    if several or unknown_unit or small or broken or {row["engine"], row["quantity"]} & set(rule.besides):
        return None
    tags = parsed_tags(row["tags"])
    filled = Filled()
    parts = [filled.vformat(part, (), row | tags) for part in rule.quantity.split(STUDY_SEPARATOR)]
    quantity = STUDY_SEPARATOR.join(part for part in (study_of(row), *parts) if part)
    setting, anchor = filled.vformat(rule.setting, (), row | tags), str(tags.get(RELATIVE_TO, ""))
    unit = FigureUnit.NONE if kind in WORDED else FigureUnit(row["unit"] or "1")
    scene, engine, setting, quantity = map(brief, (row["scene"], row["engine"], setting, quantity))
    relative = brief(anchor) if kind is FigureKind.RATIO else ""
    return FigureIdentity(scene, engine, setting, quantity, kind, unit, relative)


def study_of(row: Row) -> str:
    """Study that begins a quantity's name; a comparison's has none."""
    return "" if row["study"] == COMPARISON.name else str(row["study"])


class Filled(Formatter):
    """Templates of names: text that a row lacks is empty, a number that it lacks ``nan``."""

    def get_value(self, key: int | str, args: Any, kwargs: Any) -> Any:  # noqa: ARG002  # the signature of Formatter
        """Column or tag of a row."""
        return kwargs.get(key, math.nan)

    def format_field(self, value: Any, format_spec: str) -> str:
        """Text of a value."""
        if not format_spec and isinstance(value, float) and math.isnan(value):
            return ""
        return format(value, format_spec)


def word(identity: FigureIdentity, row: Row, parts: Key) -> Figure:
    """Figure of a digest or an outcome; without one it is missing, for the row's reason."""
    if identity.kind is FigureKind.BITS:
        found, reason = row["text"], "" if row["text"] else row["reason"] or row["outcome"]
    elif row["outcome"] == NOT_RUN:
        found, reason = "", reason_of(row)
    else:
        found, reason = row["outcome"], row["reason"]
    return Figure(identity, word=found, reason=brief(reason) or ("" if found else NO_NUMBER), depends=parts)


def number(identity: FigureIdentity, row: Row, rule: Followed, every: Mapping[Key, Row], parts: Key) -> Figure:
    """Figure of a number; one that is not finite, or that tells nothing, is missing for the row's reason."""
    value = real(row["value"])
    if value is None or row["outcome"] in {NOT_RUN, NOT_COMPARED}:
        return Figure(identity, reason=brief(reason_of(row)) or NO_NUMBER, depends=parts)
    within = every.get(key_of(row, metric=rule.within)) if rule.within else None
    bits = every.get(key_of(row, tags="", quantity="", metric=BITS)) if rule.trajectory else None
    return Figure(
        identity, value, "", real(row["low"]), real(row["high"]), None if within is None else real(within["value"]),
        "" if bits is None else bits["text"], parts,
    )  # fmt: skip


def reason_of(row: Row) -> str:
    """Why a row has no result: its reason, else its outcome; of what was not run both."""
    if row["outcome"] == NOT_RUN:
        return f"{NOT_RUN}: {row['reason']}"
    return str(row["reason"] or row["outcome"])


def real(value: Any) -> float | None:
    """Finite number, or None."""
    return float(value) if math.isfinite(value) else None
