"""Verdicts on many trials: in worker processes, or in this one."""

from __future__ import annotations

import multiprocessing
from typing import TYPE_CHECKING

from pebble import ProcessPool

from barchain.campaign.cells import Cell, Kind
from barchain.campaign.court import Judged, judged
from reports.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable

    from pebble import ProcessFuture

    from barchain.campaign.trial import Case

    Court = Callable[[list[Case]], list[Judged]]

JUDGING_S = 300.0  # beyond the horizon a verdict runs the reference itself, again and again


def at_once(cases: list[Case]) -> list[Judged]:
    """Judge in this process."""
    return [judged(case) for case in cases]


class CourtRoom:
    """Worker processes that judge."""

    def __init__(self, workers: int) -> None:
        self.pool = ProcessPool(workers, context=multiprocessing.get_context("spawn"))

    def __call__(self, cases: list[Case]) -> list[Judged]:
        """Judge; a verdict that does not come is a mistake in the campaign, and costs one cell."""
        futures = [self.pool.schedule(judged, (case,), timeout=JUDGING_S) for case in cases]
        return [self.collected(case, future) for case, future in zip(cases, futures, strict=True)]

    @staticmethod
    def collected(case: Case, future: ProcessFuture) -> Judged:
        """Verdict, or why there is none."""
        try:
            found: Judged = future.result()
        except Exception as error:
            trial, said = case.trial, f"no verdict: {type(error).__name__}: {error}"
            kind = Kind.BROKEN if trial.fault else Kind.FALSE_ALARM
            return Judged(
                Cell(trial.scene.name, trial.engine, trial.fault, kind, str(Outcome.FAILED), reason=said), {}, ()
            )
        return found

    def close(self) -> None:
        """End the processes."""
        self.pool.stop()
        self.pool.join()
