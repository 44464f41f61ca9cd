"""Search for another start, clock or scene whose motion is a result that has no balance of momenta."""

from __future__ import annotations

import itertools
import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import DOP853

from adapters.engine import AccuracyParameter, Setting
from barchain.judge.diagnosis.chance import foretells
from barchain.judge.diagnosis.mistake import Explanation, Mistake
from barchain.judge.diagnosis.motion.search import GAIN, least_squares
from barchain.judge.diagnosis.starts import ANGLES, RATES
from barchain.judge.diagnosis.trials import clock_trials, further_trials, right_motion, start_trials, strength_trials
from barchain.metrics.quantities import FIELDS, arrays
from reference_impl.integrate.stiffness import METHOD_NAMES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.search import GivenResult
from barchain.judge.diagnosis.trials import Trial

FITTED_ROWS = 24
"""Samples by which amounts are fitted in each stage"""
STAGES = (1.0 / 16.0, 1.0 / 4.0, 1.0)
"""Shares of the samples that a fit takes in turn: at first every motion is linear in a force, however large"""
ROUNDS = 4
"""Rounds of Gauss and Newton in a stage"""
HALVINGS = 3
"""Times that a step is halved until it comes nearer"""
CONVERGED = 1e-10
"""Change of amounts, relative to them, that ends a stage"""
MOST_LEFT = 0.5
"""Share of the differences that a trial must not leave at the first samples"""
TELLING = 10.0
"""Differences over their tolerances from which on samples tell whether a trial comes nearer"""
MOST_STEPS = 20_000
"""Steps of all runs together, after which nothing more is fitted: half a minute where faces turn"""
SMOOTH = 0.1
"""Steps beside faces that turn in the time of a compiled step without faces"""
LOST_STEPS = 500
"""Steps in the time of a run that ends without a motion: one that meets too many events"""
IMPLICIT = 10.0
"""Steps of the compiled reference in the time of one of SciPy's implicit method, which stiff springs need"""
WHOLE = 3.0
"""Steps of all runs, over the most for fits, after which no trial is run over the whole time any more"""
REFINED = 8
"""Trials of a kind that are fitted to the end, the best of all by their linear effects"""
LONGER = (1.0, 1e3, 1e6)
"""Factors of a probe, until the motion shows it"""
RESOLVED = 1e-8
"""Least change of a quantity by a probe, relative to its size: rounding is a millionth of it"""
GRID = 4000
"""Instants at which a clock is tried before it is fitted"""
ROUGH = Setting(AccuracyParameter.RTOL, 1e-7)
"""Accuracy of the motion on that grid, between whose instants lines are drawn"""
LEAST_KNOWN = 0.5
"""Least share of the samples of which a motion must say something"""


