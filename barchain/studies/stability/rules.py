"""All runs of one engine in one scene, judged as in every comparison, and their outcome by rules applied in turn.

docs/studies/stability.md has the rules in words. Drifts and errors grow as a power of time, which is fitted, or faster
than the scene's own error amplification.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from barchain.judge.checks.beyond_limit import MAX_KINETIC_RATIO, kinetic_ratio
from barchain.judge.evidence import Evidence
from barchain.judge.scales import NORM_SLACK
from barchain.judge.verdict import MIN_JUDGED_SHARE, TWO_SETTING_METRICS
from barchain.metrics.quantities import differences, drifts
from barchain.runs.job import Role
from barchain.solutions.reference import PERTURBATION_RAD, RICHARDSON, divergence_instant_s
from barchain.studies.timing.statistics import slope
from reports.results.comparison import PARTED_RAD
from reports.results.outcome import Outcome
from reports.results.stability import Stability

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.verdict import Row, Verdict
    from barchain.runs.job import RunResult
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

LEVELS = (Role.COARSE, Role.MAIN, Role.FINER)
"""Settings of an engine, the coarsest first"""
OTHER = {Role.COARSE: Role.MAIN, Role.MAIN: Role.FINER, Role.FINER: Role.MAIN, Role.PLAIN: Role.MAIN}
"""Run that a level's own error is estimated with: the next finer one; of the finest, the one before it, which is off by
more"""
JUDGED = (Role.MAIN, Role.FINER)
"""Levels that an outcome hangs on; the coarse one shows how the error falls"""
LEVEL_WORDS = {
    Role.COARSE: "coarse",
    Role.MAIN: "default",
    Role.FINER: "finer",
    Role.PLAIN: "SciPy's own",
    Role.EXACT: "exact",
    Role.SOLUTION: "solution",
}
WITH_TRAJECTORY = frozenset({Outcome.PASS, Outcome.JOINTS_IGNORED})
"""Runs that gave finite samples; of joints that open, wrong ones"""
ILL_POSED = "ill-posed"  # tag of scenes in which nobody need be stable
DRIFT = "drift"


@dataclass(frozen=True)
class EngineRuns:
    """Runs of one engine in one scene."""

    scene: Scene
    name: str
    engine: Declarations
    settings: dict[Role, Setting]
    runs: dict[Role, RunResult]
    solution: ReferenceSolution | None
    """None where it could not be run"""
    not_run: frozenset[Role] = frozenset()
    """Levels that were not run, as a coarser one was late"""
    verdicts: Mapping[Role, Verdict] = field(default_factory=dict)
    """Verdict of each level that can be judged"""

    @property
    def levels(self) -> tuple[Role, ...]:
        """Levels that were to be run."""
        return tuple(role for role in LEVELS if role in self.runs)

    def trajectory(self, role: Role) -> Trajectory | None:
        """Finite samples of one level, if there are any."""
        result = self.runs.get(role)
        return result.trajectory if result is not None and result.outcome in WITH_TRAJECTORY else None

    def rows(self, role: Role) -> list[Row]:
        """Rows of one level's verdict."""
        found = self.verdicts.get(role)
        return found.rows if found is not None else []

    def mean_step_s(self, role: Role) -> float | None:
        """Mean step of one level, s; None where its engine does not count them."""
        trajectory, setting = self.trajectory(role), self.settings.get(role)
        if trajectory is None or setting is None:
            return None
        if setting.parameter is AccuracyParameter.STEPS_PER_ORBIT:
            return step_s(self.scene, setting.value)
        steps = float(trajectory.info.get("steps", 0.0))
        return float(trajectory.t_s[-1]) / steps if steps else None


def judged_evidence(runs: Mapping[Role, RunResult]) -> dict[Role, Evidence]:
    """Runs of each level that a verdict on it rests on."""
    return {role: Evidence(runs[role], runs[other]) for role, other in OTHER.items() if role in runs and other in runs}


