"""Accepted changes: who accepted which value, when, why, and until when; they come back when the figure moves again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from barchain.nightly.history.changes.levels import compared
from barchain.nightly.history.changes.model import Direction, result_words
from barchain.nightly.history.changes.steps import LEAST_EFFECT
from barchain.nightly.history.model.checked_text import FigureError, need_text
from barchain.nightly.history.model.figures import STEPPED, FigureKind
from barchain.nightly.history.model.identity import content_digest

if TYPE_CHECKING:
    import datetime
    from collections.abc import Iterable

    from barchain.nightly.history.changes.model import Change
    from barchain.nightly.history.model.figures import Figure


@dataclass(frozen=True)
class Acceptance:
    """A change that somebody accepted."""

    figure: str
    """Name of the figure"""
    was: str
    became: str
    """Results in words"""
    value: float | None
    """Accepted number: of a noisy figure the factor of its step"""
    word: str
    """Accepted word"""
    since: str
    """Name of the first night with the new value"""
    who: str
    accepted: datetime.datetime
    """UTC"""
    reason: str
    until: datetime.datetime | None = None
    """UTC; the change comes back afterwards"""

    def __post_init__(self) -> None:
        """Check who and why."""
        need_text("who", self.who)
        need_text("reason", self.reason)
        if not self.reason.strip():
            raise FigureError("reason: no text given, allowed: some")

    @property
    def digest(self) -> str:
        """Identity of the acceptance."""
        return content_digest(self)


def acceptance_of(
    change: Change, who: str, accepted: datetime.datetime, reason: str, until: datetime.datetime | None = None
) -> Acceptance:
    """Acceptance of a change as it stands."""
    value = change.factor if change.identity.kind in STEPPED else change.now.value
    return Acceptance(
        change.identity.name, result_words(change.was), result_words(change.now), value, change.now.word, change.since,
        who, accepted, reason, until,
    )  # fmt: skip


def accepting(change: Change, known: Iterable[Acceptance], at: datetime.datetime) -> Acceptance | None:
    """Latest acceptance that covers a change at an instant; None if there is none, or the run is not reproducible."""
    if change.irreproducible:
        return None
    covering = [a for a in known if a.figure == change.identity.name and covers(a, change, at)]
    return max(covering, key=lambda a: a.accepted, default=None)


def covers(acceptance: Acceptance, change: Change, at: datetime.datetime) -> bool:
    """Whether an acceptance covers a change: it has not ended, and the figure has been where it was accepted since.

    A change between other nights is another change, though it may lead to the same value: the accepted night lies after
    the last one with the earlier value, and is no later than the first one with the new value.

    A time, or memory, is there if its step is: of the same night, and as large within its interval and the least
    effect. Any other figure is there by the rule of its kind.
    """
    if acceptance.until is not None and at >= acceptance.until:
        return False
    if change.identity.kind in STEPPED and not change.now.missing:
        return same_step(acceptance, change)
    accepted = start(acceptance.since)
    return start(change.last) < accepted <= start(change.since) and same_result(acceptance, change.now)


def start(night: str) -> str:
    """Start of a night by its name, whose ending is a digest."""
    return night.rpartition("-")[0]


def same_step(acceptance: Acceptance, change: Change) -> bool:
    """Whether a step is the accepted one: of the same night, and as large within its interval and the least effect."""
    if acceptance.value is None or change.factor is None or change.since != acceptance.since:
        return False
    low, high = change.factor_low or change.factor, change.factor_high or change.factor
    return low / (1.0 + LEAST_EFFECT) <= acceptance.value <= high * (1.0 + LEAST_EFFECT)


def same_result(acceptance: Acceptance, now: Figure) -> bool:
    """Whether a figure has the accepted result, numerically."""
    if now.identity.kind is FigureKind.BITS or acceptance.value is None or now.missing:
        return acceptance.word == now.word and (acceptance.value is None) == (now.value is None)
    before = replace(now, value=acceptance.value, low=None, high=None)
    judged = compared(before, now)
    return judged is None or judged.direction is Direction.SAME
