"""A night from its plan to its place in the history."""

from __future__ import annotations

import datetime
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from filelock import FileLock, Timeout

from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.folders.reading import found_in, night_here, night_without_figures, read_figures_of
from barchain.nightly.history.model.environment import capture
from barchain.nightly.history.runs import last_run
from barchain.nightly.plan.jobs import NightJob, night_jobs
from barchain.nightly.plan.tables import LOGS
from barchain.nightly.run_facts import NightRun, PartResult, PartState
from barchain.nightly.running.alarm import alarm_test, together
from barchain.nightly.running.budget import LEAST_S, MEASURED, fitting, limit_s, pace_s, working_time_s
from barchain.nightly.running.child import run_barchain
from barchain.nightly.running.progress_made import scenes_left
from barchain.nightly.running.state import (
    NightState,
    code_here,
    goes_on,
    new_folder,
    read_state,
    unfinished,
    write_state,
)
from barchain.studies.study import ignore
from reports.tables.reading import DamagedResultsError
from reports.tables.schema import SchemaVersionError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from barchain.nightly.history.model.figures import Night
    from barchain.nightly.history.store import NightStore
    from barchain.nightly.plan.loading import NightPlan

LOCK = ".night.lock"
TIMED = frozenset({"cost", "scaling"})
"""Studies that plan with a budget of time"""


@dataclass(frozen=True)
class NightProgress:
    """Callbacks for the progress of a night; by default they do nothing."""

    note: Callable[[str], None] = ignore
    """Called with a sentence"""
    begin: Callable[[str, int, int, float], None] = ignore
    """Called before each job with its name, number, the number of jobs, and its time limit, s"""
    tick: Callable[[float], None] = ignore
    """Called during a job with its time so far, s"""
    end: Callable[[PartResult], None] = ignore
    """Called after each job with its result"""


@dataclass(frozen=True)
class NightEnd:
    """End of a night."""

    folder: Path
    name: str
    """Of the night in the history"""
    run: NightRun


def run_night(
    plan: NightPlan, minutes: float, store: NightStore, out: Path, progress: NightProgress | None = None
) -> NightEnd:
    """Run a night inside its budget, and add it to the history.

    Parameters
    ----------
    plan : NightPlan
    minutes : float
        Wall time of the whole night, minutes.
    store : NightStore
    out : Path
        Folder of all nights: each has a folder in it, named by its start.
    progress : NightProgress, optional

    Returns
    -------
    NightEnd

    Raises
    ------
    PlanError, UnknownEngineError, SettingError
        If the plan can't be met; nothing was run then.
    HistoryError
        If the history can't be written; the results stay in the night's folder, and the next call adds them.

    Notes
    -----
    A night that was interrupted goes on, if plan, code and environment are the same and it began less than 20 hours
    ago. Otherwise what it did is added to the history as incomplete, and a new night begins.
    """
    progress = progress or NightProgress()
    code, now = code_here(capture()), datetime.datetime.now(datetime.UTC)
    last = last_run(store, plan.identity)
    night_jobs(plan, last.turn + 1 if last else 0, leftovers(last))  # an error of the plan comes before anything runs
    for folder, state in list(unfinished(out)):
        lock = held(folder)
        if lock is None:
            continue
        with lock:
            if goes_on(state, plan.identity, code, now):
                progress.note(f"going on with the night of {state.started}, which was interrupted")
                return finish(Running(plan, minutes, store, folder, progress), replace(state, minutes=minutes))
            file_interrupted(store, folder, state, progress)
    last = last_run(store, plan.identity)
    folder = new_folder(out, now)
    lock = held(folder)
    if lock is None:
        raise HistoryError(f"{folder}: another process holds this new folder; try again")
    with lock:
        turn, left = (last.turn + 1 if last else 0), leftovers(last)
        parts = [part.name for part in plan.file.parts]
        state = NightState(plan.identity, minutes, turn, now.replace(microsecond=0).isoformat(), code, left, parts)
        write_state(folder, state)
        return finish(Running(plan, minutes, store, folder, progress, last), state)


@dataclass(frozen=True)
class Running:
    """A night that is being run."""

    plan: NightPlan
    minutes: float
    store: NightStore
    folder: Path
    progress: NightProgress
    last: NightRun | None = None
    """Last night of the plan, for the pace of its parts"""