@dataclass(frozen=True)
class Finding:
    """Outcome of an engine in a scene."""

    stability: Stability
    reason: str = ""
    slow: bool = False
    """Whether a faster machine might see another outcome"""
    quantity: str = ""
    """Drifting quantity; empty if there is none"""
    law: GrowthLaw | None = None
    """How"""


def finding(engine_runs: EngineRuns) -> Finding:
    """Outcome by the first rule that applies; the most severe rules come first."""
    for rule in (rejected, failed, unstable, inaccurate, drifting):
        found = rule(engine_runs)
        if found is not None:
            return found
    return Finding(Stability.STABLE)


def rejected(engine_runs: EngineRuns) -> Finding | None:
    """Rejected: the engine raises a reason before its first step."""
    main = engine_runs.runs[Role.MAIN]
    return Finding(Stability.REJECTED, main.reason) if main.rejected else None


def failed(engine_runs: EngineRuns) -> Finding | None:
    """Failed: no finite trajectory to the reference solution's end at the default or the finer setting.

    Also where there is no reference solution. Time-outs depend on the machine, and are marked so.
    """
    for role in JUDGED:
        result = engine_runs.runs[role]
        if result.outcome not in WITH_TRAJECTORY:
            said = result.reason or result.outcome.advice
            return Finding(Stability.FAILED, said + at(role), result.outcome is Outcome.TIMED_OUT)
    if engine_runs.solution is None:
        return Finding(Stability.FAILED, "the reference solution of the scene could not be run")
    for role in JUDGED:
        for row in engine_runs.rows(role):
            if row["quantity"] == "run" and row["outcome"] == Outcome.INCOMPLETE:
                return Finding(Stability.FAILED, row["reason"] + at(role))
    return None


def unstable(engine_runs: EngineRuns) -> Finding | None:
    """Unstable: finite, and blown up at the default or the finer setting."""
    if engine_runs.solution is None:
        return None
    for role in JUDGED:
        trajectory = engine_runs.trajectory(role)
        said = trajectory and (blown_up(trajectory, engine_runs.solution) or ran_away(trajectory, engine_runs.solution))
        if said:
            return Finding(Stability.UNSTABLE, said + at(role))
    said = grows_with_finer(engine_runs, engine_runs.solution)
    return Finding(Stability.UNSTABLE, said) if said else None


def blown_up(trajectory: Trajectory, solution: ReferenceSolution) -> str:
    """Kinetic energy about the centre of mass above its maximum, after the attitude has left the reference solution."""
    ratio = kinetic_ratio(trajectory, solution)
    if ratio is None or ratio <= MAX_KINETIC_RATIO:
        return ""
    end = float(solution.trajectory.t_s[-1])
    left = divergence_instant_s(trajectory, solution.trajectory)
    if left >= end:
        return ""
    return f"{ratio:.3g} times the largest kinetic energy there can be, attitude lost at t = {left:.6g} of {end:.6g} s"


def ran_away(trajectory: Trajectory, solution: ReferenceSolution) -> str:
    """A departure from an unstable equilibrium that grows faster than its linear growth."""
    excess = growth_excess(trajectory, solution)
    if excess is None or not grows_too_fast(excess):
        return ""
    return f"its departure grew {excess:.3g} times more than the scene's error amplification, allowed: {NORM_SLACK:g}"


def grows_with_finer(engine_runs: EngineRuns, solution: ReferenceSolution) -> str:
    """Attitude that is accurate at the default setting, and inconsistent at the finer one."""
    errors = [
        e for role in JUDGED if (t := engine_runs.trajectory(role)) is not None and (e := attitude_error(t, solution))
    ]
    if len(errors) < len(JUDGED):
        return ""
    main, finer = (float(apart.max()) for _, apart in errors)
    wrong = any(r["quantity"] == "attitude" and not Outcome(r["outcome"]).ok for r in engine_runs.rows(Role.FINER))
    if main > PARTED_RAD or finer <= RICHARDSON * main or not wrong:
        return ""
    return f"a finer setting makes the attitude's error {finer / main if main else float('inf'):.3g} times larger"


