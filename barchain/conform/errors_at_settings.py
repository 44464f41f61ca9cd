"""Errors of an engine on one scene at several settings, from coarse to fine, and the order that they show."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.equal_steps import step_s, steps_between_samples
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.trajectory import Observable
from barchain.conform.noise import quiet
from barchain.conform.runs import ended_early, results
from barchain.conform.scenes import PARTICLE, REPEATED, lasts, rejection, scene_for, solved
from barchain.judge.error_model import ErrorModel
from barchain.judge.scales import NORM_SLACK
from barchain.metrics.quantities import differences
from barchain.runs.job import Role
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Declarations
    from adapters.trajectory import Array, Trajectory
    from barchain.conform.target import Examined
    from barchain.runs.job import RunResult
    from scenarios import Scene

QUANTITIES = ("attitude", "rate", "reaction", "com", "com_velocity")
SETTINGS = 5
"""Settings that are tried, from the coarsest to the finest"""
ABOVE_ROUNDING = 10.0
"""Least ratio of an error to its rounding floor at which the error tells of the method"""
LEAST_FALL = 0.5
"""Least exponent of the error's fall relative to the method's: chosen steps leave errors of any sign"""
LEAST_FALL_OF_PART = 0.25
"""The same over a part of the scene, in which a coarse method takes a few steps: one of them may be far better than its
request. Of a right engine on SciPy's DOP853 a part's error fell by 4.3 for a hundredth of the request"""
FALL_SLACK = 2.0
"""Slack of the fall of an error"""
SAME_STEPS = 0.01
"""Relative difference of requested and taken steps that is not worth a word"""
MOST_ABOVE = 1.0
"""Largest excess of a measured order: beyond it another method runs than the declared one"""
ORDER_ROUNDED = 0.5
"""Largest shortfall of a measured order below the whole number that it stands for"""
RUN_SHARE = 0.5
"""Longest time of one run here, over that of a run in the stage of physics"""
ALL_RUNS_SHARE = 2.5
"""Time after which no finer setting is tried, over the same"""
ASYMPTOTIC = 1e-2
"""Largest relative error at which a method's order shows: the part of the scene before counts"""


@dataclass(frozen=True)
class ErrorAtSetting:
    """Errors of one setting, relative to the scales of the quantities."""

    setting: Setting
    step: float
    """Requested error, or the step relative to the distance of two samples"""
    by_quantity: dict[str, Array]
    """Largest up to each sample, (n,) for each quantity"""
    floors: Array
    """Rounding floor up to each sample, the largest of all quantities, (n,)"""
    whole: bool
    """Whether two right runs at this setting stay together to the end of the scene"""
    bound_ratio: float
    """Largest ratio of an error to its expected-error bound"""

    steps_per_orbit: float | None = None
    """Equal steps that were taken, where samples allow no others"""
    noise: Array | None = None
    """Floor with declared noise, (n,); None without"""
    bare_ratio: float = 0.0
    """`bound_ratio` without declared noise"""
    kept_ratio: float = 0.0
    """Largest ratio of the attitude's error to that of a method that keeps its request; 0 without either"""
    run: Trajectory | None = None
    scale: dict[str, float] = field(default_factory=dict)
    """Of each quantity"""

    def __str__(self) -> str:
        """The error at its setting."""
        taken, asked = self.steps_per_orbit, self.setting.value
        real = "" if taken is None or abs(taken - asked) < SAME_STEPS * asked else f" ({taken:.0f} per orbit taken)"
        return f"{f'{self.error:.1e}' if self.whole else 'too coarse'} at {self.setting}{real}"

    @property
    def errors(self) -> Array:
        """Largest error of all quantities up to each sample, (n,)."""
        found: Array = np.max(list(self.by_quantity.values()), axis=0)
        return found

    @property
    def error(self) -> float:
        """Largest error of all quantities and samples."""
        return float(self.errors[-1])

    @property
    def tells(self) -> bool:
        """Whether the error is that of the method, not of rounding or noise."""
        return self.error > ABOVE_ROUNDING * float((self.floors if self.noise is None else self.noise)[-1])

    def largest(self, samples: int) -> str:
        """Quantity of the largest error up to some samples."""
        return max(self.by_quantity, key=lambda quantity: float(self.by_quantity[quantity][samples - 1]))


