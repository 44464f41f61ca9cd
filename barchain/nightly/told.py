"""What each night told, kept in its folder and never changed: later nights hold on to it, the calendar counts it."""

from __future__ import annotations

import json
from collections import defaultdict
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from barchain.nightly.acceptances import accepted, fits
from barchain.nightly.changes import Direction
from barchain.nightly.faults import HistoryError
from barchain.nightly.figures import STEPPED
from barchain.nightly.history import now
from barchain.nightly.standing import standing

if TYPE_CHECKING:
    import datetime
    from collections.abc import Iterable, Mapping

    from barchain.nightly.acceptances import Acceptance
    from barchain.nightly.changes import Change
    from barchain.nightly.history import NightStore
    from barchain.nightly.judged import JudgedNight


FILE = "told.json"
ATTRIBUTED = "attributed"
"""Folder of the results of attributions"""


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
    later = any(name > night.name and facts["changes"] for name, facts in told.items())
    content = {
        "worse": sum(change.direction is Direction.WORSE for change in judged.tonight), "judged": judged.judged,
        "changed": len(judged.tonight), "told": now(),
        "changes": [
            {
                "id": c.id, "figure": c.identity.name, "kind": str(c.identity.kind), "since": c.since,
                "direction": str(c.direction), "tonight": c.id in tonight,
            }
            for c in kept if not (later and c.is_step)
        ],
        "standing": [
            {"figure": state.change.identity.name, "since": state.change.since, "latest": state.latest}
            for state in standing(judged) if state.change.id not in tonight
        ],
    }  # fmt: skip
    store.place.write(f"{night.name}/{FILE}", json.dumps(content, indent=1, ensure_ascii=False).encode())


def told_by(store: NightStore) -> dict[str, dict[str, Any]]:
    """What each night told, by the name of the night.

    Raises
    ------
    HistoryError
        If a file is damaged.
    """
    told = {}
    for name, content in sorted(store.place.read_all(list(store.place.sizes(f"*/{FILE}"))).items()):
        try:
            told[name.removesuffix(f"/{FILE}")] = json.loads(content)
        except ValueError:
            raise HistoryError(f"{name} is damaged; remove it, and the night is judged anew") from None
    return told


def steps_before(told: Mapping[str, Mapping[str, Any]], before: str) -> dict[str, list[tuple[str, bool]]]:
    """Steps of times and memory that were told on the nights before one, by name of the figure, in order of nights.

    Each has the first night of its new level, and whether that is slower.
    """
    found: dict[str, list[tuple[str, bool]]] = defaultdict(list)
    for name, facts in told.items():
        for one in facts["changes"] if name < before else ():
            if one["kind"] in STEPPED:
                found[one["figure"]].append((one["since"], one["direction"] == Direction.WORSE))
    return found


def kept_judgements(store: NightStore, at: datetime.datetime) -> dict[str, tuple[int, int]]:
    """Numbers of figures that were worse than accepted and of all changes, by the name of the night that told them.

    What somebody accepted is left out, unless the acceptance ended before `at`.
    """
    known = [one for one in accepted(store) if one.until is None or one.until > at]
    found = {}
    for name, facts in told_by(store).items():
        open_states = [one for one in facts.get("standing", ()) if not is_covered(one, known)]
        worse = [one for one in facts["changes"] if one["tonight"] and one["direction"] == Direction.WORSE]
        forgiven = sum(any(a.since == one["since"] and fits(one["figure"], a.pattern) for a in known) for one in worse)
        found[name] = facts["worse"] - forgiven + len(open_states), facts["changed"]
    return found


def is_covered(state: Mapping[str, str], known: Iterable[Acceptance]) -> bool:
    """Whether an acceptance covers what a night told of a figure that was worse since an earlier night."""
    return any(
        a.since == state["latest"] and (a.first or a.since) <= state["since"] and fits(state["figure"], a.pattern)
        for a in known
    )


def attributed_words(store: NightStore, changes: Iterable[Change]) -> dict[str, str]:
    """Results of attributions in words, by the id of the change; one made under an earlier name counts too."""
    own = {name: change.id for change in changes for name in change.ids}
    found = store.place.read_all([f"{ATTRIBUTED}/{name}.json" for name in own])
    return {
        own[name.partition("/")[2].removesuffix(".json")]: json.loads(content)["words"]
        for name, content in found.items()
    }
