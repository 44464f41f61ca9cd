"""First form of the tables."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

KINDS = "kind IN ('bits', 'error', 'verdict', 'count', 'ratio', 'memory', 'value')"
UNITS = "unit IN ('', '1', 'm', 'm/s', 'rad', 'rad/s', 'N', 'N m', 'N s', 's', 'B')"
RESULT = "value IS NOT NULL OR word_id IS NOT NULL OR reason_id IS NOT NULL"


def upgrade() -> None:
    """Make all tables."""
    make_vocabulary()
    make_series()
    make_nights()
    make_figures()
    make_acceptances()


def make_vocabulary() -> None:
    """Make the tables of rows that nights share: each row once."""
    op.create_table(
        "environments",
        number_of("id"),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("machine_class", sa.String(16), nullable=False),
        *(text_of(name) for name in ("cpu", "cpu_flags")),
        sa.Column("cores", sa.Integer(), nullable=False),
        *(text_of(name) for name in ("architecture", "kernel", "libc", "blas", "python")),
        sa.PrimaryKeyConstraint("id", name="pk_environments"),
        sa.UniqueConstraint("digest", name="uq_environments_digest"),
    )
    op.create_table(
        "parts",
        number_of("id"),
        *(text_of(name) for name in ("name", "version", "digest")),
        sa.PrimaryKeyConstraint("id", name="pk_parts"),
        sa.UniqueConstraint("name", "version", "digest", name="uq_parts_name"),
    )
    op.create_table(
        "texts",
        number_of("id"),
        sa.Column("digest", sa.String(64), nullable=False),
        text_of("text"),
        sa.PrimaryKeyConstraint("id", name="pk_texts"),
        sa.UniqueConstraint("digest", name="uq_texts_digest"),
    )


def make_series() -> None:
    """Make the table of the identities of figures."""
    op.create_table(
        "series",
        number_of("id"),
        sa.Column("digest", sa.String(64), nullable=False),
        *(text_of(name) for name in ("scene", "engine", "setting", "quantity")),
        sa.Column("kind", sa.String(10), nullable=False),
        sa.Column("unit", sa.String(10), nullable=False),
        text_of("anchor"),
        sa.CheckConstraint(KINDS, name=op.f("ck_series_kind")),
        sa.CheckConstraint(UNITS, name=op.f("ck_series_unit")),
        sa.PrimaryKeyConstraint("id", name="pk_series"),
        sa.UniqueConstraint("digest", name="uq_series_digest"),
    )


def make_nights() -> None:
    """Make the table of nights, and that of their parts."""
    op.create_table(
        "nights",
        number_of("id"),
        sa.Column("identity", sa.String(64), nullable=False),
        sa.Column("name", sa.String(40), nullable=False),
        sa.Column("started", sa.DateTime(), nullable=False),
        sa.Column("duration_s", sa.Float(53), nullable=False),
        text_of("plan"),
        text_of("barchain"),
        sa.Column("source_commit", sa.Text()),
        sa.Column("environment_id", sa.Integer(), nullable=False),
        sa.Column("complete", sa.Boolean(), nullable=False),
        sa.Column("void", sa.Text()),
        sa.Column("figures", sa.Integer(), nullable=False),
        sa.CheckConstraint("duration_s >= 0", name=op.f("ck_nights_duration")),
        sa.ForeignKeyConstraint(["environment_id"], ["environments.id"], name="fk_nights_environment_id"),
        sa.PrimaryKeyConstraint("id", name="pk_nights"),
        sa.UniqueConstraint("identity", name="uq_nights_identity"),
        sa.UniqueConstraint("name", name="uq_nights_name"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_nights_started", "nights", ["started"])
    op.create_table(
        "night_parts",
        sa.Column("night_id", sa.Integer(), nullable=False),
        sa.Column("part_id", sa.Integer(), nullable=False),
        sa.ForeignKeyConstraint(["night_id"], ["nights.id"], name="fk_night_parts_night_id", ondelete="CASCADE"),
        sa.ForeignKeyConstraint(["part_id"], ["parts.id"], name="fk_night_parts_part_id"),
        sa.PrimaryKeyConstraint("night_id", "part_id", name="pk_night_parts"),
        sqlite_with_rowid=False,
    )
    op.create_index("ix_night_parts_part_id", "night_parts", ["part_id"])


def make_figures() -> None:
    """Make the table of figures, in the order of their series."""
    texts = ("word_id", "trajectory_id", "reason_id")
    op.create_table(
        "figures",
        sa.Column("series_id", sa.Integer(), nullable=False),
        sa.Column("night_id", sa.Integer(), nullable=False),
        *(sa.Column(name, sa.Float(53)) for name in ("value", "low", "high", "tolerance")),
        *(sa.Column(name, sa.Integer()) for name in texts),
        sa.Column("depends_id", sa.Integer(), nullable=False),
        sa.CheckConstraint(RESULT, name=op.f("ck_figures_result")),
        sa.ForeignKeyConstraint(["series_id"], ["series.id"], name="fk_figures_series_id"),
        sa.ForeignKeyConstraint(["night_id"], ["nights.id"], name="fk_figures_night_id", ondelete="CASCADE"),
        *(sa.ForeignKeyConstraint([n], ["texts.id"], name=f"fk_figures_{n}") for n in (*texts, "depends_id")),
        sa.PrimaryKeyConstraint("series_id", "night_id", name="pk_figures"),
        sqlite_with_rowid=False,
    )
    op.create_index("ix_figures_night_id", "figures", ["night_id"])


def make_acceptances() -> None:
    """Make the table of accepted changes."""
    op.create_table(
        "acceptances",
        number_of("id"),
        sa.Column("digest", sa.String(64), nullable=False),
        *(text_of(name) for name in ("series", "was", "became")),
        sa.Column("value", sa.Float(53)),
        text_of("word"),
        sa.Column("since", sa.String(40), nullable=False),
        text_of("who"),
        sa.Column("accepted", sa.DateTime(), nullable=False),
        text_of("reason"),
        sa.Column("until", sa.DateTime()),
        sa.PrimaryKeyConstraint("id", name="pk_acceptances"),
        sa.UniqueConstraint("digest", name="uq_acceptances_digest"),
    )
    op.create_index("ix_acceptances_series", "acceptances", ["series"])


def number_of(name: str) -> sa.Column[int]:
    """Column that numbers the rows."""
    return sa.Column(name, sa.Integer(), autoincrement=True, nullable=False)


def text_of(name: str) -> sa.Column[str]:
    """Column of text."""
    return sa.Column(name, sa.Text(), nullable=False)
