"""Part of a run that a picture shows, where the whole run would show nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Scene

MOST_ORBITS = 2.0  # later revolutions would be drawn upon the first ones


@dataclass(frozen=True)
class Window:
    """Part of a run, s."""

    start_s: float
    end_s: float

    @property
    def duration_s(self) -> float:
        """Duration of the part, s."""
        return self.end_s - self.start_s


TURNS = {
    "hard/counter_rotation": 2.0,
    "hard/spin_1e3": 1.25,
    "hard/spin_1e5": 1.25,
    "basics/two_bars_free": 4.0,
}
"""Turns of the fastest bar at its initial rate that are shown of scenes whose bars turn many times"""
SECONDS = {"hard/slew_fast": (0.92, 1.08), "hard/perigee_099": (2.6225e6, 2.6285e6)}
"""First and last instant, s, of scenes whose event is brief"""
ORBITS = {"hard/whip": 4.0, "paper/fig05": 3.0, "paper/fig05_bar_horizontal": 2.0, "paper/fig09": 2.5}
"""Orbits that are shown of scenes whose motion begins late"""


def window_of(scene: Scene) -> Window:
    """Part of the run of `scene` that its picture shows: at most two orbits by default."""
    if scene.name in SECONDS:
        return Window(*SECONDS[scene.name])
    shown_s = ORBITS.get(scene.name, MOST_ORBITS) * scene.period_s if scene.bound else scene.run.duration_s
    if scene.name in TURNS:
        fastest = max(abs(factor) for factor in scene.chain.rate_factor) * scene.orbital_rate_rad_s
        shown_s = TURNS[scene.name] * 2.0 * math.pi / fastest
    return Window(0.0, min(shown_s, scene.run.duration_s))
