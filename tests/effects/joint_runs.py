"""Runs of scenes with laws and motors of joints, in every form of the equations that has them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES

if TYPE_CHECKING:
    from _pytest.mark import ParameterSet

    from adapters.trajectory import Trajectory
    from scenarios import Scene

SETTING = Setting(AccuracyParameter.RTOL, 1e-13)


def forms(*names: str) -> list[ParameterSet]:
    """Engines as parameters; one that is not installed is skipped with the reason."""
    missing = {name: ENGINES[name].missing for name in names}
    return [
        pytest.param(name, marks=pytest.mark.skipif(bool(reason), reason=reason or ""))
        for name, reason in missing.items()
    ]


def moved(scene: Scene, engine: str) -> Trajectory:
    """Run of an engine, with its scene."""
    return ENGINES[engine].engine().run(scene, SETTING).of_run(scene)
