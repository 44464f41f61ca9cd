"""Events in a run of a chain: starts and ends of thrusts, and impulses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.integrate.stepper import TIME_EVENT_TOLERANCE, smooth_segments

if TYPE_CHECKING:
    from adapters.bar_loads.joint_tree.chain import JointTree
    from adapters.trajectory import Array
    from scenarios import Impulse, Scene


class Jumps:
    """State changes at the events of a run."""

    def __init__(self, scene: Scene, chain: JointTree) -> None:
        """Events of `scene`."""
        self.chain, self.scheduled = chain, scene.effects.impulse
        self.slack_s = TIME_EVENT_TOLERANCE * scene.run.duration_s
        self.segments = smooth_segments(scene.times_s, scene.effects.breaks_s)
        self.sums: list[tuple[float, Array]] = [(-np.inf, np.zeros((scene.bars - 1, 2)))]

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """State from which the next segment starts."""
        self.chain.inside_s = 0.5 * (start_s + end_s)
        applied = [impulse for impulse in self.scheduled if abs(impulse.at_s - start_s) <= self.slack_s]
        return self.apply_impulses(start_s, applied, y) if applied and start_s > 0.0 else y

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
