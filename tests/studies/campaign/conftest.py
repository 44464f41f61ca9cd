"""A drawn scene and its unmodified run."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import pytest

from barchain.studies.selftest.scenes import draw
from tests.studies.campaign.drawn import SEED, seen

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from scenarios import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    """Drawn scene, at a fixed number of samples."""
    drawn = draw(SEED)
    return dataclasses.replace(drawn, run=dataclasses.replace(drawn.run, samples=41))


@pytest.fixture(scope="module")
def unmodified(scene: Scene) -> Trajectory:
    """Run of it."""
    return seen(scene)
