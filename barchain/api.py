"""What notebooks and scripts use: load a scene, simulate it, compare engines on it."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.registry import Registration, find_engine
from barchain.crossval.record import new_record
from barchain.crossval.suite import ANY_EXTERNAL, Plan, Suite
from barchain.run.job import Job, Role
from barchain.run.limits import TIME_LIMIT_S
from barchain.run.pool import run_jobs
from barchain.run.selection import chosen_engines, unique_names
from barchain.run.store import Store
from reports.tables.crossval import REFERENCE_SOLUTION
from reports.tables.outcome import Outcome
from scenarios import Scene, load_scene, nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    import pandas as pd

    from adapters.trajectory import Trajectory


class SettingError(ValueError):
    """A setting that the engine does not have."""


@dataclass(frozen=True)
class ComparisonResult:
    """What :func:`compare` found."""

    metrics: pd.DataFrame
    """Tidy: scene, engine, setting, quantity, metric, value, unit, tolerance, outcome, reason, horizon_s"""
    outcomes: dict[tuple[str, str], Outcome]
    """By (scene, engine); an engine or a scene in parentheses is none, see :mod:`reports.tables.crossval`"""

    @property
    def passed(self) -> bool:
        """Whether every comparison passed or was declared unsupported, and at least one passed.

        An engine that was named, or had several scenes to do, must have been compared on one of them.
        """
        found = self.outcomes.values()
        return all(o.ok for o in found) and Outcome.PASS in found


def simulate(
    scene: Scene | str | Path,
    engine: str = "reference",
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
    engine : str
        A registered name.
    time_limit_s : float
        Wall time after which the worker is ended; an engine that compiles has ten minutes more for that.
    condition : bool
        Ask for the joint system's condition number at every sample (the reference has it).
    **setting : float
        The engine's knob, e.g. ``rtol=1e-12`` or ``steps_per_orbit=4000``; its default otherwise.

    Returns
    -------
    Trajectory

    Raises
    ------
    SceneError, UnknownEngineError, SettingError
        For a scene, an engine or a setting that does not exist.
    ValueError
        If the engine can't do this scene or has no condition number, with the reason.
    EngineError
        If the run fails, hangs, or returns what can't be a trajectory.

    Notes
    -----
    In a script, call it below ``if __name__ == "__main__":``: workers import the script.
    """
    found = scene if isinstance(scene, Scene) else load_scene(scene)
    registration = find_engine(engine)
    if registration.missing:
        raise EngineError(f"{engine}: {registration.missing}")
    loaded = registration.load()
    reason = loaded.unsupported(found)
    if reason:
        raise ValueError(f"{engine} can't do {found.name}: {reason}")
    if condition and "condition" not in loaded.options:
        raise ValueError(f"{engine} has no condition number to show; the reference has")
    options = frozenset({"condition"} if condition else ())
    job = Job(found, engine, registration, choose_setting(engine, setting), Role.MAIN, options)
    _, result = next(iter(run_jobs([job], time_limit_s=time_limit_s, workers=1)))
    if result.outcome is not Outcome.PASS or result.trajectory is None:
        raise EngineError(f"{engine} on {found.name}: {result.reason or result.outcome.advice}")
    return result.trajectory


def choose_setting(engine: str, given: Mapping[str, float]) -> Setting:
    """Setting of `engine` from what a user gave; the default one from nothing.

    Raises
    ------
    SettingError
        If the engine has another knob, or the value is out of its range.
    """
    sweep = find_engine(engine).load().sweep
    for name, value in given.items():
        if name != sweep.parameter:
            raise SettingError(
                f"{engine} has no setting {name}{nearest(name, [sweep.parameter])}; allowed: {sweep.parameter}"
            )
        least, most = (min(1e-15, *sweep.values), 1.0) if sweep.parameter is AccuracyParameter.RTOL else (1.0, 1e9)
        if not least <= value <= most:
            raise SettingError(f"{engine}: {name}={value:g} given, allowed: {least:g} to {most:g}")
        return Setting(sweep.parameter, float(value))
    return sweep.setting()


def compare(
    scenes: Iterable[Scene | str | Path],
    engine_names: Iterable[str] | None = None,
    out: Path | str | None = None,
    *,
    time_limit_s: float = TIME_LIMIT_S,
    workers: int | None = None,
    settings: Mapping[str, Mapping[str, float]] | None = None,
    resume: bool = False,
    need_external: bool = False,
    command: str = "",
    progress: Callable[[str, str, str], None] | None = None,
    notes: Callable[[str], None] | None = None,
    registered: Mapping[str, Registration] | None = None,
) -> ComparisonResult:
    """Run scenes in engines, compare each with the truth, and write tables as results come.

    Parameters
    ----------
    scenes : iterable of Scene, str or Path
    engine_names : iterable of str, optional
        All registered engines by default. One that is named, and can do none of the scenes, is a failure.
    out : Path or str, optional
        Folder for tables and trajectories (see :mod:`reports.tables.crossval`); none are kept by default.
    time_limit_s : float
        Wall time after which one run is ended; an engine that compiles has ten minutes more for that.
    workers : int, optional
        Processes side by side; all cores by default.
    settings : mapping, optional
        ``{"exudyn": {"steps_per_orbit": 2000}}``
    resume : bool
        Take over the runs that an earlier comparison left in `out`.
    need_external : bool
        Count a scene that no external engine passes as a failure.
    command : str
        What was typed, for the record.
    progress : callable, optional
        Told (scene, engine, outcome) after each verdict.
    notes : callable, optional
        Told what goes on before the first of them, in words.
    registered : mapping, optional
        Engines by name, instead of the registry's.

    Returns
    -------
    ComparisonResult

    Raises
    ------
    SceneError, UnknownEngineError, SettingError
        Before anything is run.
    """
    loaded = [s if isinstance(s, Scene) else load_scene(s) for s in scenes]
    chosen = dict(registered) if registered is not None else chosen_engines(engine_names)
    plan = Plan(
        unique_names(loaded),
        chosen,
        time_limit_s,
        workers,
        {name: choose_setting(name, values) for name, values in (settings or {}).items()},
        resume,
        need_external,
        named=engine_names is not None,
    )
    with tempfile.TemporaryDirectory() as scratch:
        order = [(s.name, e) for s in plan.scenes for e in [REFERENCE_SOLUTION, *chosen, ANY_EXTERNAL]]
        store = Store(Path(out) if out is not None else Path(scratch), new_record(plan, command), order)
        verdicts = Suite(plan, store, progress or (lambda *_: None), notes or (lambda _: None)).run()
        return ComparisonResult(store.metrics(), {pair: v.outcome for pair, v in verdicts.items()})
