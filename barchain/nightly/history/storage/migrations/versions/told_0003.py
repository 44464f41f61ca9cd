"""Changes that each night told first."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table of told changes."""
    op.create_table(
        "told_changes",
        *(sa.Column(name, sa.String(size), nullable=False) for name, size in (("night", 40), ("change", 16))),
        sa.Column("figure", sa.Text(), nullable=False),
        *(sa.Column(name, sa.String(size), nullable=False) for name, size in (("kind", 10), ("since", 40))),
        sa.Column("direction", sa.String(10), nullable=False),
        sa.Column("tonight", sa.Boolean(), nullable=False),
        sa.PrimaryKeyConstraint("night", "change", name="pk_told_changes"),
    )
