"""What each night told, kept in its folder and never changed: later nights hold on to it, the calendar counts it."""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.changes import Direction
from barchain.nightly.figures.figure import STEPPED
from barchain.nightly.history.nights import now
from barchain.nightly.history.standing import standing
from reports.results.reading import formed

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.history.acceptances import Acceptance
    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore


FILE = "told.json"
ATTRIBUTED = "attributed"
"""Folder of the results of attributions"""


@dataclass(frozen=True)
class ToldChange:
    """Change that a night told, or a step that is recorded with it."""

    id: str
    figure: str
    kind: str
    since: str
    direction: str
    tonight: bool
    """Whether the night told it"""


@dataclass(frozen=True)
class ToldStanding:
    """Figure that was worse than its level since an earlier night."""

    figure: str
    since: str
    """Night of the first step"""
    latest: str
    """Night of the latest step"""


@dataclass(frozen=True)
class ToldNight:
    """What a night told."""

    judged: int
    """Number of figures that were compared"""
    told: str
    """Instant, UTC, ISO 8601"""
    changes: tuple[ToldChange, ...]
    standing: tuple[ToldStanding, ...] = ()
    """Figures that were worse than their level since an earlier night"""

    @property
    def tonight(self) -> tuple[ToldChange, ...]:
        """Changes that the night told first."""
        return tuple(change for change in self.changes if change.tonight)

    def worse(self, known: Sequence[Acceptance]) -> int:
        """Number of figures that were worse than accepted, by acceptances that have not ended."""
        new = (ToldStanding(c.figure, c.since, c.since) for c in self.tonight if c.direction == Direction.WORSE)
        states = (*self.standing, *new)
        return sum(not any(one.reaches(s.latest, s.since, (s.figure,)) for one in known) for s in states)


class AttributionVerdict(StrEnum):
    """Result of an attribution."""

    CONFIRMED = "confirmed"
    """One suspect alone makes the change, and the others together do not"""
    BOTH = "both"
    """Several suspects make a change, each by itself"""
    INTERACTION = "interaction"
    """Suspects make the change only together"""
    NOT_REPRODUCED = "not reproduced"
    """All suspects together don't make the change in a fresh environment"""


def keep_judgement(store: NightStore, judged: JudgedNight) -> None:
    """Keep which changes a night told; what a night has told already stays as it is.

    A step that no night recorded, because the night that told it was not judged here, is recorded with this one: later
    nights hold on to it, too. If later nights have told changes, the steps of this one are not recorded.
    """
    night, told = judged.night, told_by(store)
    if night.name in told:
        return
    known, tonight = steps_before(told, night.name), {change.id for change in judged.tonight}
    missed = [
        c
        for c in judged.stepped
        if c.id not in tonight
        and not any((c.since, c.direction is Direction.WORSE) in known.get(n, ()) for n in c.names)
    ]
    kept = [*judged.tonight, *missed]
    later = any(name > night.name and facts.changes for name, facts in told.items())
    changes = tuple(
        ToldChange(c.id, c.identity.name, str(c.identity.kind), c.since, str(c.direction), c.id in tonight)
        for c in kept
        if not (later and c.is_step)
    )
    open_states = tuple(
        ToldStanding(state.change.identity.name, state.change.since, state.latest)
        for state in standing(judged)
        if state.change.id not in tonight
    )
    worse = sum(change.direction is Direction.WORSE for change in judged.tonight)
    counted = {"worse": worse, "changed": len(judged.tonight)}  # which barchain 0.7.0 asks for, in a shared history
    content = counted | asdict(ToldNight(judged.judged, now(), changes, open_states))
    store.place.write(f"{night.name}/{FILE}", json.dumps(content, indent=1, ensure_ascii=False).encode())


def told_by(store: NightStore) -> dict[str, ToldNight]:
    """What each night told, by the name of the night; a damaged file tells nothing (:func:`left_out`)."""
    return {name: told for name, told in read_told(store).items() if told is not None}


def read_told(store: NightStore) -> dict[str, ToldNight | None]:
    """What each night told, in the order of nights; None of a damaged file."""
    found: dict[str, ToldNight | None] = {}
    for name, content in sorted(store.place.read_all(list(store.place.sizes(f"*/{FILE}"))).items()):
        try:
            found[name.removesuffix(f"/{FILE}")] = formed(ToldNight, content)
        except ValueError:
            found[name.removesuffix(f"/{FILE}")] = None
    return found


def left_out(store: NightStore) -> dict[str, str]:
    """Nights that count as not there, and files that tell nothing, each with the reason."""
    damaged = [f"{name}/{FILE}" for name, told in read_told(store).items() if told is None]
    return store.left_out() | dict.fromkeys(damaged, "it is damaged; copy it again, or remove it")


def steps_before(told: Mapping[str, ToldNight], before: str) -> dict[str, list[tuple[str, bool]]]:
    """Steps of times and memory that were told on the nights before one, by name of the figure, in order of nights.

    Each has the first night of its new level, and whether that is slower.
    """
    found: dict[str, list[tuple[str, bool]]] = defaultdict(list)
    for name, facts in told.items():
        for one in facts.changes if name < before else ():
            if one.kind in STEPPED:
                found[one.figure].append((one.since, one.direction == Direction.WORSE))
    return found


def attributed_words(store: NightStore, changes: Iterable[Change]) -> dict[str, str]:
    """Results of attributions in words, by the id of the change; one made under an earlier name counts too.

    Raises
    ------
    HistoryError
        If a file is damaged.
    """
    own = {name: change.id for change in changes for name in change.ids}
    words = {}
    for name, content in store.place.read_all([f"{ATTRIBUTED}/{name}.json" for name in own]).items():
        try:
            words[own[name.partition("/")[2].removesuffix(".json")]] = str(formed(dict[str, Any], content)["words"])
        except (ValueError, KeyError) as error:
            raise HistoryError(
                f"{store}/{name} is damaged ({error}); remove it, and attribute the change anew"
            ) from None
    return words
