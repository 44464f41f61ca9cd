"""Verdicts on many trials: in worker processes, or in this one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.runs.call import CallLateError
from barchain.runs.cases import run_tasks
from barchain.studies.selftest.campaign.cells import CampaignCell
from barchain.studies.selftest.campaign.messages import JUDGED
from barchain.studies.selftest.campaign.rating import Judged, judged
from reports.tables.faults.campaign import CellClass
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.runs.executors import Executor
    from barchain.studies.selftest.trial import TrialCase

    JudgeCases = Callable[[list[TrialCase]], list[Judged]]


def judge_serially(cases: list[TrialCase]) -> list[Judged]:
    """Judge in this process."""
    return [judged(case) for case in cases]


def judge_in_workers(executor: Executor) -> JudgeCases:
    """Judge in worker processes; a verdict that does not come is a mistake in the campaign, and costs one cell."""

    def judge(cases: list[TrialCase]) -> list[Judged]:
        found = run_tasks([JUDGED.task(judged, case) for case in cases], executor)
        return [verdict_or_reason(case, one) for case, one in zip(cases, found, strict=True)]

    return judge


def verdict_or_reason(case: TrialCase, found: Judged | BaseException) -> Judged:
    """Verdict, or why there is none."""
    if isinstance(found, Judged):
        return found
    trial, said = case.trial, f"no verdict: {found}"
    kind = CellClass.BROKEN if trial.fault else CellClass.FALSE_ALARM
    outcome = Outcome.NOTHING_COMPARED if isinstance(found, CallLateError) else Outcome.FAILED
    return Judged(CampaignCell(trial.scene.name, trial.engine, trial.fault, kind, str(outcome), reason=said), {}, ())
