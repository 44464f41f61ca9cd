"""The campaign's folder: cells as they come, rates, the findings' scenes, and the record.

``campaign.csv``
    a row for each engine on each scene, and for each fault in each host on each scene, columns :data:`COLUMNS`;
``rates.csv``
    rates with 95 % intervals, columns :data:`RATE_COLUMNS`;
``scenes/<scene>-<engine>[-<fault>].toml``
    a scene for each finding, as simple as one could be found;
``record.json``
    what ran where, and whether it passed.
"""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

from barchain.studies.selftest.campaign.cells import COLUMNS
from barchain.studies.selftest.campaign.rates import RATE_COLUMNS
from reports.tables.files import StudyFiles

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.record.study_store import StudyStore
    from barchain.studies.selftest.campaign.cells import CampaignCell
    from barchain.studies.selftest.campaign.rates import Rate

FILES = StudyFiles("campaign", {"campaign": COLUMNS, "rates": RATE_COLUMNS})
SCENES = "scenes"


class CampaignTables:
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
