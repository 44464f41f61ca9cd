"""Judging of files from their paths to a result, with the report of a comparison where a folder is given."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.registry import RESERVED, Registration
from barchain.judge.written import Declared
from barchain.metrics.quantities import differences
from barchain.result_files.channels import read_channels
from barchain.result_files.numbers import half_of
from barchain.result_files.one_verdict import one_verdict
from barchain.result_files.samples import placed
from barchain.result_files.table import TableError
from barchain.result_files.verdict import judge_file
from barchain.runs.cases import run_cases
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import Job, Role, RunResult
from barchain.runs.run import keep_run
from barchain.runs.tasks import limit_of, run_task
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.judging import SolutionFailedError, solution_case
from barchain.solutions.proof import proven_words
from barchain.solutions.reference import closely_sampled
from barchain.studies.comparison.plan import SceneProgress
from barchain.studies.comparison.run import Comparison, ComparisonResult
from barchain.studies.comparison.suite import Suite
from barchain.studies.study import ignore, run_and_render
from reports.results.outcome import Outcome
from scenarios import load_scene
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from barchain.record.study_store import StudyStore
    from barchain.result_files.channels import Channels
    from barchain.result_files.samples import Samples
    from barchain.result_files.verdict import FileVerdict
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.study import Reporter
    from scenarios import Scene

NOTHING = Declared()
FEW_DIGITS = range(3, 11)
"""Digits to which people round results"""
ROUNDING = 4e-16
"""Of a number and its nearest multiple of a unit"""
MORE_DIGITS = 5.0
"""Units over those that were written, from which on zeros stand behind the digits"""


@dataclass(frozen=True)
class FileResult:
    """Verdict on a file, for people."""

    scene: str
    outcome: Outcome
    until_s: float
    """Last instant of the file inside the scene, s"""
    duration_s: float
    """Of the scene, s"""
    advice: list[str]
    """Sentences on the file as a whole: another number of bars, an undeclared accuracy"""
    mistakes: str
    """Mistakes that explain what is wrong, in sentences"""
    reasons: list[str]
    """Why it does not pass"""
    sizes: list[tuple[str, float, str]]
    """Quantity, largest difference, unit"""
    notes: list[str]
    """What was done with the file, and what was not judged"""
    report: Path | None

    @property
    def passed(self) -> bool:
        """Whether the file passes."""
        return self.outcome is Outcome.PASS


def judge_files(
    scene: Scene | str,
    file: Path,
    finer: Path | None = None,
    declared: Declared = NOTHING,
    mapping: Mapping[str, str] | None = None,
    *,
    digits: int | None = None,
    out: Path | None = None,
    time_limit_s: float,
    overwrite: bool = False,
    command: str = "",
    render: Callable[[Path], Path | None] = ignore,
) -> FileResult:
    """Judge a file that another program wrote.

    Parameters
    ----------
    scene : Scene or str
    file : Path
    finer : Path, optional
        Result of half the step or a tenth of the requested error, with the same columns and rows.
    declared : Declared
        Order, requested error and coordinates of the program.
    mapping : mapping of str to str, optional
        Names of channels to names or numbers of columns.
    digits : int, optional
        Digits of each number that count; by default all that are written.
    out : Path, optional
        Folder of the report and its tables.
    time_limit_s : float
        Of each run for the solution of a scene that comes without one, s.
    overwrite : bool
        Whether a comparison in the folder is replaced.
    command : str
        For the record.
    render : callable, optional
        Writes the report of a folder and returns its page.

    Raises
    ------
    TableError
        If a file can't be read as a table of the scene.
    SceneError, SolutionFailedError, ResultsInPlaceError
    """
    loaded = closely_sampled(load_scene(scene) if isinstance(scene, str) else scene)
    read = [read_channels(path, loaded, mapping or {}, digits) for path in (file, finer) if path is not None]
    if 0 < read[0].bars < loaded.bars and shipped_solution(loaded) is None:  # whose run may take long
        raise TableError(f"{file} has columns of {plural(read[0].bars, 'bar')}, and the scene has {loaded.bars}")
    solution = solution_of(loaded, time_limit_s)
    main, *second = (placed(channels, solution) for channels in read)
    if second and not np.array_equal(second[0].trajectory.t_s, main.trajectory.t_s):
        raise TableError(f"{finer} has other times than {file}; both need the same rows")
    if second and second[0].whole != main.whole:
        raise TableError(f"{finer} has other columns than {file}")
    if second and not any(d.any() for d in differences(main.trajectory, second[0].trajectory).values()):
        raise TableError(f"{finer} has the numbers of {file}; give a result of half the step or a tenth of the error")
    name = file_name(file)
    with np.errstate(all="ignore"):  # numbers of a file may be as large, or as small, as doubles are
        found = judge_file(name, main, second[0] if second else None, declared)
        few = rounded_to(read[0]) if finer is None and digits is None else 0
        if few and found.verdict.outcome is not Outcome.PASS:
            rounded = placed(read_channels(file, loaded, mapping or {}, few), solution)
            found = with_fewer_digits(few, name, found, main, rounded, declared)
    if digits is not None:
        found.notes.append(f"{plural(digits, 'digit')} of each number count")
    proven = proven_words(loaded)
    if proven:
        found.notes.append(proven)
    page = None
    if out is not None:
        study = FileComparison([loaded], {}, name=name, found=found)
        page = run_and_render(study, out, render, resume=None, overwrite=overwrite, command=command)[1]
    rows, first_s = found.verdict.rows, float(main.trajectory.t_s[0])
    reasons = {row["quantity"]: row["reason"] for row in rows if row["reason"]}  # the last one of each counts
    return FileResult(
        loaded.name,
        found.verdict.outcome,
        float(main.trajectory.t_s[-1]),
        float(solution.trajectory.t_s[-1]),
        found.advice,
        "" if found.mistakes is None else str(found.mistakes),
        [f"{quantity}: {reason}" for quantity, reason in reasons.items()],
        [
            (row["quantity"], row["value"], row["unit"])
            for row in rows
            if row["metric"] == "max" and row["limit_s"] > first_s
        ],  # the start itself tells nothing
        found.notes,
        page,
    )


def with_fewer_digits(
    few: int, name: str, found: FileVerdict, main: Samples, rounded: Samples, declared: Declared
) -> FileVerdict:
    """Verdict on a file that fails; where it passes with fewer digits, advice to declare them in place of mistakes.

    Parameters
    ----------
    few : int
        Digits that its numbers show.
    name : str
    found : FileVerdict
    main, rounded : Samples
        The file with all of its digits, and with those.
    declared : Declared
    """
    if judge_file(name, rounded, None, declared).verdict.outcome is not Outcome.PASS:
        return found
    said = f"no number has more than {few} digits before the zeros at its end; if all were rounded to these"
    advice = [f"{said}, declare it (--digits {few}): then the file passes"]
    plain, *_ = one_verdict(name, main, None, declared, {})
    return replace(found, verdict=plain, mistakes=None, advice=advice)


def rounded_to(channels: Channels) -> int:
    """Digits to which all numbers of a file may have been rounded before zeros were written behind them; 0 of others.

    Columns in other units than SI show none.
    """
    for digits in FEW_DIGITS:
        zeros = False
        for name, values in channels.values.items():
            unit = 2.0 * half_of(values, digits)
            seen = unit > 0.0
            off = values[seen] - unit[seen] * np.rint(values[seen] / unit[seen])
            if np.any(np.abs(off) > ROUNDING * np.abs(values[seen])):
                break
            zeros |= bool(np.any(unit > MORE_DIGITS * 2.0 * channels.half_units[name]))
        else:
            return digits if zeros else 0
    return 0


def file_name(file: Path) -> str:
    """Name of a file in tables and folders: letters, digits, _ and -."""
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-_")[:60] or "file"
    return f"{name}-file" if name.lower() in RESERVED else name


def solution_of(scene: Scene, time_limit_s: float) -> ReferenceSolution:
    """Solution that judges a scene: the certified one that comes with it, or the reference's, run here."""
    shipped = shipped_solution(scene)
    if shipped is not None:
        return shipped
    case = solution_case(scene, lambda job: run_task(job, limit_of(job, time_limit_s)))
    try:
        ((_, found),) = run_cases([(scene.name, case)], ALL_CORES)
    except SolutionFailedError as error:
        raise SolutionFailedError(f"{scene.name} has no solution to judge by: {error}") from error
    return found


