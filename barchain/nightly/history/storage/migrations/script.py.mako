"""${message}"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op
${imports if imports else ""}
revision = ${repr(up_revision)}
down_revision = ${repr(down_revision)}


def upgrade() -> None:
    """Make the tables of this revision from those of the earlier one."""
    ${upgrades if upgrades else "pass"}


def downgrade() -> None:
    """Go back to the earlier revision."""
    ${downgrades if downgrades else "pass"}