class TrialSearch:
    """Trials for one result; amounts are fitted once, by the tolerances of the first search."""

    def __init__(self, result: GivenResult) -> None:
        """Keep the result; nothing is run yet."""
        self.result = result
        self.weights = result.weights
        self.rows: NDArray[np.intp] = np.flatnonzero(np.any([w > 0.0 for w in self.weights.values()], axis=0))
        self.steps = 0.0
        """Steps so far of all runs by which amounts are fitted, and trials are chosen"""
        self.whole_steps = 0.0
        """Steps so far of all runs over the whole time"""
        self.motions: dict[tuple[str, bytes], Trajectory | None] = {}

    def steps_of(self, seen: Trajectory | None) -> float:
        """Steps of a run, by those beside faces that turn, which take as long."""
        if seen is None:
            return LOST_STEPS
        effects = self.result.scene.effects
        smooth = 1.0 if effects.drag or effects.solar_pressure else SMOOTH
        as_many = smooth if seen.info.get("method") == METHOD_NAMES[DOP853] else IMPLICIT
        return as_many * float(seen.info.get("steps", 0.0))

    def explaining(self, result: GivenResult) -> list[Explanation]:
        """Explanations of the result under its present tolerances, by the fewest fitted numbers, best first."""
        tried = 0
        for kind in ("simple", "further"):
            found: list[tuple[int, Explanation]] = []
            made: list[tuple[Trial, Array]] = getattr(self, kind)
            tried += len(made)
            for trial, amounts in made:
                seen = self.seen(trial, amounts, result)
                if seen is None:
                    continue
                known, motion = seen
                at = result.at(known) if len(known) < result.n else result
                without, fit = at.fit(at.right).own_error, at.fit(motion.samples(known))
                explanation = Explanation((Mistake(trial.name, trial.words(amounts), trial.section),), fit)
                fitted = 0 if trial.nice(amounts) else len(amounts)
                if (
                    explanation.explains(without)
                    and without >= (GAIN if fitted else 1.0) * fit.own_error
                    and foretells(at.digits_of(at.quantities), fitted, tried)
                ):
                    found.append((fitted, explanation))
            if found:
                fewest = min(fitted for fitted, _ in found)
                return sorted((e for k, e in found if k == fewest), key=lambda e: e.fit.normalised_error)
        return []

    def seen(self, trial: Trial, amounts: Array, result: GivenResult) -> tuple[NDArray[np.intp], Trajectory] | None:
        """Samples of which a trial says something, and its motion; None where these are few."""
        key = (trial.name, amounts.tobytes())
        if key not in self.motions:
            within = self.whole_steps <= WHOLE * MOST_STEPS
            self.motions[key] = trial.run(amounts, result.right.t_s) if within else None
            self.whole_steps += self.steps_of(self.motions[key])
        motion = self.motions[key]
        if motion is None:
            return None
        finite = [np.isfinite(v).reshape(len(motion.t_s), -1).all(axis=1) for v in arrays(motion).values()]
        known = np.flatnonzero(np.all(finite, axis=0))
        return (known, motion) if len(known) >= LEAST_KNOWN * result.n else None

    @cached_property
    def simple(self) -> list[tuple[Trial, Array]]:
        """Starts, clocks and strengths of effects, with their amounts."""
        scene, compared = self.result.scene, self.result.quantities
        track, state = ({"com", "com_velocity"} <= compared, {"attitude", "rate"} <= compared)
        starts = (t for t in start_trials(scene, track=track, state=state and not self.result.absent)
                  if {"attitude", "rate"} & compared or t.section not in (ANGLES, RATES))  # fmt: skip
        clocks = clock_trials(scene, float(self.result.right.t_s[self.rows[0]]), self.likely_late_s)
        return self.amounts_of(itertools.chain(clocks, starts, strength_trials(scene)))

    @cached_property
    def further(self) -> list[tuple[Trial, Array]]:
        """All other numbers of the scene and other scenes, with their amounts."""
        return self.amounts_of(further_trials(self.result.scene))

    def amounts_of(self, trials: Iterable[Trial]) -> list[tuple[Trial, Array]]:
        """Trials with their amounts, those that come nearer; of fitted ones, the best by their linear effects."""
        every = list(trials)
        shares = {k: self.linear_share(t) for k, t in enumerate(every) if t.probes}
        best = sorted((k for k in shares if shares[k] <= MOST_LEFT), key=lambda k: shares[k])[:REFINED]
        fitted = [(every[k], a) for k in best if (a := self.fitted(every[k])) is not None]
        fixed = [(t, np.zeros(0)) for t in every if not t.probes]
        return [*((t, a) for t, a in fixed if self.comes_nearer(t, a)), *fitted]

    def comes_nearer(self, trial: Trial, amounts: Array) -> bool:
        """Whether a motion leaves less than the right one, and is right where that is: the first samples decide.

        They save long runs.
        """
        for share in STAGES[:-1]:
            rows = self.stage_rows(share, len(amounts))
            here = self.off(trial, amounts, rows)
            if here is None:
                return False
            if np.abs(self.right_off(rows)).max(initial=0.0) >= TELLING:
                return self.left(here, rows) <= MOST_LEFT
            if np.abs(here).max(initial=0.0) >= TELLING:
                return False
        return True

    def right_off(self, rows: NDArray[np.intp]) -> Array:
        """Weighted differences from the right motion at some samples, (k,)."""
        return self.result.apart(self.result.right.samples(rows), rows, self.weights).ravel()

    def left(self, here: Array, rows: NDArray[np.intp]) -> float:
        """Share of the differences from the right motion that is left."""
        size = float(np.linalg.norm(self.right_off(rows)))
        return float(np.linalg.norm(here)) / size if size else math.inf

    @cached_property
    def likely_late_s(self) -> float:
        """Time by which the right motion moves nearest to the samples, on a grid, s."""
        right, rows = self.result.right, self.stage_rows(1.0, 1)
        end_s, t_s = float(self.result.scene.run.duration_s), right.t_s[rows]
        grid = np.linspace(0.0, t_s[-1] + end_s, GRID)
        seen = right_motion(self.result.scene, grid, ROUGH)
        self.steps += self.steps_of(seen)
        if seen is None:
            return 0.0
        late_s = np.append(0.0, np.concatenate([grid - t_s[0], -grid[grid < t_s[-1]]]))
        cost, count = np.zeros(len(late_s)), np.zeros(len(late_s))
        shifted = t_s[:, None] + late_s
        inside = (shifted >= 0.0) & (shifted <= grid[-1])
        for q in self.weights:
            given, motion = (getattr(t, FIELDS[q]) for t in (self.result.given.samples(rows), seen))
            if given is None or motion is None:
                continue
            lacking = self.result.absent.get(FIELDS[q])
            columns = range(given[0].size) if lacking is None else np.flatnonzero(~lacking.ravel())
            for c in columns:
                path = motion.reshape(len(grid), -1)[:, c]
                off = np.interp(shifted.ravel(), grid, path).reshape(shifted.shape)
                off -= given.reshape(len(rows), -1)[:, c, None]
                size = float(np.ptp(path)) or 1.0
                cost += np.sum(np.where(inside, (off / size) ** 2, 0.0), axis=0)
                count += np.sum(inside, axis=0)
        cost = np.where(count >= LEAST_KNOWN * count.max(), cost / np.maximum(count, 1.0), math.inf)
        return float(late_s[int(np.argmin(cost))])

    def stage_rows(self, share: float, numbers: int) -> NDArray[np.intp]:
        """Samples of a stage, spread over the first share of all."""
        last = min(len(self.rows), max(numbers + 3, math.ceil(share * len(self.rows))))
        return self.rows[np.unique(np.linspace(0, last - 1, FITTED_ROWS).astype(np.intp))]

    def off(self, trial: Trial, amounts: Array, rows: NDArray[np.intp]) -> Array | None:
        """Weighted differences from the motion of a trial at some samples, (k,); None where there is no motion."""
        if self.steps > MOST_STEPS:
            return None
        seen = trial.run(amounts, self.result.right.t_s[rows])
        self.steps += self.steps_of(seen)
        return None if seen is None else self.result.apart(seen, rows, self.weights).ravel()

    def slopes(self, trial: Trial, amounts: Array, here: Array, rows: NDArray[np.intp]) -> Array | None:
        """Change of the weighted differences by each amount, (k, m); None where there is no motion, or no change."""
        found = np.zeros((len(here), len(amounts)))
        for k, probe in enumerate(trial.probes):
            for longer in LONGER:
                step = np.zeros(len(amounts))
                step[k] = longer * probe * max(1.0, abs(amounts[k]))
                there = self.off(trial, amounts + step, rows)
                if there is None:
                    return None
                found[:, k] = (there - here) / step[k]
                if np.any(np.abs(there - here) > RESOLVED * self.sizes(rows)):
                    break
            if not found[:, k].any():
                return None
        return found

    def sizes(self, rows: NDArray[np.intp]) -> Array:
        """Sizes of the quantities at some samples in weights, (k,)."""
        found = []
        for q, weight in self.weights.items():
            values = getattr(self.result.right, FIELDS[q])
            if values is not None:
                found.append(np.repeat(self.result.scale[q] * weight[rows, None], values[0].size, axis=1))
        return np.concatenate(found, axis=1).ravel()

    def linear_share(self, trial: Trial) -> float:
        """Least share of the differences that a trial leaves by its linear effect, in the first and the last stage."""
        found = [1.0]
        for share in (STAGES[0], STAGES[-1]):
            rows, amounts = self.stage_rows(share, len(trial.probes)), np.array(trial.begin)
            here = self.off(trial, amounts, rows)
            slopes = None if here is None else self.slopes(trial, amounts, here, rows)
            if here is not None and slopes is not None and np.any(self.right_off(rows)):
                found.append(self.left(here + slopes @ least_squares(slopes, -here), rows))
        return min(found)

    def fitted(self, trial: Trial) -> Array | None:
        """Amounts by Gauss and Newton, over more and more of the samples; None where a motion ends."""
        amounts = np.array(trial.begin)
        for share in STAGES:
            rows = self.stage_rows(share, len(amounts))
            here = self.off(trial, amounts, rows)
            if here is None:
                return None
            for _ in range(ROUNDS):
                nearer = self.nearer(trial, amounts, here, rows)
                if nearer is None:
                    break
                step, here = nearer
                amounts = amounts + step
                if np.linalg.norm(step) <= CONVERGED * np.linalg.norm(amounts):
                    break
            if np.abs(self.right_off(rows)).max(initial=0.0) >= TELLING and self.left(here, rows) > MOST_LEFT:
                return None
        return amounts

    def nearer(self, trial: Trial, amounts: Array, here: Array, rows: NDArray[np.intp]) -> tuple[Array, Array] | None:
        """A step that comes nearer to the samples, and the differences after it; None where none is found."""
        slopes = self.slopes(trial, amounts, here, rows)
        whole = np.zeros(len(amounts)) if slopes is None else least_squares(slopes, -here)
        for step in (whole * 0.5**k for k in range(HALVINGS + 1)):
            there = self.off(trial, amounts + step, rows)
            if there is not None and np.linalg.norm(there) < np.linalg.norm(here):
                return step, there
        return None
