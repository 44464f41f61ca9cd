"""State of a night on disk, and its place in the history: nothing is lost, whatever the instant of a kill."""

from __future__ import annotations

import contextlib
import datetime
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.dependencies import Installation  # noqa: TC001  # pydantic reads the annotations of the state
from barchain.nightly.figures.results import night_here, read_figures_of
from barchain.nightly.running.jobs import NightJob, beside
from barchain.record.claim import locked
from barchain.studies.selftest.faults.catalogue import CONTROLS
from reports.results.nights import STATE
from reports.results.nights.document import CUT, AlarmTest, NightRun, PartResult, PartState
from reports.results.reading import DamagedResultsError, form_of, formed
from reports.results.schema import SchemaVersionError
from reports.results.selftest import FILES, FaultOutcome
from reports.results.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator
    from pathlib import Path

    from barchain.nightly.history.nights import NightStore


SET_ASIDE = f"{STATE}.damaged"
LONGEST_PAUSE = datetime.timedelta(hours=20)
"""An interrupted night goes on within this time; later a new one begins"""
NOT_PLANTED = {str(FaultOutcome.NOTHING), str(FaultOutcome.INVISIBLE)}
"""Outcomes of faults that change nothing"""
REJECTED = {str(FaultOutcome.FALSE_ALARM), str(FaultOutcome.BROKEN)}
"""Outcomes of an unmodified engine that must not be"""


@dataclass(frozen=True)
class NightState:
    """State of a night."""

    plan: str
    """Identity of the plan"""
    minutes: float
    turn: int
    started: datetime.datetime
    """UTC"""
    code: str
    """Digest of sources, engines, libraries and environment: a night goes on with the same ones only"""
    parts: tuple[str, ...]
    """Names of all parts of the plan"""
    installation: Installation
    """Of the start of the night: what its results come from, whenever they are filed"""
    jobs: tuple[NightJob, ...]
    """All jobs of the night"""
    begun: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Scenes that a job took on when it began, by name"""
    given_s: dict[str, float] = field(default_factory=dict)
    """Times that jobs were given when they began, by name, s"""
    results: dict[str, PartResult] = field(default_factory=dict)
    """Ends of jobs, by name"""
    finished: bool = False

    def goes_on(self, plan: str, code: str, now: datetime.datetime) -> bool:
        """Whether an interrupted night goes on: the same plan, code and environment, and not too long ago."""
        return self.plan == plan and self.code == code and abs(now - self.started) < LONGEST_PAUSE


def write_state(folder: Path, state: NightState) -> None:
    """Write the state whole."""
    write_atomically(folder / STATE, form_of(NightState).dump_json(state, indent=1))


def read_state(folder: Path) -> NightState | None:
    """State in a night's folder; None if there is none.

    Raises
    ------
    ValueError, OSError
        If it can't be read; the message is one line.
    """
    with contextlib.suppress(FileNotFoundError):
        return formed(NightState, (folder / STATE).read_bytes())
    return None


def unfinished(out: Path, note: Callable[[str], None]) -> Iterator[tuple[Path, NightState]]:
    """Nights in a folder that did not come to their end, the latest first; some may still be running.

    A state that can't be read is told once, and gets another name. The results beside it stay.
    """
    for folder in sorted((each for each in out.iterdir() if each.is_dir()), reverse=True) if out.is_dir() else []:
        try:
            state = read_state(folder)
        except (ValueError, OSError) as error:
            remedy = "results of its parts stay there, and `barchain history add DIR` adds them"
            note(f"{folder / STATE}: is damaged ({error}); {remedy}")
            (folder / STATE).replace(folder / SET_ASIDE)
            continue
        if state is not None and not state.finished:
            yield folder, state


def not_ended(out: Path, known: Collection[str]) -> list[str]:
    """Names of the nights in a folder that began, did not come to their end, and do not run now.

    Parameters
    ----------
    out : Path
    known : collection of str
        Nights that the history holds.
    """
    found = []
    for path in sorted(out.glob(f"*/{STATE}")):
        name = path.parent.name
        with contextlib.suppress(ValueError, OSError):  # damaged, or another process writes into the folder
            state = read_state(path.parent) if name not in known else None
            if state is not None and not state.finished:
                with locked(path.parent):
                    found.append(name)
    return found


def results_fault(folder: Path) -> str:
    """Why the results of a job can't be read; empty if they can. A job ended while it began has its record only."""
    try:
        read_figures_of(folder)
    except (HistoryError, FileNotFoundError, DamagedResultsError, SchemaVersionError) as error:
        return str(error)
    return ""


