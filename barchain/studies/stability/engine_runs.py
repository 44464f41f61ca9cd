"""All runs of one engine in one scene, judged as in every comparison."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.runs.job import Role
from barchain.studies.stability.plan import LEVELS
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Trajectory
    from barchain.judge.verdict import Row, Verdict
    from barchain.runs.job import RunResult
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

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
