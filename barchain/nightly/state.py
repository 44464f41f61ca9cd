"""State of a night on disk, and its place in the history: nothing is lost, whatever the instant of a kill."""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import platform
import time
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

import psutil

from barchain.nightly.faults import HistoryError
from barchain.nightly.figures import NIGHT_FORMAT, content_digest
from barchain.nightly.parts import installation_of
from barchain.nightly.results import (
    found_in,
    night_here,
    plan_of,
    read_figures_of,
    recorded_installation,
    records_of,
    started,
)
from barchain.nightly.run_facts import (
    INTERRUPTED,
    NightRun,
    PartResult,
    PartState,
    alarm_test,
    part_of,
    together,
    tuples,
)
from reports.tables.reading import DamagedResultsError, brief
from reports.tables.schema import SchemaVersionError
from reports.tables.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from barchain.nightly.figures import Night
    from barchain.nightly.history import NightStore
    from barchain.nightly.parts import Installation


FILE = "night.json"
SET_ASIDE = "night.json.damaged"
HOLDER = "running.json"
LONGEST_PAUSE = datetime.timedelta(hours=20)
"""An interrupted night goes on within this time; later a new one begins"""
LABEL_DIGITS = 8


class DamagedStateError(ValueError):
    """Raised for a state that can't be read; the message is one line."""


@dataclass(frozen=True)
class PlannedJob:
    """Job that a night begins with."""

    part: str
    scenes: tuple[str, ...] = ()


@dataclass(frozen=True)
class NightState:
    """State of a night."""

    plan: str
    """Identity of the plan"""
    minutes: float
    turn: int
    started: str
    """UTC, ISO 8601"""
    code: str
    """Digest of sources, engines, libraries and environment: a night goes on with the same ones only"""
    left: dict[str, list[str]]
    """What the night before had left, by part"""
    parts: list[str]
    """Names of all parts of the plan"""
    waiting: list[str] = field(default_factory=list)
    """Parts of which the night before did nothing"""
    jobs: dict[str, PlannedJob] = field(default_factory=dict)
    """All jobs of the night, by name"""
    begun: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Scenes that a job took on when it began, by name"""
    installation: Installation | None = None
    """Of the start of the night: what its results come from, whenever they are filed"""
    results: dict[str, PartResult] = field(default_factory=dict)
    """Ends of jobs, by name"""
    finished: bool = False

    @property
    def start(self) -> datetime.datetime:
        """Start in UTC."""
        return datetime.datetime.fromisoformat(self.started)

    @property
    def duration_s(self) -> float:
        """Time that jobs took."""
        return sum(result.duration_s for result in self.results.values())

    def with_result(self, name: str, result: PartResult) -> NightState:
        """State after a job; time of an earlier attempt counts too."""
        before = self.results.get(name)
        spent = before.duration_s if before else 0.0
        ended = replace(result, duration_s=round(result.duration_s + spent, 3))
        return replace(self, results=self.results | {name: ended})


def write_state(folder: Path, state: NightState) -> None:
    """Write the state whole."""
    write_atomically(folder / FILE, json.dumps(asdict(state), indent=1, allow_nan=False))


def read_state(folder: Path) -> NightState | None:
    """State in a night's folder; None if there is none.

    Raises
    ------
    DamagedStateError
        If it can't be read.
    """
    try:
        return state_of(json.loads((folder / FILE).read_text("utf-8")))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise DamagedStateError(error.strerror or "can't be read") from None
    except KeyError as error:
        raise DamagedStateError(f"entry {brief(error)} is missing") from None
    except (ValueError, TypeError, AttributeError) as error:
        raise DamagedStateError(brief(error)) from None


def state_of(found: dict[str, Any]) -> NightState:
    """State of the entries of its file; one of an earlier barchain lacks some."""
    content = {name: value for name, value in found.items() if name != "stored"}
    content["results"] = {name: part_of(entry) for name, entry in content["results"].items()}
    content["jobs"] = {name: PlannedJob(**tuples(entry)) for name, entry in content.get("jobs", {}).items()}
    content["begun"] = {name: tuple(scenes) for name, scenes in content.get("begun", {}).items()}
    content["installation"] = content.get("installation") and installation_of(content["installation"])
    state = NightState(**content)
    _ = state.start - state.start, state.duration_s + state.minutes + state.turn
    return state


def new_folder(out: Path, start: datetime.datetime) -> Path:
    """New folder of a night, named by its start, and by its machine and process: two nights never share one.

    Raises
    ------
    OSError
        If it can't be made.
    """
    label = content_digest([platform.node(), os.getpid(), time.monotonic_ns()])[:LABEL_DIGITS]
    folder = out / f"{start.strftime(NIGHT_FORMAT)}-{label}"
    folder.mkdir(parents=True)
    return folder


def night_folders(out: Path) -> list[Path]:
    """Folders of all nights, the latest first."""
    return sorted((each for each in out.iterdir() if each.is_dir()), reverse=True) if out.is_dir() else []


def unfinished(out: Path) -> Iterator[tuple[Path, NightState]]:
    """Nights in a folder that did not come to their end, the latest first; some may still be running."""
    for folder in night_folders(out):
        try:
            state = read_state(folder)
        except DamagedStateError:
            continue
        if state is not None and not state.finished:
            yield folder, state


def damaged(out: Path) -> Iterator[tuple[Path, str]]:
    """Nights in a folder whose state can't be read, the latest first, each with the reason."""
    for folder in night_folders(out):
        try:
            read_state(folder)
        except DamagedStateError as error:
            yield folder, str(error)


