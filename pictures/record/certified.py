"""Record of the certified solutions that come with barchain: error bars at the end, amplification, limit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from barchain.solutions.certified_file import read_table, shipped_path, shipped_solution
from scenarios.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.trajectory import Array
    from scenarios import Scene

QUANTITIES = {name: CHANNELS[name].column_of("error") for name in ("com", "attitude", "reaction")}
SHIPPED, TABLE, NONE = "solution", "table", ""
"""Kinds of certified solutions: at all samples, at some instants, none"""


def certified_rows(scenes: Iterable[Scene]) -> list[dict[str, Any]]:
    """A row for each scene."""
    return [{"scene": scene.name} | facts(scene) for scene in scenes]


def facts(scene: Scene) -> dict[str, Any]:
    """Kind of a scene's certified solution, and its errors."""
    solution = shipped_solution(scene)
    if solution is not None:
        known = {"amplification": float(solution.amplification.max()), "limit_s": solution.limit_s}
        return {"source": SHIPPED} | largest(solution.error) | known
    path = shipped_path(scene.name)
    return {"source": TABLE} | largest(read_table(path).error) if path.exists() else {"source": NONE}


def largest(error: Mapping[str, Array]) -> dict[str, float]:
    """Largest error bar of each quantity; NaN for a quantity that the scene lacks."""
    return {
        column: float(error[name].max()) if name in error and len(error[name]) else math.nan
        for name, column in QUANTITIES.items()
    }
