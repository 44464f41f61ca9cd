"""Dependence of a result on the runs before it in the same process."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from barchain.judge.diagnosis.channels import sizes_of
from barchain.judge.diagnosis.fit import QUANTITY_OF
from barchain.metrics.quantities import differences

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Trajectory
    from barchain.conform.checks import Check
    from barchain.runs.job import RunResult

PAGE = "docs/howto/conform.md#physics"
DEPENDENT = (
    "the result depends on the runs before it: in a process of its own the scene gives other numbers. Something is "
    "kept from run to run, in the module or in the class"
)
SAME = 1e-9
"""Largest relative difference of results that count as the same: a library's sums may depend on where arrays lie"""


def dependent_check(failed: Check, after_others: RunResult, alone: Callable[[], RunResult]) -> Check | None:
    """Failed check with another reason, if a scene gives other numbers alone than after other scenes; None if not.

    An engine that starts at random gives other numbers each time: two runs alone then differ, too.

    Parameters
    ----------
    failed : Check
        Of the scene.
    after_others : RunResult
        Run after those of other scenes, in one process.
    alone : callable
        Makes the same run in a process of its own.
    """
    first = alone().trajectory
    if first is None or after_others.trajectory is None or same_numbers(first, after_others.trajectory):
        return None
    second = alone().trajectory
    if second is None or not same_numbers(first, second):
        return None
    return dataclasses.replace(failed, words=DEPENDENT, page=PAGE, explained=True)


def same_numbers(one: Trajectory, other: Trajectory) -> bool:
    """Whether two results are the same."""
    if len(one.t_s) != len(other.t_s) or one.observables != other.observables:
        return False
    apart = differences(one, other)
    return all(
        float(apart[QUANTITY_OF[field]].max(initial=0.0)) <= SAME * float(size.max(initial=0.0))
        for field, size in sizes_of(one).items()
        if QUANTITY_OF[field] in apart
    )
