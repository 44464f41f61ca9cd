"""State of a night on disk: what goes on after an interruption, whatever the instant of a kill."""

from __future__ import annotations

import datetime
import json
from dataclasses import asdict, dataclass, field, replace
from typing import TYPE_CHECKING, Any

from barchain.nightly.history.model.figures import NIGHT_FORMAT
from barchain.nightly.history.model.identity import content_digest
from barchain.nightly.run_facts import PartResult, part_of
from barchain.record.sources import digest_of
from reports.tables.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from barchain.nightly.history.model.figures import Environment

FILE = "night.json"
LONGEST_PAUSE = datetime.timedelta(hours=20)
"""An interrupted night goes on within this time; later a new one begins"""
PACKAGES = ("barchain", "adapters", "reference_impl", "scenarios", "reports")
MOST_IN_A_SECOND = 100


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
    """Digest of barchain's sources and of the environment: a night goes on with the same ones only"""
    left: dict[str, list[str]]
    """What the night before had left, by part"""
    parts: list[str]
    """Names of all parts of the plan"""
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


def code_here(environment: Environment) -> str:
    """Digest of barchain's sources and of the environment."""
    return content_digest([digest_of(*PACKAGES), environment])[:16]


def write_state(folder: Path, state: NightState) -> None:
    """Write the state whole."""
    write_atomically(folder / FILE, json.dumps(asdict(state), indent=1, allow_nan=False))


def read_state(folder: Path) -> NightState | None:
    """State in a night's folder; None if there is none, or it is damaged."""
    try:
        found: dict[str, Any] = json.loads((folder / FILE).read_text("utf-8"))
        found["results"] = {name: part_of(entry) for name, entry in found["results"].items()}
        state = NightState(**found)
        _ = state.start, state.duration_s
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None
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


def unfinished(out: Path) -> Iterator[tuple[Path, NightState]]:
    """Nights in a folder that did not come to their end, the latest first; some may still be running."""
    folders = sorted((each for each in out.iterdir() if each.is_dir()), reverse=True) if out.is_dir() else []
    for folder in folders:
        state = read_state(folder)
        if state is not None and not state.finished:
            yield folder, state


def goes_on(state: NightState, plan: str, code: str, now: datetime.datetime) -> bool:
    """Whether an interrupted night goes on: the same plan, code and environment, and not too long ago."""
    return state.plan == plan and state.code == code and now - state.start < LONGEST_PAUSE
