"""Search for another start, clock or scene whose motion is a result that has no balance of momenta."""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import DOP853

from adapters.engine import AccuracyParameter, Setting
from barchain.judge.diagnosis.chance import foretells
from barchain.judge.diagnosis.mistake import EQUAL_FACTOR, Explanation, Mistake
from barchain.judge.diagnosis.motion.search import GAIN, least_squares
from barchain.judge.diagnosis.starts import ANGLES, RATES
from barchain.judge.diagnosis.trials import clock_trials, further_trials, right_motion, start_trials, strength_trials
from barchain.metrics.quantities import FIELDS, arrays
from reference_impl.integrate.stiffness import METHOD_NAMES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.reading_search import GivenResult
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
SETTLED = 1e-3
"""Change of the differences by a step, over their tolerances, that ends a stage, too"""
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
FOR_SHARES = 0.5
"""Share of these steps after which no linear effect is looked at any more: fits need the rest"""
WHOLE = 3.0
"""Steps of all runs, over the most for fits, after which no trial is run over the whole time any more"""
REFINED = 12
"""Trials that are fitted, the best of all by their linear effects"""
LONGER, LONGEST = 3, 1e3
"""Lengths of a probe that are tried until the motion shows it, and the largest factor from one to the next"""
RESOLVED = 1e-8
"""Least change of a quantity by a probe, relative to its size: rounding is a millionth of it"""
SAME = 2.0
"""Ratio of residuals below which explanations are in the order of the trials"""
AS_RUN = 1e-10
"""Share of the differences that a trial may leave beyond all tolerances: its runs are no better"""
ROUNDED = 1e-11
"""Residual relative to a quantity's scale that says nothing: runs of the reference leave as much"""
WITH_INERTIA = "-with-inertia"
"""Part of the names of bars' properties that change moments of inertia, too"""
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
        self.left_out = False
        """Whether some trials were not looked at, as those before took too many steps"""
        self.motions: dict[tuple[str, bytes], Trajectory | None] = {}
        self.probes: dict[tuple[str, int, bytes], float] = {}
        """Probes that motions show, by trial, amount and samples"""
        self.unchanged: dict[bytes | None, Array] = {}
        """Differences from motions without a change, by their samples: every trial begins with these"""

    @property
    def incomplete(self) -> bool:
        """Whether steps ran out before everything was tried."""
        return self.left_out or self.steps > MOST_STEPS or self.whole_steps > WHOLE * MOST_STEPS

    def steps_of(self, seen: Trajectory | None) -> float:
        """Steps of a run, by those beside faces that turn, which take as long."""
        if seen is None:
            return LOST_STEPS
        effects = self.result.scene.effects
        smooth = 1.0 if effects.on_faces else SMOOTH
        as_many = smooth if seen.info.get("method") == METHOD_NAMES[DOP853] else IMPLICIT
        return as_many * float(seen.info.get("steps", 0.0))

    def explaining(self, result: GivenResult) -> list[Explanation]:
        """Explanations of the result under its present tolerances, by the fewest fitted numbers, best first."""
        found: list[tuple[int, Explanation]] = []
        for trial, amounts in self.made:
            seen = self.seen(trial, amounts, result)
            if seen is None:
                continue
            known, motion = seen
            at = result.at(known) if len(known) < result.n else result
            without, fit = at.fit(at.right).own_error, at.fit(motion.samples(known))
            explanation = Explanation((Mistake(trial.name, trial.words(amounts), trial.section),), fit)
            fitted = 0 if trial.nice(amounts) else len(amounts)
            if (
                (explanation.explains(without) or fit.own_error <= AS_RUN * without)
                and without >= (GAIN if fitted else 1.0) * fit.own_error
                and foretells(at.digits_of(at.quantities), fitted, len(self.trials))
            ):
                found.append((fitted, explanation))
        return simplest(found)

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
    def trials(self) -> list[Trial]:
        """Clocks, starts, strengths of effects, and all other numbers of the scene and other scenes."""
        scene, compared = self.result.scene, self.result.quantities
        track, state = ({"com", "com_velocity"} <= compared, {"attitude", "rate"} <= compared)
        starts = (t for t in start_trials(scene, track=track, state=state and not self.result.absent)
                  if {"attitude", "rate"} & compared or t.section not in (ANGLES, RATES))  # fmt: skip
        clocks = clock_trials(scene, float(self.result.right.t_s[self.rows[0]]), self.likely_late_s)
        return [*clocks, *starts, *strength_trials(scene), *further_trials(scene)]

    @cached_property
    def made(self) -> list[tuple[Trial, Array]]:
        """Trials with their amounts, those that come nearer; of fitted ones, the best by their linear effects.

        Those without an amount go first: a single fit of forces that are far too strong may use all steps.
        """
        fixed = [(t, np.zeros(0)) for t in self.trials if not t.probes]
        nearer = [(t, a) for t, a in fixed if self.comes_nearer(t, a)]
        fewest_first = sorted((t for t in self.trials if t.probes), key=lambda t: len(t.probes))
        begun = (self.begun(t) for t in fewest_first if self.steps <= FOR_SHARES * MOST_STEPS)
        tried = [(t, self.linear_share(t)) for t in begun]
        self.left_out = len(tried) < sum(bool(t.probes) for t in self.trials)
        most = min(MOST_LEFT, max(sorted(share for _, share in tried)[:REFINED], default=0.0))
        best = [trial for trial, share in tried if share <= most]
        return [*self.fitted(best), *nearer]

    def begun(self, trial: Trial) -> Trial:
        """Trial that begins with a slip, if that comes nearer than the right motion."""
        for slip in trial.slips:
            if self.comes_nearer(trial, np.array([slip])):
                return dataclasses.replace(trial, begin=(slip,))
        return trial

    def comes_nearer(self, trial: Trial, amounts: Array) -> bool:
        """Whether a motion leaves less than the right one, and is right where that is: the first samples decide.

        They save long runs.
        """
        for share in STAGES[:-1]:
            rows = self.stage_rows(share, len(amounts))
            here = self.off(trial, amounts, rows)
            if here is None:
                return False
            if self.tells(rows):
                return self.left(here, rows) <= MOST_LEFT
            if np.abs(here).max(initial=0.0) >= TELLING:
                return False
        return True

    def right_off(self, rows: NDArray[np.intp]) -> Array:
        """Weighted differences from the right motion at some samples, (k,)."""
        return self.result.apart(self.result.right.samples(rows), rows, self.weights).ravel()

    def tells(self, rows: NDArray[np.intp]) -> bool:
        """Whether some samples differ enough from the right motion to tell a trial."""
        return bool(np.abs(self.right_off(rows)).max(initial=0.0) >= TELLING)

    def left(self, here: Array, rows: NDArray[np.intp]) -> float:
        """Share of the differences from the right motion that is left."""
        size = float(np.linalg.norm(self.right_off(rows)))
        return float(np.linalg.norm(here)) / size if size else math.inf

    @cached_property
    def likely_late_s(self) -> float:
        """Time by which the right motion moves nearest to the samples, on a grid, s; of several the shortest."""
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
        best = int(np.argmin(cost))
        near = cost[max(best - 1, 0) : best + 2]  # next to the best one on the grid, which orbits repeat
        alike = late_s[cost <= np.max(near[np.isfinite(near)], initial=0.0)]
        return float(alike[np.argmin(np.abs(alike))]) if len(alike) else 0.0

    def stage_rows(self, share: float, numbers: int) -> NDArray[np.intp]:
        """Samples of a stage, spread over the first share of all."""
        last = min(len(self.rows), max(numbers + 3, math.ceil(share * len(self.rows))))
        return self.rows[np.unique(np.linspace(0, last - 1, FITTED_ROWS).astype(np.intp))]

    def off(self, trial: Trial, amounts: Array, rows: NDArray[np.intp]) -> Array | None:
        """Weighted differences from the motion of a trial at some samples, (k,); None where there is no motion."""
        key = None if len(amounts) == 0 or amounts.any() else rows.tobytes()
        if key in self.unchanged:
            return self.unchanged[key]
        if self.steps > MOST_STEPS or not np.all((trial.within[0] <= amounts) & (amounts <= trial.within[1])):
            return None
        seen = trial.run(amounts, self.result.right.t_s[rows])
        self.steps += self.steps_of(seen)
        found = None if seen is None else self.result.apart(seen, rows, self.weights).ravel()
        if key is not None and found is not None:
            self.unchanged[key] = found
        return found

    def slopes(self, trial: Trial, amounts: Array, here: Array, rows: NDArray[np.intp]) -> Array | None:
        """Change of the weighted differences by each amount, (k, m); None where there is no motion, or no change."""
        found, least = np.zeros((len(here), len(amounts))), RESOLVED * self.sizes(rows)
        for k, probe in enumerate(trial.probes):
            step = np.zeros(len(amounts))
            key = (trial.name, k, rows.tobytes())
            step[k] = self.probes.get(key, probe * max(1.0, abs(amounts[k])))
            for _ in range(LONGER):
                there = self.off(trial, amounts + step, rows)
                if there is None:
                    return None
                found[:, k] = (there - here) / step[k]
                shown = float(np.max(np.abs(there - here)[least > 0.0] / least[least > 0.0], initial=0.0))
                if shown >= 1.0:
                    self.probes[key] = step[k]
                    break
                step[k] *= min(2.0 / shown, LONGEST) if shown else LONGEST
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
            if share < 1.0 and not self.tells(rows):
                continue
            here = self.off(trial, amounts, rows)
            slopes = None if here is None else self.slopes(trial, amounts, here, rows)
            if here is not None and slopes is not None and np.any(self.right_off(rows)):
                found.append(self.left(here + slopes @ least_squares(slopes, -here), rows))
        return min(found)

    def fitted(self, trials: list[Trial]) -> list[tuple[Trial, Array]]:
        """Amounts of trials by Gauss and Newton, over more and more of the samples.

        Of these some are left out on the way: those whose motion ends, and those that leave far more than others do.
        """
        found = [(t, np.array(t.begin)) for t in trials]
        for share in STAGES:
            if share < 1.0 and not self.tells(self.stage_rows(share, 0)):
                continue
            fits = [(t, fit) for t, amounts in found if (fit := self.stage(t, amounts, share)) is not None]
            left = [(len(amounts), left) for _, (amounts, left, _) in fits]
            found = [(t, amounts) for (t, (amounts, _, tells)), own in zip(fits, left, strict=True)
                     if not tells or not outdone(*own, left, EQUAL_FACTOR**2)]  # fmt: skip
        return found

    def stage(self, trial: Trial, amounts: Array, share: float) -> tuple[Array, float, bool] | None:
        """Amounts by the first share of the samples, what is left there, and whether that tells; None: too much is."""
        rows = self.stage_rows(share, len(amounts))
        here = self.off(trial, amounts, rows)
        if here is None:
            return None
        for _ in range(ROUNDS):
            nearer = self.nearer(trial, amounts, here, rows)
            if nearer is None:
                break
            step, here, settled = nearer
            amounts = amounts + step
            if settled or np.linalg.norm(step) <= CONVERGED * np.linalg.norm(amounts):
                break
        left = self.left(here, rows)
        if left > MOST_LEFT and self.tells(rows):
            return None
        return amounts, left, bool(np.abs(here).max(initial=0.0) >= TELLING)

    def nearer(
        self, trial: Trial, amounts: Array, here: Array, rows: NDArray[np.intp]
    ) -> tuple[Array, Array, bool] | None:
        """A step that comes nearer to the samples, the differences after it, and whether a next one would be none.

        None where no step is found.
        """
        slopes = self.slopes(trial, amounts, here, rows)
        if slopes is None:
            return None
        whole = least_squares(slopes, -here)
        if np.abs(slopes @ whole).max(initial=0.0) <= SETTLED:
            return None
        for share in (0.5**k for k in range(HALVINGS + 1)):
            there = self.off(trial, amounts + share * whole, rows)
            if there is not None and np.linalg.norm(there) < np.linalg.norm(here):
                bent = np.abs(there - here - slopes @ whole).max(initial=0.0)
                return share * whole, there, bool(bent <= SETTLED)
        return None


