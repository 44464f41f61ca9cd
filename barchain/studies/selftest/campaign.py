"""The random campaign: engines and faults on random scenes, and the rates of wrong verdicts."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from adapters.registry import find_engine
from barchain.runs.asking import declarations_of
from barchain.runs.cases import Known, Shared, run_cases
from barchain.runs.choices import chosen_engines
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import TIME_LIMIT_S
from barchain.solutions.reference import closely_sampled
from barchain.studies.selftest.faults.catalogue import RANDOM_SCENES, find
from barchain.studies.selftest.rating import CampaignCell, passed, rated, rates
from barchain.studies.selftest.scenes import draw
from barchain.studies.selftest.shrinking import kept_findings, kinds
from barchain.studies.selftest.trial import SceneRuns, Trial
from reports.results.comparison import JUDGING_SOLUTION
from reports.results.faults.campaign import ALL, FILES, SCENES, CellClass
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.record.study_store import StudyStore
    from barchain.runs.cases import Case
    from barchain.runs.executors import Executor
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.shrinking import KeptFinding
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles
    from scenarios import Scene

HOSTS = ("reference", "exudyn", "exudyn-tree", "pymunk")
"""Steps that are chosen; multipliers of second order; a tree of sixth order; impulses"""
CHUNK = 8  # scenes at a time: their runs are held until all of them are judged
MOST_RERUNS = 3
SHRINK_S = 60.0


@dataclass(frozen=True)
class Campaign:
    """Result of a campaign."""

    study: CampaignStudy
    cells: list[CampaignCell]
    rates: list[dict[str, Any]]
    findings: list[KeptFinding] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether no fault above its detection limit is missed, and false alarms are rare enough."""
        return passed(self.cells)


@dataclass(frozen=True)
class CampaignStudy:
    """The random campaign."""

    scenes: int
    """Number of random scenes"""
    seed: int = 0
    """Number of the first scene"""
    engines: tuple[str, ...] = ()
    """Engines that are judged unmodified"""
    hosts: tuple[str, ...] = HOSTS
    """Engines that faults are inserted into; none: unmodified engines alone"""
    faults: tuple[str, ...] = tuple(RANDOM_SCENES)
    most_reruns: int = MOST_RERUNS
    """Faults in one host on one scene that need runs of their own"""
    shrink_s: float = SHRINK_S
    """Time for the search of a simpler scene of one finding; 0: no search"""
    executor: Executor = ALL_CORES
    """Place of runs and verdicts; all cores of this machine by default"""
    files: ClassVar[StudyFiles] = FILES

    @property
    def unmodified(self) -> tuple[str, ...]:
        """Engines that are judged unmodified: hosts too, as their verdicts state the detection limits."""
        return tuple(dict.fromkeys((*self.engines, *self.hosts)))

    def record(self) -> dict[str, Any]:
        """Scenes, engines and faults."""
        faults = {
            name: {"words": RANDOM_SCENES[name].words, "group": str(RANDOM_SCENES[name].group)} for name in self.faults
        }
        return {
            "seed": self.seed,
            "scenes": self.scenes,
            "engines": list(self.unmodified),
            "hosts": list(self.hosts),
            "most_reruns": self.most_reruns,
            "faults": faults,
        }

    def run(self, store: StudyStore, reporter: Reporter) -> Campaign:
        """Try engines and faults on random scenes, and write tables as cells come."""
        store.write("campaign", ())
        cells = list[CampaignCell]()
        with reporter.counted("scenes", self.scenes) as done:
            numbers = iter(range(self.seed, self.seed + self.scenes))
            while chunk := list(itertools.islice(numbers, CHUNK)):
                cases = (
                    (k, on_scene(draw(k), self.unmodified, self.hosts, self.faults, self.most_reruns)) for k in chunk
                )
                found = {}
                for k, its_cells in run_cases(cases, self.executor):
                    found[k] = its_cells
                    done(1)
                new = [cell for k in chunk for cell in found[k]]
                cells += new
                store.append("campaign", (cell.row() for cell in new))
                found_rates = rates(cells)
                store.write("rates", (rate for rate in found_rates if rate["by"] == ALL))
                store.write("rates_of_parts", (rate for rate in found_rates if rate["by"] != ALL))
        groups = kinds(cell for cell in cells if cell.is_finding)
        with reporter.counted("findings", len(groups)) as done:
            kept = kept_findings(groups, store.folder / SCENES, alone_on, self.shrink_s, self.executor, done)
        result = Campaign(self, cells, rates(cells), kept)
        store.record["passed"] = result.passed
        return result