def inaccurate(engine_runs: EngineRuns) -> Finding | None:
    """Inaccurate: finite, and rejected by the comparison point by point, up to the predictability limit."""
    for role in JUDGED:
        result = engine_runs.runs[role]
        if result.outcome is Outcome.JOINTS_IGNORED:
            return Finding(Stability.INACCURATE, result.reason + at(role))
        rows = [r for r in engine_runs.rows(role) if r["metric"] != DRIFT and r["metric"] not in TWO_SETTING_METRICS]
        wrong = [r for r in rows if counts_against(r, engine_runs)]
        if wrong:
            return Finding(Stability.INACCURATE, worst(wrong) + at(role))
    return None


def counts_against(row: Row, engine_runs: EngineRuns) -> bool:
    """Whether a row stands against an engine.

    Settings that part early count only where the reference solution's own predictability limit is later.
    """
    outcome = Outcome(row["outcome"])
    if outcome is Outcome.TOO_COARSE:
        return engine_runs.solution is not None and row["limit_s"] <= MIN_JUDGED_SHARE * engine_runs.solution.limit_s
    return not outcome.ok


def worst(wrong: list[Row]) -> str:
    """The row farthest outside, in words; inconsistent rows before those that exceed a bound.

    A quantity beyond its expected-error bound is represented by the row of its largest difference.
    """

    def grave(row: Row) -> tuple[bool, bool, float]:
        whole = row["quantity"] == "run"
        inconsistent = row["outcome"] == Outcome.INCONSISTENT
        return whole, inconsistent, float(row["value"] or 0.0) if row["metric"] != "max" else 0.0

    row = max(wrong, key=grave)
    named = "" if row["quantity"] == "run" else f"{row['quantity'].replace('_', ' ')}: "
    said = next(r["reason"] for r in (row, *wrong) if r["quantity"] == row["quantity"] and r["reason"])
    return f"{named}{said}"


def drifting(engine_runs: EngineRuns) -> Finding | None:
    """Drifting: an invariant exceeds its drift bound at the default or the finer setting."""
    for role in JUDGED:
        trajectory = engine_runs.trajectory(role)
        out = [r for r in engine_runs.rows(role) if r["metric"] == DRIFT and not Outcome(r["outcome"]).ok]
        if not out or trajectory is None:
            continue
        row = max(out, key=lambda r: float(r["value"]) / float(r["tolerance"]) if r["tolerance"] else float("inf"))
        found = law(trajectory.t_s, drifts(engine_runs.scene, trajectory)[row["quantity"]])
        words = f", {found.words}" if found else ""
        said = f"{row['quantity'].replace('_', ' ')}: {row['reason']}{words}{at(role)}"
        return Finding(Stability.DRIFTING, said, quantity=row["quantity"], law=found)
    return None


def at(role: Role) -> str:
    """Name of the setting, where it is not the default."""
    return "" if role is Role.MAIN else f" (at its {LEVEL_WORDS[role]} setting)"


DECADES = 1.0  # of time, up to the end: earlier, a drift is what one revolution leaves, and hides how it grows
POINTS = 24  # evenly spaced in log t: a running maximum says nothing new from one sample to the next
CLEAR = 10.0  # times the first size, or the reference solution's own error, from which an error counts as grown
FEWEST = 5  # samples of a fit
UNSTABLE = "unstable"  # tag of scenes on an unstable equilibrium


@dataclass(frozen=True)
class GrowthLaw:
    """``drift = at_end (t/T)^exponent`` over the last decade of a run that ends at T."""

    exponent: float
    low: float
    high: float
    """Student's interval at 95 % of the exponent; of one realisation, so that another random walk may lie outside"""
    at_end: float

    @property
    def words(self) -> str:
        """``as t^0.98 (0.95 to 1.01), 3.2e-09 at the end``."""
        return f"as t^{self.exponent:.2f} ({self.low:.2f} to {self.high:.2f}), {self.at_end:.2g} at the end"