def add(store: NightStore, folder: Path, state: NightState) -> tuple[str, NightRun]:
    """Add a night to the history, with the installation of its start, and return its name there and its run.

    An earlier, incomplete state of the same night is replaced. Results are taken in the order of the plan's parts.

    Raises
    ------
    HistoryError
        If the history can't be written; the message names the folder that keeps the results.
    """
    order = sorted(state.jobs, key=lambda job: (state.parts.index(job.part), job.name))
    readable = [folder / job.name for job in order if not results_fault(folder / job.name)]
    run = run_of(folder, state, [path for path in readable if path.name in state.results])
    night = night_here(
        readable,
        state.installation,
        started=state.started,
        duration_s=sum(result.duration_s for result in state.results.values()),
        plan=state.plan,
        complete=run.complete,
        void=run.alarm.void if run.alarm else None,
        label=folder.name.rpartition("-")[2],
    )
    try:
        store.add(night, run)
    except HistoryError as error:
        raise HistoryError(f"{error}; the night's results stay in {folder}, and the next call adds them") from error
    return night.name, run


def run_of(folder: Path, state: NightState, ended: Iterable[Path]) -> NightRun:
    """Run of a night: its parts, each with all of its jobs, and all tests of the alarm in results of jobs as one."""
    parts: dict[str, PartResult] = {}
    for job in state.jobs:
        left = job.scenes or (job.part,)
        command = job.shown(folder / job.name)
        not_begun = PartResult(job.part, PartState.LEFT, 0.0, 0.0, left, CUT, command=command, begun=False)
        result = state.results.get(job.name, not_begun)
        result = replace(result, left=tuple(map(beside, result.left)))
        parts[result.name] = joined(parts[result.name], result) if result.name in parts else result
    tests = [test for test in map(alarm_test, ended) if test]
    alarm = AlarmTest(
        sum(test.planted for test in tests), tuple(fault for test in tests for fault in test.missed), state.turn,
        tuple(scene for test in tests for scene in test.false_alarms),
    )  # fmt: skip
    return NightRun(state.plan, state.minutes, tuple(parts.values()), alarm if tests else None, state.turn)


def alarm_test(folder: Path) -> AlarmTest | None:
    """Result of the planted faults in a result folder; None if none was tried to its end.

    A fault is missed if no check detects it in any scene in which it changes anything. So is a fault that does not
    run as it should: nobody knows whether it would be detected. Of a self-test that was interrupted, those faults count
    that have their result in all of their scenes.
    """
    if not FILES.has_record(folder):
        return None
    tables = FILES.contents(folder)
    unmodified = tables.fates["fault"].isin(list(CONTROLS))
    faults, controls = tables.fates[~unmodified], tables.fates[unmodified]
    if not tables.record.get("complete"):
        scenes = set(tables.record.get("scenes") or ())
        tried = {name for name, rows in faults.groupby("fault") if scenes and scenes <= set(rows["scene"])}
        faults = faults[faults["fault"].isin(tried)]
    planted = set(faults.loc[~faults["fate"].isin(NOT_PLANTED), "fault"])
    broken = set(faults.loc[faults["fate"] == str(FaultOutcome.BROKEN), "fault"])
    killed = set(faults.loc[faults["fate"] == str(FaultOutcome.KILLED), "fault"])
    rejected = set(controls.loc[controls["fate"].isin(REJECTED), "scene"])
    if not planted and not rejected:
        return None
    return AlarmTest(len(planted), tuple(sorted(planted - killed | broken)), false_alarms=tuple(sorted(rejected)))


def joined(first: PartResult, second: PartResult) -> PartResult:
    """Result of a part of two jobs: scenes that were left before, and this night's."""
    worst = max((first, second), key=lambda part: list(PartState).index(part.state))
    return PartResult(
        first.name, worst.state, round(first.share_s + second.share_s, 1),
        round(first.duration_s + second.duration_s, 3), (*first.left, *second.left), worst.reason,
        first.done + second.done, " && ".join(c for c in (first.command, second.command) if c),
        first.missing or second.missing, first.bad_input or second.bad_input, first.begun or second.begun,
    )  # fmt: skip
