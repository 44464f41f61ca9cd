"""Migrations of the history's tables; the folder is Alembic's own layout."""
