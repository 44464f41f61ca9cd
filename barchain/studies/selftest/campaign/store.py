"""The campaign's folder: cells as they come, rates, the findings' scenes, and what ran where.

``campaign.csv``
    a row for each engine on each scene, and for each fault in each host on each scene, columns :data:`COLUMNS`;
``rates.csv``
    rates with 95 % intervals, columns :data:`RATE_COLUMNS`;
``scenes/<scene>-<engine>[-<fault>].toml``
    a scene for each finding, as simple as one could be found;
``campaign.json``
    what ran where, and whether it passed.
"""

from __future__ import annotations

import json
import shutil
from typing import TYPE_CHECKING, Any

import pandas as pd

from barchain.record.files import write_atomically
from barchain.studies.selftest.campaign.cells import COLUMNS
from barchain.studies.selftest.campaign.rates import RATE_COLUMNS

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.studies.selftest.campaign.cells import CampaignCell
    from barchain.studies.selftest.campaign.rates import Rate

FOLDER = "campaign"
SCENES = "scenes"


class CampaignStore:
    """Tables and record of one campaign."""

    def __init__(self, folder: Path, record: dict[str, Any]) -> None:
        """Open `folder`; what an earlier campaign left there is replaced."""
        self.folder, self.record = folder, record
        folder.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(folder / SCENES, ignore_errors=True)
        (folder / "campaign.csv").write_text(",".join(COLUMNS) + "\n", encoding="utf-8")
        self.write_record()

    def keep_cells(self, cells: Iterable[CampaignCell]) -> None:
        """Append cells."""
        frame = pd.DataFrame([cell.row() for cell in cells], columns=list(COLUMNS))
        with (self.folder / "campaign.csv").open("a", encoding="utf-8") as table:
            frame.to_csv(table, index=False, header=False)

    def keep_rates(self, found: list[Rate]) -> None:
        """Write the rates as they stand."""
        frame = pd.DataFrame([rate.row() for rate in found], columns=list(RATE_COLUMNS))
        write_atomically(self.folder / "rates.csv", frame.to_csv(index=False))

    def scene_path(self, cell: CampaignCell) -> Path:
        """File of a finding's scene."""
        folder = self.folder / SCENES
        folder.mkdir(exist_ok=True)
        words = (cell.scene.rpartition("/")[2], cell.engine.strip("()").replace(" ", "-"), cell.fault)
        return folder / f"{'-'.join(filter(None, words))}.toml"

    def write_record(self) -> None:
        """Write the record as it stands."""
        write_atomically(self.folder / "campaign.json", json.dumps(self.record, indent=1))
