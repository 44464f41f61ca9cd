"""Drawn scenes, and runs of them with faults."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter, Setting
from adapters.reference.numpy_engines import Reference
from barchain.studies.selftest.faults.catalogue import RANDOM_SCENES
from barchain.studies.selftest.rating import CampaignCell

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from reports.results.faults.campaign import CellClass
    from scenarios import Scene

SEED = 8
"""Three bars in a point's pull, for a third of an orbit"""
FREE = 6
"""Two bars without gravity"""
EVENTS = 2
"""An impulse, a thrust and a slew"""
MAIN, FINER = Setting(AccuracyParameter.RTOL, 1e-10), Setting(AccuracyParameter.RTOL, 1e-11)


def seen(scene: Scene, setting: Setting = MAIN) -> Trajectory:
    """Run of the reference."""
    return Reference().run(scene, setting)


def with_fault(name: str, run: Trajectory, scene: Scene, setting: Setting = MAIN) -> Trajectory:
    """What a run shows with a fault in it."""
    fault = RANDOM_SCENES[name]
    return fault.output_of(run, scene, setting, fault.natural)


def cells(kind: CellClass, number: int, fault: str = "", outcome: str = "") -> list[CampaignCell]:
    """So many equal cells."""
    return [CampaignCell(f"random/{k}", "pymunk", fault, outcome, kind) for k in range(number)]
