"""Wrong verdicts of the judge: one scene of each kind, simplified and written."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from barchain.runs.call import Call, pickled
from barchain.runs.workers import Slot
from barchain.studies.selftest.campaign.scenes.draw import draw
from barchain.studies.selftest.campaign.scenes.shrink import alike, cell_of, simplest
from reports.tables.writing import write_atomically
from scenarios.toml.writing import scene_toml

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from pathlib import Path

    from barchain.studies.selftest.campaign.cells import CampaignCell
    from barchain.studies.selftest.campaign.store import CampaignStore
    from scenarios import Scene

MOST_SHRUNK = 5
PATIENCE = 2.0
START_S = 60.0
"""A process that looks for simpler scenes is ended after this more than `PATIENCE` times what it is given"""


@dataclass(frozen=True)
class KeptFinding:
    """A finding and its scene."""

    cell: CampaignCell
    """First one of its kind"""
    times: int
    """Cells of its kind"""
    path: Path


def kinds(findings: Iterable[CampaignCell]) -> list[list[CampaignCell]]:
    """Findings that differ by their scene alone, together; missed faults first."""
    groups: dict[tuple[str, ...], list[CampaignCell]] = {}
    for cell in findings:
        groups.setdefault((cell.engine, cell.fault, cell.outcome, cell.quantity), []).append(cell)
    return sorted(groups.values(), key=lambda cells: not cells[0].fault)


def kept_findings(
    groups: list[list[CampaignCell]], tables: CampaignStore, seconds: float, done: Callable[[int], None]
) -> list[KeptFinding]:
    """Write a scene of each kind of finding; of the first few, one as simple as is found in some seconds each.

    Without hypothesis, which looks for them, all scenes stay as they were drawn.
    """
    kept, searches = [], importlib.util.find_spec("hypothesis") is not None
    for k, cells in enumerate(groups):
        first, path = cells[0], tables.scene_path(cells[0])
        scene = draw(int(first.scene.rpartition("/")[2]))
        write_scene(scene, first, path)
        if k < MOST_SHRUNK and seconds > 0.0 and searches:
            shrink(scene, first, path, seconds)
        kept.append(KeptFinding(first, len(cells), path))
        done(1)
    return kept


def write_scene(scene: Scene, cell: CampaignCell, path: Path) -> None:
    """Write a scene with its finding as description."""
    what = f"{cell.engine} with {cell.fault}" if cell.fault else cell.engine
    said = f"{what}: {cell.kind}, {cell.outcome}. {cell.quantity} {cell.reason}".strip()
    named = replace(scene, title=f"From {cell.scene}", description=said)
    write_atomically(path, scene_toml(named))


def shrink(scene: Scene, cell: CampaignCell, path: Path, seconds: float) -> None:
    """Look for a simpler scene in a process of its own: an engine that dies or hangs there ends the search alone."""
    slot = Slot()
    try:  # where it gives no answer, the simplest scene so far is written already
        slot.run(pickled(Call(search, (scene, cell, path, seconds), PATIENCE * seconds + START_S)))
    finally:
        slot.close()


def search(scene: Scene, cell: CampaignCell, path: Path, seconds: float) -> bytes:
    """Write ever simpler scenes."""
    simplest(
        scene,
        lambda one: alike(cell_of(one, cell.engine, cell.fault), cell),
        seconds,
        lambda one: write_scene(one, cell, path),
    )
    return b""
