"""Environment of Alembic: migrations run in the transaction of the connection that is given."""

from __future__ import annotations

from alembic import context

from barchain.nightly.history.storage.tables import metadata

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=metadata,
    transactional_ddl=True,
    transaction_per_migration=False,
)
context.run_migrations()
