"""Rows of a round-off study's tables, each task's at its own place, and the tables that follow from them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.studies.roundoff.laws.engine_fits import engine_laws
from barchain.studies.roundoff.laws.fits import best_laws, best_table, evaluation_laws, growth_laws
from reports.tables.roundoff import COLUMNS, PARTS

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd

    from barchain.record.study_store import StudyStore

DERIVED = {
    "laws": ("evaluation", evaluation_laws),
    "growth_laws": ("growth", growth_laws),
    "engine_laws": ("engines", engine_laws),
}


class RoundoffRows:
    """Rows of one study's tables."""

    def __init__(self, store: StudyStore, parts: Iterable[str]) -> None:
        """Start with no rows, and remove tables of the same parts that an earlier study left."""
        self.store = store
        store.remove(*(table for part in parts for table in PARTS[part]))
        self.rows: dict[str, dict[int, list[dict[str, Any]]]] = {}

    def keep(self, table: str, rows: list[dict[str, Any]], place: int = 0) -> None:
        """Add a task's rows to a table, in the order of tasks whenever they come, and write the table."""
        self.rows.setdefault(table, {})[place] = rows
        self.store.write(table, self.table(table))

    def table(self, name: str) -> pd.DataFrame:
        """Table as it stands."""
        return self.store.frame(name, (row for _, own in sorted(self.rows.get(name, {}).items()) for row in own))

    def finish(self) -> None:
        """Write the tables that follow from others."""
        for name, (source, laws) in DERIVED.items():
            if source in self.rows:
                self.store.write(name, laws(self.table(source)))
        if "trajectories" in self.rows:
            best = best_table(self.table("trajectories"))
            self.store.write("best", best.reindex(columns=list(COLUMNS["best"])))
            self.store.write("best_laws", best_laws(best))
