"""Place of a night in the history: of one that ended, of one that was interrupted, of one whose state is damaged."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.folders.reading import (
    found_in,
    night_here,
    plan_of,
    read_figures_of,
    recorded_installation,
    records_of,
    started,
)
from barchain.nightly.run_facts import INTERRUPTED, NightRun, PartResult, PartState
from barchain.nightly.running.alarm import alarm_test, together
from barchain.nightly.running.state import FILE, damaged, held, label_of, set_aside, start_of, write_state
from reports.tables.reading import DamagedResultsError
from reports.tables.schema import SchemaVersionError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from barchain.nightly.history.model.figures import Night
    from barchain.nightly.history.store import NightStore
    from barchain.nightly.running.state import NightState


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


def add(store: NightStore, folder: Path, state: NightState) -> tuple[str, NightRun]:
    """Add a night to the history, and return its name there and its run.

    An earlier, incomplete state of the same night is replaced.

    Raises
    ------
    HistoryError
        If the history can't be written; the message names the folder that keeps the results.
    """
    run = run_of(state, folder)
    night = night_of(folder, state, run)
    try:
        store.add(night, run)
    except HistoryError as error:
        raise HistoryError(f"{error}; the night's results stay in {folder}, and the next call adds them") from error
    return night.name, run


def run_of(state: NightState, folder: Path) -> NightRun:
    """Run of a night: its parts, each with all of its jobs, and the test of the alarm."""
    parts: dict[str, PartResult] = {}
    for result in (*state.results.values(), *not_begun(state)):
        parts[result.name] = joined(parts[result.name], result) if result.name in parts else result
    readable = [folder / name for name in state.results if not results_fault(folder / name)]
    tests = [test for test in (alarm_test(each, state.turn) for each in readable) if test]
    return NightRun(state.plan, state.minutes, tuple(parts.values()), together(tests), state.turn)


def not_begun(state: NightState) -> list[PartResult]:
    """Results of the jobs that have none; a night that an earlier barchain began knows its parts only."""
    jobs = [(job.part, job.scenes) for name, job in state.jobs.items() if name not in state.results]
    if not state.jobs:
        known = {result.name for result in state.results.values()}
        jobs = [(part, ()) for part in state.parts if part not in known]
    return [PartResult(part, PartState.LEFT, 0.0, 0.0, scenes or (part,), INTERRUPTED) for part, scenes in jobs]


def joined(first: PartResult, second: PartResult) -> PartResult:
    """Result of a part of two jobs: scenes that were left before, and this night's."""
    worst = max((first, second), key=lambda part: list(PartState).index(part.state))
    return PartResult(
        first.name, worst.state, round(first.share_s + second.share_s, 1),
        round(first.duration_s + second.duration_s, 3), (*first.left, *second.left), worst.reason,
        first.done + second.done, " && ".join(c for c in (first.command, second.command) if c),
        first.missing or second.missing, first.bad_input or second.bad_input,
    )  # fmt: skip


def night_of(folder: Path, state: NightState, run: NightRun) -> Night:
    """Night of the result folders of its jobs, with the parts of its start.

    Of a night that an earlier barchain began, the parts are known by the versions in its records.
    """
    folders = readable_folders(folder, state)
    return night_here(
        folders,
        started=state.start,
        duration_s=state.duration_s,
        plan=state.plan,
        complete=run.complete,
        void=run.alarm.void if run.alarm else None,
        installation=state.installation or recorded_installation(folders),
        label=label_of(folder),
    )


def readable_folders(folder: Path, state: NightState | None = None) -> list[Path]:
    """Result folders of a night in the order of the plan's parts."""
    parts = state.parts if state else []
    of_part = {name: result.name for name, result in state.results.items()} if state else {}

    def place(each: Path) -> tuple[int, str]:
        part = of_part.get(each.name, each.name)
        return (parts.index(part) if part in parts else len(parts)), each.name

    return [each for each in sorted(folder.iterdir(), key=place) if each.is_dir() and not results_fault(each)]


def file_interrupted(store: NightStore, folder: Path, state: NightState, note: Callable[[str], None]) -> None:
    """Add what an interrupted night did, which does not go on, and close its folder."""
    name, run = add(store, folder, state)
    write_state(folder, replace(state, finished=True))
    kept = "all that it did is kept" if run.complete else "what it did is kept as incomplete"
    note(f"the night of {state.started} was interrupted; {kept}: {name}")


def file_damaged(store: NightStore, out: Path, note: Callable[[str], None]) -> None:
    """Add what can be read of nights whose state is damaged, as incomplete nights; each is told in one line.

    The damaged state gets another name, and all results stay in their folder.
    """
    for folder, fault in damaged(out):
        with held(folder) as taken:
            if taken:
                note(f"{folder / FILE}: is damaged ({fault}); {rescued(store, folder)}")
                set_aside(folder)


def rescued(store: NightStore, folder: Path) -> str:
    """Add the results in a folder without a state, and return in words what became of them."""
    folders = readable_folders(folder)
    if not folders:
        return "no results can be read there; the folder is kept"
    read = records_of(folders)
    start = start_of(folder) or min(started(folder, record) for _, record in read)
    there = next((night for night in store.nights() if night.name == folder.name), None)
    if there is not None and there.complete:
        return f"the history holds the night already: {there.name}"
    alarm = together(test for test in map(alarm_test, folders) if test)
    night = night_here(
        folders,
        started=start,
        duration_s=sum(float(record.get("seconds") or 0.0) for _, record in read),
        plan=plan_of(read),
        complete=False,
        void=alarm.void if alarm else None,
        installation=recorded_installation(folders),
        label=label_of(folder),
    )
    store.add(night)
    return f"its results are kept as an incomplete night: {night.name}"
