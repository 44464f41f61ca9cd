"""Events in a run of a chain: starts and ends of thrusts, impulses, and faces that turn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.integrate.stepper import TIME_EVENT_TOLERANCE, smooth_segments
from reference_impl.model.effect import EDGE_ON

TOGETHER = 1e-9
"""Sines up to which bars turn at one instant, as those of a straight chain: turned so much early, a force is wrong by
a part in 1e9 for a moment"""

if TYPE_CHECKING:
    from adapters.bar_loads.joint_tree.chain import JointTree
    from adapters.trajectory import Array
    from scenarios import Impulse, Scene


class HeldFaces:
    """Faces that bars turn to the wind and the Sun, held until one turns: the solver stops there."""

    def __init__(self, chain: JointTree) -> None:
        """Hold none yet."""
        self.chain = chain
        self.faces: list[list[float]] = []

    def hold(self, t_s: float, y: Array) -> None:
        """Hold the faces of a state."""
        self.faces = [[math.copysign(1.0, x) for x in found] for found in self.chain.incidences(t_s, y)]
        self.chain.hold_faces(self.faces)

    def release(self) -> None:
        """Take the faces of each state from here on."""
        self.chain.hold_faces([None] * len(self.faces))

    def sines(self, t_s: float, y: Array) -> list[list[float]]:
        """Sines of the angles to the source, positive where the held face is right."""
        found = self.chain.incidences(t_s, y)
        return [[f * x for f, x in zip(*both, strict=True)] for both in zip(self.faces, found, strict=True)]

    def margin(self, t_s: float, y: Array) -> float:
        """Least of the sines, positive while the faces are right; a bar that stays edge-on turns none."""
        return min(min(each) for each in self.sines(t_s, y)) + EDGE_ON

    def change(self, t_s: float, y: Array) -> None:
        """Turn the bars whose sines vanish at this instant."""
        sines = self.sines(t_s, y)
        least = min(map(min, sines)) + TOGETHER
        self.faces = [
            [-f if x <= least else f for f, x in zip(*both, strict=True)]
            for both in zip(self.faces, sines, strict=True)
        ]
        self.chain.hold_faces(self.faces)


class Jumps:
    """State changes at the events of a run."""

    def __init__(self, scene: Scene, chain: JointTree) -> None:
        """Events of `scene`."""
        self.chain, self.scheduled = chain, scene.effects.impulse
        self.faces: HeldFaces | None = None
        self.slack_s = TIME_EVENT_TOLERANCE * scene.run.duration_s
        self.segments = smooth_segments(scene.times_s, scene.effects.breaks_s)
        self.sums: list[tuple[float, Array]] = [(-np.inf, np.zeros((scene.bars - 1, 2)))]

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """State from which the next segment starts."""
        self.chain.inside_s = 0.5 * (start_s + end_s)
        applied = [impulse for impulse in self.scheduled if abs(impulse.at_s - start_s) <= self.slack_s]
        begun = self.apply_impulses(start_s, applied, y) if applied and start_s > 0.0 else y
        if self.faces:
            self.faces.hold(start_s, begun)
        return begun

    def begin(self, y: Array) -> Array:
        """State just after impulses at t = 0."""
        self.chain.inside_s = 0.5 * sum(self.segments[0])
        applied = [impulse for impulse in self.scheduled if impulse.at_s <= self.slack_s]
        return self.apply_impulses(-np.inf, applied, y) if applied else y

    def apply_impulses(self, at_s: float, applied: list[Impulse], y: Array) -> Array:
        """State after impulses; the impulsive reactions are stored."""
        after, found = self.chain.apply_impulses(y, applied)
        self.sums.append((at_s, self.sums[-1][1] + found))
        return after

    def before(self, t_s: float) -> float:
        """An instant within the segment that ends at `t_s` or contains it."""
        start, end = next((part for part in self.segments if t_s <= part[1] + self.slack_s), self.segments[-1])
        return 0.5 * (start + end)

    def impulses(self, t_s: Array) -> Array:
        """Sum of the impulsive reactions before each sample, (n, N-1, 2) N s."""
        return np.array([[found for at, found in self.sums if at < t - self.slack_s][-1] for t in t_s])
