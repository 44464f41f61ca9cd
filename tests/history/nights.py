"""Nights for tests of the history."""

from __future__ import annotations

from barchain.history.figures import CodePart, Figure, FigureKind, FigureUnit, Night, Series

ERROR = Series("paper/fig05", "exudyn", "steps_per_orbit=1300", "attitude", "max", FigureKind.ERROR, FigureUnit.RADIAN)
VERDICT = Series("paper/fig05", "exudyn", "steps_per_orbit=1300", "run", "outcome", FigureKind.VERDICT)
BITS = Series("paper/fig05", "exudyn", "steps_per_orbit=1300", "trajectory", "digest", FigureKind.BITS)
STEPS = Series("paper/fig05", "exudyn", "steps_per_orbit=1300", "steps", "count", FigureKind.COUNT)


def night(day: int, value: float = 1e-6, **changes: object) -> Night:
    """Night of a day in January, with one figure of four kinds."""
    figures = (
        Figure(ERROR, value=value, roundoff=1e-12, parts=("barchain", "engine exudyn")),
        Figure(VERDICT, word="pass", parts=("barchain", "engine exudyn")),
        Figure(BITS, word=f"{value!r}", parts=("barchain", "engine exudyn")),
        Figure(STEPS, value=7000.0, parts=("engine exudyn",)),
    )
    entries = {
        "started": f"2026-01-{day:02d}T01:00:00+00:00",
        "command": "barchain crossval",
        "barchain": "0.6.0",
        "machine": "0123456789abcdef",
        "environment": {"cpu": "a", "cores": 2},
        "parts": (CodePart("barchain", "0.6.0", "ab"), CodePart("engine exudyn", "1.13.6", "")),
        "figures": figures,
        "seconds": 60.0,
    }
    return Night(**entries | changes)  # type: ignore[arg-type]
