"""Nights on which scenes and figures were measured, as the store tells."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import sqlalchemy as sa

from barchain.nightly.history.changes.vanished import Subject, subject_of
from barchain.nightly.history.kept.runs import runs_of_nights
from barchain.nightly.history.storage.connection import told
from barchain.nightly.history.storage.tables import figures, series
from barchain.nightly.history.storage.vocabulary import identity_of
from barchain.nightly.run_facts import PartState, scene_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from barchain.nightly.history.model.figures import FigureIdentity
    from barchain.nightly.history.model.series_model import NightSummary
    from barchain.nightly.history.store import NightStore
    from barchain.nightly.run_facts import NightRun, PartResult

STUDY_OF_COMMAND = {"compare": "comparison"}
"""Studies whose command has another name"""


@dataclass(frozen=True)
class StoredPresence:
    """Presence over some nights of a store; each question is a query, and asked once."""

    store: NightStore
    nights: Sequence[NightSummary]

    def of_figure(self, identity: FigureIdentity) -> frozenset[int]:
        """Nights that have a figure."""
        number = self.numbers.get(identity)
        return self.nights_with([number] if number is not None else [])

    def of_subject(self, subject: Subject) -> frozenset[int]:
        """Nights on which a scene was done to its end by a study."""
        if subject not in self.known:
            study, scene, _ = subject
            whole = self.nights_with(self.members.get(subject, ()))
            self.known[subject] = frozenset(n for n in whole if self.was_done(n, study, scene))
        return self.known[subject]

    def nights_with(self, numbers: Sequence[int]) -> frozenset[int]:
        """Nights that have one of some series."""
        query = sa.select(figures.c.night_id).where(figures.c.series_id.in_(numbers)).distinct()
        with told(self.store.given), self.store.engine.connect() as connection:
            return frozenset(connection.execute(query).scalars())

    def was_done(self, number: int, study: str, scene: str) -> bool:
        """Whether a night did a scene with all engines; an incomplete one tells what it left."""
        left = self.left.get(number)
        if left is None:
            return number in self.complete
        return not {(study, scene), (study, "")} & left

    @cached_property
    def known(self) -> dict[Subject, frozenset[int]]:
        """Answers so far."""
        return {}

    @cached_property
    def complete(self) -> frozenset[int]:
        """Numbers of the complete nights."""
        return frozenset(night.number for night in self.nights if night.complete)

    @cached_property
    def left(self) -> dict[int, frozenset[tuple[str, str]]]:
        """Studies and scenes that each night left; of nights that know it."""
        return {number: left_of(run) for number, run in runs_of_nights(self.store).items()}

    @cached_property
    def numbers(self) -> dict[FigureIdentity, int]:
        """Numbers of all series."""
        with told(self.store.given), self.store.engine.connect() as connection:
            return {identity_of(row): row.id for row in connection.execute(sa.select(series))}

    @cached_property
    def members(self) -> dict[Subject, list[int]]:
        """Numbers of the series of each subject."""
        found: dict[Subject, list[int]] = {}
        for identity, number in self.numbers.items():
            found.setdefault(subject_of(identity), []).append(number)
        return found


def left_of(run: NightRun) -> frozenset[tuple[str, str]]:
    """Studies and scenes that a night did not do; an empty scene where it is not known which."""
    return frozenset(pair for part in run.parts if part.state is not PartState.DONE for pair in left_of_part(part))


def left_of_part(part: PartResult) -> Iterable[tuple[str, str]]:
    """Study and scenes that a part left; without a command nothing of the part was run."""
    for word in part.command.split()[1:2]:
        study = STUDY_OF_COMMAND.get(word, word)
        known = part.state is PartState.LEFT and part.left and part.left != (part.name,)
        yield from ((study, scene_name(scene)) for scene in part.left) if known else ((study, ""),)
