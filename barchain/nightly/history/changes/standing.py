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
    from barchain.nightly.history.model.figures import FigureIdentity


def still_holding(judged: JudgedNight) -> list[Change]:
    """Changes for the worse of earlier nights, before which the figure was still better than it is.

    Of a figure the last one stands for those before it, as the figure is where that one led. Steps of times and memory
    are factors, and stand for themselves. A run that was not reproducible is an event of its night, and no state that
    holds.
    """
    own: dict[FigureIdentity, list[Change]] = {}
    for change in sorted(judged.changes, key=lambda c: c.since):
        own.setdefault(change.identity, []).append(change)
    told = {change.id for change in judged.tonight}
    found = []
    for identity, changes in own.items():
        holding = [c for c in changes if is_regression(c) and holds(c, changes)]
        found += [c for c in (holding if identity.kind in STEPPED else holding[-1:]) if c.id not in told]
    return found


def is_regression(change: Change) -> bool:
    """Whether a change is for the worse, and a state that can hold."""
    return change.direction is Direction.WORSE and not change.irreproducible


def holds(change: Change, own: Sequence[Change]) -> bool:
    """Whether a figure is still worse than before a change, from all of its changes in their order.

    Steps of times and memory multiply: a slow-down holds until later steps have taken it back, up to half the least
    effect. One without later steps holds as long as it is there.
    """
    if change.identity.kind in STEPPED and change.factor is not None:
        steps = [c.factor for c in own if c.since >= change.since and c.factor is not None]
        return len(steps) == 1 or math.prod(steps) >= 1.0 + LEAST_EFFECT / 2.0
    return change.now is own[-1].now or is_worse(change.was, own[-1].now)