def campaign_study(
    scenes: int, engines: tuple[str, ...] = (), faults: tuple[str, ...] = (), **options: Any
) -> CampaignStudy:
    """Campaign on random scenes; all default engines that are installed, and all faults, if none are named.

    Parameters
    ----------
    scenes : int
    engines, faults : tuple of str
    **options
        Further fields of the study.

    Raises
    ------
    UnknownFaultError
        For a fault that does not exist.
    ClusterError
        For a Dask cluster that can't be used.
    """
    installed = tuple(name for name, r in chosen_engines(None).items() if not r.missing)
    known = tuple(find(name, RANDOM_SCENES).name for name in dict.fromkeys(faults or RANDOM_SCENES))
    study = CampaignStudy(scenes, engines=engines or installed, faults=known, **options)
    study.executor.check()
    return study


def on_scene(
    drawn: Scene,
    engines: Sequence[str],
    hosts: Sequence[str] = (),
    faults: Sequence[str] = (),
    most_reruns: int = MOST_RERUNS,
    limit_s: float = TIME_LIMIT_S,
) -> Case[list[CampaignCell]]:
    """Try engines as they are on a scene, sampled as a comparison samples it, then faults in the hosts that pass.

    Parameters
    ----------
    drawn : Scene
    engines : sequence of str
        The hosts among them.
    hosts, faults : sequence of str
    most_reruns : int
        Faults in one host that need runs of their own, of all that there are; the scene chooses them.
    limit_s : float
        Wall time of a run, s.
    """
    scene = SceneRuns(closely_sampled(drawn), limit_s=limit_s)
    name = scene.scene.name
    (solution,) = yield [scene.solution]
    if isinstance(solution, str):
        failed = str(Outcome.FAILED)
        return [CampaignCell(name, JUDGING_SOLUTION, "", failed, CellClass.FALSE_ALARM, reason=solution)]
    unmodified: list[CampaignCell] = yield [unmodified_engine(scene, engine, solution) for engine in engines]
    before = dict(zip(engines, unmodified, strict=True))
    able = [host for host in hosts if before[host].kind in (CellClass.PASS, CellClass.LIMITED)]
    inserted: list[CampaignCell] = yield [
        one for host in able for one in faulty_engine(scene, host, faults, most_reruns, solution, before[host])
    ]
    return [*unmodified, *inserted]


def unmodified_engine(scene: SceneRuns, name: str, solution: ReferenceSolution) -> Known | Shared:
    """Rating of an engine as it is, or that it does not support the scene."""
    engine = declarations_of(find_engine(name))
    reason = engine.unsupported(scene.scene) or engine.unsupported_motion(solution.scene, solution.fine)
    if reason is None:
        return Shared(rated(scene, Trial(scene.scene, name), solution))
    unsupported = str(Outcome.UNSUPPORTED), CellClass.UNSUPPORTED
    return Known(CampaignCell(scene.scene.name, name, "", *unsupported, reason=reason))


def faulty_engine(
    scene: SceneRuns,
    host: str,
    faults: Sequence[str],
    most_reruns: int,
    solution: ReferenceSolution,
    before: CampaignCell,
) -> list[Known | Shared]:
    """Ratings of faults in a host: first those that can't be inserted, then trials."""
    trials = [Trial(scene.scene, host, fault) for fault in faults]
    reasons = {trial.fault: trial.left_out(solution) for trial in trials}
    left_out = [
        Known(CampaignCell(scene.scene.name, host, fault, kind=CellClass.NOTHING, reason=reason))
        for fault, reason in reasons.items()
        if reason
    ]
    wanted = thinned([trial for trial in trials if not reasons[trial.fault]], most_reruns)
    return [*left_out, *(Shared(rated(scene, trial, solution, before)) for trial in wanted)]


def thinned(trials: list[Trial], most_reruns: int) -> list[Trial]:
    """Trials of which no more than some need runs of their own, in the same order."""
    own = [k for k, trial in enumerate(trials) if not trial.replays]
    if len(own) <= most_reruns:
        return trials
    words = f"{trials[0].scene.digest}|{trials[0].engine}".encode()
    kept = set(np.random.default_rng(list(words)).permutation(own)[:most_reruns].tolist())
    return [trial for k, trial in enumerate(trials) if trial.replays or k in kept]


def alone_on(scene: Scene, cell: CampaignCell, limit_s: float) -> Case[CampaignCell | None]:
    """Cell of a finding's engine, or of its fault in it, on another scene; None where it can't be tried."""
    engines = [] if cell.engine == JUDGING_SOLUTION else [cell.engine]
    faults = [cell.fault] if cell.fault else []
    found = yield from on_scene(scene, engines, engines if faults else [], faults, len(faults), limit_s)
    wanted = JUDGING_SOLUTION if cell.engine == JUDGING_SOLUTION else cell.engine
    return next((one for one in found if (one.engine, one.fault) == (wanted, cell.fault)), None)
