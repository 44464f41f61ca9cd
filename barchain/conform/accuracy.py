"""Accuracy against the setting: errors that fall as requested, within the promised bound, with the declared order."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.equal_steps import step_s, steps_between_samples
from adapters.engine import AccuracyParameter, Setting
from adapters.trajectory import Observable
from barchain.conform.checks import FAILED, PASSED, WARNING, Check
from barchain.conform.physics import reason_against, unsupported_check
from barchain.conform.runs import TIME_LIMITS, ended_early, results
from barchain.conform.target import PARTICLE, REPEATED, scene_of, solved
from barchain.judge.diagnosis.words import SINGLE_PRECISION, looks_single
from barchain.judge.error_model import ErrorModel
from barchain.judge.scales import NORM_SLACK
from barchain.metrics.quantities import differences
from barchain.runs.job import Role
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array
    from barchain.conform.target import Examined
    from barchain.runs.job import RunResult
    from scenarios import Scene

QUANTITIES = ("attitude", "rate", "reaction", "com", "com_velocity")
SETTINGS = 5
"""Settings that are tried, from the coarsest to the finest"""
RUN_SHARE = 0.5
"""Longest time of one run here, over that of a run in the stage of physics"""
ALL_RUNS_SHARE = 2.5
"""Time after which no finer setting is tried, over the same"""
ABOVE_ROUNDING = 10.0
"""Least ratio of an error to its rounding floor at which the error tells of the method"""
LEAST_FALL = 0.5
"""Least exponent of the error's fall relative to the method's: chosen steps leave errors of any sign"""
LEAST_FALL_OF_PART = 0.25
"""The same over a part of the scene, in which a coarse method takes a few steps: one of them may be far better than its
request. Of a right engine on SciPy's DOP853 a part's error fell by 4.3 for a hundredth of the request"""
FALL_SLACK = 2.0
"""Slack of the fall of an error"""
ORDER_SLACK = 0.5
"""Largest shortfall of a measured order: between it and the next lower order"""
MOST_ABOVE = 1.0
"""Largest excess of a measured order: beyond it another method runs than the declared one"""
SAME_STEPS = 0.01
"""Relative difference of requested and taken steps that is not worth a word"""
ASYMPTOTIC = 1e-2
"""Largest relative error at which a method's order shows: the part of the scene before counts"""
HELD_ORDER = (0.5, 1.5)
"""Measured orders between which something is probably held over a step"""


@dataclass(frozen=True)
class ErrorAtSetting:
    """Errors of one setting, relative to the scales of the quantities."""

    setting: Setting
    step: float
    """Requested error, or the step relative to the distance of two samples"""
    errors: Array
    """Largest up to each sample, of all quantities, (n,)"""
    floors: Array
    """Rounding floor up to each sample, the largest of all quantities, (n,)"""
    whole: bool
    """Whether two right runs at this setting stay together to the end of the scene"""
    bound_ratio: float
    """Largest ratio of an error to its expected-error bound"""

    steps_per_orbit: float | None = None
    """Equal steps that were taken, where samples allow no others"""

    def __str__(self) -> str:
        """The error at its setting."""
        taken, asked = self.steps_per_orbit, self.setting.value
        real = "" if taken is None or abs(taken - asked) < SAME_STEPS * asked else f" ({taken:.0f} per orbit taken)"
        return f"{f'{self.error:.1e}' if self.whole else 'too coarse'} at {self.setting}{real}"

    @property
    def error(self) -> float:
        """Largest error of all quantities and samples."""
        return float(self.errors[-1])

    @property
    def tells(self) -> bool:
        """Whether the error is that of the method, not of rounding."""
        return self.error > ABOVE_ROUNDING * float(self.floors[-1])


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

    def __str__(self) -> str:
        """Both errors, with the part of the scene."""
        one, other = self.settings
        part = "" if self.whole else f" up to sample {self.samples}"
        return f"{self.coarse:.1e} at {one} and {self.fine:.1e} at {other}{part}"

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
            settings = coarse.setting, fine.setting
            pairs.append(Compared(*errors, settings, n, coarse.step / fine.step, tells, whole))
    return pairs