@dataclass(frozen=True)
class Compared:
    """Errors of two settings over the same part of the scene: the part in which the coarse one is small."""

    coarse: float
    fine: float
    settings: tuple[Setting, Setting]
    """The coarse one and the fine one"""
    samples: int
    """Of the part"""
    finer: float
    """Ratio of the steps, or of the requested errors"""
    tells: bool
    """Whether the finer error is that of the method, not of rounding"""
    whole: bool
    """Whether the part is the whole scene"""
    noise: float = 0.0
    """Declared noise at the finer setting"""
    quantity: str = ""
    """That of the finer error"""
    apart: float = math.inf
    """Largest difference of the two runs in it"""

    def __str__(self) -> str:
        """Both errors, with the part of the scene."""
        one, other = self.settings
        part = "" if self.whole else f" up to sample {self.samples}"
        return f"{self.coarse:.1e} at {one} and {self.fine:.1e} at {other}{part}"

    @property
    def noisy(self) -> bool:
        """Whether the declared noise explains the finer error."""
        return self.fine <= ABOVE_ROUNDING * self.noise

    def falls(self, order: float | None) -> bool:
        """Whether the error falls as far as that of a method of an order must, or is below its request.

        Where samples, not the request, decide the steps, errors far below the request need not fall.
        """
        if order is None and self.fine <= self.settings[1].value:
            return True
        least = float(self.finer ** ((LEAST_FALL if self.whole else LEAST_FALL_OF_PART) * (order or 1.0)))
        return self.fine * least <= FALL_SLACK * self.coarse

    @property
    def order(self) -> float:
        """Exponent of the error's fall."""
        return math.log(self.coarse / self.fine) / math.log(self.finer)


def compared(found: list[ErrorAtSetting]) -> list[Compared]:
    """Neighbouring settings whose errors can be compared, from coarse to fine."""
    pairs = []
    for coarse, fine in pairwise(found):
        n = min(int(np.count_nonzero(coarse.errors < ASYMPTOTIC)), len(fine.errors))
        if n > 1 and coarse.errors[n - 1] > 0.0 and fine.errors[n - 1] > 0.0:
            tells = bool(fine.errors[n - 1] > ABOVE_ROUNDING * fine.floors[n - 1])
            whole = coarse.whole and n == len(coarse.errors)
            errors = float(coarse.errors[n - 1]), float(fine.errors[n - 1])
            noise = 0.0 if fine.noise is None else float(fine.noise[n - 1])
            settings, quantity, apart = (coarse.setting, fine.setting), fine.largest(n), math.inf
            if coarse.run is not None and fine.run is not None:
                apart = float(differences(coarse.run, fine.run)[quantity][:n].max()) / fine.scale[quantity]
            ratio = coarse.step / fine.step
            pairs.append(Compared(*errors, settings, n, ratio, tells, whole, noise, quantity, apart))
    return pairs


@dataclass(frozen=True)
class SettingRuns:
    """Runs of an engine at several settings, from coarse to fine; the last ones may be missing for lack of time."""

    scene: Scene
    settings: tuple[Setting, ...]
    results: tuple[RunResult, ...]

    @property
    def faults(self) -> dict[Setting, str]:
        """Reason why a run has no error that can be judged; empty without one."""
        return {s: self.fault(r) for s, r in zip(self.settings, self.results, strict=False)}

    def fault(self, result: RunResult) -> str:
        """Reason of one run."""
        if result.outcome is not Outcome.PASS or result.trajectory is None:
            return result.reason
        return ended_early(self.scene, result.trajectory)

    def errors(self, engine: Declarations) -> list[ErrorAtSetting]:
        """Errors of the runs without a fault."""
        faults = self.faults
        each = zip(self.settings, self.results, strict=False)
        return [setting_error(engine, self.scene, s, r.trajectory) for s, r in each if r.trajectory and not faults[s]]


def repeated_scene(engine: Declarations) -> str | None:
    """Scene of accuracy: the first that an engine supports; None without one."""
    scenes = REPEATED if Observable.ATTITUDE in engine.observables else PARTICLE
    for name in scenes:
        with suppress(EngineError):
            if rejection(engine, scene_for(engine, name)) is None:
                return name
    return None


