"""Recorded outcomes, and changes since, for better or worse."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from reports.tables.reading import brief, damaged
from reports.tables.stability import Stability
from reports.tables.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Mapping

    from barchain.studies.stability.rules import Finding

PATH = Path(__file__).with_name("expected.toml")
HEADER = "# How each engine fares in each hard scene; written by `barchain stability --accept FILE`.\n"
SLOW = "failed: time"  # a time-out, which another machine may not see
HARM = (
    Stability.STABLE, Stability.DRIFTING, Stability.UNSUPPORTED, Stability.REJECTED, Stability.INACCURATE,
    Stability.UNSTABLE, Stability.FAILED,
)  # fmt: skip
"""From the best to the worst for who relies on it: saying no is better than being wrong"""

Pair = tuple[str, str]


@dataclass(frozen=True)
class OutcomeChange:
    """An outcome that is not the one recorded."""

    scene: str
    engine: str
    before: str
    now: str

    @property
    def direction(self) -> str:
        """Whether it is better or worse."""
        now, before = (HARM.index(stability_of(word)) for word in (self.now, self.before))
        return "better" if now < before else "worse"

    @property
    def words(self) -> str:
        """In one line."""
        return f"{self.scene}  {self.engine}: {self.before} before, {self.now} now ({self.direction})"


def stability_of(word: str) -> Stability:
    """Outcome of a recorded word."""
    return Stability.FAILED if word == SLOW else Stability(word)


def recorded(path: Path = PATH) -> dict[Pair, str]:
    """Recorded words by scene and engine.

    Raises
    ------
    DamagedResultsError
        If the file holds anything else.
    """
    if not path.exists():
        return {}
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:  # no TOML, or no UTF-8
        raise damaged(path, f"it is no TOML ({brief(error)})") from error
    return {(scene, engine): word for scene, by in found.items() for engine, word in words_of(path, scene, by)}


def words_of(path: Path, scene: str, by: object) -> list[tuple[str, str]]:
    """Engines and recorded words of a scene, each an outcome."""
    allowed = (*Stability, SLOW)
    if not isinstance(by, dict) or any(word not in allowed for word in by.values()):
        raise damaged(path, f"of {brief(scene)}: expected an engine and one of {', '.join(allowed)} in each line")
    return list(by.items())


def word_of(finding: Finding) -> str:
    """Recorded word of a finding."""
    return SLOW if finding.slow else str(finding.stability)


def change(scene: str, engine: str, before: str | None, finding: Finding) -> OutcomeChange | None:
    """Change of an outcome; None where nothing counts as a change.

    A run that timed out before may finish now, or fail otherwise before its time limit: the cause is the machine. An
    outcome that is replaced by a time-out is a change.
    """
    now = word_of(finding)
    if before is None or before in (now, SLOW) or stability_of(before) is finding.stability:
        return None
    return OutcomeChange(scene, engine, before, now)


def accept(found: Mapping[Pair, Finding], path: Path = PATH) -> None:
    """Record these outcomes, and keep those of other scenes and engines."""
    words = recorded(path) | {pair: word_of(f) for pair, f in found.items()}
    lines = [HEADER]
    for scene in sorted({s for s, _ in words}):
        own = [f'{engine} = "{word}"' for (s, engine), word in sorted(words.items()) if s == scene]
        lines.append("\n".join([f'["{scene}"]', *own, ""]))
    write_atomically(path, "\n".join(lines))
