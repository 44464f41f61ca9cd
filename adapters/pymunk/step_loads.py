"""Loads on the bars in the current step.

Velocities are half a step ahead of the positions. Loads that depend on velocities use the linear extrapolation of the
last two, (3 v(n-1/2) - v(n-3/2))/2, at the positions' instant: second order. Just after a start the two are the initial
rates and the rates half a step later.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.bar_loads.assemble import ChainLoads
    from adapters.bar_loads.interface import FrameState, Load
    from adapters.pymunk.samples import Rows


class StepLoads:
    """Loads on each bar in the current step."""

    def __init__(self, effect_loads: ChainLoads) -> None:
        """Prepare for the first step."""
        self.effect_loads = effect_loads
        self.steps = 0
        self.before: Rows = []
        self.found: list[Load] = []

    def begin(self) -> None:
        """Discard the velocities: the chain restarts."""
        self.steps, self.before = 0, []

    def move_to(self, frame_state: FrameState) -> None:
        """Prepare a step to `frame_state`."""
        self.frame_state, self.found = frame_state, []

    def load(self, j: int, positions: Callable[[], Rows], velocities: Callable[[], Rows]) -> Load:
        """Load of bar `j`; the first call of a step computes the loads of all bars."""
        if not self.found:
            rates = self.rates(velocities()) if self.effect_loads.of_rates else []
            self.found = self.effect_loads(self.frame_state, positions(), rates)
        return self.found[j]

    def rates(self, now: Rows) -> Rows:
        """Velocities at the instant of the positions, from velocities half a step earlier."""
        step, before, self.before = self.steps, self.before, now
        self.steps += 1
        if step == 0:
            return now
        ahead = 1.0 if step == 1 else 0.5  # share of the last change: half a step, later a whole one
        return [
            (vx + ahead * (vx - ux), vy + ahead * (vy - uy), w + ahead * (w - u))
            for (vx, vy, w), (ux, uy, u) in zip(now, before, strict=True)
        ]
