"""Defaults of the studies of times, effects and stability; the command line's help shows them without the studies."""

from __future__ import annotations

from typing import NamedTuple


class TimingLimits(NamedTuple):
    """Limits of a study that measures times again and again."""

    time_limit_s: float
    """Of one run"""
    repeats: int
    """Times that each point is measured; the median's interval is drawn from six on, and is the range below"""
    minutes: float
    """Budget of the study"""


COST = TimingLimits(2.0, 7, 8.0)
"""Some ten thousand times what the fastest engine needs for 1e-10 rad; the paper's scenes in all engines, so that
start-up and report end inside 15 minutes"""
SCALING = TimingLimits(10.0, 5, 25.0)
EFFECTS = TimingLimits(300.0, 7, 0.3)
"""Compiling has its own time besides; no further round is begun after the budget"""
STABILITY_LIMIT_S = 60.0
"""Of one run of a stability study: some thirty times what a run of the default set takes"""

DIVIDED_SCENE = "paper/fig13"
"""Scene whose chain is cut into more bars: at 80° it stays regular; a horizontal one of many bars buckles at once"""
BARS = (2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000, 100_000)
"""Numbers of bars of a scaling study"""
FAST, SLOW = "reference-fast", "reference"
"""Forms of the reference in an effects study"""
RTOL = 1e-12
"""Accuracy of the tighter runs of an effects study: changes are told from the numerics as far as doubles go"""
RTOLS = (1e-14, 1e-3)
"""Its bounds: ten times looser is still an accuracy"""
MATTERS = 1e-3
"""Change from which an effect is relevant"""
WIDTHS_M = (1e-6, 1e6)
"""Bounds of a bar's width: from a hair's hundredth to the widest sail that anybody drew"""
