"""Figures that are gone: measured on two occasions in a row, and on none since.

An occasion is a night of the same plan on which the figure's scene was done by its study: parts of a plan divide their
scenes among nights, and a night that ran out of time has done some scenes only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from barchain.nightly.history.changes.model import Change, Direction
from barchain.nightly.history.model.figures import Figure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.model.figures import FigureIdentity
    from barchain.nightly.history.model.series_model import FigureSeries, NightSummary

OCCASIONS = 2
"""Occasions in a row that must have a figure: some figures are measured only now and then"""
SAMPLED = ("stability.", "selftest.", "campaign.")
"""Beginnings of the quantities of studies of which a night does a part only: scenes, or faults, of that night"""
STUDIES = frozenset({"cost", "scaling", "stability", "effects", "roundoff", "selftest", "campaign"})
COMPARISON = "comparison"
Subject = tuple[str, str, str]
"""Study, scene and fault of a figure: what is done as a whole"""


class Presence(Protocol):
    """Nights on which scenes and figures were measured, by name."""

    def of_figure(self, identity: FigureIdentity) -> frozenset[str]:
        """Nights that have a figure, with or without a result."""

    def of_subject(self, subject: Subject) -> frozenset[str]:
        """Nights on which a scene was done to its end by a study."""


@dataclass(frozen=True)
class PresenceInSeries:
    """Presence of series that have all of their nights; of an incomplete night nothing counts as done to its end."""

    series: Sequence[FigureSeries]
    nights: Sequence[NightSummary]

    def of_figure(self, identity: FigureIdentity) -> frozenset[str]:
        """Nights that have a figure."""
        return frozenset(night.name for one in self.series if one.identity == identity for night in one.nights)

    def of_subject(self, subject: Subject) -> frozenset[str]:
        """Complete nights that have a figure of the subject."""
        own = [one for one in self.series if subject_of(one.identity) == subject]
        return frozenset(night.name for one in own for night in one.nights if night.complete)


def vanished(
    series: Sequence[FigureSeries], nights: Sequence[NightSummary], presence: Presence | None = None
) -> tuple[Change, ...]:
    """Figures that are gone up to the last of some nights, each since the first occasion without it.

    A figure that is gone stays so on the nights of other plans and machines.

    Parameters
    ----------
    series : sequence of FigureSeries
    nights : sequence of NightSummary
        In their order.
    presence : Presence, optional
    """
    if not nights:
        return ()
    presence = presence or PresenceInSeries(series, nights)
    tonight = nights[-1]
    plans = [[night for night in nights if night.plan == plan] for plan in {night.plan: None for night in nights}]
    current = [one for one in series if one.nights and one.nights[-1].name == tonight.name]
    not_run = {place(one.identity) for one in current if one.figures[-1].not_run}
    found = []
    for one in series:
        absent = bool(one.nights) and one.nights[-1].name != tonight.name and not one.figures[-1].missing
        changes = [vanished_figure(one, plan, presence) for plan in plans] if absent else []
        gone = min((c for c in changes if c), key=lambda c: c.since, default=None)
        if gone and not (gone.since == tonight.name and place(one.identity) in not_run):
            found.append(gone)
    return tuple(found)


def vanished_figure(one: FigureSeries, plan: Sequence[NightSummary], presence: Presence) -> Change | None:
    """Change of a figure that no night of the plan has any more; None if no night should have had it."""
    last, whole = one.nights[-1], presence.of_subject(subject_of(one.identity))
    occasions = [night for night in plan if night.name in whole]
    if not any(night.started > last.started for night in occasions):
        if one.identity.quantity.startswith(SAMPLED):
            return None
        occasions = [night for night in plan if night.complete]  # nothing of its scene was measured since
    before = [night for night in occasions if night.started <= last.started][-OCCASIONS:]
    after = next((night for night in occasions if night.started > last.started), None)
    if after is None or len(before) < OCCASIONS or not all(night.name in whole for night in before):
        return None
    own = presence.of_figure(one.identity)
    if not all(night.name in own for night in before):
        return None
    reason = f"not measured, though each of the {OCCASIONS} nights before that did its scene had it"
    was = one.figures[-1]
    now = Figure(one.identity, reason=reason, depends=was.depends)
    return Change(one.identity, was, now, last.name, after.name, Direction.WORSE, reason)


def study_of(identity: FigureIdentity) -> str:
    """Study that a figure is of."""
    first = identity.quantity.partition(".")[0]
    return first if first in STUDIES else COMPARISON


def subject_of(identity: FigureIdentity) -> Subject:
    """Study, scene and fault of a figure."""
    study = study_of(identity)
    return study, identity.scene, identity.setting if study in {"selftest", "campaign"} else ""


def place(identity: FigureIdentity) -> tuple[str, str, str, str]:
    """Study, scene, engine and setting of a figure: a run that had no time lacks all of its figures."""
    return study_of(identity), identity.scene, identity.engine, identity.setting
