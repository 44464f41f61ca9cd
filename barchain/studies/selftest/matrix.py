"""The kill matrix: controls and known faults in every scene, and on request the smallest sizes that are detected."""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.engine import EngineError
from adapters.registry import find_own_engine
from barchain.faults.catalogue import CONTROLS, FIXED_SCENES, find
from barchain.record.scene_description import scene_words
from barchain.runs.asking import engine_class
from barchain.runs.cases import run_cases
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import Role
from barchain.solutions.judging import NUMPY
from barchain.studies.selftest.fates import FaultCell, tried
from barchain.studies.selftest.stages import STAGES, find_scene
from barchain.studies.selftest.trial import SceneRuns, Trial
from barchain.studies.study import ignore
from reports.tables.faults.selftest import CAUGHT, FILES, MISSED, FaultOutcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.faults.fault import Fault, Size
    from barchain.record.study_store import StudyStore
    from barchain.runs.cases import Case
    from barchain.runs.executors import Executor
    from barchain.studies.selftest.fates import Reading
    from barchain.studies.study import Reporter
    from reports.tables.files import StudyFiles
    from reports.tables.rows import Rows
    from scenarios import Scene

HOST = "reference"
OCTAVES = 44  # below the natural size: 6e-14 of it, with the natural 1 % less than a rounding of the faulty value


class SelftestError(EngineError):
    """Raised where a run fails that the self-test can't go on without."""


@dataclass(frozen=True)
class Matrix:
    """All cells."""

    cells: tuple[FaultCell, ...]

    @property
    def unkilled(self) -> tuple[Fault, ...]:
        """Faults inserted somewhere, detected nowhere, and not proven invisible."""
        fates: dict[str, set[FaultOutcome]] = {}
        faults = {c.fault.name: c.fault for c in self.cells if c.fault.name in FIXED_SCENES}
        for one in self.cells:
            fates.setdefault(one.fault.name, set()).add(one.fate)
        missed = (n for n in faults if FaultOutcome.SURVIVES in fates[n] and FaultOutcome.KILLED not in fates[n])
        return tuple(faults[name] for name in missed)

    @property
    def wrong(self) -> tuple[FaultCell, ...]:
        """False alarms, and faults that are not inserted as they are meant."""
        return tuple(c for c in self.cells if c.fate in (FaultOutcome.FALSE_ALARM, FaultOutcome.BROKEN))

    @property
    def passed(self) -> bool:
        """Whether every detectable fault is detected, and no unmodified engine is rejected."""
        return not self.unkilled and not self.wrong


@dataclass(frozen=True)
class SelftestStudy:
    """Scenes, faults and their host."""

    scenes: tuple[Scene, ...]
    faults: tuple[Fault, ...]
    host: str = HOST
    smallest: bool = False
    """Whether the smallest detected size of each continuous fault is looked for"""
    executor: Executor = ALL_CORES
    left_out: dict[str, str] = field(default_factory=dict)
    """Scenes that the host does not support, with the reason"""
    files: ClassVar[StudyFiles] = FILES

    @property
    def trials(self) -> list[Trial]:
        """Controls and faults in all scenes, in the order of the table."""
        names = [*CONTROLS, *(n for n in FIXED_SCENES if n in {f.name for f in self.faults})]
        return [Trial(scene, self.host, name) for name in names for scene in self.scenes]

    def record(self) -> dict[str, Any]:
        """Host, scenes and faults in words."""
        return {
            "host": self.host,
            "roles": [str(Role.MAIN), str(Role.FINER)],
            "scenes": {s.name: scene_words(s) | {"effects": sorted(s.effects.names)} for s in self.scenes},
            "faults": {f.name: fault_words(f) for f in (*CONTROLS.values(), *self.faults)},
        }

    def run(self, store: StudyStore, reporter: Reporter) -> Matrix:
        """Try every fault in every scene.

        Raises
        ------
        SelftestError
            If a reference solution or a run of the unmodified engine fails.
        """
        scenes = {scene.name: SceneRuns(scene, NUMPY) for scene in self.scenes}
        with reporter.counted("reference solutions", len(scenes)) as done:
            for _ in run_cases(((name, established(one, self.host)) for name, one in scenes.items()), self.executor):
                done(1)
        trials, cells = self.trials, dict[int, FaultCell]()
        with reporter.counted("faults", len(trials)) as done, kept_if_interrupted(store, cells):
            cases = ((k, tried(scenes[trial.scene.name], trial)) for k, trial in enumerate(trials))
            for k, found in run_cases(cases, self.executor):
                cells[k] = found
                done(1)
        result = Matrix(tuple(cells[k] for k in range(len(trials))))
        write_cells(store, result.cells)
        store.record.update(passed=result.passed, unkilled=[f.name for f in result.unkilled])
        if self.smallest:
            store.write_record()
            self.look_for_smallest(result, scenes, store.summary, reporter)
        return result

    def look_for_smallest(self, tried_all: Matrix, scenes: dict[str, SceneRuns], found: Rows, told: Reporter) -> None:
        """Bisect the size of each continuous fault that was inserted, and add the sizes to the rows."""
        pairs = [
            (one, Bracket(one.fault.size).told(0, one.killer))
            for one in tried_all.cells if one.fault.size and one.readings
        ]  # fmt: skip
        with told.counted("sizes", sum(pair.most_trials for _, pair in pairs)) as done:
            cases = [settled(pair, scenes[one.scene], self.host, one.fault.name, done) for one, pair in pairs]
            brackets = dict(run_cases(enumerate(cases), self.executor))
        for k, (one, _) in enumerate(pairs):
            brackets[k].add_rows(found, scene=one.scene, engine=self.host, fault=one.fault.name)


