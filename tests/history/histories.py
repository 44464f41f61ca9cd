"""Synthetic histories in memory."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, Any

from barchain.history.series_model import FigureSeries, NightSummary
from tests.history.synthetic import ENVIRONMENT, PARTS, night

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.history.figures import Environment, Figure, NightPart

FIGURES: dict[str, Sequence[Figure]] = {}
"""Figures of the nights made here, by name"""


def history_of(
    *nights: Sequence[Figure],
    parts: dict[int, tuple[NightPart, ...]] | None = None,
    environment: dict[int, Environment] | None = None,
    complete: dict[int, bool] | None = None,
    void: dict[int, str] | None = None,
) -> list[NightSummary]:
    """Nights with the given figures; what is not given for a night is as on the others."""
    found = []
    for k, figures in enumerate(nights):
        more: dict[str, Any] = {
            "parts": (parts or {}).get(k, PARTS),
            "environment": (environment or {}).get(k, ENVIRONMENT),
            "complete": (complete or {}).get(k, True),
            "void": (void or {}).get(k),
        }
        made = night(*figures, number=k, **more)
        FIGURES[made.name] = made.figures
        found.append(
            NightSummary(
                k, made.name, made.started, made.duration_s, made.plan, made.barchain, made.environment, made.parts,
                len(made.figures), made.commit, made.complete, made.void,
            )
        )  # fmt: skip
    return found


def as_series(nights: Sequence[NightSummary]) -> tuple[FigureSeries, ...]:
    """All figures of nights of :func:`history_of`."""
    found = defaultdict(list)
    for each in nights:
        for figure in FIGURES[each.name]:
            found[figure.identity].append((each, figure))
    return tuple(
        FigureSeries(identity, tuple(n for n, _ in own), tuple(f for _, f in own)) for identity, own in found.items()
    )
