"""State of a night on disk: what goes on after an interruption, whatever the instant of a kill."""

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

from barchain.nightly.history.model.figures import NIGHT_FORMAT
from barchain.nightly.history.model.identity import content_digest
from barchain.nightly.history.model.installation import installation_of
from barchain.nightly.run_facts import PartResult, part_of, tuples
from reports.tables.reading import brief
from reports.tables.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from barchain.nightly.history.model.installation import Installation

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
