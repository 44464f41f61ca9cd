"""The smallest plan of a comparison and of each study."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SmallPlan:
    """A small plan, and the columns of its table that do not depend on the machine's speed."""

    command: str
    table: str
    columns: tuple[str, ...] = ()
    """Empty: all"""


SMALL = {
    "comparison": SmallPlan("compare basics/kepler_circular --engine reference --engine rebound --workers 1",
                         "metrics.csv"),
    "stability": SmallPlan("stability hard/vertical_fall --engine rebound --workers 1", "stability/outcomes.csv"),
    "cost": SmallPlan("cost basics/kepler_circular --engine rebound --orbits 0.2 --repeats 1 --minutes 0.01",
                   "cost/points.csv", ("scene", "engine", "setting")),
    "scaling": SmallPlan("scaling --engine reference --bars 2 --bars 3 --repeats 1 --minutes 0.2", "scaling/points.csv",
                      ("engine", "bars", "outcome")),
    "roundoff": SmallPlan("roundoff --part times", "roundoff/times.csv", ("code", "arithmetic", "bars")),
    "effects": SmallPlan("effects basics/two_bars_free --engine reference --repeats 1 --minutes 0.01",
                      "effects/effects.csv", ("effect", "kind", "on", "attitude_rad", "com_m", "reaction_N")),
    "selftest": SmallPlan("selftest basics/kepler_circular --fault scale-rate --workers 1", "selftest/selftest.csv"),
    "campaign": SmallPlan("selftest --random 1 --host none --engine reference --shrink-seconds 0 --workers 1",
                       "campaign/campaign.csv", ("scene", "engine", "class", "outcome")),
    "ensemble": SmallPlan("ensemble basics/two_bars_free --vary angle_deg=normal(0,1) --runs 3 --samples 3 "
                          "--orbits 0.1", "ensemble/quantiles.csv"),
}  # fmt: skip
