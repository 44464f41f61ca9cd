"""Verdict of one declaration on a file, and its diagnosis."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.compare import verdict_on
from barchain.judge.diagnosis.verdicts import diagnosis_of_verdict
from barchain.judge.evidence import Evidence
from barchain.judge.written import MeasuredErrors, WrittenErrors, WrittenResiduals
from barchain.runs.job import RunResult
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Array
    from barchain.judge.diagnosis.diagnose import Diagnosis
    from barchain.judge.error_model import ErrorModel
    from barchain.judge.verdict import Verdict
    from barchain.judge.written import Declared
    from barchain.result_files.samples import Samples


def one_verdict(
    name: str, main: Samples, finer: Samples | None, declared: Declared, own: dict[str, Array], *, restarts: bool = True
) -> tuple[Verdict, Declarations, Setting]:
    """Verdict without a diagnosis, the program's declarations and its setting."""
    errors = error_model(main, declared, own)
    result = RunResult(Outcome.PASS, trajectory=main.trajectory)
    second = result if finer is None else RunResult(Outcome.PASS, trajectory=finer.trajectory)
    run = WrittenResiduals(errors, Evidence(result, second), main.judged, whole=main.complete, restarted=restarts)
    return dataclasses.replace(verdict_on(name, run), further_runs=()), errors.engine, errors.setting


def error_model(main: Samples, declared: Declared, own: Mapping[str, Array]) -> ErrorModel:
    """Error model of a file; `own` is its difference from the finer one by quantity, (n,)."""
    kind = MeasuredErrors if declared.rtol is None else WrittenErrors
    errors = kind(declared.engine, declared.setting, main.solution, main.trajectory)
    errors.written, errors.absent = main.written, main.absent
    if isinstance(errors, MeasuredErrors):
        errors.own = own
    return errors


def diagnosis(verdict: Verdict, main: Samples) -> Diagnosis:
    """Mistakes that explain what is wrong."""
    assert verdict.series is not None
    series = verdict.series
    if main.starts_late:
        series = series.copy()
        series.loc[0, series.columns != "t_s"] = np.nan
    seen = dataclasses.replace(verdict, series=series)
    return diagnosis_of_verdict(seen, main.trajectory, main.solution, absent=main.absent, kept=main.kept)
