"""Samples dense enough for a comparison: a scene's own instants, and more between distant instants."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Scene

MOST_TURNED_RAD = 0.3
"""Largest rotation of the orbit, or of the fastest bar at the start, between two samples. In that time an error grows
at most 1.7 times, at the rate sqrt(3) n: the next sample can always be predicted."""
MOST_SAMPLES = 2001  # a run of ten thousand orbits is sampled sparsely


def closely_sampled(scene: Scene) -> Scene:
    """`scene` with its own samples, and equally many between any two if they are too far apart for a comparison.

    Of two samples an orbit apart, the second sample of a chaotic run can't be predicted.
    """
    intervals = scene.run.samples - 1
    turning = scene.orbital_rate_rad_s * max(1.0, *map(abs, scene.chain.rate_factor))
    rate = max(2.0 * math.pi / scene.step_period_s, turning)
    wanted = math.ceil(scene.run.duration_s * rate / (MOST_TURNED_RAD * intervals))
    times = max(1, min(wanted, (MOST_SAMPLES - 1) // intervals))
    if times == 1:
        return scene
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, samples=times * intervals + 1))
