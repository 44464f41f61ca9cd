"""Measured record in `docs/record/`: small tables from runs, from which the pages are rendered."""
