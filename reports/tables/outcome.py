"""How a comparison can end: a closed set, each with a sentence of advice."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable


class Outcome(StrEnum):
    """Outcome of one row of the metrics table."""

    PASS = "pass"
    REPORTED = "reported"
    UNSUPPORTED = "unsupported"
    ROUNDOFF_LIMITED = "roundoff_limited"
    INCONSISTENT = "inconsistent"
    EXCEEDS_BOUND = "exceeds_bound"
    NOTHING_COMPARED = "nothing_compared"
    MALFORMED = "malformed"
    INCOMPLETE = "incomplete"
    NOT_FINITE = "not_finite"
    JOINTS_IGNORED = "joints_ignored"
    TIMED_OUT = "timed_out"
    FAILED = "failed"
    MISSING = "missing"

    @property
    def ok(self) -> bool:
        """Whether a run with this outcome may still exit with 0."""
        return self in {Outcome.PASS, Outcome.REPORTED, Outcome.UNSUPPORTED, Outcome.ROUNDOFF_LIMITED}

    @property
    def advice(self) -> str:
        """Meaning, and advice."""
        return ADVICE[self]


ADVICE = {
    Outcome.PASS: "The difference is explained by the errors of both, and inside the engine's band.",
    Outcome.REPORTED: "A measured value that is not judged.",
    Outcome.UNSUPPORTED: "The engine can't carry this scene exactly, says why, and is left out.",
    Outcome.ROUNDOFF_LIMITED: "The difference is the round-off of this run, measured, in coordinates as large as the "
    "orbit's radius: not wrong, and not as good as its method. The reason says how many digits are left.",
    Outcome.MALFORMED: "The values have a form that no integration gives: written with too few digits.",
    Outcome.INCONSISTENT: "The two differ by more than both errors, round-off and the declared model difference: "
    "look for different physics, a wrong sign, or an error estimate that is too small.",
    Outcome.EXCEEDS_BOUND: "The error is larger than this engine at this setting should make: "
    "look for a lost order, a loosened tolerance or wrong options.",
    Outcome.NOTHING_COMPARED: "Two settings of the engine part too early for a comparison: refine the setting.",
    Outcome.INCOMPLETE: "The run stopped early or lacks a quantity that the engine declares.",
    Outcome.NOT_FINITE: "The engine returned NaN or infinity.",
    Outcome.JOINTS_IGNORED: "Bars that a joint ties drift apart like free bodies: the joints did not act.",
    Outcome.TIMED_OUT: "The worker was ended at its time limit; raise it with --time-limit or use a coarser setting.",
    Outcome.FAILED: "The engine or its process failed; the reason is its own last word.",
    Outcome.MISSING: "The engine is not installed here; the reason says how to get it.",
}

SEVERITY = (
    Outcome.REPORTED,
    Outcome.PASS,
    Outcome.UNSUPPORTED,
    Outcome.ROUNDOFF_LIMITED,
    Outcome.EXCEEDS_BOUND,
    Outcome.INCONSISTENT,
    Outcome.NOTHING_COMPARED,
    Outcome.MALFORMED,
    Outcome.INCOMPLETE,
    Outcome.NOT_FINITE,
    Outcome.JOINTS_IGNORED,
    Outcome.TIMED_OUT,
    Outcome.FAILED,
    Outcome.MISSING,
)
"""Outcomes from the least to the most severe: a cell has the most severe outcome of its rows"""


def gravest(outcomes: Iterable[Outcome]) -> Outcome:
    """Return the worst of some outcomes; of none, that nothing was compared."""
    return max(outcomes, key=SEVERITY.index, default=Outcome.NOTHING_COMPARED)
