"""Functions for notebooks and scripts: list scenes and engines, simulate, compare, render."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from adapters.engine import EngineError, SettingError
from adapters.registry import engines as registered_engines
from adapters.registry import find_engine
from barchain.arguments import (
    ADDRESS,
    FOLDER,
    OPTIONAL_FOLDER,
    PROGRESS,
    SECONDS,
    SWITCH,
    TAG,
    WORKERS,
    ArgumentError,
    check,
    check_settings,
    engine_list,
    scene_list,
)
from barchain.record.claim import locked_if_there
from barchain.runs.asking import declarations_of
from barchain.runs.choices import choose_setting, chosen_engines
from barchain.runs.estimate import need_runnable
from barchain.runs.executors import WORKERS_S, LocalProcesses, chosen_executor
from barchain.runs.job import TIME_LIMIT_S, Job, Role
from barchain.runs.other_settings import default_engine, failure_advice
from barchain.runs.tasks import run_jobs
from reports.results.outcome import Outcome
from scenarios import Scene, check_scene, load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    import pandas as pd

    from adapters.registry import Registration
    from adapters.trajectory import Trajectory
    from barchain.studies.comparison.run import ComparisonResult

__all__ = [
    "ArgumentError",
    "SettingError",
    "choose_setting",
    "compare",
    "engines",
    "render",
    "rows",
    "scenes",
    "simulate",
]


def scenes(tag: str | None = None) -> list[str]:
    """Names of the scenes that come with barchain, sorted; :func:`barchain.load_scene` takes each.

    Parameters
    ----------
    tag : str, optional
        Keep only scenes with this tag, e.g. ``"paper"``; all scenes by default.

    Returns
    -------
    list of str
        E.g. ``paper/fig05``.

    Raises
    ------
    ArgumentError
        If `tag` is no text.
    """
    check(TAG, tag=tag)
    names = scene_names()
    return names if tag is None else [name for name in names if tag in load_scene(name).tags]


def engines() -> dict[str, Registration]:
    """Registered engines by name, barchain's own first, then those of other installed packages.

    Returns
    -------
    dict
        ``missing`` of a registration is None if the engine can run here, else the reason and the remedy;
        ``version`` is the installed version; ``by_default`` tells whether :func:`compare` takes the engine unasked.
    """
    return registered_engines()


def simulate(
    scene: Scene | str | Path,
    engine: str | None = None,
    *,
    time_limit_s: float = TIME_LIMIT_S,
    condition: bool = False,
    **setting: float,
) -> Trajectory:
    """Run one scene in one engine, in a worker process.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, its name, or the path of its file.
    engine : str, optional
        A registered name, see :func:`engines`; by default the reference: its compiled form ``reference-fast`` where it
        is built and supports the scene, else ``reference``.
    time_limit_s : float
        Wall time after which the worker is ended, s; an engine that compiles has ten minutes more for compiling.
    condition : bool
        Add the condition number of the joint system at every sample; only the reference supports it.
    **setting : float
        The engine's accuracy parameter, e.g. ``rtol=1e-12`` or ``steps_per_orbit=4000``; its default otherwise.

    Returns
    -------
    Trajectory
        n samples in SI units and inertial axes, e.g. ``com_m`` (n, 2), ``angle_rad`` (n, N), ``reaction_N``
        (n, N-1, 2); a quantity that the engine does not give is None.

    Raises
    ------
    SceneError, UnknownEngineError, SettingError
        If the scene, the engine or the setting does not exist, or is of a wrong type; if a scene that was made or
        changed in Python breaks a rule of scene files.
    ArgumentError
        If another argument is of a wrong type; the message gives the allowed values.
    ValueError
        If the engine does not support the scene or has no condition number; the message gives the reason.
    EngineError
        If the engine is not installed, or its run fails, times out, or returns a malformed trajectory.
    """
    check(SECONDS, time_limit_s=time_limit_s)
    check(SWITCH, condition=condition)
    loaded = check_scene(scene) if isinstance(scene, Scene) else load_scene(scene)
    need_runnable([loaded], time_limit_s)
    engine = default_engine(loaded, condition=condition) if engine is None else engine
    registration = find_engine(engine)
    if registration.missing:
        raise EngineError(f"{engine}: {registration.missing}")
    declared = declarations_of(registration)
    reason = declared.unsupported(loaded)
    if reason:
        raise ValueError(f"{engine} does not support {loaded.name}: {reason}")
    if condition and "condition" not in declared.options:
        raise ValueError(f"{engine} has no condition number; the reference has one")
    options = ("condition",) if condition else ()
    job = Job(loaded, engine, registration, choose_setting(engine, setting), Role.MAIN, options)
    _, result = next(iter(run_jobs([job], time_limit_s=time_limit_s, executor=LocalProcesses(1))))
    if result.outcome is not Outcome.PASS or result.trajectory is None:
        advice = failure_advice(loaded, engine, job.setting, result.outcome)
        raise EngineError(f"{engine} on {loaded.name}: {result.reason or result.outcome.advice}{advice}")
    return result.trajectory.of_run(loaded, engine, str(job.setting))


def checked(scene: Scene | str | Path) -> Scene | str | Path:
    """Check a scene that was made in Python, and return it; a name or a file is checked where it is loaded."""
    return check_scene(scene) if isinstance(scene, Scene) else scene


def compare(
    scenes: Iterable[Scene | str | Path],
    engines: Iterable[str] | None = None,
    out: Path | str | None = None,
    *,
    settings: Mapping[str, Mapping[str, float]] | None = None,
    time_limit_s: float = TIME_LIMIT_S,
    workers: int | None = None,
    dask: str | None = None,
    dask_wait_s: float = WORKERS_S,
    certify: bool = False,
    resume: bool = False,
    overwrite: bool = False,
    progress: Callable[[str, str, str], None] | None = None,
) -> ComparisonResult:
    """Run scenes in engines, and compare every run with the judging solution of its scene.

    Parameters
    ----------
    scenes : iterable of Scene, str or Path
        Scenes, their names, or the paths of their files.
    engines : iterable of str, optional
        Registered names; by default the engines whose registration says ``by_default``. A named engine that supports
        none of the scenes is a failure.
    out : Path or str, optional
        Folder for tables and trajectories, written as results come (see :mod:`reports.results.comparison`);
        nothing is kept by default.
    settings : mapping, optional
        Accuracy other than an engine's default, e.g. ``{"exudyn": {"steps_per_orbit": 2000}}``.
    time_limit_s : float
        Wall time after which one run is ended, s; an engine that compiles has ten minutes more for compiling.
    workers : int, optional
        Number of processes side by side; all cores by default.
    dask : str, optional
        Address of a Dask scheduler whose workers make the runs instead.
    dask_wait_s : float
        Longest time that the scheduler may have no worker, s.
    certify : bool
        Judge scenes of your own by solutions of heyoka in quadruple precision, whose equations are independent of the
        reference's; a few seconds to minutes a scene.
    resume : bool
        Take over the runs that an earlier comparison of these scenes and engines left in `out`.
    overwrite : bool
        Delete an earlier comparison in `out` first.
    progress : callable, optional
        Called with (scene, engine, outcome) after each verdict.

    Returns
    -------
    ComparisonResult
        The table of metrics, and the outcome of each scene and engine.

    Raises
    ------
    SceneError, UnknownEngineError, SettingError
        If a scene, an engine or a setting does not exist, or is of a wrong type; if a scene that was made or changed
        in Python breaks a rule of scene files. Nothing has been run.
    ArgumentError
        If another argument is of a wrong type, e.g. a text instead of a list of scenes; nothing has been run.
    ResultsInPlaceError
        If `out` holds results, and neither `resume` nor `overwrite` is given.
    SchemaVersionError, DamagedResultsError
        If `resume` finds results of another schema version in `out`, or damaged ones.
    FolderInUseError
        If another process writes into `out`.
    ClusterError
        If the Dask cluster can't be used, or fails.
    """
    from barchain.studies.comparison.run import run_comparison  # noqa: PLC0415  # a single run needs no judge
    from barchain.studies.study import Reporter, ignore  # noqa: PLC0415

    given, names = list(map(checked, scene_list(scenes))), engine_list(engines)
    check_settings(settings, chosen_engines(names))
    check(OPTIONAL_FOLDER, out=out)
    check(SECONDS, time_limit_s=time_limit_s, dask_wait_s=dask_wait_s)
    check(WORKERS, workers=workers)
    check(ADDRESS, dask=dask)
    check(SWITCH, resume=resume, overwrite=overwrite, certify=certify)
    check(PROGRESS, progress=progress)
    return run_comparison(
        given,
        names,
        out,
        time_limit_s=time_limit_s,
        executor=chosen_executor(workers, dask, dask_wait_s),
        settings=settings,
        certify=certify,
        resume=resume,
        overwrite=overwrite,
        reporter=Reporter(progress or ignore),
    )


def render(folder: Path | str) -> list[Path]:
    """Write the pages and texts of all results in a folder, from its stored tables alone.

    Parameters
    ----------
    folder : Path or str
        Result folder of a comparison, of studies, or of both.

    Returns
    -------
    list of Path
        Files written: HTML pages, and the Markdown report of a comparison.

    Raises
    ------
    ArgumentError
        If `folder` is neither text nor a path.
    FileNotFoundError
        If the folder holds neither a comparison nor a study.
    DamagedResultsError
        If a table can't be read.
    SchemaVersionError
        If the results have another schema version than this barchain reads.
    FolderInUseError
        If another process writes into the folder.
    """
    from reports.render import render_all  # noqa: PLC0415  # charts take a second to import

    check(FOLDER, folder=folder)
    with locked_if_there(Path(folder)):
        return render_all(Path(folder))


def rows(folder: Path | str) -> pd.DataFrame:
    """Rows of all results in a folder: everything that was measured or judged, one number or outcome each.

    Parameters
    ----------
    folder : Path or str
        Result folder of a comparison, of studies, or of both.

    Returns
    -------
    DataFrame
        Columns ``study, scene, engine, setting, tags, quantity, metric`` (together unique), ``value, low, high, unit,
        limit, outcome, reason, text, until_s``; numbers in the unit of their row, ``until_s`` in s.
        :func:`reports.results.rows.spread` makes columns of ``tags``.

    Raises
    ------
    ArgumentError
        If `folder` is neither text nor a path.
    FileNotFoundError
        If the folder holds no results.
    DamagedResultsError, SchemaVersionError
        If a table is damaged, or the results are of another schema version.
    """
    from reports.results.studies import rows_of  # noqa: PLC0415  # a single run needs no tables

    check(FOLDER, folder=folder)
    return rows_of(Path(folder))
