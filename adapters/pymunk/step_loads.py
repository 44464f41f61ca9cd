"""What acts on the bars in the step that is being taken.

Velocities are half a step ahead of the places. What depends on them is asked at the places' instant, with the line
through the last two, (3 v(n-1/2) - v(n-3/2))/2: second order. Just after a start there are the rates of the start, and
then those half a step later: the line through these.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.bar_loads.assemble import ChainLoads
    from adapters.bar_loads.interface import FrameState, Load
    from adapters.pymunk.samples import Rows


class StepLoads:
    """What acts on each bar in the step being taken."""

    def __init__(self, effect_loads: ChainLoads) -> None:
        """Prepare for the first step."""
        self.effect_loads = effect_loads
        self.steps = 0
        self.before: Rows = []
        self.found: list[Load] = []

    def begin(self) -> None:
        """Forget the velocities: the chain starts anew."""
        self.steps, self.before = 0, []

    def move_to(self, frame_state: FrameState) -> None:
        """Be ready for a step onto `here`."""
        self.frame_state, self.found = frame_state, []

    def load(self, j: int, places: Callable[[], Rows], velocities: Callable[[], Rows]) -> Load:
        """Load of bar `j`; those of all are worked out when the first is asked for."""
        if not self.found:
            rates = self.rates(velocities()) if self.effect_loads.of_rates else []
            self.found = self.effect_loads(self.frame_state, places(), rates)
        return self.found[j]

    def rates(self, now: Rows) -> Rows:
        """Velocities at the instant of the places, from those half a step before."""
        step, before, self.before = self.steps, self.before, now
        self.steps += 1
        if step == 0:
            return now
        ahead = 1.0 if step == 1 else 0.5  # of what was gained in the last half step, or whole step
        return [
            (vx + ahead * (vx - ux), vy + ahead * (vy - uy), w + ahead * (w - u))
            for (vx, vy, w), (ux, uy, u) in zip(now, before, strict=True)
        ]
