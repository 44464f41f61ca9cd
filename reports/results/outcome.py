"""Outcomes of a comparison: a closed set, each with a sentence of advice."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable


class Outcome(StrEnum):
    """Outcome of one row of the metrics table, from the least to the most severe."""

    REPORTED = "reported"
    PASS = "pass"
    UNSUPPORTED = "unsupported"
    ROUNDOFF_LIMITED = "roundoff_limited"
    TOO_COARSE = "too_coarse"
    EXCEEDS_BOUND = "exceeds_bound"
    INCONSISTENT = "inconsistent"
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
        return self in {
            Outcome.PASS, Outcome.REPORTED, Outcome.UNSUPPORTED, Outcome.ROUNDOFF_LIMITED, Outcome.TOO_COARSE,
        }  # fmt: skip

    @property
    def judged(self) -> bool:
        """Whether a run with this outcome was compared, or should have been."""
        return self not in {Outcome.REPORTED, Outcome.UNSUPPORTED, Outcome.TOO_COARSE}

    @property
    def advice(self) -> str:
        """Meaning of the outcome, and remedy."""
        return ADVICE[self]


ADVICE = {
    Outcome.PASS: "The errors of both runs explain the difference, which lies within the expected-error bound.",
    Outcome.REPORTED: "A measured value without a criterion.",
    Outcome.UNSUPPORTED: "The engine does not support an effect or a setting of this scene; the pair is skipped and "
    "the reason shown.",
    Outcome.ROUNDOFF_LIMITED: "Measured round-off of this run explains the difference: no error of the physics, but "
    "less accuracy than the method has. The reason gives the ratio to the bound, or the digits left.",
    Outcome.MALFORMED: "The values have fewer digits than an integration gives.",
    Outcome.INCONSISTENT: "The difference exceeds both errors, round-off and the declared model difference. Check "
    "the physics, the signs and the error estimate.",
    Outcome.EXCEEDS_BOUND: "The error exceeds the expected-error bound of this engine at this setting. Check "
    "the order, the tolerance and the options.",
    Outcome.TOO_COARSE: "Of this scene too little can be predicted at this setting of the engine: no error, and no "
    "agreement. Refine the setting.",
    Outcome.NOTHING_COMPARED: "Nothing of the run can be compared; the reason says why.",
    Outcome.INCOMPLETE: "The run stopped early or lacks a quantity that the engine declares.",
    Outcome.NOT_FINITE: "The engine returned NaN or infinity.",
    Outcome.JOINTS_IGNORED: "Connected bars drift apart like free bodies: the joints did not act.",
    Outcome.TIMED_OUT: "The run was ended at its time limit. Raise --time-limit or use a coarser setting.",
    Outcome.FAILED: "The engine or its process failed; the reason is its last message.",
    Outcome.MISSING: "The engine is not installed; the reason shows how to install it.",
}

SEVERITY = tuple(Outcome)
"""Outcomes from the least to the most severe: a cell has the most severe outcome of its rows"""


def gravest(outcomes: Iterable[Outcome]) -> Outcome:
    """Most severe of some outcomes; ``NOTHING_COMPARED`` of none."""
    return max(outcomes, key=SEVERITY.index, default=Outcome.NOTHING_COMPARED)