def outdone(fitted: int, error: float, others: Iterable[tuple[int, float]], factor: float) -> bool:
    """Whether one of other fits leaves far less than one with a number of fitted amounts does.

    Each amount more lets it leave less by as much.

    Parameters
    ----------
    fitted : int
    error : float
    others : iterable of tuple
        Number of fitted amounts, and error.
    factor : float
        Ratio of errors that is far.
    """
    return any(error > factor ** (1 + max(0, more - fitted)) * other for more, other in others)


def simplest(found: list[tuple[int, Explanation]]) -> list[Explanation]:
    """Explanations by the fewest fitted numbers that no other outdoes, the best ones first, else in their order.

    Of bars' properties whose moments of inertia do not show, one name is enough.
    """
    errors = [(fitted, e.fit.normalised_error) for fitted, e in found]
    kept = [each for each, own in zip(found, errors, strict=True)
            if each[1].fit.relative_error <= ROUNDED or not outdone(*own, errors, EQUAL_FACTOR)]  # fmt: skip
    fewest = min((fitted for fitted, _ in kept), default=0)
    fine = [e for fitted, e in kept if fitted == fewest]
    names = {e.names[0] for e in fine}
    single = [e for e in fine if WITH_INERTIA not in e.names[0] or e.names[0].replace(WITH_INERTIA, "") not in names]
    least = min((e.fit.normalised_error for e in single), default=0.0)
    return sorted(single, key=lambda e: e.fit.relative_error > ROUNDED and e.fit.normalised_error > SAME * least)
