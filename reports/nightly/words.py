"""Changes of a night by their cause, for its page and summary."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from reports.tables.nights.facts import ChangeEntry

NOT_REPRODUCIBLE = "not reproducible: the parts are the same, the bits are others"


@dataclass(frozen=True)
class CauseGroup:
    """Changes of one cause."""

    cause: str
    """Suspects with what they were and are"""
    confirmed: str
    accepted: str
    changes: tuple[ChangeEntry, ...]

    @property
    def amounts(self) -> str:
        """``12 worse, 2 changed``."""
        found = Counter(change.direction for change in self.changes)
        return ", ".join(f"{count} {direction}" for direction, count in found.most_common())

    @property
    def where(self) -> str:
        """Engines, and the number of scenes: ``mujoco in 3 scenes``."""
        engines = sorted({change.engine for change in self.changes if change.engine})
        scenes = len({change.scene for change in self.changes if change.scene})
        place = f"{scenes} {'scene' if scenes == 1 else 'scenes'}" if scenes else ""
        return " in ".join(part for part in (", ".join(engines), place) if part)


def by_cause(changes: Iterable[ChangeEntry]) -> list[CauseGroup]:
    """Changes by cause, in the order in which the causes come first."""
    found: dict[tuple[str, str, str], list[ChangeEntry]] = {}
    for change in changes:
        cause = NOT_REPRODUCIBLE if change.irreproducible else change.suspect_words
        accepted = change.accepted.sentence if change.accepted else ""
        found.setdefault((cause, change.confirmed_words, accepted), []).append(change)
    return [CauseGroup(*key, tuple(own)) for key, own in found.items()]


def seconds_words(duration_s: float) -> str:
    """``12 min 5 s``."""
    minutes, seconds = divmod(round(duration_s), 60)
    return f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
