"""Functions for notebooks and scripts that measure: errors against run times, relevance of effects, sweeps of numbers.

:func:`barchain.ensemble` and :func:`barchain.measure` stand beside their studies.
"""

from __future__ import annotations

import contextlib
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from barchain.api import checked
from barchain.arguments import (
    AMOUNT,
    OPTIONAL_FOLDER,
    PROGRESS,
    SECONDS,
    SWITCH,
    WORKERS,
    check,
    check_settings,
    engine_list,
    items,
    scene_list,
)
from barchain.runs.choices import chosen_engines
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import TIME_LIMIT_S
from barchain.runs.other_settings import default_engine
from barchain.studies.defaults import COST, EFFECTS, MATTERS, RTOL
from barchain.studies.study import Reporter, ignore, run_study
from reports.results.cost import read_cost
from scenarios import Scene, load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from barchain.runs.executors import Executor
    from barchain.studies.sweep.study import SweepResult
    from reports.results.files import StudyTables


def cost(
    scenes: Iterable[Scene | str | Path] | None = None,
    engines: Iterable[str] | None = None,
    out: Path | str | None = None,
    *,
    orbits: float = 1.0,
    repeats: int = COST.repeats,
    minutes: float = COST.minutes,
    time_limit_s: float = COST.time_limit_s,
    resume: bool = False,
    overwrite: bool = False,
    progress: Callable[[str, str, str], None] | None = None,
) -> StudyTables:
    """Measure errors and run times of every setting of engines, as `barchain cost` does.

    Runs are made one by one: times need a quiet machine.

    Parameters
    ----------
    scenes : iterable of Scene, str or Path, optional
        Scenes, their names, or the paths of their files; those of ``paper/`` by default. Their certified solutions give
        the errors.
    engines : iterable of str, optional
        Registered names; all installed engines by default.
    out : Path or str, optional
        Result folder; nothing is kept by default.
    orbits : float
        Part of each scene that is run, from its start, in orbits.
    repeats : int
        Times that each point is timed, as far as the budget goes.
    minutes : float
        Budget of wall time, minutes.
    time_limit_s : float
        Longest wall time of a run, s; a run that is expected to take longer is left out.
    resume : bool
        Go on from results in `out`.
    overwrite : bool
        Delete earlier results of the study in `out` first.
    progress : callable, optional
        Called with (scene, engine and setting, outcome) after each first run.

    Returns
    -------
    StudyTables
        Tables as attributes: ``points`` (a row for each run: errors in rad, N, m, times in s), ``reach`` (time, s, and
        setting that reach a target error), ``orders``, ``price``, ``loads``; ``record`` has versions and limits.

    Raises
    ------
    SceneError, UnknownEngineError, CertifiedSolutionError
        If a scene or an engine does not exist, or a scene has no certified solution.
    ArgumentError
        If another argument is of a wrong type.
    ResultsInPlaceError
        If `out` holds results of the study, and neither `resume` nor `overwrite` is given.
    """
    from barchain.studies.cost.study import cost_study  # noqa: PLC0415  # heyoka is an extra

    given = None if scenes is None else list(map(checked, scene_list(scenes)))
    check(AMOUNT, orbits=orbits, minutes=minutes)
    check(SECONDS, time_limit_s=time_limit_s)
    check(WORKERS, repeats=repeats)
    limits = {"repeats": repeats, "minutes": minutes, "time_limit_s": time_limit_s}
    study = cost_study(given, engine_list(engines), orbits, **limits)
    with kept_in(out, resume=resume, overwrite=overwrite, progress=progress) as folder:
        run_study(study, folder, resume=resume, overwrite=overwrite, reporter=Reporter(progress or ignore))
        return read_cost(folder)


def effects(
    scene: Scene | str | Path,
    out: Path | str | None = None,
    *,
    rtol: float = RTOL,
    matters: float = MATTERS,
    width_m: float | None = None,
    engine: str | None = None,
    repeats: int = EFFECTS.repeats,
    minutes: float = EFFECTS.minutes,
    resume: bool = False,
    overwrite: bool = False,
    progress: Callable[[str, str, str], None] | None = None,
) -> StudyTables:
    """Measure relevance and run time of each effect of a scene, as `barchain effects` does.

    Each effect is switched off, or on with stated defaults where the scene does not have it.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, its name, or the path of its file.
    out : Path or str, optional
        Result folder; nothing is kept by default.
    rtol : float
        Requested accuracy of a step; a run at ten times that shows the numerical error.
    matters : float
        Change from which an effect is relevant: rad of attitude, or relative to the largest reaction or to the initial
        distance from the centre.
    width_m : float, optional
        Width of every bar, m, for drag and sunlight that the scene does not have; the scene's own by default.
    engine : str, optional
        ``"reference-fast"`` or ``"reference"``; the compiled form by default, where it is installed and supports the
        scene.
    repeats : int
        Rounds of timing, as far as the budget goes.
    minutes : float
        Budget of wall time, minutes; no further round is begun after it.
    resume : bool
        Go on from results in `out`.
    overwrite : bool
        Delete earlier results of the study in `out` first.
    progress : callable, optional
        Called with (scene, run, outcome) after each run.

    Returns
    -------
    StudyTables
        Tables as attributes, with changes in rad, N, m and times in s; ``record`` has the scene and what was switched.

    Raises
    ------
    SceneError
        If the scene does not exist.
    ValueError
        If a width is beyond a bar's length; an ArgumentError if an argument is of a wrong type.
    ResultsInPlaceError
        If `out` holds results of the study, and neither `resume` nor `overwrite` is given.
    """
    from barchain.studies.effects.study import effects_study  # noqa: PLC0415

    check(AMOUNT, rtol=rtol, matters=matters, minutes=minutes)
    check(WORKERS, repeats=repeats)
    options = {"rtol": rtol, "matters": matters, "width_m": width_m, "engine": engine, "repeats": repeats}
    loaded = checked(scene)
    study = effects_study(
        loaded if isinstance(loaded, Scene) else load_scene(loaded), seconds=60.0 * minutes, **options
    )
    with kept_in(out, resume=resume, overwrite=overwrite, progress=progress) as folder:
        run_study(study, folder, resume=resume, overwrite=overwrite, reporter=Reporter(progress or ignore))
        return study.files.contents(folder)


