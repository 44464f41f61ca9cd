"""Store of a campaign: cells as they come, rates, and the scenes of findings."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

from reports.tables.faults.campaign import SCENES

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.record.study_store import StudyStore
    from barchain.studies.selftest.campaign.cells import CampaignCell
    from barchain.studies.selftest.campaign.rates import Rate


class CampaignStore:
    """Cells, rates and scenes of one campaign."""

    def __init__(self, store: StudyStore) -> None:
        """Start with no cells, and remove the scenes that an earlier campaign left."""
        self.store = store
        shutil.rmtree(store.folder / SCENES, ignore_errors=True)
        store.write("campaign", ())

    def keep_cells(self, cells: Iterable[CampaignCell]) -> None:
        """Append cells."""
        self.store.append("campaign", (cell.row() for cell in cells))

    def keep_rates(self, found: list[Rate]) -> None:
        """Write the rates as they stand."""
        self.store.write("rates", (rate.row() for rate in found))

    def scene_path(self, cell: CampaignCell) -> Path:
        """File of a finding's scene."""
        folder = self.store.folder / SCENES
        folder.mkdir(exist_ok=True)
        words = (cell.scene.rpartition("/")[2], cell.engine.strip("()").replace(" ", "-"), cell.fault)
        return folder / f"{'-'.join(filter(None, words))}.toml"