def accuracy(engine: Examined) -> Iterator[Check]:
    """Checks of errors at several settings."""
    scenes = REPEATED if Observable.ATTITUDE in engine.load().observables else PARTICLE
    name = next((n for n in scenes if reason_against(engine, n) is None), None)
    if name is None:
        yield unsupported_check(engine, "errors at several settings", scenes)
        return
    settings = tried_settings(engine, scene_of(name))
    jobs = [engine.job(scene_of(name), setting, Role.MAIN) for setting in settings]
    engine.note(f"accuracy: {len(jobs)} settings on {name}")
    limit_s, all_s = RUN_SHARE * engine.run_s, ALL_RUNS_SHARE * engine.run_s
    made = results(engine, jobs, [solved(name).trajectory.t_s] * len(jobs), limit_s, all_s)
    faults = {s: fault_of(name, r) for s, r in zip(settings, made, strict=False)}
    failed = [f"{s}: {fault}" for s, fault in faults.items() if fault]
    if len(made) < len(settings):
        said = f"{len(made)} of {len(settings)} settings end within {all_s:g} s"
        yield Check("time of runs", WARNING if made else FAILED, said, scene=name)
    if failed:
        late = any(r.outcome is Outcome.TIMED_OUT for r in made)
        page = TIME_LIMITS if late else ""
        yield Check("runs at several settings", FAILED, "; ".join(failed), page, scene=name)
    found = [setting_error(engine, name, s, r) for s, r in zip(settings, made, strict=False) if not faults[s]]
    if not found:
        return
    order = engine.load().order
    yield bound_check(found, name)
    yield falling_check(found, order, name)
    yield request_check(found, name) if order is None else order_check(found, float(order), name)


def fault_of(name: str, result: RunResult) -> str:
    """Reason why a run has no error that can be judged; empty without one."""
    if result.outcome is not Outcome.PASS or result.trajectory is None:
        return result.reason
    return ended_early(scene_of(name), result.trajectory)


def tried_settings(engine: Examined, scene: Scene) -> list[Setting]:
    """Some settings of the sweep, coarse to fine, its ends among them, that differ in this scene."""
    every = list({step_of(s, scene): s for s in reversed(engine.load().sweep.settings)}.values())[::-1]
    rows = np.unique(np.linspace(0, len(every) - 1, min(SETTINGS, len(every))).round().astype(int))
    return [every[k] for k in rows]


def step_of(setting: Setting, scene: Scene) -> float:
    """Equal steps relative to the distance of two samples, which holds an even number; or the requested error."""
    if setting.parameter is AccuracyParameter.RTOL:
        return setting.value
    return 1.0 / steps_between_samples(scene, setting.value)


def setting_error(engine: Examined, name: str, setting: Setting, result: RunResult) -> ErrorAtSetting:
    """Errors of one run."""
    assert result.trajectory is not None
    solution = solved(name)
    errors = ErrorModel(engine.load(), setting, solution, result.trajectory)
    apart = {q: v for q, v in differences(result.trajectory, solution.trajectory).items() if q in QUANTITIES}
    n = int(np.count_nonzero(errors.t_s <= errors.limit_s))  # two right runs part later
    relative = np.max([v[:n] / errors.scale[q] for q, v in apart.items()], axis=0)
    floors = np.max([errors.unbounded_floor[q][:n] / errors.scale[q] for q in apart], axis=0)
    noise = {q: NORM_SLACK * errors.unbounded_floor[q][:n] for q in apart}
    bounds = {q: errors.bound[q][:n] + solution.error[q][:n] + noise[q] for q in apart}
    ratio = max(float(np.max(v[:n] / np.where(bounds[q] > 0.0, bounds[q], np.inf))) for q, v in apart.items())
    scene = scene_of(name)
    equal_steps = setting.parameter is AccuracyParameter.STEPS_PER_ORBIT
    taken = scene.step_period_s / step_s(scene, setting.value) if equal_steps else None
    until_now = np.maximum.accumulate
    return ErrorAtSetting(
        setting, step_of(setting, scene), until_now(relative), until_now(floors), n == errors.n, ratio, taken
    )


