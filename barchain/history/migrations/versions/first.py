"""Nights, their parts, series and figures."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make all tables."""
    op.create_table(
        "night",
        sa.Column("id", sa.String(16), primary_key=True),
        sa.Column("started", sa.String(40), nullable=False, index=True),
        sa.Column("seconds", sa.Double, nullable=False),
        sa.Column("command", sa.Text, nullable=False),
        sa.Column("barchain", sa.String(60), nullable=False),
        sa.Column("commit", sa.String(64), nullable=False),
        sa.Column("machine", sa.String(16), nullable=False, index=True),
        sa.Column("environment", sa.Text, nullable=False),
        sa.Column("complete", sa.Boolean, nullable=False),
        sa.Column("void", sa.Text, nullable=False),
    )
    op.create_table(
        "part",
        sa.Column("night", sa.String(16), sa.ForeignKey("night.id", ondelete="CASCADE"), primary_key=True),
        sa.Column("name", sa.String(120), primary_key=True),
        sa.Column("version", sa.String(120), nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
    )
    names = ("scene", "engine", "setting", "quantity", "metric", "kind", "unit")
    op.create_table(
        "series",
        sa.Column("id", sa.Integer, primary_key=True, autoincrement=True),
        *(sa.Column(name, sa.String(200), nullable=False) for name in names),
        sa.UniqueConstraint(*names, name="series_name"),
    )
    op.create_table(
        "figure",
        sa.Column("night", sa.String(16), sa.ForeignKey("night.id", ondelete="CASCADE"), primary_key=True),
        sa.Column("series", sa.Integer, sa.ForeignKey("series.id"), primary_key=True, index=True),
        sa.Column("value", sa.Double),
        sa.Column("word", sa.String(200), nullable=False),
        sa.Column("low", sa.Double),
        sa.Column("high", sa.Double),
        sa.Column("roundoff", sa.Double),
        sa.Column("reason", sa.Text, nullable=False),
        sa.Column("parts", sa.Text, nullable=False),
    )
