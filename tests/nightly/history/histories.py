"""Synthetic histories in memory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from barchain.nightly.figures.figure import STEPPED
from barchain.nightly.figures.steps import time_changes
from barchain.nightly.figures.table import figures_content, read_numbers
from barchain.nightly.history.advance import advance
from barchain.nightly.history.levels import FoldedNight, JudgedNight, LevelTable
from tests.nightly.history.synthetic import ENVIRONMENT, PARTS, night

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.figures.changes import Change
    from barchain.nightly.figures.figure import Environment, Figure, Night, NightPart, NightSummary
    from barchain.nightly.figures.table import NumberSeries

MADE: dict[str, Night] = {}
"""Nights made here, by name"""


def history_of(
    *nights: Sequence[Figure],
    parts: dict[int, tuple[NightPart, ...]] | None = None,
    environment: dict[int, Environment] | None = None,
    complete: dict[int, bool] | None = None,
    void: dict[int, str] | None = None,
) -> list[NightSummary]:
    """Nights with the given figures; what is not given for a night is as on the others."""
    made = []
    for k, figures in enumerate(nights):
        more: dict[str, Any] = {
            "parts": (parts or {}).get(k, PARTS),
            "environment": (environment or {}).get(k, ENVIRONMENT),
            "complete": (complete or {}).get(k, True),
            "void": (void or {}).get(k),
        }
        made.append(night(*figures, number=k, **more))
    return summaries(*made)


def summaries(*nights: Night) -> list[NightSummary]:
    """Nights without their figures, which :func:`times_of` finds again."""
    MADE.update({each.name: each for each in nights})
    return [each.summary() for each in nights]


def times_of(nights: Sequence[NightSummary]) -> list[NumberSeries]:
    """Times and memory of nights of :func:`history_of`."""
    table = read_numbers((each, figures_content(MADE[each.name])) for each in nights)
    return [table.series(identity) for identity in table.identities if identity.kind in STEPPED]


def folded(nights: Sequence[NightSummary]) -> list[FoldedNight]:
    """Nights of one machine class, or of several that follow each other, folded one after the other."""
    found, table = [], LevelTable()
    for each in nights:
        if each.void is None:
            found.append(advance(table, each, MADE[each.name].figures))
            table = found[-1].table
    return found


def news_of(nights: Sequence[NightSummary]) -> list[Change]:
    """All that these nights tell."""
    return [change for one in folded(nights) for change in one.news]


def judged_last(nights: Sequence[NightSummary]) -> JudgedNight:
    """Judgement of the last of some nights."""
    if nights[-1].void is not None:
        return JudgedNight(LevelTable(), night=nights[-1])
    last = folded(nights)[-1]
    stepped, fresh = time_changes(times_of(nights))
    return JudgedNight(
        **vars(last), night=nights[-1], compared_with=tuple(nights[:-1]), stepped=stepped, fresh=fresh
    )  # fmt: skip