@dataclass(frozen=True, kw_only=True)
class FileComparison(Comparison):
    """Comparison of one file with one solution."""

    name: str
    found: FileVerdict

    def record(self) -> dict[str, Any]:
        """The file's facts in place of an engine's."""
        engine, setting = self.found.engine, self.found.setting
        facts = {
            "external": True, "version": "", "missing": None, "title": f"the file {self.name}",
            "coordinates": str(engine.coordinates), "parameter": str(setting.parameter), "default": setting.value,
            "order": engine.order,
        }  # fmt: skip
        return super().record() | {"engines": {self.name: facts}}

    def run(self, store: StudyStore, reporter: Reporter) -> ComparisonResult:
        """Write what was judged."""
        found, suite = self.found, Suite(self, store, reporter)
        scene = found.solution.scene
        suite.establish(SceneProgress(scene, source=found.solution.source), found.solution)
        for role, run in ((Role.MAIN, found.main), (Role.FINER, found.finer)):
            if run is not None:
                job = Job(scene, self.name, Registration("file"), found.setting, role)
                keep_run(store, job, RunResult(Outcome.PASS, trajectory=run))
        suite.settle(scene.name, self.name, found.verdict)
        return ComparisonResult(suite.store.read("metrics"), {(scene.name, self.name): found.verdict.outcome})
