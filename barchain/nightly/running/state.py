"""State of a night on disk: what goes on after an interruption, whatever the instant of a kill."""

from __future__ import annotations

import contextlib
import datetime
import json
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

from barchain.nightly.history.model.figures import NIGHT_FORMAT
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
LONGEST_PAUSE = datetime.timedelta(hours=20)
"""An interrupted night goes on within this time; later a new one begins"""
MOST_IN_A_SECOND = 100


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
    stored: str = ""
    """Name under which the history holds what was done so far"""
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
    content = dict(found)
    content["results"] = {name: part_of(entry) for name, entry in content["results"].items()}
    content["jobs"] = {name: PlannedJob(**tuples(entry)) for name, entry in content.get("jobs", {}).items()}
    content["begun"] = {name: tuple(scenes) for name, scenes in content.get("begun", {}).items()}
    content["installation"] = content.get("installation") and installation_of(content["installation"])
    state = NightState(**content)
    _ = state.start - state.start, state.duration_s + state.minutes + state.turn
    return state


def new_folder(out: Path, start: datetime.datetime) -> Path:
    """New folder of a night, named by its start; two nights never share one.

    Raises
    ------
    OSError
        If it can't be made.
    """
    out.mkdir(parents=True, exist_ok=True)
    name = start.strftime(NIGHT_FORMAT)
    for ending in ("", *(f"-{k}" for k in range(2, MOST_IN_A_SECOND))):
        try:
            (out / f"{name}{ending}").mkdir()
        except FileExistsError:
            continue
        return out / f"{name}{ending}"
    raise FileExistsError(17, "too many nights began in this second", str(out / name))


def night_folders(out: Path) -> list[Path]:
    """Folders of all nights, the latest first."""
    return sorted((each for each in out.iterdir() if each.is_dir()), reverse=True) if out.is_dir() else []


def folders_by_name(out: Path) -> dict[str, Path]:
    """Folders with the results of nights, by the names under which a history holds the nights."""
    found = {}
    for folder in night_folders(out):
        with contextlib.suppress(DamagedStateError):
            state = read_state(folder)
            if state is not None and state.stored:
                found[state.stored] = folder
    return found


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
