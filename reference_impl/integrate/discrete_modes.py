"""What a run holds fixed between the instants at which a model's effects are not smooth, and its blows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from reference_impl.model.complex_vectors import along
from reference_impl.model.effect import Situation

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.integrate.coordinate_sets import Packing
    from reference_impl.model.arrays import Array
    from reference_impl.model.effect import Effect, Indices, Modes

LOOKS = (0.25, 0.5, 0.75, 1.0)  # of a step: where something that falls and rises again within it is looked for
FALL_SLACK = 1e-12  # of a step: how closely the instant of a fall is found; the state is as good as its interpolant
SECANT = 1e-4  # of a step: over which a margin's slope is taken
SECANTS = 5  # two are enough: the interpolant is off by 1e-7 of a step or less
SPELL_SLACK = 1e-6  # of the time between two looks: anywhere within a spell will do
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
        self.packing, self.model = packing, packing.model
        self.watching = watching and any(effect.watched for effect in self.model.effects)
        self.slack_s = SAME_INSTANT * end_s
        self.waiting = sorted(self.model.impulses, key=lambda blow: blow.at_s)
        self.blows: list[tuple[float, Array]] = []
        """Instants and impulsive reactions (N-1, 2) so far"""
        self.fallen: set[int] = set()
        """Margins that fell at the instant found last"""

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
            end = start_s + share * (end_s - start_s)
            for t in (*self.spells(dense, before, end), end):
                now = self.margins(t, dense(t))
                if np.any(now < 0.0):
                    return self.first(dense, before, t, low, np.nonzero(now < 0.0)[0])
                before, low = t, now
        return None

    def first(self, dense: Callable[[float], Array], start_s: float, end_s: float, low: Array, below: Indices) -> float:
        """Instant at which the first of the margins `below` falls; `low` are all margins at the start."""
        instants = {int(k): self.root(dense, int(k), start_s, end_s, float(low[k])) for k in below}
        earliest = min(instants.values())
        self.fallen = {k for k, t in instants.items() if t == earliest}
        return earliest

    def spells(self, dense: Callable[[float], Array], start_s: float, end_s: float) -> list[float]:
        """Instants between two looks in the middle of what may have come and gone meanwhile, increasing."""
        found = []
        for effect in self.model.effects:
            if effect.has_spells and self.watching:

                def side(t: float, effect: Effect = effect) -> float:
                    return effect.spell(self.situation(t, dense(t)))

                if side(start_s) * side(end_s) < 0.0:
                    found.append(float(brentq(side, start_s, end_s, xtol=SPELL_SLACK * (end_s - start_s))))
        return sorted(found)

    def root(self, dense: Callable[[float], Array], k: int, start_s: float, end_s: float, before: float) -> float:
        """Instant at which margin `k` is zero or just below."""
        if before <= 0.0:
            return start_s

        def margin(t: float) -> float:
            return float(self.margins(t, dense(t))[k])

        slack = FALL_SLACK * (end_s - start_s)
        found: float = brentq(margin, start_s, end_s, xtol=slack)
        return min(found + 2.0 * slack, end_s)

    def let_go(self, exact: Callable[[float], Array], t_s: float, step: tuple[float, float]) -> tuple[float, Array]:
        """Turn round the margins that :meth:`fall` found to fall; returns when they do, and the state there.

        Their signs there do not tell: an angle of a few radians is known to 1e-16, and the root may lie on either
        side of that. A margin not turned round would be found to fall there again, and the run never get on.

        Parameters
        ----------
        exact : callable
            State at an instant of the step, by the method itself.
        t_s : float
            Where they fall by the step's interpolant.
        step : tuple of float
            When the step starts and ends.
        """
        t_s, y = self.meet(exact, t_s, step)
        at, modes, offset = self.situation(t_s, y), list(self.modes or ()), 0
        for i, (effect, mode) in enumerate(zip(self.model.effects, modes, strict=True)):
            if mode is not None and effect.watched:
                count = len(effect.margin(at, mode))
                crossed = np.array([k - offset for k in sorted(self.fallen) if 0 <= k - offset < count], np.intp)
                modes[i] = effect.flipped(mode, crossed) if len(crossed) else mode
                offset += count
        self.packing.modes = tuple(modes)
        return t_s, y

    def meet(self, exact: Callable[[float], Array], t_s: float, step: tuple[float, float]) -> tuple[float, Array]:
        """Instant near `t_s` at which what falls is zero or just below in the method's own states, by secants.

        Where a margin only touches zero, its slope is rounding or none, and secants lead anywhere: those that leave the
        step, or do not fall, leave it at the interpolant's instant, which is as good as any near.
        """
        fallen, (start_s, end_s) = sorted(self.fallen), step
        slack_s = FALL_SLACK * (end_s - start_s)

        def margin(t: float) -> tuple[float, Array]:
            y = exact(t)
            return float(self.margins(t, y)[fallen].max()), y

        aside_s = max(t_s - SECANT * (end_s - start_s), start_s)
        (before, _), (now, y) = margin(aside_s), margin(t_s)
        slope, found_s, found = (now - before) / (t_s - aside_s) if t_s > aside_s else 0.0, t_s, y
        for _ in range(SECANTS):
            if not slope < 0.0 or -slack_s * slope >= -now >= 0.0:
                break
            found_s -= (now - 0.5 * slack_s * slope) / slope
            if not start_s <= found_s <= end_s:
                return t_s, y
            now, found = margin(found_s)
        return found_s, found

    def impulses(self, t_s: Array) -> Array | None:
        """Sum of the impulsive reactions before each sample, (n, N-1, 2); None where nothing strikes."""
        if not self.model.impulses:
            return None
        total = np.zeros((len(t_s), self.model.bars - 1, 2))
        for at_s, reaction in self.blows:
            total[t_s > at_s + self.slack_s] += reaction
        return total
