"""The round-off study: digits of the reactions that each kind of coordinates leaves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from barchain.record.environment import package_version
from barchain.runs.executors import ALL_CORES
from barchain.studies.roundoff.formulations.states import MEMBERS
from barchain.studies.roundoff.objects import objects
from barchain.studies.roundoff.plan import PARTS, SCENE, RoundoffPlan, make_plan
from barchain.studies.roundoff.run import RoundoffResult, RoundoffRun
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT_DIGITS, long_doubles
from reports.tables.roundoff import FILES

if TYPE_CHECKING:
    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles


@dataclass(frozen=True)
class RoundoffOptions:
    """Options of a round-off study."""

    parts: tuple[str, ...] = PARTS
    full: bool = False
    """All sizes, arithmetics and numbers of bars, finer steps, longer runs: half an hour instead of minutes"""
    executor: Executor = ALL_CORES
    """Place of the tasks that are not timed; all cores of this machine by default"""
    sizes: tuple[float, ...] = ()
    """Sizes at which one evaluation is judged; all by default"""


@dataclass(frozen=True)
class RoundoffStudy:
    """The round-off study."""

    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: RoundoffOptions) -> RoundoffPlan:
        """Tasks of the parts.

        Raises
        ------
        ClusterError
            For a Dask cluster that can't be used.
        ValueError
            For a size at which no evaluation is judged.
        """
        plan = make_plan(options.parts, full=options.full, executor=options.executor, sizes=options.sizes)
        options.executor.check()
        return plan

    def record(self, plan: RoundoffPlan) -> dict[str, Any]:
        """Parts, arithmetics, and the objects named on the axes; failed tasks are added as they come."""
        return {
            "packages": {"gmpy2": package_version("gmpy2")},
            "full": plan.full,
            "parts": {part: {} for part in plan.parts},
            "scene": SCENE,
            "members": MEMBERS,
            "exact_digits": EXACT_DIGITS,
            "unit_roundoff": {name: a.unit_roundoff for name, a in ARITHMETICS.items()},
            "long_doubles": long_doubles(),
            "objects": objects(),
            "failed": [],
        }

    def run(self, plan: RoundoffPlan, store: StudyStore, reporter: Reporter) -> RoundoffResult:
        """Run the tasks in a pool of processes, then time evaluations alone."""
        return RoundoffRun(plan, store, reporter).run()
