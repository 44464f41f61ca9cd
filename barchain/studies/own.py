"""A study of one's own: cases that ask for runs and return rows, kept, resumed and read like every other study.

A case is a generator. It yields the runs that it needs, receives their results, may ask for more, and returns rows::

    def case(altitude_m):
        scene = barchain.change_scene(barchain.load_scene("paper/fig05"), {"orbit": {"altitude_m": altitude_m}})
        coarse, fine = yield [asked_run(scene, "pymunk", steps_per_orbit=n) for n in (1000, 2000)]
        ...
        return [{"metric": "error_ratio", "value": ratio, "scene": scene.name, "engine": "pymunk"}]

    rows = measure("altitude", {"300 km": case(300e3), "500 km": case(500e3)}, "results")
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adapters.registry import find_engine
from barchain.arguments import REPETITION, SECONDS, check
from barchain.runs.cases import run_cases
from barchain.runs.choices import choose_setting
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import TIME_LIMIT_S, Job, Role
from barchain.runs.tasks import limit_of, run_task
from barchain.studies.study import Reporter, StudyEnd, run_study
from reports.results.files import StudyFiles
from reports.results.rows import spread
from reports.results.studies import STUDIES
from scenarios import Scene, load_scene
from scenarios.load import check_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import pandas as pd

    from barchain.record.study_store import StudyStore
    from barchain.runs.cases import Case, Task
    from barchain.runs.executors import Executor
    from reports.results.rows import Row

NAME = r"[a-z][a-z0-9_]{0,39}"


def asked_run(
    scene: Scene | str | Path, engine: str, *, time_limit_s: float = TIME_LIMIT_S, repetition: int = 0, **setting: float
) -> Task:  # fmt: skip
    """Run that a case asks for.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, its name, or the path of its file.
    engine : str
        A registered name.
    time_limit_s : float
        Wall time of the run, s.
    repetition : int
        Number of a run that is made several times, as for its time: runs of equal numbers are made once.
    **setting : float
        The engine's accuracy parameter, e.g. ``rtol=1e-12``; its default otherwise.

    Returns
    -------
    Task
        Its result is a :class:`~barchain.runs.job.RunResult`: outcome, reason, trajectory (None without one), seconds.

    Raises
    ------
    SceneError, UnknownEngineError, SettingError
        If the scene, the engine or the setting does not exist.
    ArgumentError
        If another argument is of a wrong type.
    """
    check(REPETITION, repetition=repetition)
    check(SECONDS, time_limit_s=time_limit_s)
    loaded = check_scene(scene) if isinstance(scene, Scene) else load_scene(scene)
    job = Job(loaded, engine, find_engine(engine), choose_setting(engine, setting), Role.MAIN)
    return run_task(job, limit_of(job, time_limit_s), repetition=repetition)


def measure(
    name: str,
    cases: Mapping[str, Case[list[Row]]],
    out: Path | str,
    *,
    summary: Callable[[pd.DataFrame], list[Row]] | None = None,
    executor: Executor = ALL_CORES,
    resume: bool = False,
    overwrite: bool = False,
    command: str = "",
    reporter: Reporter | None = None,
) -> pd.DataFrame:
    """Run the cases of a study, side by side, and keep their rows in a result folder.

    Parameters
    ----------
    name : str
        Of the study: lower-case letters, digits and ``_``; none of barchain's own.
    cases : mapping
        Generators by what progress calls them. Each returns a list of rows: arguments of
        :meth:`reports.results.rows.Rows.add`, ``metric`` and at most a value or outcome with its engine, scene,
        quantity, unit; any other name is a tag.
    out : Path or str
        Result folder. ``barchain show OUT`` prints the rows, :func:`barchain.rows` reads them.
    summary : callable, optional
        Makes further rows of those of all cases, which it gets as a table with a column for each tag.
    executor : Executor
        Place of the runs; all cores of this machine by default.
    resume : bool
        Go on from the runs that an interrupted study left in `out`.
    overwrite : bool
        Delete the study's earlier results in `out` first.
    command : str
        For the record.
    reporter : Reporter, optional
        Callbacks for progress.

    Returns
    -------
    DataFrame
        Rows, with a column for each tag.

    Raises
    ------
    ValueError
        If the name has a wrong form, or is that of another study.
    ResultsInPlaceError
        If `out` holds results of the study, and neither `resume` nor `overwrite` is given.
    RowError
        If two rows have one identity, or a tag is none.
    """
    taken = [files.study for files in STUDIES]
    if not re.fullmatch(NAME, name) or name in taken:
        raise ValueError(f"{name!r} given as a study, allowed: lower-case letters, digits and _, none of {taken}")
    files = StudyFiles(name)
    study = OwnStudy(files, dict(cases), summary, executor)
    run_study(study, Path(out), command=command, reporter=reporter, resume=resume, overwrite=overwrite)
    return spread(files.rows(Path(out)))


@dataclass(frozen=True)
class OwnStudy:
    """Study whose rows are those that its cases return."""

    files: StudyFiles
    cases: dict[str, Case[list[Row]]]
    summary: Callable[[pd.DataFrame], list[Row]] | None
    executor: Executor

    def record(self) -> dict[str, Any]:
        """Names of the cases."""
        return {"cases": list(self.cases)}

    def run(self, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Run all cases; rows are in the order of the cases, whichever ends first."""
        found = {}
        for case, rows in run_cases(self.cases.items(), self.executor):
            found[case] = rows
            reporter.step(case, "", f"{len(rows)} rows")
        made = store.summary
        for case in self.cases:
            for row in found[case]:
                made.add(**row)
        for row in self.summary(spread(made.frame())) if self.summary else ():
            made.add(**row)
        return StudyEnd()
