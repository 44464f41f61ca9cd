"""Which figures a night should have: studies, and the scenes that a night did to their end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.nightly.changes import OTHER_STUDIES
from reports.tables.crossval import COMPARISON

if TYPE_CHECKING:
    from collections.abc import Mapping

    from barchain.nightly.figures import Figure, FigureIdentity, NightSummary


OCCASIONS = 2
"""Occasions in a row that must have a figure: some figures are measured only now and then"""
SAMPLED = ("stability.", "selftest.", "campaign.")
"""Beginnings of the quantities of studies of which a night does a part only: scenes, or faults, of that night"""
Subject = tuple[str, str, str]
"""Study, scene and fault of a figure: what is done as a whole"""


class Presence:
    """What a night measured."""

    def __init__(self, night: NightSummary, here: Mapping[FigureIdentity, Figure]) -> None:
        """Take the figures of a night."""
        self.night, self.here = night, here
        self.subjects = {subject_of(identity) for identity in here}
        self.not_run = {place(identity) for identity, figure in here.items() if figure.not_run}
        """Study, scene, engine and setting of runs that had no time"""

    def of_subject(self, subject: Subject) -> bool:
        """Whether a study did a scene to its end, with all engines.

        Such a night left nothing of the scene; without a run of a plan, it is complete.
        """
        if subject not in self.subjects:
            return False
        if self.night.run is None:
            return self.night.complete
        study, scene, _ = subject
        return not {(study, scene), (study, "")} & self.night.run.left


def study_of(identity: FigureIdentity) -> str:
    """Study that a figure is of."""
    first = identity.quantity.partition(".")[0]
    return first if first in OTHER_STUDIES else COMPARISON


def subject_of(identity: FigureIdentity) -> Subject:
    """Study, scene and fault of a figure."""
    study = study_of(identity)
    return study, identity.scene, identity.setting if study in {"selftest", "campaign"} else ""


def place(identity: FigureIdentity) -> tuple[str, str, str, str]:
    """Study, scene, engine and setting of a figure: a run that had no time lacks all of its figures."""
    return study_of(identity), identity.scene, identity.engine, identity.setting