def sweep(
    scene: Scene | str | Path,
    vary: Iterable[str],
    measures: Iterable[str] = (),
    out: Path | str | None = None,
    *,
    engines: Iterable[str] | None = None,
    settings: Mapping[str, Mapping[str, float]] | None = None,
    runs: int | None = None,
    seed: int = 1,
    time_limit_s: float = TIME_LIMIT_S,
    executor: Executor = ALL_CORES,
    resume: bool = False,
    overwrite: bool = False,
    progress: Callable[[int], None] | None = None,
) -> SweepResult:
    """Vary numbers of a scene, run each in some engines, and measure every run.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, its name, or the path of its file.
    vary : iterable of str
        Numbers of the scene's file, e.g. ``["orbit.speed_factor=1:1.3:7", "chain.bars=2,4,8",
        "chain.angle_deg[2]=normal(80, 1)"]``: a grid ``low:high:count``, a list, or one of the distributions of
        :func:`barchain.ensemble`. Lists count from 1, and ``[*]`` draws each value of a list by itself. Grids and lists
        make all combinations; numbers that are drawn are drawn together, the same at each combination. Keys go together
        by ``"chain.length_m=10,20 with chain.mass_kg=1,3"``, or as multiples, ``"chain.mass_kg=0.2*chain.length_m"``.
    measures : iterable of str
        E.g. ``["largest(tension)", "final(attitude[2])", "p95(altitude)"]``: ``largest``, ``least``, ``peak`` (size),
        ``final``, ``rms`` or a percentile over the samples of a stored or derived channel, of one bar or joint or the
        worst of all, or of one column. By default the largest reaction and both ends of the altitude.
    out : Path or str, optional
        Result folder; nothing is kept by default.
    engines : iterable of str, optional
        Registered names; by default the reference, compiled where it is built and supports the scene.
    settings : mapping, optional
        Accuracy other than an engine's default, e.g. ``{"exudyn": {"steps_per_orbit": 2000}}``.
    runs : int, optional
        Number of draws; 1000 by default.
    seed : int
        Equal seeds draw equal numbers.
    time_limit_s : float
        Wall time after which one run is ended, s.
    executor : Executor
        Place of the runs; all cores of this machine by default.
    resume : bool
        Go on from results in `out`.
    overwrite : bool
        Delete earlier results of the study in `out` first.
    progress : callable, optional
        Called with the number of runs after each part.

    Returns
    -------
    SweepResult
        ``samples``, a table with a row for each run and engine, in the units of the names; ``failures`` in words.

    Raises
    ------
    SceneError, UnknownEngineError, SettingError
        If the scene, an engine or a setting does not exist.
    ValueError
        If a variation or a measure can't be read, or the scene refuses a value; nothing has been run.
    EngineError
        If an engine is not installed.
    ResultsInPlaceError
        If `out` holds results of the study, and neither `resume` nor `overwrite` is given.
    """
    from barchain.studies.sweep.study import sweep_study  # noqa: PLC0415

    loaded = checked(scene)
    loaded = loaded if isinstance(loaded, Scene) else load_scene(loaded)
    names = engine_list(engines) or [default_engine(loaded)]
    check_settings(settings, chosen_engines(names))
    check(SECONDS, time_limit_s=time_limit_s)
    check(AMOUNT, runs=1 if runs is None else runs)
    varying = items("vary", vary, 'a list of texts, e.g. ["orbit.speed_factor=1:1.3:7"]')
    measured = items("measures", measures, 'a list of texts, e.g. ["largest(tension)"]') if measures else ()
    study = sweep_study(
        loaded, varying, measured, engines=names, settings=settings, runs=runs, seed=seed,
        time_limit_s=time_limit_s, executor=executor,
    )  # fmt: skip
    with kept_in(out, resume=resume, overwrite=overwrite, progress=progress) as folder:
        reporter = Reporter(counted=lambda *_: contextlib.nullcontext(progress or ignore))
        return run_study(study, folder, resume=resume, overwrite=overwrite, reporter=reporter)


@contextlib.contextmanager
def kept_in(out: Path | str | None, *, resume: bool, overwrite: bool, progress: object) -> Iterator[Path]:
    """Folder of the results: `out`, or one that is removed at the end.

    Raises
    ------
    ArgumentError
        If an argument is of a wrong type.
    """
    check(OPTIONAL_FOLDER, out=out)
    check(SWITCH, resume=resume, overwrite=overwrite)
    check(PROGRESS, progress=progress)
    if out is not None:
        yield Path(out)
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)
