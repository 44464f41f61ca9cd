"""Tables of the history. The migrations make them; a test compares both."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING, Any

from sqlalchemy import (
    Boolean,
    CheckConstraint,
    Column,
    DateTime,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
)
from sqlalchemy.types import TypeDecorator

if TYPE_CHECKING:
    from sqlalchemy.engine.interfaces import Dialect

HEAD = "0003"
"""Revision of the migrations that these tables belong to"""
NAMES = {
    "ix": "ix_%(table_name)s_%(column_0_name)s",
    "uq": "uq_%(table_name)s_%(column_0_name)s",
    "ck": "ck_%(table_name)s_%(constraint_name)s",
    "fk": "fk_%(table_name)s_%(column_0_name)s",
    "pk": "pk_%(table_name)s",
}
metadata = MetaData(naming_convention=NAMES)


class UtcTime(TypeDecorator[datetime.datetime]):
    """Date and time in UTC; stored without an offset, so that both databases order and compare alike."""

    impl = DateTime
    cache_ok = True

    def process_bind_param(self, value: datetime.datetime | None, dialect: Dialect) -> Any:  # noqa: ARG002
        """Value as it is stored."""
        return None if value is None else value.astimezone(datetime.UTC).replace(tzinfo=None)

    def process_result_value(self, value: Any, dialect: Dialect) -> datetime.datetime | None:  # noqa: ARG002
        """Value with its offset."""
        return None if value is None else value.replace(tzinfo=datetime.UTC)


def number_of(name: str) -> Column[int]:
    """Column that numbers the rows of a table."""
    return Column(name, Integer, primary_key=True, autoincrement=True)


environments = Table(
    "environments",
    metadata,
    number_of("id"),
    Column("digest", String(64), nullable=False, unique=True),
    Column("machine_class", String(16), nullable=False),
    Column("cpu", Text, nullable=False),
    Column("cpu_flags", Text, nullable=False),
    Column("cores", Integer, nullable=False),
    Column("architecture", Text, nullable=False),
    Column("kernel", Text, nullable=False),
    Column("libc", Text, nullable=False),
    Column("blas", Text, nullable=False),
    Column("python", Text, nullable=False),
)

nights = Table(
    "nights",
    metadata,
    number_of("id"),
    Column("identity", String(64), nullable=False, unique=True),
    Column("name", String(40), nullable=False, unique=True),
    Column("started", UtcTime, nullable=False, index=True),
    Column("duration_s", Float(53), nullable=False),
    Column("plan", Text, nullable=False),
    Column("barchain", Text, nullable=False),
    Column("source_commit", Text),
    Column("environment_id", ForeignKey("environments.id"), nullable=False),
    Column("complete", Boolean(create_constraint=False), nullable=False),
    Column("void", Text),
    Column("figures", Integer, nullable=False),
    CheckConstraint("duration_s >= 0", name="duration"),
    sqlite_autoincrement=True,
)

runs = Table(
    "runs",
    metadata,
    Column("night_id", ForeignKey("nights.id", ondelete="CASCADE"), primary_key=True, autoincrement=False),
    Column("plan", Text, nullable=False),
    Column("content", Text, nullable=False),
)
"""What a night did of its plan, as JSON"""

judgements = Table(
    "judgements",
    metadata,
    Column("night_id", ForeignKey("nights.id", ondelete="CASCADE"), primary_key=True, autoincrement=False),
    Column("worse", Integer, nullable=False),
    Column("changes", Integer, nullable=False),
    Column("judged", Integer, nullable=False),
)
"""Numbers of changes that each night told when it was judged last: for the calendar"""

parts = Table(
    "parts",
    metadata,
    number_of("id"),
    Column("name", Text, nullable=False),
    Column("version", Text, nullable=False),
    Column("digest", Text, nullable=False),
    UniqueConstraint("name", "version", "digest"),
)

night_parts = Table(
    "night_parts",
    metadata,
    Column("night_id", ForeignKey("nights.id", ondelete="CASCADE"), primary_key=True),
    Column("part_id", ForeignKey("parts.id"), primary_key=True, index=True),
    sqlite_with_rowid=False,
)

series = Table(
    "series",
    metadata,
    number_of("id"),
    Column("digest", String(64), nullable=False, unique=True),
    Column("scene", Text, nullable=False),
    Column("engine", Text, nullable=False),
    Column("setting", Text, nullable=False),
    Column("quantity", Text, nullable=False),
    Column("kind", String(10), nullable=False),
    Column("unit", String(10), nullable=False),
    Column("anchor", Text, nullable=False),
    CheckConstraint("kind IN ('bits', 'error', 'verdict', 'count', 'ratio', 'memory', 'value')", name="kind"),
    CheckConstraint("unit IN ('', '1', 'm', 'm/s', 'rad', 'rad/s', 'N', 'N m', 'N s', 's', 'B')", name="unit"),
)

texts = Table(
    "texts",
    metadata,
    number_of("id"),
    Column("digest", String(64), nullable=False, unique=True),
    Column("text", Text, nullable=False),
)
"""Outcomes, digests, reasons and lists of parts: each text once"""

figures = Table(
    "figures",
    metadata,
    Column("series_id", ForeignKey("series.id"), primary_key=True),
    Column("night_id", ForeignKey("nights.id", ondelete="CASCADE"), primary_key=True),
    Column("value", Float(53)),
    Column("low", Float(53)),
    Column("high", Float(53)),
    Column("tolerance", Float(53)),
    Column("word_id", ForeignKey("texts.id")),
    Column("trajectory_id", ForeignKey("texts.id")),
    Column("reason_id", ForeignKey("texts.id")),
    Column("depends_id", ForeignKey("texts.id"), nullable=False),
    CheckConstraint("value IS NOT NULL OR word_id IS NOT NULL OR reason_id IS NOT NULL", name="result"),
    Index("ix_figures_night_id", "night_id"),
    sqlite_with_rowid=False,
)
"""In the order of the series: one figure over all nights lies together"""

told_changes = Table(
    "told_changes",
    metadata,
    Column("night", String(40), primary_key=True),
    Column("change", String(16), primary_key=True),
    Column("figure", Text, nullable=False),
    Column("kind", String(10), nullable=False),
    Column("since", String(40), nullable=False),
    Column("direction", String(10), nullable=False),
    Column("tonight", Boolean, nullable=False),
)
"""Changes that each night told first, and steps that an earlier night told unrecorded (not `tonight`); they refer to
nights and figures by name, and stay when nights are pruned"""

acceptances = Table(
    "acceptances",
    metadata,
    number_of("id"),
    Column("digest", String(64), nullable=False, unique=True),
    Column("series", Text, nullable=False),
    Column("was", Text, nullable=False),
    Column("became", Text, nullable=False),
    Column("value", Float(53)),
    Column("word", Text, nullable=False),
    Column("since", String(40), nullable=False),
    Column("who", Text, nullable=False),
    Column("accepted", UtcTime, nullable=False),
    Column("reason", Text, nullable=False),
    Column("until", UtcTime),
    Index("ix_acceptances_series", "series"),
)
"""Changes that somebody accepted; they refer to figures by name, and stay when nights are pruned"""

attributions = Table(
    "attributions",
    metadata,
    number_of("id"),
    Column("change", String(16), nullable=False, unique=True),
    Column("figure", Text, nullable=False),
    Column("last", String(40), nullable=False),
    Column("since", String(40), nullable=False),
    Column("verdict", String(20), nullable=False),
    Column("culprits", Text, nullable=False),
    Column("words", Text, nullable=False),
    Column("made", UtcTime, nullable=False),
)
"""Results of real runs on the causes of changes; they refer to figures by name, and stay when nights are pruned"""
