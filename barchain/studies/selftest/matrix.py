"""The kill matrix: controls first, then every fault in every scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.engine import EngineError
from barchain.faults.catalogue import CONTROLS, FIXED_SCENES, UNMODIFIED, find
from barchain.studies.selftest.check_results import FaultCell, tried
from barchain.studies.selftest.trial import Trial
from barchain.studies.selftest.trial_runner import untold
from reports.tables.faults.selftest import FaultOutcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.faults.fault import Fault
    from barchain.studies.selftest.trial_runner import TrialRunner
    from scenarios import Scene

    Done = Callable[[int], None]
    Seen = Callable[[FaultCell], None]

HOST = "reference"


def unseen(one: FaultCell) -> None:
    """Keep nothing of a cell."""
    del one


@dataclass(frozen=True)
class Matrix:
    """All cells."""

    cells: tuple[FaultCell, ...]

    def of(self, fault: str) -> tuple[FaultCell, ...]:
        """Cells of one fault."""
        return tuple(c for c in self.cells if c.fault.name == fault)

    @property
    def unkilled(self) -> tuple[Fault, ...]:
        """Faults inserted somewhere, detected nowhere, and not proven invisible."""
        faults = {c.fault.name: c.fault for c in self.cells if c.fault.name in FIXED_SCENES}
        return tuple(f for name, f in faults.items() if survives({c.fate for c in self.of(name)}))

    @property
    def wrong(self) -> tuple[FaultCell, ...]:
        """False alarms, and faults that are not inserted as they are meant."""
        return tuple(c for c in self.cells if c.fate in (FaultOutcome.FALSE_ALARM, FaultOutcome.BROKEN))

    @property
    def passed(self) -> bool:
        """Whether every detectable fault is detected, and no unmodified engine is rejected."""
        return not self.unkilled and not self.wrong


def survives(fates: set[FaultOutcome]) -> bool:
    """Whether a fault with these outcomes was inserted and never detected, nor proven invisible."""
    return FaultOutcome.SURVIVES in fates and FaultOutcome.KILLED not in fates


class SelftestError(EngineError):
    """Raised where a run fails that the self-test can't go on without."""


def need_unmodified(scenes: Iterable[Scene], runner: TrialRunner, host: str) -> None:
    """Stop where the unmodified engine does not run: its runs serve all faults in samples.

    Raises
    ------
    SelftestError
        If a run of it failed.
    """
    for job in (job for scene in scenes for job in Trial(scene, host, UNMODIFIED).jobs()):
        result = runner.runs[job]
        if result.trajectory is None:
            raise SelftestError(f"{host} can't be run on {job.scene.name}: {result.reason}")


def inserted(faults: Iterable[str], scenes: Iterable[Scene], runner: TrialRunner, host: str) -> Iterator[FaultCell]:
    """Insert faults into scenes, and judge them: first those that change nothing, then others as they come."""
    trials = []
    for trial in (Trial(scene, host, fault) for fault in faults for scene in scenes):
        reason = trial.left_out(runner.solutions[trial.scene.name])
        if reason:
            yield FaultCell(find(trial.fault), trial.scene.name, FaultOutcome.NOTHING, reason)
        else:
            trials.append(trial)
    yield from tried(trials, runner)


def matrix(
    faults: Iterable[Fault],
    scenes: tuple[Scene, ...],
    runner: TrialRunner,
    host: str = HOST,
    *,
    done: Done = untold,
    seen: Seen = unseen,
) -> Matrix:
    """Controls and faults in all scenes, in the order of the catalogue.

    Parameters
    ----------
    faults : iterable of Fault
    scenes : tuple of Scene
        Whose reference solutions the runner has.
    runner : TrialRunner
    host : str
        Engine that the faults are inserted into.
    done : callable
        Given 1 for each cell.
    seen : callable
        Given each cell as soon as it is there.

    Raises
    ------
    SelftestError
        If the unmodified engine can't be run.
    """
    cells = []
    for names in (tuple(CONTROLS), tuple(f.name for f in faults)):
        for one in inserted(names, scenes, runner, host):
            cells.append(one)
            seen(one)
            done(1)
        need_unmodified(scenes, runner, host)
    place = {name: k for k, name in enumerate([*CONTROLS, *FIXED_SCENES])}
    order = {scene.name: k for k, scene in enumerate(scenes)}
    return Matrix(tuple(sorted(cells, key=lambda c: (place[c.fault.name], order[c.scene]))))
