"""Plan of a scaling study: one chain cut into more and more bars, up to each engine's time limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from barchain.runs.declared import engine_class
from barchain.runs.job import Job, Role
from barchain.runs.timing.divided_chain import divided
from barchain.studies.scaling.limits import BARS, MINUTES, REPEATS, TIME_LIMIT_S

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.registry import Registration
    from scenarios import Scene

SHARES = (1.0, 0.5, 0.2, 0.1, 0.05)  # of an orbit; the last is two steps between samples for the fewest steps taken
MEMORY_SHARE = 0.5  # of the machine's memory that a model may take
LAST = 3  # points that tell how costs grow
FEW_EXPONENT, MOST_EXPONENT = 2.0, 3.0  # beyond which growth is not believed, of fewer points and of all of them


@dataclass(frozen=True)
class ScalingPlan:
    """Measurements, and their limits of time."""

    scene: Scene
    engines: dict[str, Registration]
    bars: tuple[int, ...] = BARS
    repeats: int = REPEATS
    minutes: float = MINUTES
    time_limit_s: float = TIME_LIMIT_S
    named: frozenset[str] = frozenset()
    """Engines that were asked for by name"""

    @property
    def turns(self) -> int:
        """Number of points to be reported, those that are not run among them."""
        return len(self.engines) * len(self.bars)

    def job(self, engine: str, bars: int, share: float) -> Job:
        """Run of the chain of `bars` bars over a share of its orbit, at the engine's default setting."""
        registration = self.engines[engine]
        return Job(
            divided(self.scene, bars, share),
            engine,
            registration,
            engine_class(registration).sweep.setting(),
            Role.MAIN,
        )


def predicted(bars: Sequence[int], cost: Sequence[float], wanted: int) -> float:
    """Cost at `wanted` bars by the last points' own exponent; 0 where nothing is known.

    Points come in order of rising N; costs that are not positive numbers are none.
    """
    known = [(n, c) for n, c in zip(bars, cost, strict=True) if math.isfinite(c) and c > 0.0][-LAST:]
    if not known:
        return 0.0
    n, c = known[-1]
    exponent = FEW_EXPONENT
    if len(known) > 1:
        x, y = np.log([k[0] for k in known]), np.log([k[1] for k in known])
        exponent = float(np.clip(np.polyfit(x, y, 1)[0], 0.0, MOST_EXPONENT if len(known) == LAST else FEW_EXPONENT))
    return float(c * (wanted / n) ** exponent)


def affordable(orbit_s: float, limit_s: float) -> float:
    """Largest share of an orbit that keeps to the limit; 0 if even the smallest does not."""
    return next((share for share in SHARES if share * orbit_s <= limit_s), 0.0)
