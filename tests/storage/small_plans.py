"""The smallest plan of a comparison and of each study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from tests.support.results import read_table

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd


@dataclass(frozen=True)
class SmallPlan:
    """A small plan, and the columns of its main table that do not depend on the machine's speed."""

    study: str
    table: str
    command: str
    columns: tuple[str, ...] = ()
    """Empty: all"""

    def read(self, out: Path) -> pd.DataFrame:
        """These columns of the table in a result folder."""
        found = read_table(out, self.study, self.table)
        return found[list(self.columns)] if self.columns else found


PLANS = (
    SmallPlan("comparison", "metrics",
              "compare basics/kepler_circular --engine reference --engine rebound --workers 1"),
    SmallPlan("stability", "outcomes", "stability hard/vertical_fall --engine rebound --workers 1"),
    SmallPlan("cost", "points", "cost basics/kepler_circular --engine rebound --orbits 0.2 --repeats 1 --minutes 0.01",
              ("scene", "engine", "setting")),
    SmallPlan("scaling", "points", "scaling --engine reference --bars 2 --bars 3 --repeats 1 --minutes 0.2",
              ("engine", "bars", "outcome")),
    SmallPlan("roundoff", "times", "roundoff --part times", ("code", "arithmetic", "bars")),
    SmallPlan("effects", "effects", "effects basics/two_bars_free --engine reference --repeats 1 --minutes 0.01",
              ("effect", "kind", "on", "attitude_rad", "com_m", "reaction_N")),
    SmallPlan("selftest", "fates", "selftest basics/kepler_circular --fault scale-rate --workers 1"),
    SmallPlan("ensemble", "quantiles",
              "ensemble basics/two_bars_free --vary angle_deg=normal(0,1) --runs 3 --samples 3 --orbits 0.1"),
    SmallPlan("sweep", "measures",
              "sweep basics/two_bars_free --engine reference --vary chain.rate_factor[1]=4,5,6 --vary run.samples=5"),
)  # fmt: skip
SMALL = {plan.study: plan for plan in PLANS}
