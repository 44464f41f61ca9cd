"""All runs of one engine in one scene, judged as in every comparison, and their outcome by rules applied in turn.

docs/studies/stability.md has the rules in words.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from barchain.judge.checks.beyond_limit import MAX_KINETIC_RATIO, kinetic_ratio
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.judge.scales import NORM_SLACK
from barchain.judge.verdict import MIN_JUDGED_SHARE, TWO_SETTING_METRICS
from barchain.metrics.quantities import drifts
from barchain.runs.job import Role
from barchain.solutions.reference import RICHARDSON, divergence_instant_s
from barchain.studies.stability.growth import GrowthLaw, attitude_error, grows_too_fast, growth_excess, law
from reports.tables.crossval import PARTED_RAD
from reports.tables.outcome import Outcome
from reports.tables.stability import Stability

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Trajectory
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
    engine: type[Engine]
    settings: dict[Role, Setting]
    runs: dict[Role, RunResult]
    solution: ReferenceSolution | None
    """None where it could not be run"""
    not_run: frozenset[Role] = frozenset()
    """Levels that were not run, as a coarser one was late"""

    @property
    def levels(self) -> tuple[Role, ...]:
        """Levels that were to be run."""
        return tuple(role for role in LEVELS if role in self.runs)

    def trajectory(self, role: Role) -> Trajectory | None:
        """Finite samples of one level, if there are any."""
        result = self.runs.get(role)
        return result.trajectory if result is not None and result.outcome in WITH_TRAJECTORY else None

    @cached_property
    def verdicts(self) -> dict[Role, Verdict]:
        """Verdict of each level that can be judged."""
        return {role: v for role in self.runs if (v := self.verdict(role)) is not None}

    def verdict(self, role: Role) -> Verdict | None:
        """Verdict on one level; None without its run, its other run or the reference solution."""
        mine, other = self.runs.get(role), self.runs.get(OTHER.get(role, role))
        if self.solution is None or mine is None or other is None or role not in OTHER:
            return None
        return judge(self.name, self.engine, self.settings[role], Evidence(mine, other), self.solution)

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
