"""Steps of the reference in absolute coordinates, where round-off holds their tolerance up."""

import numpy as np

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from benchmarks.random_campaign.scenes import draw
from scenarios import Scene


def moved(scene: Scene, engine: str) -> Trajectory:
    """Run of a form of the reference."""
    run = ENGINES[engine].load()()
    run.build(scene, Setting(AccuracyParameter.RTOL, 1e-12))
    run.simulate()
    return run.read()


def test_short_bars_on_soft_springs_are_as_accurate_as_round_off_in_absolute_coordinates_allows() -> None:
    """Eight bars of 0.1 to 0.2 m: the error estimate of long steps was 2000 times too small, the attitude 6e-5 rad off.

    A step is held to 6e-8 rad (4 roundings of the radius over the shortest bar) by its root mean square over 48
    components, so that one angle may have 4e-7 rad of a step, and 118 such steps 5e-6 rad as a random walk.
    """
    scene = draw(7192)
    right, absolute = moved(scene, "reference"), moved(scene, "reference-absolute")
    assert np.abs(absolute.angle_rad - right.angle_rad).max() < 5e-6
