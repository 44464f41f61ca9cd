"""A random campaign from start to tables: what the command line and notebooks call."""

from __future__ import annotations

import itertools
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from barchain.record.environment import provenance
from barchain.studies.selftest.campaign.bench import TrialBench
from barchain.studies.selftest.campaign.faults.catalogue import FAULTS
from barchain.studies.selftest.campaign.findings import kept_findings, kinds
from barchain.studies.selftest.campaign.rates import passed, rates
from barchain.studies.selftest.campaign.runs import RunCache
from barchain.studies.selftest.campaign.scenes.draw import draw
from barchain.studies.selftest.campaign.store import FOLDER, CampaignStore

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager
    from pathlib import Path

    from barchain.studies.selftest.campaign.cells import CampaignCell
    from barchain.studies.selftest.campaign.findings import KeptFinding
    from barchain.studies.selftest.campaign.judging import Court
    from barchain.studies.selftest.campaign.rates import Rate
    from barchain.studies.selftest.campaign.runs import Runner
    from scenarios import Scene

    Counter = Callable[[str, int], AbstractContextManager[Callable[[int], None]]]

HOSTS = ("reference", "exudyn", "exudyn-tree", "pymunk")
"""Steps that are chosen; multipliers of second order; a tree of sixth order; impulses"""
CHUNK = 8  # scenes at a time: their runs are kept until all of them are judged
MOST_RERUNS = 3
SHRINK_S = 60.0


@dataclass(frozen=True)
class CampaignPlan:
    """What is to be tried."""

    scenes: int
    seed: int = 0
    """Number of the first scene; the others follow"""
    engines: tuple[str, ...] = ()
    hosts: tuple[str, ...] = HOSTS
    """Engines that faults are put into; none: sound engines alone"""
    faults: tuple[str, ...] = tuple(FAULTS)
    most_reruns: int = MOST_RERUNS
    """Faults in one host on one scene that need runs of their own"""
    shrink_s: float = SHRINK_S
    """Time for a simpler scene of one finding; 0: none is looked for"""
    workers: int | None = None

    @property
    def sound(self) -> tuple[str, ...]:
        """Engines that are judged as they are: hosts too, as their verdicts say what they would detect."""
        return tuple(dict.fromkeys((*self.engines, *self.hosts)))

    def drawn(self) -> Iterator[Scene]:
        """Scenes, in order."""
        return map(draw, range(self.seed, self.seed + self.scenes))


@dataclass(frozen=True)
class Campaign:
    """What a campaign found."""

    plan: CampaignPlan
    cells: list[CampaignCell]
    rates: list[Rate]
    findings: list[KeptFinding] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether the judge misses nothing that it says it would see, and hardly ever refuses a sound engine."""
        return passed(self.cells)


def campaign(plan: CampaignPlan, out: Path, run: Runner, court: Court, *, command: str, counted: Counter) -> Campaign:
    """Try engines and faults on random scenes, and write the tables into ``out/campaign`` as they come.

    Parameters
    ----------
    plan : Plan
    out : Path
        Result folder.
    run : callable
        Makes runs, see `barchain.studies.selftest.campaign.runs`.
    court : callable
        Gives verdicts, see `barchain.studies.selftest.campaign.judging`.
    command : str
        What was typed, for the record.
    counted : callable
        Given what is done and how often, a context with a callback to count it.

    Returns
    -------
    Campaign
    """
    start = time.perf_counter()
    store = CampaignStore(out / FOLDER, new_record(plan, command))
    cells: list[CampaignCell] = []
    with counted("scenes", plan.scenes) as done:
        drawn = plan.drawn()
        while scenes := list(itertools.islice(drawn, CHUNK)):
            found = tried(plan, scenes, run, court)
            cells += found
            store.keep_cells(found)
            store.keep_rates(rates(cells))
            done(len(scenes))
    groups = kinds(cell for cell in cells if cell.is_finding)
    with counted("findings", len(groups)) as done:
        kept = kept_findings(groups, store, plan.shrink_s, done)
    result = Campaign(plan, cells, rates(cells), kept)
    store.record.update(finished=True, passed=result.passed, seconds=time.perf_counter() - start)
    store.write_record()
    return result


def tried(plan: CampaignPlan, drawn: list[Scene], run: Runner, court: Court) -> list[CampaignCell]:
    """Cells of some scenes."""
    bench = TrialBench(RunCache(run), court)
    scenes = bench.establish(drawn)
    cells, trials = [], []
    for scene in scenes:
        left_out, more = bench.try_sound(scene, plan.sound)
        cells += left_out
        trials += more
    cells += bench.settle(trials)
    trials = []
    for scene, host in itertools.product(scenes, plan.hosts):
        left_out, more = bench.plant(scene, host, plan.faults, plan.most_reruns)
        cells += left_out
        trials += more
    return cells + bench.settle(trials)


def new_record(plan: CampaignPlan, command: str) -> dict[str, object]:
    """campaign.json before the first run."""
    return provenance(command) | {
        "seed": plan.seed,
        "scenes": plan.scenes,
        "engines": list(plan.sound),
        "hosts": list(plan.hosts),
        "most_reruns": plan.most_reruns,
        "faults": {name: {"words": FAULTS[name].words, "group": str(FAULTS[name].group)} for name in plan.faults},
    }
