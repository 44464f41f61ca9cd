"""What each night did of its plan."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table of runs."""
    op.create_table(
        "runs",
        sa.Column("night_id", sa.Integer(), nullable=False, autoincrement=False),
        sa.Column("plan", sa.Text(), nullable=False),
        sa.Column("content", sa.Text(), nullable=False),
        sa.ForeignKeyConstraint(["night_id"], ["nights.id"], name="fk_runs_night_id", ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("night_id", name="pk_runs"),
    )
