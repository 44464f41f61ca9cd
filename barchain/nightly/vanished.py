"""Figures that are gone, and the nights on which figures and scenes were measured."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np

from barchain.nightly.changes import Change, Direction
from barchain.nightly.figures import Figure, FigureSeries

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from barchain.nightly.figures import FigureIdentity, NightSummary


OCCASIONS = 2
"""Occasions in a row that must have a figure: some figures are measured only now and then"""
SAMPLED = ("stability.", "selftest.", "campaign.")
"""Beginnings of the quantities of studies of which a night does a part only: scenes, or faults, of that night"""
STUDIES = frozenset({"cost", "scaling", "stability", "effects", "roundoff", "selftest", "campaign"})
COMPARISON = "comparison"
Subject = tuple[str, str, str]
"""Study, scene and fault of a figure: what is done as a whole"""


class Presence:
    """Nights on which figures and scenes were measured."""

    def __init__(
        self, nights: Sequence[NightSummary], identities: Sequence[FigureIdentity], there: NDArray[np.bool_]
    ) -> None:
        """Take which figures are there, with or without a result: shape (identities, nights)."""
        self.nights, self.there = nights, there
        self.number = {identity: k for k, identity in enumerate(identities)}
        self.members: dict[Subject, list[int]] = defaultdict(list)
        for identity, number in self.number.items():
            self.members[subject_of(identity)].append(number)
        self.left = [None if night.run is None else night.run.left for night in nights]
        """Studies and scenes that each night left, of nights that know it"""
        self.known: dict[Subject, frozenset[str]] = {}

    def of_figure(self, identity: FigureIdentity) -> frozenset[str]:
        """Names of the nights that have a figure."""
        return frozenset(self.nights[k].name for k in np.flatnonzero(self.there[self.number[identity]]).tolist())

    def of_subject(self, subject: Subject) -> frozenset[str]:
        """Names of the nights on which a study did a scene to its end, with all engines.

        Such a night left nothing of the scene; without a run of a plan, it is complete.
        """
        if subject not in self.known:
            (study, scene, _), done = subject, []
            for k in np.flatnonzero(np.any(self.there[self.members.get(subject, [])], axis=0)).tolist():
                left = self.left[k]
                if self.nights[k].complete if left is None else not {(study, scene), (study, "")} & left:
                    done.append(self.nights[k].name)
            self.known[subject] = frozenset(done)
        return self.known[subject]


def presence_in(series: Sequence[FigureSeries], nights: Sequence[NightSummary]) -> Presence:
    """Presence of series that have all of their nights."""
    names = [{night.name for night in one.nights} for one in series]
    there = np.array([[night.name in own for night in nights] for own in names], bool).reshape(-1, len(nights))
    return Presence(nights, [one.identity for one in series], there)


def vanished(series: Sequence[FigureSeries], nights: Sequence[NightSummary], presence: Presence) -> tuple[Change, ...]:
    """Figures that are gone up to the last of some nights, each since the first occasion without it.

    A figure that is gone stays so on the nights of other plans and machines.

    Parameters
    ----------
    series : sequence of FigureSeries
    nights : sequence of NightSummary
        In their order.
    presence : Presence
    """
    if not nights:
        return ()
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
    last, names = one.nights[-1], (*(name for name, _ in one.earlier), one.identity)
    whole = frozenset[str]().union(*(presence.of_subject(subject_of(name)) for name in names))
    occasions = [night for night in plan if night.name in whole]
    if not any(night.started > last.started for night in occasions):
        if one.identity.quantity.startswith(SAMPLED):
            return None
        occasions = [night for night in plan if night.complete]  # nothing of its scene was measured since
    before = [night for night in occasions if night.started <= last.started][-OCCASIONS:]
    after = next((night for night in occasions if night.started > last.started), None)
    if after is None or len(before) < OCCASIONS or not all(night.name in whole for night in before):
        return None
    own = frozenset[str]().union(*map(presence.of_figure, names))
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