def start_of(folder: Path) -> datetime.datetime | None:
    """Start of a night by the name of its folder; None of another name."""
    try:
        found = datetime.datetime.strptime(folder.name[: len("2026-01-05T02-00-00")], NIGHT_FORMAT)
    except ValueError:
        return None
    return found.replace(tzinfo=datetime.UTC)


def set_aside(folder: Path) -> None:
    """Give a damaged state another name, so that it is told once."""
    (folder / FILE).replace(folder / SET_ASIDE)


def goes_on(state: NightState, plan: str, code: str, now: datetime.datetime) -> bool:
    """Whether an interrupted night goes on: the same plan, code and environment, and not too long ago."""
    return state.plan == plan and state.code == code and abs(now - state.start) < LONGEST_PAUSE


def label_of(folder: Path) -> str:
    """Ending of the name of a night's folder that tells nights of one second apart; empty of another name."""
    return folder.name[len("2026-01-05T02-00-00-") :]


@contextlib.contextmanager
def held(folder: Path) -> Iterator[bool]:
    """Whether this process holds a night's folder: no other process that still runs does.

    A file names the holder, by its machine, number and start: nothing is left over where a machine goes down, and no
    file system has to know locks. Of another machine it is not known whether the holder still runs.
    """
    own = [platform.node(), os.getpid(), psutil.Process().create_time()]
    path = folder / HOLDER
    taken = take(path, own)
    if not taken and not is_running(path):
        path.unlink(missing_ok=True)
        taken = take(path, own)
    try:
        yield taken
    finally:
        if taken:
            path.unlink(missing_ok=True)


def take(path: Path, own: list[object]) -> bool:
    """Make the file of a folder's holder; False if there is one."""
    try:
        with path.open("x") as file:
            json.dump(own, file)
    except FileExistsError:
        return False
    return True


def is_running(path: Path) -> bool:
    """Whether the process that holds a folder still runs; one of another machine counts as running."""
    try:
        node, pid, began = json.loads(path.read_text("utf-8"))
        return node != platform.node() or bool(psutil.Process(pid).create_time() == began)
    except (OSError, ValueError, TypeError, psutil.Error):
        return False


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
