"""What a run holds fixed between the instants at which a model's effects are not smooth, and its blows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from reference_impl.effect import Situation
from reference_impl.plane import along

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.chain import Array
    from reference_impl.effect import Effect, Modes
    from reference_impl.simulate import Packing

LOOKS = (0.25, 0.5, 0.75, 1.0)  # of a step: where something that falls and rises again within it is looked for
FALL_SLACK = 1e-12  # of a step: how closely the instant of a fall is found; the state is as good as its interpolant
SAME_INSTANT = 1e-12  # of the run: blows nearer than this to a break are at it


class ModelSwitches:
    """Modes of a model's effects along one run, in one set of coordinates."""

    def __init__(self, packing: Packing, end_s: float, *, watching: bool = True) -> None:
        """Prepare a run.

        Parameters
        ----------
        packing : Packing
        end_s : float
            When the run ends.
        watching : bool
            Whether the stepper looks for where a mode ends; if not, such modes are told from the state at all times.
        """
        self.packing, self.model, self.watching = packing, packing.model, watching
        self.slack_s = SAME_INSTANT * end_s
        self.waiting = sorted(self.model.impulses, key=lambda blow: blow.at_s)
        self.blows: list[tuple[float, Array]] = []
        """Instants and impulsive reactions (N-1, 2) so far"""

    @property
    def modes(self) -> Modes | None:
        """What the right-hand side holds now."""
        return self.packing.modes

    def enter(self, start_s: float, end_s: float, y: Array) -> Array:
        """Strike the blows of this instant, and settle what holds until `end_s`."""
        due = [blow for blow in self.waiting if blow.at_s <= start_s + self.slack_s]
        self.waiting = self.waiting[len(due) :]
        if due:
            from reference_impl.effects.impulse import struck  # noqa: PLC0415  # only where something strikes

            state, reaction = struck(self.model, self.packing.unpack(y), due)
            self.blows.append((due[0].at_s, reaction))
            y = self.packing.pack(state)
        self.settle(start_s, end_s, y)
        return y

    def settle(self, start_s: float, end_s: float, y: Array) -> None:
        """Modes from the time where they are a matter of time, else from the state at the start."""
        at = self.situation(start_s, y)

        def held(effect: Effect) -> Array | None:
            if effect.watched:
                return effect.mode(at) if self.watching else None
            return effect.piece(start_s, end_s)

        self.packing.modes = tuple(held(effect) for effect in self.model.effects)

    def situation(self, t_s: float, y: Array) -> Situation:
        """A vector as effects see it."""
        state = self.packing.unpack(y)
        return Situation(self.model, t_s, state, along(state.angle_rad))

    def margins(self, t_s: float, y: Array) -> Array:
        """All margins of what is held at a vector, positive while it holds."""
        at, held = self.situation(t_s, y), self.modes or ()
        found = [e.margin(at, m) for e, m in zip(self.model.effects, held, strict=True) if m is not None and e.watched]
        return np.concatenate([*found, np.ones(1)])

    def fall(self, dense: Callable[[float], Array], start_s: float, end_s: float) -> float | None:
        """First instant in a step, looked for in quarters of it, at which a margin has fallen through zero."""
        before, low = start_s, self.margins(start_s, dense(start_s))
        for share in LOOKS:
            t = start_s + share * (end_s - start_s)
            now = self.margins(t, dense(t))
            if np.any(now < 0.0):
                fallen = np.nonzero(now < 0.0)[0]
                return min(self.root(dense, int(k), before, t, float(low[k])) for k in fallen)
            before, low = t, now
        return None

    def root(self, dense: Callable[[float], Array], k: int, start_s: float, end_s: float, before: float) -> float:
        """Instant at which margin `k` is zero or just below."""
        if before <= 0.0:
            return start_s

        def margin(t: float) -> float:
            return float(self.margins(t, dense(t))[k])

        slack = FALL_SLACK * (end_s - start_s)
        found: float = brentq(margin, start_s, end_s, xtol=slack)
        return min(found + 2.0 * slack, end_s)

    def let_go(self, t_s: float, y: Array) -> None:
        """Turn round whatever margin is not positive any more."""
        at, modes = self.situation(t_s, y), list(self.modes or ())
        for i, (effect, mode) in enumerate(zip(self.model.effects, modes, strict=True)):
            if mode is not None and effect.watched:
                crossed = np.nonzero(effect.margin(at, mode) <= 0.0)[0]
                modes[i] = effect.flipped(mode, crossed) if len(crossed) else mode
        self.packing.modes = tuple(modes)

    def impulses(self, t_s: Array) -> Array | None:
        """Sum of the impulsive reactions before each sample, (n, N-1, 2); None where nothing strikes."""
        if not self.model.impulses:
            return None
        total = np.zeros((len(t_s), self.model.bars - 1, 2))
        for at_s, reaction in self.blows:
            total[t_s > at_s + self.slack_s] += reaction
        return total
