"""A night from its plan to its place in the history."""

from __future__ import annotations

import contextlib
import datetime
import os
import platform
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.dependencies import code_of, installation_here
from barchain.nightly.figures.figure import NIGHT_FORMAT, content_digest
from barchain.nightly.figures.results import has_results
from barchain.nightly.history.nights import last_run
from barchain.nightly.running.budget import (
    ALARM,
    COST,
    ENDING_S,
    LEAST_S,
    MEASURED,
    fitting,
    last_of,
    leftovers,
    limit_s,
    running_s,
    scenes_left,
    times_left_out,
    waiting_parts,
    working_time_s,
)
from barchain.nightly.running.jobs import NightJob, night_jobs, plan_engines
from barchain.nightly.running.plan import LOGS
from barchain.nightly.running.state import (
    NightState,
    add,
    alarm_test,
    read_state,
    results_fault,
    unfinished,
    write_state,
)
from barchain.record.claim import FolderInUseError, locked
from barchain.runs.processes import GRACE_S, Finished, run_barchain
from barchain.studies.study import ignore
from reports.results.nights import STATE
from reports.results.nights.document import CUT, NightRun, PartResult, PartState
from scenarios import scene_names

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from barchain.nightly.history.nights import NightStore
    from barchain.nightly.running.plan import NightPlan