@cache
def setting_runs(engine: Examined, name: str) -> SettingRuns:
    """Runs of a scene at several settings."""
    scene = engine.scene(name)
    settings = tried_settings(engine.declarations, scene)
    jobs = [engine.job(scene, setting, Role.MAIN) for setting in settings]
    engine.note(f"accuracy: {len(jobs)} settings on {name}")
    limit_s, all_s = RUN_SHARE * engine.run_s, ALL_RUNS_SHARE * engine.run_s
    made = results(engine, jobs, [solved(scene).trajectory.t_s] * len(jobs), limit_s, all_s)
    return SettingRuns(scene, tuple(settings), tuple(made))


@cache
def judged_declarations(engine: Examined) -> Declarations:
    """Declarations that judge: the engine's, with the order that its errors show if it declares a lower one.

    A declared order that is too low allows any error, and asks for settings that are needlessly fine. The order is
    measured where the declared one makes the default setting too coarse for an ordinary scene.
    """
    loaded, name = engine.declarations, repeated_scene(engine.declarations)
    if loaded.order is None or name is None or lasts(loaded, loaded.sweep.setting(), engine.scene(name)):
        return loaded
    slopes = slopes_above(setting_runs(engine, name).errors(loaded), loaded.order)
    if not slopes:
        return loaded
    return replace(loaded, order=float(math.floor(min(slopes) + ORDER_ROUNDED)))


def slopes_above(found: list[ErrorAtSetting], order: float) -> list[float]:
    """Measured orders that are all far above a declared one; empty if they are not.

    A single coarse pair, or a short part of the scene, may show more than the order.
    """
    pairs = [pair for pair in compared(found) if pair.tells and not pair.noisy]
    every = [[pair.order for pair in pairs if pair.whole], [pair.order for pair in pairs]]
    return next((slopes for slopes in every if len(slopes) > 1 and min(slopes) > order + MOST_ABOVE), [])


def tried_settings(engine: Declarations, scene: Scene) -> list[Setting]:
    """Some settings of the sweep, coarse to fine, its ends among them, that differ in this scene."""
    every = list({step_of(s, scene): s for s in reversed(engine.sweep.settings)}.values())[::-1]
    rows = np.unique(np.linspace(0, len(every) - 1, min(SETTINGS, len(every))).round().astype(int))
    return [every[k] for k in rows]


def step_of(setting: Setting, scene: Scene) -> float:
    """Equal steps relative to the distance of two samples, which holds an even number; or the requested error."""
    if setting.parameter is AccuracyParameter.RTOL:
        return setting.value
    return 1.0 / steps_between_samples(scene, setting.value)


def setting_error(engine: Declarations, scene: Scene, setting: Setting, run: Trajectory) -> ErrorAtSetting:
    """Errors of one run."""
    solution = solved(scene)
    errors = ErrorModel(engine, setting, solution, run)
    bare = ErrorModel(quiet(engine), setting, solution, run)
    apart = {q: v for q, v in differences(run, solution.trajectory).items() if q in QUANTITIES}
    n = int(np.count_nonzero(errors.t_s <= errors.limit_s))  # two right runs part later
    until_now = np.maximum.accumulate

    def floors(model: ErrorModel) -> Array:
        return until_now(np.max([model.unbounded_floor[q][:n] / errors.scale[q] for q in apart], axis=0))

    def ratio(model: ErrorModel) -> float:
        bounds = {
            q: model.bound[q][:n] + solution.error[q][:n] + NORM_SLACK * model.unbounded_floor[q][:n] for q in apart
        }
        return max(float(np.max(v[:n] / np.where(bounds[q] > 0.0, bounds[q], np.inf))) for q, v in apart.items())

    equal_steps = setting.parameter is AccuracyParameter.STEPS_PER_ORBIT
    taken = scene.step_period_s / step_s(scene, setting.value) if equal_steps else None
    by_quantity = {q: until_now(v[:n] / errors.scale[q]) for q, v in apart.items()}
    kept = 0.0
    if not equal_steps and "attitude" in apart:
        kept = float((apart["attitude"][:n] / errors.kept_request["attitude"][:n]).max())
    return ErrorAtSetting(
        setting, step_of(setting, scene), by_quantity, floors(bare), n == errors.n, ratio(errors), taken,
        floors(errors), ratio(bare), kept, run, errors.scale,
    )  # fmt: skip
