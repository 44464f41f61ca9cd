"""Alembic's entry: runs the steps on the connection that the store has opened."""

from __future__ import annotations

from alembic import context

from barchain.history.tables import METADATA

context.configure(connection=context.config.attributes["connection"], target_metadata=METADATA)
context.run_migrations()
