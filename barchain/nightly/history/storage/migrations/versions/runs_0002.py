"""What each night did of its plan, and how many changes it told."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the tables of runs and of judgements."""
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