def held(folder: Path) -> FileLock | None:
    """Lock of a night's folder, taken; None if another process runs the night."""
    lock = FileLock(folder / LOCK, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        return None
    return lock


def leftovers(last: NightRun | None) -> dict[str, list[str]]:
    """What the last night of the plan left, by part: scenes, or the part's name."""
    if last is None:
        return {}
    return {part.name: list(part.left or (part.name,)) for part in last.parts if part.state is PartState.LEFT}


def finish(night: Running, state: NightState) -> NightEnd:
    """Run the jobs that are not done, and add the night to the history, also if it is interrupted."""
    try:
        state = run_jobs(night, state)
    except KeyboardInterrupt:
        add(night.store, night.folder, read_state(night.folder) or state, complete=False)
        raise
    name, run = add(night.store, night.folder, state, complete=True)
    write_state(night.folder, replace(read_state(night.folder) or state, stored=name, finished=True))
    return NightEnd(night.folder, name, run)


def run_jobs(night: Running, state: NightState) -> NightState:
    """Run all jobs that are not done, one after the other, and write the state after each."""
    end = time.monotonic() + working_time_s(night.minutes)
    jobs = night_jobs(night.plan, state.turn, state.left)
    waiting = [job for job in jobs if job.name not in state.results or state.results[job.name].state is PartState.LEFT]
    for k, job in enumerate(waiting):
        time_s = limit_s(job, waiting[k + 1 :], max(end - time.monotonic(), 0.0))
        night.progress.begin(job.name, len(jobs) - len(waiting) + k + 1, len(jobs), time_s)
        state = state.with_result(job.name, run_job(night, job, time_s))
        write_state(night.folder, state)
        night.progress.end(state.results[job.name])
    return state


def run_job(night: Running, job: NightJob, time_s: float) -> PartResult:
    """Run one job inside its time."""
    if time_s < LEAST_S:
        return PartResult(job.part, PartState.LEFT, time_s, 0.0, job.scenes or (job.part,), "no time was left")
    taken, beyond = fitting(job, time_s, pace_s(job.part, night.last))
    out = night.folder / job.name
    more = ("--minutes", f"{MEASURED * time_s / 60.0:.3f}") if job.study in TIMED else ()
    again = ("--resume",) if has_results(out) else ()
    ended = run_barchain(
        (*taken.command(out, *more, *again),), night.folder / LOGS / f"{job.name}.txt", time_s, night.progress.tick
    )
    left: tuple[str, ...] = ()
    state, reason = PartState.DONE, ended.reason
    if ended.failed:
        state = PartState.FAILED
    elif not ended.interrupted and (fault := results_fault(out)):
        state, reason = PartState.FAILED, fault
    elif ended.interrupted:
        left = scenes_left(taken, out) if job.scenes else (job.part,)
        state, reason = PartState.LEFT, f"interrupted at its limit of {time_s:.0f} s"
    if beyond and state is not PartState.FAILED:
        state, reason = PartState.LEFT, reason or f"more scenes than fit into {time_s:.0f} s"
    left = (*left, *beyond)
    done = 0 if state is PartState.FAILED else max(taken.items - len(left) + len(beyond), 0)
    return PartResult(
        job.part, state, round(time_s, 1), round(ended.duration_s, 3), left, reason, done, taken.shown(out)
    )


def has_results(folder: Path) -> bool:
    """Whether a job began to write results."""
    try:
        return bool(found_in(folder))
    except HistoryError:
        return False


def results_fault(folder: Path) -> str:
    """Why the results of a job can't be read; empty if they can. A job ended while it began has its record only."""
    try:
        read_figures_of(folder)
    except (HistoryError, FileNotFoundError, DamagedResultsError, SchemaVersionError) as error:
        return str(error)
    return ""


def file_interrupted(store: NightStore, folder: Path, state: NightState, progress: NightProgress) -> None:
    """Add what an interrupted night did, which does not go on, and close its folder."""
    if is_complete(store, state.stored):  # killed between its place in the history and the end of its folder
        write_state(folder, replace(state, finished=True))
        return
    name, _ = add(store, folder, state, complete=False)
    write_state(folder, replace(state, stored=name, finished=True))
    progress.note(f"the night of {state.started} was interrupted; what it did is kept as incomplete: {name}")


def is_complete(store: NightStore, name: str) -> bool:
    """Whether the history holds a whole night of this name."""
    return any(night.name == name and night.complete for night in store.nights()) if name else False


def add(store: NightStore, folder: Path, state: NightState, *, complete: bool) -> tuple[str, NightRun]:
    """Add a night to the history, and return its name there and its run.

    An earlier, incomplete state of the same night is replaced in the same transaction.
    """
    run = run_of(state, folder)
    night = night_of(folder, state, run, complete=complete and run.complete)
    store.add(night, replaces=state.stored or None, run=run)
    write_state(folder, replace(state, stored=night.name))
    return night.name, run


def run_of(state: NightState, folder: Path) -> NightRun:
    """Run of a night: its parts, each with all of its jobs, and the test of the alarm."""
    parts: dict[str, PartResult] = {}
    for result in state.results.values():
        parts[result.name] = joined(parts[result.name], result) if result.name in parts else result
    for name in state.parts:
        parts.setdefault(name, PartResult(name, PartState.LEFT, 0.0, 0.0, (name,), "the night was interrupted"))
    readable = [folder / name for name in state.results if not results_fault(folder / name)]
    tests = [test for test in (alarm_test(each, state.turn) for each in readable) if test]
    return NightRun(state.plan, state.minutes, tuple(parts.values()), together(tests), state.turn)


def joined(first: PartResult, second: PartResult) -> PartResult:
    """Result of a part of two jobs: scenes that were left before, and this night's."""
    worst = max((first, second), key=lambda part: list(PartState).index(part.state))
    return PartResult(
        first.name, worst.state, round(first.share_s + second.share_s, 1),
        round(first.duration_s + second.duration_s, 3), (*first.left, *second.left), worst.reason,
        first.done + second.done, " && ".join(c for c in (first.command, second.command) if c),
    )  # fmt: skip


def night_of(folder: Path, state: NightState, run: NightRun, *, complete: bool) -> Night:
    """Night of the result folders of its jobs."""
    folders = [each for each in sorted(folder.iterdir()) if each.is_dir() and not results_fault(each)]
    void = run.alarm.void if run.alarm else None
    make = night_here if folders else night_without_figures
    return make(
        folders, started=state.start, duration_s=state.duration_s, plan=state.plan, complete=complete, void=void
    )