BAD_INPUT = 2
"""Exit code of a command whose scene, or other input, can't be read"""
TIMED = frozenset({COST, "scaling"})
"""Studies that plan with a budget of time"""
LABEL_DIGITS = 8
MORE = "-more"
"""Ending of the name of a job that does what another one of the night did not take on"""


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
    plan: NightPlan,
    minutes: float,
    store: NightStore,
    out: Path,
    progress: NightProgress | None = None,
    spent_s: float = 0.0,
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
    spent_s : float
        Part of the wall time that went by before this call, s.

    Returns
    -------
    NightEnd

    Raises
    ------
    PlanError
        If the plan can't be met; nothing was run then.
    HistoryError
        If the history can't be written; the results stay in the night's folder, and the next call adds them.

    Notes
    -----
    A night that was interrupted goes on, if plan, sources, engines, libraries and environment are the same and it
    began less than 20 hours ago. Otherwise what it did is added to the history, with the parts of its start, and a new
    night begins.
    """
    progress = progress or NightProgress()
    end, now = time.monotonic() - spent_s + working_time_s(minutes), datetime.datetime.now(datetime.UTC)
    last = last_run(store, plan.identity)
    next_jobs(plan, last)  # an error of the plan comes before anything runs
    if ahead := [night for night in store.nights() if night.started > now]:
        several = f"{len(ahead)} nights start" if len(ahead) > 1 else "a night starts"
        progress.note(f"history: {several} later than now, e.g. {ahead[-1].name}; a clock was or is wrong")
    engines = plan_engines(plan)
    installation = installation_here(engines, scene_names())
    code = code_of(installation, engines)
    for folder, state in list(unfinished(out, progress.note)):
        with contextlib.ExitStack() as holding:
            try:
                holding.enter_context(locked(folder))
            except FolderInUseError:
                continue
            if state.goes_on(plan.identity, code, now):
                progress.note(
                    f"going on with the night of {state.started.isoformat()}, which is not in the history yet"
                )
                return finish(Running(end, store, folder, progress, last), replace(state, minutes=minutes))
            name, run = add(store, folder, with_cut_job(folder, state))
            write_state(folder, replace(state, finished=True))
            kept = "all that it did is kept" if run.complete else "what it did is kept as incomplete"
            progress.note(f"the night of {state.started.isoformat()} was interrupted; {kept}: {name}")
    last = last_run(store, plan.identity)
    label = content_digest([platform.node(), os.getpid(), time.monotonic_ns()])[:LABEL_DIGITS]
    folder = out / f"{now.strftime(NIGHT_FORMAT)}-{label}"  # two nights never share one
    with locked(folder):
        state = NightState(
            plan.identity, minutes, last.turn + 1 if last else 0, now.replace(microsecond=0), code,
            tuple(part.name for part in plan.file.parts), installation, next_jobs(plan, last),
        )  # fmt: skip
        write_state(folder, state)
        return finish(Running(end, store, folder, progress, last), state)


def next_jobs(plan: NightPlan, last: NightRun | None) -> tuple[NightJob, ...]:
    """Jobs of the next night of a plan.

    Raises
    ------
    PlanError
        If the plan can't be met.
    """
    return night_jobs(plan, last.turn + 1 if last else 0, leftovers(last), waiting_parts(last))


@dataclass(frozen=True)
class Running:
    """A night that is being run."""

    end: float
    """Time of the monotonic clock at which all jobs have ended"""
    store: NightStore
    folder: Path
    progress: NightProgress
    last: NightRun | None = None
    """Last night of the plan, for the pace of its parts"""


def finish(night: Running, state: NightState) -> NightEnd:
    """Run the jobs that are not done, and add the night to the history, also if it is interrupted."""
    try:
        state = run_jobs(night, state)
    except OSError as error:
        said = f"{error.filename or night.folder}: {error.strerror or error}"
        raise HistoryError(f"{said}; results so far stay in {night.folder}, and the next call goes on") from error
    except KeyboardInterrupt:
        add(night.store, night.folder, with_cut_job(night.folder, read_state(night.folder) or state))
        raise
    name, run = add(night.store, night.folder, state)
    write_state(night.folder, replace(state, finished=True))
    return NightEnd(night.folder, name, run)


def run_jobs(night: Running, state: NightState) -> NightState:
    """Run all jobs that are not done, one after the other, and write the state before and after each.

    A job that began already goes on with the scenes of its begin. Scenes beyond those that it takes on come once more
    after all other jobs, at tonight's pace: the last night may have been slower.
    """
    done = {name for name, result in state.results.items() if result.state is not PartState.LEFT}
    waiting = [job for job in state.jobs if job.name not in done]
    for k, job in enumerate(waiting):
        left_s = max(night.end - time.monotonic(), 0.0)
        time_s = limit_s(job, waiting[k + 1 :], left_s)
        total = len(state.jobs)
        night.progress.begin(job.name, total - len(waiting) + k + 1, total, time_s)
        if time_s < LEAST_S:
            left, shown = job.scenes or (job.part,), job.shown(night.folder / job.name)
            result = PartResult(job.part, PartState.LEFT, time_s, 0.0, left, "no time was left", command=shown)
        else:
            begun = state.begun.get(job.name)
            if begun is None:
                tonight = state.results.get(job.name.removesuffix(MORE)) if job.name.endswith(MORE) else None
                pace = tonight if tonight and tonight.done else last_of(job.part, night.last)
                begun = fitting(job, running_s(time_s), pace).scenes
            given_s = state.given_s | {job.name: round(time_s, 1)}
            state = replace(state, begun=state.begun | {job.name: begun}, given_s=given_s)
            if begun != job.scenes and not job.name.endswith(MORE):
                job, later = divided(job, begun)  # noqa: PLW2901  # what is run of it now
                state = replace(state, jobs=(*(job if one.name == job.name else one for one in state.jobs), later))
                waiting.append(later)
            write_state(night.folder, state)
            result = run_job(night, job, replace(job, scenes=begun), time_s)
        before = state.results.get(job.name)  # the time of an earlier attempt counts too
        result = replace(result, duration_s=round(result.duration_s + (before.duration_s if before else 0.0), 3))
        state = replace(state, results=state.results | {job.name: result})
        write_state(night.folder, state)
        night.progress.end(result)
    return state


def with_cut_job(folder: Path, state: NightState) -> NightState:
    """State of a night that was cut, with what its last job did by then: nobody was there to write that down.

    The state was written as the job began, and its log or its results as it last did anything.
    """
    cut = {}
    for job in state.jobs:
        if job.name not in state.begun or job.name in state.results:
            continue
        out, taken = folder / job.name, replace(job, scenes=state.begun[job.name])
        places = (folder / LOGS / f"{job.name}.txt", *out.glob("*"), *out.glob("*/*"))
        last = max((each.stat().st_mtime for each in places if each.exists()), default=0.0)
        given_s = state.given_s.get(job.name, 0.0)
        used_s = min(max(last - (folder / STATE).stat().st_mtime, 0.0), given_s)
        result = result_of(job, taken, given_s, Finished(None, used_s), out)
        reason = CUT if result.state is PartState.LEFT else ""
        cut[job.name] = replace(result, reason=reason, begun=result.done > 0)
    return replace(state, results=state.results | cut)


def divided(job: NightJob, scenes: tuple[str, ...]) -> tuple[NightJob, NightJob]:
    """Job with some of its scenes, and a later one with the others."""
    others = tuple(scene for scene in job.scenes if scene not in scenes)
    later = replace(job, name=f"{job.name}{MORE}", scenes=others, waits=False, favoured=False)
    return replace(job, scenes=scenes), later


def run_job(night: Running, job: NightJob, taken: NightJob, time_s: float) -> PartResult:
    """Run one job inside its time, with the scenes that it takes on."""
    out, limit = night.folder / job.name, running_s(time_s)
    more = ("--minutes", f"{MEASURED * limit / 60.0:.3f}") if job.study in TIMED else ()
    again = ("--resume",) if has_results(out) else ()
    grace_s = max(min(night.end - time.monotonic() - limit, GRACE_S), ENDING_S)
    ended = run_barchain(
        taken.command(out, *more, *again), night.folder / LOGS / f"{job.name}.txt", limit, night.progress.tick, grace_s
    )
    return result_of(job, taken, time_s, ended, out)


def result_of(job: NightJob, taken: NightJob, time_s: float, ended: Finished, out: Path) -> PartResult:
    """Result of a job whose process has ended.

    A part whose engines are not all installed is done with the others, and leaves its night incomplete. Of an
    interrupted job of faults those count that it tried; another job without scenes is done whole or not at all.
    """
    beyond = tuple(scene for scene in job.scenes if scene not in taken.scenes)
    left: tuple[str, ...] = ()
    state, reason, fault = PartState.DONE, ended.reason, results_fault(out)
    alarm = alarm_test(out) if job.study == ALARM and not fault else None
    if ended.interrupted:
        left = scenes_left(taken, out) if job.scenes else (job.part,)
        if left or not job.scenes:  # else it was measured to the end, and its report was cut
            state, reason = PartState.LEFT, f"interrupted at its limit of {time_s:.0f} s"
        else:
            reason = ""
    elif ended.failed:
        state = PartState.FAILED
    elif fault:
        state, reason = PartState.FAILED, fault
    elif job.study == ALARM and alarm is None:
        state, reason = PartState.FAILED, "no fault was inserted: the alarm was not tried"
    elif job.study == COST:
        reason = times_left_out(out)
    if beyond and state is not PartState.FAILED:
        waits = f"{len(beyond)} of {len(job.scenes)} scenes did not fit into its {time_s:.0f} s"
        state, reason = PartState.LEFT, reason or waits
    done = taken.items - len(left)
    if state is PartState.FAILED:
        done = 0
    elif left and not taken.scenes:
        done = alarm.planted if alarm else 0
    return PartResult(
        job.part, state, round(time_s, 1), round(ended.duration_s, 3), (*left, *beyond), reason, done,
        taken.shown(out), taken.missing,
        taken.bad_input or (ended.code == BAD_INPUT and state is PartState.FAILED),
    )  # fmt: skip
