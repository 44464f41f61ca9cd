"""Samples close enough for a comparison: a scene's own instants, and more in between where they lie far apart."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Scene

MOST_TURNED_RAD = 0.3
"""Largest turn of the orbit, or of the fastest bar at the start, between two samples. The fastest growth of an error
in an orbit, sqrt(3) n, makes it 1.7 times larger in that time: the next sample can always be predicted."""
MOST_SAMPLES = 2001  # a run of ten thousand orbits is not looked at closely


def closely_sampled(scene: Scene) -> Scene:
    """`scene` with its own samples, and equally many between any two where they are too far apart to be compared.

    Two samples an orbit apart say next to nothing about a chaotic run: the second one is beyond prediction.
    """
    intervals = scene.run.samples - 1
    turning = scene.orbital_rate_rad_s * max(1.0, *map(abs, scene.chain.rate_factor))
    rate = max(2.0 * math.pi / scene.step_period_s, turning)
    wanted = math.ceil(scene.run.duration_s * rate / (MOST_TURNED_RAD * intervals))
    times = max(1, min(wanted, (MOST_SAMPLES - 1) // intervals))
    if times == 1:
        return scene
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=times * intervals + 1))
