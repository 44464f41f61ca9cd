"""Verdicts on many trials: in worker processes, or in this one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.execution.call import CallLateError
from barchain.execution.executors import ALL_CORES
from barchain.run.verdict_workers import Judges
from barchain.studies.selftest.campaign.cells import CampaignCell
from barchain.studies.selftest.campaign.messages import JUDGED
from barchain.studies.selftest.campaign.rating import Judged, judged
from reports.tables.faults.campaign import CellClass
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.execution.executors import Executor
    from barchain.studies.selftest.trial import TrialCase

    JudgeCases = Callable[[list[TrialCase]], list[Judged]]


def judge_serially(cases: list[TrialCase]) -> list[Judged]:
    """Judge in this process."""
    return [judged(case) for case in cases]


class VerdictWorkers:
    """Worker processes that judge."""

    def __init__(self, executor: Executor = ALL_CORES) -> None:
        self.judges: Judges[int, Judged] = Judges(JUDGED, executor)

    def __call__(self, cases: list[TrialCase]) -> list[Judged]:
        """Judge; a verdict that does not come is a mistake in the campaign, and costs one cell."""
        for number, case in enumerate(cases):
            self.judges.submit(number, judged, case)
        found = dict(self.judges.collected(wait=True))
        return [self.cell(case, found[number]) for number, case in enumerate(cases)]

    @staticmethod
    def cell(case: TrialCase, found: Judged | BaseException) -> Judged:
        """Verdict, or why there is none."""
        if isinstance(found, Judged):
            return found
        trial, said = case.trial, f"no verdict: {found}"
        kind = CellClass.BROKEN if trial.fault else CellClass.FALSE_ALARM
        outcome = Outcome.NOTHING_COMPARED if isinstance(found, CallLateError) else Outcome.FAILED
        return Judged(
            CampaignCell(trial.scene.name, trial.engine, trial.fault, kind, str(outcome), reason=said), {}, ()
        )

    def close(self) -> None:
        """End the processes."""
        self.judges.close()
