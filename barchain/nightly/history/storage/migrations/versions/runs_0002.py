"""What each night did of its plan, how many changes it told, and attributions."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the tables of runs, judgements and attributions."""
    op.create_table(
        "runs",
        sa.Column("night_id", sa.Integer(), nullable=False, autoincrement=False),
        sa.Column("plan", sa.Text(), nullable=False),
        sa.Column("content", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["night_id"], ["nights.id"], name="fk_runs_night_id", ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("night_id", name="pk_runs"),
    )
    op.create_table(
        "judgements",
        sa.Column("night_id", sa.Integer(), nullable=False, autoincrement=False),
        *(sa.Column(name, sa.Integer(), nullable=False) for name in ("worse", "changes", "judged")),
        sa.ForeignKeyConstraint(["night_id"], ["nights.id"], name="fk_judgements_night_id", ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("night_id", name="pk_judgements"),
    )
    op.create_table(
        "attributions",
        sa.Column("id", sa.Integer(), nullable=False, autoincrement=True),
        sa.Column("change", sa.String(16), nullable=False),
        sa.Column("figure", sa.Text(), nullable=False),
        *(sa.Column(name, sa.String(40), nullable=False) for name in ("last", "since")),
        sa.Column("verdict", sa.String(20), nullable=False),
        *(sa.Column(name, sa.Text(), nullable=False) for name in ("culprits", "words")),
        sa.Column("made", sa.DateTime(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_attributions"),
        sa.UniqueConstraint("change", name="uq_attributions_change"),
    )
