"""Verdicts made in other processes: tasks of cases, and their messages.

Beyond the predictability limit a verdict takes as long as the engine's own runs: the reference is restarted from the
engine's states again and again (`barchain.judge.checks.restart`). A verdict whose process dies costs its own row, like
a run. One that takes too long is no verdict, and no failure of the engine.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pandas as pd

from adapters.common.equal_steps import finer_setting
from barchain.judge.compare import judge
from barchain.judge.error_model import ErrorModel
from barchain.judge.verdict import Verdict
from barchain.runs.asking import taken_along
from barchain.runs.call import Call, CallFailedError
from barchain.runs.cases import Task
from barchain.runs.job import Role
from barchain.runs.message import MessageError, message_bytes, plain_text, read_message
from reports.results.comparison import METRIC_COLUMNS
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Declarations, Setting
    from barchain.judge.evidence import Evidence
    from barchain.runs.call import Answer
    from barchain.runs.cases import Case
    from barchain.solutions.reference import ReferenceSolution

JUDGING_S = 300.0  # of processor time; a verdict on the longest shipped scene takes some twenty seconds in NumPy
FIRST = (-1.0,)
"""Priority of verdicts before all runs: what is judged is reported, and its trajectories are forgotten"""


def verdict_case(
    name: str, engine: Declarations, setting: Setting, evidence: Evidence, solution: ReferenceSolution
) -> Case[Verdict]:
    """Verdict made here, or in another process where it goes beyond the predictability limit."""
    run = evidence.main.trajectory
    if run is None:
        return judge(name, engine, setting, evidence, solution)
    settings = setting, finer_setting(solution.scene, engine.sweep, setting)
    t_s = ErrorModel(engine, setting, solution, run).t_s
    engine = taken_along(engine, solution.scene, settings, t_s)
    errors = ErrorModel(engine, setting, solution, run)
    if not goes_beyond(errors):
        return judge(name, engine, setting, evidence, solution, errors)
    (found,) = yield [verdict_task(judge, name, engine, setting, evidence, solution, errors)]
    if not isinstance(found, Verdict):
        raise found
    return found


def goes_beyond(errors: ErrorModel) -> bool:
    """Whether a verdict compares beyond the predictability limit, which takes long."""
    try:
        return bool(errors.limit_s < errors.solution.trajectory.t_s[-1])
    except Exception:  # of samples that arithmetic fails on, or an adapter's own: the verdict says so
        return False


def verdict_task(function: Callable[..., Verdict], *given: Any) -> Task:
    """Task whose result is the verdict of a module's function, or the :class:`CallFailedError` that tells why not."""
    return Task(Call(judged, (function, given), JUDGING_S, "verdicts", own_work=True), verdict_of, FIRST)


def judged(function: Callable[..., Verdict], given: tuple[Any, ...]) -> bytes:
    """Verdict of a function as bytes, in the process that calls it."""
    return verdict_bytes(function(*given))


def verdict_of(answer: Answer) -> Verdict | CallFailedError:
    """Verdict of an answer, or the reason why there is none."""
    try:
        return verdict_from(answer.needed())
    except CallFailedError as error:
        return error
    except (MessageError, ValueError, TypeError, KeyError) as error:
        return CallFailedError(f"its verdict is damaged: {plain_text(error)}")


def verdict_bytes(verdict: Verdict) -> bytes:
    """Message with a verdict: text and float64 arrays, read without running code."""
    columns = None if verdict.series is None else list(verdict.series.columns)
    header = {"rows": verdict.rows, "columns": columns, "further_runs": [str(role) for role in verdict.further_runs]}
    arrays = {} if verdict.series is None else {f"c{k}": verdict.series[name] for k, name in enumerate(columns or [])}
    return message_bytes(header, {name: values.to_numpy() for name, values in arrays.items()})


def verdict_from(content: bytes) -> Verdict:
    """Verdict of a message.

    Raises
    ------
    MessageError, ValueError, TypeError, KeyError
        If a part is missing or of a wrong type.
    """
    header, arrays = read_message(content)
    columns = header["columns"]
    series = None if columns is None else pd.DataFrame({name: arrays[f"c{k}"] for k, name in enumerate(columns)})
    for row in header["rows"]:
        if tuple(row) != METRIC_COLUMNS:
            raise MessageError(f"a row has the columns {', '.join(row)}")
        Outcome(row["outcome"])
    return Verdict(header["rows"], series, tuple(map(Role, header["further_runs"])))