def bound_check(found: list[ErrorAtSetting], name: str) -> Check:
    """Check that every error is inside the bound that the setting and the declarations promise."""
    beyond = [e for e in found if not e.bound_ratio <= 1.0]
    if beyond:
        said = "; ".join(f"{e.bound_ratio:.3g} times the bound at {e.setting}" for e in beyond)
        return Check("errors inside the bound", FAILED, said, scene=name)
    most = max(e.bound_ratio for e in found)
    return Check("errors inside the bound", PASSED, f"at most {most:.2g} of it", scene=name)


def falling_check(found: list[ErrorAtSetting], order: float | None, name: str) -> Check:
    """Check that a finer setting gives a smaller error, down to rounding."""
    shown, pairs = ", ".join(map(str, found)), compared(found)
    if not pairs:
        few = "one setting gave a result, so that no fall shows"
        said = f"no two errors are below {ASYMPTOTIC:g}, where they have to fall" if len(found) > 1 else few
        return Check("errors fall with the setting", WARNING, f"{said}: {shown}", scene=name)
    for pair in pairs:
        if pair.tells and not pair.falls(order) and not third_setting_falls(found, pair, order):
            hint = f". {SINGLE_PRECISION}" if all(looks_single(e) for e in (pair.coarse, pair.fine)) else ""
            said = f"the error does not follow the setting, {pair}: {shown}{hint}"
            return Check("errors fall with the setting", FAILED, said, scene=name)
    return Check("errors fall with the setting", PASSED, shown, scene=name)


def third_setting_falls(found: list[ErrorAtSetting], pair: Compared, order: float | None) -> bool:
    """Whether the error of a method that chooses its steps falls past a pair of settings between which it does not.

    A sum of errors of any sign may be small at one setting by chance. The next finer setting then decides.
    """
    k = next(k for k, each in enumerate(found) if each.setting == pair.settings[0])
    further = compared([found[k], found[k + 2]]) if order is None and k + 2 < len(found) else []
    return any(further_pair.falls(order) for further_pair in further)


def request_check(found: list[ErrorAtSetting], name: str) -> Check:
    """Tell the ratio of the error to the requested one."""
    ratios = [e.error / e.setting.value for e in found if e.tells]
    if not ratios:
        return Check("error over request", PASSED, "rounding at all settings", scene=name)
    said = f"{min(ratios):.2g} to {max(ratios):.2g} times the request"
    return Check("error over request", PASSED, said, scene=name)


def order_check(found: list[ErrorAtSetting], order: float, name: str) -> Check:
    """Check the declared order of a method of equal steps."""
    pairs = [pair for pair in compared(found) if pair.tells]
    slopes, whole = [pair.order for pair in pairs], [pair.order for pair in pairs if pair.whole]
    if not slopes:
        return Check("order", WARNING, "no two settings whose errors show the order", scene=name)
    measured = ", ".join(f"{s:.2f}" for s in slopes)
    said = f"measured {measured}, declared {order:g}{'; the finest pair counts' if len(slopes) > 1 else ''}"
    if slopes[-1] < order - ORDER_SLACK:
        held = HELD_ORDER[0] < slopes[-1] < HELD_ORDER[1]
        hint = "; order 1 is that of Euler's method, or of a force that is held over a step" if held else ""
        return Check("order", FAILED, said + hint, scene=name)
    above = (pairs for pairs in (whole, slopes) if len(pairs) > 1 and min(pairs) > order + MOST_ABOVE)
    if any(above):  # a single coarse pair, or a short part, may show more
        return Check("order", WARNING, said, scene=name)
    return Check("order", PASSED, f"measured {measured}; declared {order:g}", scene=name)
