"""The effect budget's folder; :mod:`reports.tables.effects` says what is in it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.record.files import write_atomically
from reports.tables.effects import COLUMNS

if TYPE_CHECKING:
    from pathlib import Path


class EffectsStore:
    """Table and record of one budget."""

    def __init__(self, folder: Path, record: dict[str, Any]) -> None:
        """Open `folder`; what an earlier budget left there is replaced."""
        self.folder, self.record = folder, record
        folder.mkdir(parents=True, exist_ok=True)

    def write(self, rows: list[dict[str, Any]]) -> None:
        """Write both as they stand."""
        table = pd.DataFrame(rows, columns=list(COLUMNS))
        write_atomically(self.folder / "effects.csv", table.to_csv(index=False))
        write_atomically(self.folder / "record.json", json.dumps(self.record, indent=1))