def selftest_study(
    scenes: Iterable[str] = (), faults: Iterable[str] = (), host: str = HOST, **how: Any
) -> SelftestStudy:
    """Self-test on scenes by name or file, eight short ones by default, with faults by name, all by default.

    Further arguments are fields of the study. Faults in the code itself need the reference as host.

    Raises
    ------
    SceneError, UnknownFaultError, UnknownEngineError
        For a scene, a fault or an engine that does not exist.
    ClusterError
        For a Dask cluster that can't be used.
    """
    engine = engine_class(find_own_engine(host))
    chosen = [find(n, FIXED_SCENES) for n in dict.fromkeys(faults or FIXED_SCENES) if n not in CONTROLS]
    loaded = list(map(find_scene, dict.fromkeys(scenes or STAGES)))
    reasons = {s.name: engine.unsupported(s) for s in loaded}
    able = tuple(s for s in loaded if not reasons[s.name])
    left_out = {name: reason for name, reason in reasons.items() if reason}
    study = SelftestStudy(able, tuple(chosen), host, left_out=left_out, **how)
    study.executor.check()
    return study


def established(scene: SceneRuns, host: str) -> Case[None]:
    """Find a scene's reference solution, and make the runs of the unmodified engine: all faults need them.

    Raises
    ------
    SelftestError
        If a run of either failed.
    """
    solution, *made = yield [scene.solution, *map(scene.run_of, Trial(scene.scene, host).jobs())]
    if isinstance(solution, str):
        raise SelftestError(f"{scene.scene.name}: {solution}")
    for result in made:
        if result.trajectory is None:
            raise SelftestError(f"{host} can't be run on {scene.scene.name}: {result.reason}")


@contextlib.contextmanager
def kept_if_interrupted(store: StudyStore, cells: dict[int, FaultCell]) -> Iterator[None]:
    """Write the cells so far if the matrix is interrupted: a fault that no check detects is told then too."""
    try:
        yield
    except KeyboardInterrupt:
        if cells:
            write_cells(store, cells.values())
        raise


def write_cells(store: StudyStore, cells: Iterable[FaultCell]) -> None:
    """Write the tables of cells."""
    found = list(cells)
    store.write("fates", (one.row for one in found))
    store.write("readings", (row for one in found for row in one.reading_rows()))


@dataclass(frozen=True)
class Bracket:
    """Bracket of a continuous fault's detection limit; powers of two of its natural size, less its size of no fault."""

    size: Size
    caught: int | None = None
    """Smallest known to be caught"""
    missed: int | None = None
    """Largest known to be missed"""
    by: Reading | None = None
    """Check that caught it"""

    @property
    def highest(self) -> int:
        """Largest power that is tried."""
        if self.size.most is None:
            return 0
        return max(0, round(math.log2((self.size.most - self.size.none) / (self.size.natural - self.size.none))))

    @property
    def most_trials(self) -> int:
        """Largest number of trials that may be taken."""
        return math.ceil(math.log2(OCTAVES + 1 + max(1, self.highest)))

    @property
    def next(self) -> int | None:
        """Power to be tried next: the natural size, the largest, then between; None where it is settled."""
        if self.caught is None:
            untried = [k for k in (0, self.highest) if self.missed is None or k > self.missed]
            return untried[0] if untried else None
        low = -OCTAVES - 1 if self.missed is None else self.missed
        return None if self.caught - low <= 1 else (self.caught + low) // 2

    def at(self, power: int) -> float:
        """Size of a power."""
        return self.size.none + (self.size.natural - self.size.none) * 2.0**power

    def told(self, power: int, by: Reading | None) -> Bracket:
        """Bracket narrowed by the outcome at a power."""
        return replace(self, missed=power) if by is None else replace(self, caught=power, by=by)

    def add_rows(self, found: Rows, **where: Any) -> None:
        """Add a row for each of the two sizes that is known."""
        if self.caught is not None:
            found.add(CAUGHT, self.at(self.caught), text=self.by.quantity if self.by else "", **where)
        if self.missed is not None:
            found.add(MISSED, self.at(self.missed), **where)


def settled(
    pair: Bracket, scene: SceneRuns, host: str, fault: str, done: Callable[[int], None] = ignore
) -> Case[Bracket]:
    """Bracket narrowed to a factor of two, one trial after the other."""
    while (power := pair.next) is not None:
        found = yield from tried(scene, Trial(scene.scene, host, fault, pair.at(power)))
        pair = pair.told(power, found.killer)
        done(1)
    return pair


def fault_words(fault: Fault) -> dict[str, Any]:
    """Entry of a fault in the record."""
    size = fault.size
    return {
        "words": fault.words,
        "stands_for": fault.stands_for,
        "group": str(fault.group),
        "natural": size.natural if size else None,
        "none": size.none if size else None,
        "unit": size.unit if size else "",
        "invisible": fault.invisible,
    }
