"""Words of a night's page and summary: changes as rows, factors, durations."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from reports.tables.nights.facts import AcceptanceEntry, ChangeEntry

DIGITS = 8
MOST_OPEN = 12
"""Changes of a cause that the page shows at once; the others are folded"""
NOT_REPRODUCIBLE = "not reproducible: the parts are the same, the bits are others"
NOT_TRIED = "not tried"
SIGNS = {"worse": "▲", "better": "▼", "changed": "△", "same": "·"}
CLASSES = {"worse": "fail", "better": "pass", "changed": "gone", "same": "aside"}


@dataclass(frozen=True)
class ChangeRow:
    """A change in words."""

    entry: ChangeEntry
    was: str
    became: str
    sign: str
    style: str
    factor: str
    suspects: str
    confirmed: str
    accepted: str


def change_rows(changes: Iterable[ChangeEntry]) -> list[ChangeRow]:
    """Rows of the table of changes."""
    return [
        ChangeRow(
            change, shortened(change.kind, change.was), shortened(change.kind, change.became),
            SIGNS[change.direction], "aside" if change.accepted else CLASSES[change.direction],
            factor_words(change), suspect_words(change), confirmed_words(change), acceptance_words(change.accepted),
        )
        for change in changes
    ]  # fmt: skip


@dataclass(frozen=True)
class CauseGroup:
    """Changes of one cause."""

    cause: str
    """Suspects with what they were and are"""
    confirmed: str
    accepted: str
    rows: tuple[ChangeRow, ...]

    @property
    def amounts(self) -> str:
        """``12 worse, 2 changed``."""
        found = Counter(row.entry.direction for row in self.rows)
        return ", ".join(f"{count} {direction}" for direction, count in found.most_common())

    @property
    def where(self) -> str:
        """Engines, and the number of scenes: ``mujoco in 3 scenes``."""
        engines = sorted({row.entry.engine for row in self.rows if row.entry.engine})
        scenes = len({row.entry.scene for row in self.rows if row.entry.scene})
        place = f"{scenes} {'scene' if scenes == 1 else 'scenes'}" if scenes else ""
        return " in ".join(part for part in (", ".join(engines), place) if part)

    @property
    def shown(self) -> tuple[ChangeRow, ...]:
        """Changes that the page shows at once."""
        return self.rows[:MOST_OPEN]

    @property
    def folded(self) -> tuple[ChangeRow, ...]:
        """Changes that the page shows after a click."""
        return self.rows[MOST_OPEN:]


def by_cause(rows: Iterable[ChangeRow]) -> list[CauseGroup]:
    """Changes by cause, in the order in which the causes come first."""
    found: dict[tuple[str, str, str], list[ChangeRow]] = {}
    for row in rows:
        cause = NOT_REPRODUCIBLE if row.entry.irreproducible else row.suspects
        found.setdefault((cause, row.confirmed, row.accepted), []).append(row)
    return [CauseGroup(*key, tuple(own)) for key, own in found.items()]


def shortened(kind: str, result: str) -> str:
    """Result as a table shows it: of a digest the first digits, as of suspects."""
    return result[:DIGITS] if kind == "bits" else result


def factor_words(change: ChangeEntry) -> str:
    """``×1.21 (1.18 to 1.25)``; empty without a factor."""
    if change.factor is None:
        return ""
    found = f"×{change.factor:.4g}"
    if change.factor_low is None or change.factor_high is None:
        return found
    return f"{found} ({change.factor_low:.3g} to {change.factor_high:.3g})"


def suspect_words(change: ChangeEntry) -> str:
    """Suspects with what they were and are."""
    if change.suspects:
        return ", ".join(f"{s.name} {s.before or '(none)'} → {s.after or '(none)'}" for s in change.suspects)
    if change.unknown:
        return f"no known one; of unknown state: {', '.join(change.unknown)}"
    return "none: all parts that the figure depends on are the same"


def confirmed_words(change: ChangeEntry) -> str:
    """Whether real runs confirm the suspects."""
    return change.confirmed or (NOT_TRIED if change.suspects else "")


def acceptance_words(acceptance: AcceptanceEntry | None) -> str:
    """Acceptance in one line; empty without one."""
    if acceptance is None:
        return ""
    until = f", until {acceptance.until.date()}" if acceptance.until else ""
    return f"accepted by {acceptance.who} on {acceptance.when.date()}{until}: {acceptance.reason}"


def seconds_words(duration_s: float) -> str:
    """``12 min 5 s``."""
    minutes, seconds = divmod(round(duration_s), 60)
    return f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
