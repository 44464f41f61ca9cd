"""The kill matrix: controls first, then every fault in every scene."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.execution.executors import ALL_CORES
from barchain.faults.catalogue import CONTROLS, FIXED_SCENES, UNMODIFIED
from barchain.run.job import Role
from barchain.studies.selftest.check_results import FaultCell, cell, nothing
from barchain.studies.selftest.trial import FaultTrial, SelftestError, run_trials
from reports.tables.faults.selftest import FaultOutcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from barchain.execution.executors import Executor
    from barchain.faults.fault import Fault
    from barchain.studies.selftest.trial import SelftestCase, TrialResult

    Done = Callable[[int], None]
    Seen = Callable[[FaultCell], None]

HOST = "reference"


def quiet(done: int) -> None:
    """Report nothing."""
    del done


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


def insert_faults(
    faults: Iterable[Fault], found: list[SelftestCase], *, executor: Executor = ALL_CORES, done: Done = quiet
) -> Iterator[tuple[FaultCell, TrialResult | None]]:
    """Insert faults into scenes: a cell for each pair, with its result where something was run."""
    trials = []
    for fault in faults:
        for case in found:
            left_out = nothing(case, fault)
            if left_out:
                yield left_out, None
                done(1)
            else:
                trials.append(FaultTrial(case, fault, fault.natural))
    for result in run_trials(trials, executor=executor):
        yield cell(result), result
        done(1)


def with_controls(
    found: list[SelftestCase], *, executor: Executor = ALL_CORES, done: Done = quiet, seen: Seen = unseen
) -> tuple[list[SelftestCase], list[FaultCell]]:
    """Cases with the controls' runs, and the controls' cells."""
    kept, cells = {g.scene.name: g for g in found}, []
    for one, result in insert_faults(CONTROLS.values(), found, executor=executor, done=done):
        cells.append(one)
        seen(one)
        if result is not None:
            name = one.scene
            kept[name] = with_control(kept[name], result)
    return list(kept.values()), cells


def with_control(case: SelftestCase, result: TrialResult) -> SelftestCase:
    """Case that keeps the results of a control.

    Raises
    ------
    SelftestError
        If the control does not run.
    """
    main, finer = result.main.trajectory, result.finer.trajectory
    if main is None or finer is None:
        raise SelftestError(f"{result.trial.fault.name} can't be run on {case.scene.name}: {result.main.reason}")
    controls = case.controls | {result.trial.fault.name: main}
    if result.trial.fault.name != UNMODIFIED:
        return dataclasses.replace(case, controls=controls)
    unmodified = {case.settings[Role.MAIN]: main, case.settings[Role.FINER]: finer}
    return dataclasses.replace(case, controls=controls, unmodified_runs=unmodified)


def matrix(
    faults: Iterable[Fault],
    found: list[SelftestCase],
    *,
    executor: Executor = ALL_CORES,
    done: Done = quiet,
    seen: Seen = unseen,
) -> tuple[Matrix, list[SelftestCase]]:
    """Controls and faults in all scenes, in the order of the catalogue; and the cases with the controls' runs.

    `seen` is called with each cell as soon as it is there.
    """
    ready, cells = with_controls(found, executor=executor, done=done, seen=seen)
    for one, _ in insert_faults(faults, ready, executor=executor, done=done):
        cells.append(one)
        seen(one)
    place = {name: k for k, name in enumerate([*CONTROLS, *FIXED_SCENES])}
    scenes = {g.scene.name: k for k, g in enumerate(found)}
    return Matrix(tuple(sorted(cells, key=lambda c: (place[c.fault.name], scenes[c.scene])))), ready
