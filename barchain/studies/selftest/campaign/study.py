"""The random campaign: engines and faults on random scenes, and the rates of wrong verdicts."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from barchain.faults.catalogue import RANDOM_SCENES, find
from barchain.runs.executors import ALL_CORES
from barchain.runs.selection import chosen_engines
from barchain.studies.selftest.campaign.cells import CampaignCell
from barchain.studies.selftest.campaign.findings import kept_findings, kinds
from barchain.studies.selftest.campaign.judging import judge_in_workers
from barchain.studies.selftest.campaign.rates import passed, rates
from barchain.studies.selftest.campaign.scenes.draw import draw
from barchain.studies.selftest.campaign.store import CampaignStore
from barchain.studies.selftest.campaign.trial_runner import CampaignRunner
from barchain.studies.selftest.runs import RunCache, in_workers
from reports.tables.faults.campaign import FILES

if TYPE_CHECKING:
    from collections.abc import Iterator

    from barchain.record.study_store import StudyStore
    from barchain.runs.executors import Executor
    from barchain.studies.selftest.campaign.findings import KeptFinding
    from barchain.studies.selftest.campaign.judging import JudgeCases
    from barchain.studies.selftest.campaign.rates import Rate
    from barchain.studies.selftest.runs import Runner
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles
    from scenarios import Scene

HOSTS = ("reference", "exudyn", "exudyn-tree", "pymunk")
"""Steps that are chosen; multipliers of second order; a tree of sixth order; impulses"""
CHUNK = 8  # scenes at a time: their runs are kept until all of them are judged
MOST_RERUNS = 3
SHRINK_S = 60.0


@dataclass(frozen=True)
class CampaignOptions:
    """Options of a campaign."""

    scenes: int
    """Number of random scenes"""
    seed: int = 0
    """Number of the first scene"""
    engines: tuple[str, ...] = ()
    """Engines that are judged unmodified; all installed engines that `barchain engines` marks as default by default"""
    hosts: tuple[str, ...] = HOSTS
    """Engines that faults are inserted into; none: unmodified engines alone"""
    faults: tuple[str, ...] = ()
    """Names; all by default"""
    most_reruns: int = MOST_RERUNS
    """Faults in one host on one scene that need runs of their own"""
    shrink_s: float = SHRINK_S
    """Time for the search of a simpler scene of one finding; 0: no search"""
    executor: Executor = ALL_CORES
    """Place of runs and verdicts; all cores of this machine by default"""


@dataclass(frozen=True)
class CampaignPlan(CampaignOptions):
    """Options with every engine and fault named."""

    faults: tuple[str, ...] = tuple(RANDOM_SCENES)

    @property
    def unmodified(self) -> tuple[str, ...]:
        """Engines that are judged unmodified: hosts too, as their verdicts state the detection limits."""
        return tuple(dict.fromkeys((*self.engines, *self.hosts)))

    def drawn(self) -> Iterator[Scene]:
        """Scenes, in order."""
        return map(draw, range(self.seed, self.seed + self.scenes))


@dataclass(frozen=True)
class Campaign:
    """Result of a campaign."""

    plan: CampaignPlan
    cells: list[CampaignCell]
    rates: list[Rate]
    findings: list[KeptFinding] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether no fault above its detection limit is missed, and false alarms are rare enough."""
        return passed(self.cells)


@dataclass(frozen=True)
class CampaignStudy:
    """The random campaign."""

    runner: Runner | None = None
    """Makes runs, see :mod:`barchain.studies.selftest.runs`; by default the plan's executor"""
    judge_cases: JudgeCases | None = None
    """Gives verdicts, see :mod:`barchain.studies.selftest.campaign.judging`; by default the plan's executor"""
    files: ClassVar[StudyFiles] = FILES

    def plan(self, options: CampaignOptions) -> CampaignPlan:
        """Plan of a campaign, with the default engines and faults by name.

        Raises
        ------
        UnknownFaultError
            For a fault that does not exist.
        ClusterError
            For a Dask cluster that can't be used.
        """
        installed = tuple(name for name, r in chosen_engines(None).items() if not r.missing)
        faults = tuple(find(name, RANDOM_SCENES).name for name in dict.fromkeys(options.faults or RANDOM_SCENES))
        options.executor.check()
        return CampaignPlan(**(vars(options) | {"engines": options.engines or installed, "faults": faults}))

    def record(self, plan: CampaignPlan) -> dict[str, Any]:
        """Scenes, engines and faults."""
        faults = {
            name: {"words": RANDOM_SCENES[name].words, "group": str(RANDOM_SCENES[name].group)} for name in plan.faults
        }
        return {
            "seed": plan.seed,
            "scenes": plan.scenes,
            "engines": list(plan.unmodified),
            "hosts": list(plan.hosts),
            "most_reruns": plan.most_reruns,
            "faults": faults,
        }

    def run(self, plan: CampaignPlan, store: StudyStore, reporter: Reporter) -> Campaign:
        """Try engines and faults on random scenes, and write tables as cells come."""
        tables, cells = CampaignStore(store), list[CampaignCell]()
        run, judge_cases = self.runner or in_workers(plan.executor), self.judge_cases or judge_in_workers(plan.executor)
        with reporter.counted("scenes", plan.scenes) as done:
            drawn = plan.drawn()
            while scenes := list(itertools.islice(drawn, CHUNK)):
                found = tried(plan, scenes, run, judge_cases)
                cells += found
                tables.keep_cells(found)
                tables.keep_rates(rates(cells))
                done(len(scenes))
        groups = kinds(cell for cell in cells if cell.is_finding)
        with reporter.counted("findings", len(groups)) as done:
            kept = kept_findings(groups, tables, plan.shrink_s, done)
        result = Campaign(plan, cells, rates(cells), kept)
        store.record["passed"] = result.passed
        return result


def tried(plan: CampaignPlan, drawn: list[Scene], run: Runner, judge_cases: JudgeCases) -> list[CampaignCell]:
    """Cells of some scenes."""
    runner = CampaignRunner(RunCache(run), judge_cases)
    scenes = runner.establish(drawn)
    cells, trials = [], []
    for scene in scenes:
        left_out, more = runner.unmodified_trials(scene, plan.unmodified)
        cells += left_out
        trials += more
    cells += runner.judge_trials(trials)
    trials = []
    for scene, host in itertools.product(scenes, plan.hosts):
        left_out, more = runner.fault_trials(scene, host, plan.faults, plan.most_reruns)
        cells += left_out
        trials += more
    return cells + runner.judge_trials(trials)
