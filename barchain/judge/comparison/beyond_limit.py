"""Rows of the verdict beyond the predictability limit: the energy, and segments from the engine's own states."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import Coordinates, EngineError
from barchain.judge.checks.between_segments import STATE_QUANTITIES, fault_between_segments
from barchain.judge.checks.relative_energy import MAX_KINETIC_RATIO, kinetic_ratio
from barchain.judge.checks.restart import RestartSegment, can_restart, restart_segments
from barchain.judge.comparison.verdict import row
from barchain.judge.measured_roundoff import max_roundoff
from barchain.judge.residuals import Residuals, worst
from barchain.solutions.reference import TRACK
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from barchain.judge.comparison.verdict import Row
    from barchain.judge.error_model import ErrorModel
    from barchain.judge.evidence import Evidence

MAX_EMPTY_SHARE = 0.75
"""Largest share of the segments beyond the limit that may predict no sample; in manoeuvres most do not"""


class BeyondLimit(Residuals):
    """Rows of one engine in one scene beyond the predictability limit."""

    def __init__(self, name: str, errors: ErrorModel, evidence: Evidence) -> None:
        """Prepare the rows of the engine called `name`; the other arguments are those of `Residuals`."""
        super().__init__(errors, evidence)
        self.name = name
        self.segments: list[RestartSegment] = []

    def row(
        self,
        quantity: str,
        metric: str,
        value: float | None,
        tolerance: float | None,
        outcome: Outcome,
        reason: str = "",
    ) -> Row:
        """One row of the metrics table for this engine and scene."""
        limit_s = float(self.t[-1]) if self.com_only or quantity in TRACK else self.limit_s
        return row(
            self.scene.name, self.name, self.setting, quantity, metric, value, tolerance, outcome, reason, limit_s
        )

    def rows_beyond_limit(self) -> list[Row]:
        """Rows on what is judged beyond the predictability limit."""
        first = int(np.count_nonzero(self.t <= self.limit_s)) - 1
        if first >= self.n - 1 or self.com_only:
            return []
        rows = [self.energy_row()]
        if not can_restart(self.main):
            said = f"no rates: nothing can be judged beyond the predictability limit, {self.limit_s:.4g} s"
            return [*rows, self.row("run", "outcome", None, None, Outcome.NOTHING_COMPARED, said)]
        try:
            self.segments = restart_segments(self.errors, self.main, first)
        except (EngineError, ArithmeticError) as error:
            said = f"the reference can't be restarted from the engine's states: {error}"
            return [*rows, self.row("run", "outcome", None, None, Outcome.NOTHING_COMPARED, said)]
        rows += self.segment_rows(self.segments) + self.unpredictable_segment_rows(self.segments)
        return rows + (self.uncovered_sample_rows(first) if all(Outcome(r["outcome"]).ok for r in rows) else [])

    def uncovered_sample_rows(self, first: int) -> list[Row]:
        """Row of a fault at samples that no segment covers (`barchain.judge.checks.between_segments`)."""
        compared = (self.errors, self.main, self.segments, first)
        wrong = fault_between_segments(*compared, extra={})
        if wrong is None:
            return []
        quantity, used, reason = wrong
        outcome = Outcome.EXCEEDS_BOUND
        if self.engine.coordinates is Coordinates.ABSOLUTE:
            most = max_roundoff(self.errors, np.ones(self.errors.n))  # nothing is amplified in a single state
            extra = {quantity: most[quantity] for quantity in STATE_QUANTITIES}
            limited = fault_between_segments(*compared, extra=extra) is None
            outcome = Outcome.ROUNDOFF_LIMITED if limited else Outcome.EXCEEDS_BOUND
        return [self.row(quantity, "own_state_ratio", used, 1.0, outcome, reason)]

    def unpredictable_segment_rows(self, found: list[RestartSegment]) -> list[Row]:
        """Row of a setting that is too coarse, if most segments could predict no sample."""
        empty = sum(s.empty for s in found)
        if not found or empty <= MAX_EMPTY_SHARE * len(found):
            return []
        said = (
            f"beyond the predictability limit, {self.limit_s:.4g} s, in {empty} of {len(found)} segments the "
            f"next sample can't be predicted: the rates are too uncertain at {self.setting}"
        )
        return [self.row("run", "outcome", None, None, Outcome.TOO_COARSE, said)]

    def energy_row(self) -> Row:
        """Row of the kinetic energy about the centre of mass, relative to its largest possible value."""
        unlimited = self.scene.effects.thrust or self.scene.effects.impulse or self.scene.effects.prescribed_rotation
        each = [] if unlimited else [kinetic_ratio(run, self.solution) for run in (self.main, self.finer)]
        ratio = max((r for r in each if r is not None), default=None)
        if ratio is None:
            return self.row("relative_energy", "drift", None, None, Outcome.REPORTED)
        good = Outcome.PASS if ratio <= MAX_KINETIC_RATIO else Outcome.EXCEEDS_BOUND
        reason = "" if ratio <= MAX_KINETIC_RATIO else f"{ratio:.3g} times the largest possible kinetic energy"
        return self.row("relative_energy", "drift", ratio, MAX_KINETIC_RATIO, good, reason)

    def segment_rows(self, segments: list[RestartSegment]) -> list[Row]:
        """Row of each quantity's largest ratio to its bound in segments from the engine's own states."""
        rows = []
        for quantity in segments[0].difference if segments else ():
            each = [(*worst(s.difference[quantity], s.allowed[quantity], s.everywhere), s) for s in segments]
            used, at, segment = max(each, key=lambda e: e[0])
            outcome = Outcome.PASS if used <= 1.0 else self.segment_outcome(quantity, segments)
            when, start = (self.main.t_s[k] for k in (segment.first + at, segment.first))
            reason = (
                f"{used:.3g} times the expected-error bound at t = {when:.6g} s, compared with the reference "
                f"restarted from the engine's own state at t = {start:.6g} s"
            )
            rows.append(self.row(quantity, "restart_ratio", used, 1.0, outcome, "" if used <= 1.0 else reason))
        return rows

    def segment_outcome(self, quantity: str, segments: list[RestartSegment]) -> Outcome:
        """Outcome of a quantity outside its bound in a segment: rounding of absolute coordinates is no fault."""
        if self.engine.coordinates is not Coordinates.ABSOLUTE:
            return Outcome.EXCEEDS_BOUND
        for s in segments:
            since = self.errors.amplification / self.errors.amplification[s.first]
            most = max_roundoff(self.errors, since)[quantity][s.first : s.last + 1]
            if not np.all(s.difference[quantity] <= s.allowed[quantity] + most):
                return Outcome.EXCEEDS_BOUND
        return Outcome.ROUNDOFF_LIMITED
