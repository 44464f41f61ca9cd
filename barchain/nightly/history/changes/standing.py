"""Changes for the worse that an earlier night told and that still hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from barchain.nightly.history.changes.levels import is_worse
from barchain.nightly.history.changes.model import Direction
from barchain.nightly.history.changes.steps import LEAST_EFFECT
from barchain.nightly.history.model.figures import STEPPED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.changes.judging import JudgedNight
    from barchain.nightly.history.changes.model import Change


def still_holding(judged: JudgedNight) -> list[Change]:
    """Last change for the worse of each figure on an earlier night, if the figure is still worse than before it.

    A run that was not reproducible is an event of its night, and no state that holds.
    """
    ordered = sorted(judged.changes, key=lambda c: c.since)
    own: dict[object, list[Change]] = {}
    for change in ordered:
        own.setdefault(change.identity, []).append(change)
    latest = {c.identity: c for c in ordered if c.direction is Direction.WORSE and not c.irreproducible}
    told = {change.id for change in judged.tonight}
    return [c for c in latest.values() if c.id not in told and holds(c, own[c.identity])]


def holds(change: Change, own: Sequence[Change]) -> bool:
    """Whether a figure is still worse than before a change, from all of its changes in their order.

    Steps of times and memory multiply: a slow-down holds until later steps have taken it back. One without later steps
    holds as long as it is there.
    """
    if change.identity.kind in STEPPED and change.factor is not None:
        steps = [c.factor for c in own if c.since >= change.since and c.factor is not None]
        return len(steps) == 1 or math.prod(steps) >= 1.0 + LEAST_EFFECT
    return change.now is own[-1].now or is_worse(change.was, own[-1].now)