def law(t_s: Array, drift: Array) -> GrowthLaw | None:
    """Law of a drift, fitted to its running maximum by least squares in both logarithms.

    Parameters
    ----------
    t_s, drift : ndarray, shape (n,)

    Returns
    -------
    Law or None
        None where the drift is zero or seen too few times.
    """
    finite = np.isfinite(drift)
    t, largest = t_s[finite], np.maximum.accumulate(np.abs(drift[finite]))
    if len(t) < FEWEST:
        return None
    wanted = np.geomspace(t[-1] * 10.0**-DECADES, t[-1], POINTS)
    at = np.unique(np.searchsorted(t, wanted * (1.0 - 1e-12)))
    at = at[(t[at] > 0.0) & (largest[at] > 0.0)]
    if len(at) < FEWEST:
        return None
    found = slope(np.log(t[at]), np.log(largest[at]))
    return GrowthLaw(found.value, found.low, found.high, float(largest[-1]))


def attitude_error(trajectory: Trajectory, solution: ReferenceSolution) -> tuple[Array, Array] | None:
    """Instants up to the predictability limit, s, and attitude errors there, rad, each (n,); None without attitude."""
    apart = differences(trajectory, solution.trajectory).get("attitude")
    if apart is None:
        return None
    t = solution.trajectory.t_s[: len(apart)]
    inside = t <= solution.limit_s
    return t[inside], apart[inside]


def exponential_rate(t_s: Array, size: Array, inside: NDArray[np.bool_]) -> tuple[float, float] | None:
    """Rate of exponential growth, 1/s, and its lower end, over the samples inside; None of too few."""
    if np.count_nonzero(inside) < FEWEST:
        return None
    found = slope(t_s[inside], np.log(size[inside]))
    return found.value, found.low


def linear_rate(solution: ReferenceSolution) -> tuple[float, float] | None:
    """Rate of the scene's error amplification, 1/s: that of the perturbed run while it is linear."""
    amplification = solution.amplification
    inside = (amplification > CLEAR) & (amplification < PARTED_RAD / PERTURBATION_RAD)
    return exponential_rate(solution.trajectory.t_s[: len(amplification)], amplification, inside)


def own_motion(solution: ReferenceSolution) -> Array:
    """Largest departure of the reference solution from its initial attitude so far, (n,) rad, to its own horizontal."""
    trajectory = solution.trajectory
    assert trajectory.angle_rad is not None
    longitude = np.unwrap(np.arctan2(trajectory.com_m[:, 1], trajectory.com_m[:, 0]))
    stood = trajectory.angle_rad - longitude[:, None]
    largest: Array = np.maximum.accumulate(np.abs(stood - stood[0]).max(axis=1))
    return largest


def growth_excess(trajectory: Trajectory, solution: ReferenceSolution) -> float | None:
    """Growth of an error over the scene's linear error amplification; None where no growth is resolved.

    Asked of scenes on an unstable equilibrium (tag `unstable`): elsewhere nothing grows exponentially from the start.

    Both rates are fitted, and that of the departure is taken at the lower end of its interval. Errors that are added
    on the way make a departure grow faster than the linear rate at first only: from ten times its first size on by
    less than a tenth more in all. The fit covers instants at which the departure exceeds the reference solution's own
    motion. Where the reference solution moves more, a method errs in proportion to a motion that itself grows, which
    feeds the departure and is no instability.
    """
    if UNSTABLE not in solution.scene.tags:
        return None
    error, own = attitude_error(trajectory, solution), linear_rate(solution)
    if error is None or own is None:
        return None
    t, apart = error
    size = np.maximum.accumulate(apart)
    nonzero = size[size > 0.0]
    if not len(nonzero):
        return None
    clear = CLEAR * np.maximum(nonzero[0], solution.error["attitude"][: len(size)])
    inside = (size > np.maximum(clear, own_motion(solution)[: len(size)])) & (size < PARTED_RAD)
    found = exponential_rate(t, size, inside)
    if found is None:
        return None
    return float(np.exp((found[1] - own[0]) * np.ptp(t[inside])))


def grows_too_fast(excess: float | None) -> bool:
    """Whether an error grew by more than the scene's amplification and the slack of every bound."""
    return excess is not None and excess > NORM_SLACK
