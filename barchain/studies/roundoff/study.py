"""The round-off study: digits of the reactions that each kind of coordinates leaves.

Its tasks are cases that run side by side; then evaluations are timed alone.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.registry import ENGINES
from barchain.record.environment import package_version
from barchain.runs.call import Call, CallFailedError
from barchain.runs.cases import Shared, Task, run_cases
from barchain.runs.choices import unique_names
from barchain.runs.estimate import need_runnable
from barchain.runs.executors import ALL_CORES, KeptAnswers
from barchain.runs.message import MessageError, message_bytes, read_message
from barchain.solutions.reference import closely_sampled
from barchain.studies.roundoff.engines import engine_rows
from barchain.studies.roundoff.evaluation import longitude_rows, rows_of, time_rows
from barchain.studies.roundoff.floors import FloorTask, floor_tasks
from barchain.studies.roundoff.formulations import EQUATOR_M, MEMBERS, EvaluationCase, StateKind
from barchain.studies.roundoff.power_laws import best_laws, best_table, engine_laws, evaluation_laws, growth_laws
from barchain.studies.roundoff.scenes import PRECISIONS, digit_rows, need_carried, shortened
from barchain.studies.roundoff.third_parties import present
from barchain.studies.roundoff.trajectories import (
    ScaledScene,
    chosen_step_rows,
    equal_step_rows,
    growth_rows,
    solution_bytes,
    solution_from,
)
from barchain.studies.study import StudyEnd
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT_DIGITS, long_doubles
from reports.results.outcome import Outcome
from reports.results.roundoff import FILES, TABLES
from scenarios import Scene, load_scene

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    import pandas as pd

    from adapters.registry import Registration
    from barchain.record.study_store import StudyStore
    from barchain.runs.call import Answer
    from barchain.runs.cases import Case
    from barchain.runs.executors import Executor
    from barchain.studies.roundoff.trajectories import HighPrecisionSolution
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles

    Rows = list[dict[str, Any]]

PARTS = ("evaluation", "trajectories", "engines", "times")
SCENE = "paper/fig15"  # the 80° chain turning with its orbit, which stays regular: what grows is round-off alone
DECADES = tuple(10.0**-k for k in range(2, 13))
REACH = 0.1  # of the Earth's radius, that the chain may span: a longer one would touch the ground
ALL, SHORT = ("float32", "float64", "long double"), ("float32", "float64")
COORDINATES = ("minimal", "relative", "absolute")
SWEEPS = {
    "exudyn": (4096, 12288, 36864, 122880),
    "exudyn-absolute": (4096, 12288, 36864, 122880),
    "exudyn-index3": (4096, 12288, 28672, 61440, 122880),
    "exudyn-absolute-index3": (4096, 12288, 28672, 61440, 122880),
    "pymunk": (4096, 16384, 98304, 163840, 262144),
    "pymunk-absolute": (4096, 16384, 57344, 102400, 163840),
    "mujoco": (4096, 24576, 122880),
    "pinocchio": (1e-6, 1e-9, 1e-12),
    "reference": (1e-6, 1e-9, 1e-12),
    "reference-absolute": (1e-6, 1e-9, 1e-12),
}
"""Steps in an orbit, or tolerances, of other engines: index 3 and pymunk from truncation far into round-off"""
FULL_STEPS = tuple(1024 * 2**k for k in range(8))
FULL_SWEEPS = {name: FULL_STEPS for name, values in SWEEPS.items() if values[0] > 1.0} | {
    "pymunk": (*FULL_STEPS, 262144, 524288)
}
PART, FULL_PART = 1.0 / 256.0, 1.0 / 64.0  # of an orbit: noise is there from the first steps on, and steps cost
TASK_LIMIT_S = 600.0
SOLUTION_LIMIT_S = 3600.0  # without a high-precision solution none of its tasks is run
FIRST, LATER = (0.0,), (1.0,)
"""Priorities of high-precision solutions and of tasks"""
OBJECTS = tuple(
    {"name": name, "length_m": length_m, "ratio": length_m / EQUATOR_M}
    for name, length_m in (
        ("20 km tether", 20e3), ("1 km tether", 1e3), ("100 m truss", 100.0), ("7 m robot arm link", 7.0),
        ("10 cm CubeSat", 0.1), ("5 mm hinge", 5e-3), ("10 µm MEMS beam", 1e-5),
    )
)  # fmt: skip
"""Objects on the axis of sizes, from the longest"""
DERIVED = {
    "laws": ("evaluation", evaluation_laws),
    "growth_laws": ("growth", growth_laws),
    "engine_laws": ("engines", engine_laws),
}
"""Tables that follow from others"""


@dataclass(frozen=True)
class RoundoffTask:
    """Some rows of a table, from a function that a process imports and calls."""

    table: str
    title: str
    function: Callable[..., Rows]
    """Of a module, so that a process can import it"""
    arguments: tuple[Any, ...]
    solution: ScaledScene | None = None
    """Whose high-precision solution is the function's first argument"""
    limit_s: float = TASK_LIMIT_S


@dataclass(frozen=True)
class RoundoffStudy:
    """Tasks of some parts."""

    tasks: tuple[RoundoffTask | FloorTask, ...]
    timed: tuple[RoundoffTask, ...] = ()
    """Tasks whose times count: they are made after all else, one by one"""
    full: bool = False
    parts: tuple[str, ...] = PARTS
    executor: Executor = ALL_CORES
    """Place of the tasks that are not timed"""
    left_out: dict[str, str] = field(default_factory=dict)
    """Engines that do not support a scene, with the reasons"""
    files: ClassVar[StudyFiles] = FILES

    @property
    def turns(self) -> int:
        """Number of tasks to be reported."""
        return len(self.tasks) + len(self.timed)

    def record(self) -> dict[str, Any]:
        """Parts, arithmetics, and the objects named on the axes; failed tasks are added as they come."""
        return {
            "packages": {"gmpy2": package_version("gmpy2")},
            "full": self.full,
            "parts": {part: {} for part in self.parts},
            "scene": SCENE,
            "members": MEMBERS,
            "exact_digits": EXACT_DIGITS,
            "unit_roundoff": {name: a.unit_roundoff for name, a in ARITHMETICS.items()},
            "long_doubles": long_doubles(),
            "objects": list(OBJECTS),
            "failed": [],
        }

    def run(self, store: StudyStore, reporter: Reporter) -> StudyEnd:
        """Run everything and write the tables; an interrupted run leaves the rows so far."""
        assert isinstance(self.executor, KeptAnswers)
        failed = store.record["failed"]
        rows: dict[str, dict[int, Rows]] = {}

        def table(name: str) -> pd.DataFrame:
            """Rows so far in the order of the tasks, whenever they came."""
            return TABLES[name].framed(row for _, own in sorted(rows[name].items()) for row in own)

        try:
            for tasks, place in ((self.tasks, self.executor), (self.timed, self.executor.one_by_one())):
                for k, found in run_cases(enumerate(cases_of(tasks, reporter.note)), place):
                    task = tasks[k]
                    if isinstance(found, str):
                        failed.append({"table": task.table, "task": task.title, "reason": found})
                        reporter.step(task.table, f"{task.title}: {found}", str(Outcome.FAILED))
                    else:
                        for row in found:  # some have rows of two tables
                            rows.setdefault(row.get("table", task.table), {}).setdefault(k, []).append(row)
                        for name in dict.fromkeys(row.get("table", task.table) for row in found):
                            store.write(name, table(name))
                        reporter.step(task.table, task.title, str(Outcome.PASS))
        finally:
            for name, (source, laws) in DERIVED.items():
                if source in rows:
                    store.write(name, laws(table(source)))
            if "trajectories" in rows:
                best = best_table(table("trajectories"))
                store.write("best", best)
                store.write("best_laws", best_laws(best))
        return StudyEnd(tuple(f"{f['table']}: {f['task']}: {f['reason']}" for f in failed), self.left_out)


def scene_study(
    scenes: Iterable[str | Path | Scene],
    engines: dict[str, Registration] | None = None,
    settings: Mapping[str, Mapping[str, float]] | None = None,
    orbits: float | None = None,
    executor: Executor = ALL_CORES,
) -> RoundoffStudy:
    """Study of the digits of scenes over their first orbits, or of the floors of engines in them.

    Values of `settings` are by engine; engines have their own without them, and scenes their whole run without orbits.

    Raises
    ------
    SceneError, SettingError
        For a scene that does not exist or that the formulations can't carry, or a setting that an engine does not have.
    ClusterError
        For a Dask cluster that can't be used.
    """
    loaded = unique_names([shortened(s if isinstance(s, Scene) else load_scene(s), orbits) for s in scenes])
    executor.check()
    if engines:
        need_runnable(loaded)
        floors, left_out = floor_tasks(map(closely_sampled, loaded), engines, settings or {})
        return RoundoffStudy(tuple(floors), parts=("floors",), executor=executor, left_out=left_out)
    for scene in loaded:
        need_carried(scene)
    tasks = tuple(
        RoundoffTask("digits", f"{scene.name}, {name}", digit_rows, (scene, name), limit_s=SOLUTION_LIMIT_S)
        for name in reversed(PRECISIONS) for scene in loaded  # the longest first
        if name != "long double" or long_doubles()
    )  # fmt: skip
    return RoundoffStudy(tasks, parts=("scenes",), executor=executor)


def roundoff_study(
    parts: tuple[str, ...] = PARTS, sizes: tuple[float, ...] = (), *, full: bool = False, executor: Executor = ALL_CORES
) -> RoundoffStudy:
    """Round-off study; `parts`, `sizes` and `full` are those of :func:`tasks_of`.

    Raises
    ------
    ClusterError
        For a Dask cluster that can't be used.
    ValueError
        For a size at which no evaluation is judged.
    """
    tasks = tasks_of(parts, sizes, full=full)
    executor.check()
    bars = (5, 50, 500) if full else (5, 50)
    timed = (RoundoffTask("times", "relative over absolute", time_rows, (bars,)),) if "times" in parts else ()
    return RoundoffStudy(tasks, timed, full, tuple(parts), executor)


def cases_of(tasks: tuple[RoundoffTask | FloorTask, ...], note: Callable[[str], None]) -> Iterator[Case[Rows | str]]:
    """Cases of tasks; those of one family of scenes share its high-precision solution."""
    families = {t.solution for t in tasks if isinstance(t, RoundoffTask) and t.solution is not None}
    solutions = {family: Shared(solution_case(family)) for family in families}
    for task in tasks:
        if isinstance(task, FloorTask):
            yield task.case(note)
        else:
            yield task_case(task, None if task.solution is None else solutions[task.solution])


def solution_case(family: ScaledScene) -> Case[HighPrecisionSolution | str]:
    """High-precision solution of a family of scenes, or why there is none."""
    call = Call(solution_bytes, (family,), SOLUTION_LIMIT_S)
    (found,) = yield [Task(call, checked(lambda content: solution_from(family, content)), FIRST)]
    solution: HighPrecisionSolution | str = found
    return solution


def task_case(task: RoundoffTask, solution: Shared | None) -> Case[Rows | str]:
    """Rows of a task, or why there are none; one that hangs is ended, and costs its own rows."""
    given = task.arguments
    if solution is not None:
        (known,) = yield [solution]
        if isinstance(known, str):
            return f"no high-precision solution: {known}"
        given = (known, *given)
    read = checked(lambda content: read_message(content)[0]["rows"])
    (found,) = yield [Task(Call(task_bytes, (task.function, given), task.limit_s), read, LATER)]
    rows: Rows | str = found
    return rows


def task_bytes(function: Callable[..., Rows], arguments: tuple[Any, ...]) -> bytes:
    """Message with a task's rows; the function is called here."""
    return message_bytes({"rows": function(*arguments)}, {})


def checked(read: Callable[[bytes], Any]) -> Callable[[Answer], Any]:
    """Reading of an answer, which gives the reason as text where there is none, or a damaged one."""

    def result(answer: Answer) -> Any:
        try:
            return read(answer.needed())
        except (CallFailedError, MessageError, KeyError) as error:
            return str(error)

    return result


def tasks_of(parts: Sequence[str], sizes: Sequence[float] = (), *, full: bool = False) -> tuple[RoundoffTask, ...]:
    """Tasks of some parts, which may run side by side; the times of evaluations are taken by others.

    Parameters
    ----------
    parts : sequence of str
        Of :data:`PARTS`.
    sizes : sequence of float
        Sizes at which one evaluation is judged, of :data:`DECADES`; all by default.
    full : bool
        Every size, arithmetic and number of bars, finer steps, longer runs: half an hour instead of minutes.

    Raises
    ------
    ValueError
        If a size is none of these.
    """
    check_sizes(sizes)
    tasks: list[RoundoffTask] = []
    if "evaluation" in parts:
        wanted = (
            t for t in evaluations(full) if not sizes or any(math.isclose(t.arguments[0].ratio, r) for r in sizes)
        )
        tasks += [*wanted, *longitudes()]
    if "trajectories" in parts:
        tasks += [*growths(full), *trajectories(full)]
    if "engines" in parts:
        tasks += engines(full)
    return tuple(tasks)


def check_sizes(sizes: Sequence[float]) -> None:
    """Reject sizes at which no evaluation is judged.

    Raises
    ------
    ValueError
        If there is one.
    """
    for size in sizes:
        if not any(math.isclose(size, known) for known in DECADES):
            raise ValueError(f"{size:g} given, allowed: powers of ten from {min(DECADES):g} to {max(DECADES):g}")


def evaluations(full: bool) -> Iterator[RoundoffTask]:
    """One evaluation in all formulations; fewer where exact arithmetic takes long."""
    few, every = ("relative", "absolute"), ("relative", "minimal", "absolute", "absolute accelerations")
    ours = ("reference",) if ENGINES["reference-fast"].missing else ("reference", "reference-fast")
    ordinary = (StateKind.GENERIC, StateKind.STRAIGHT, StateKind.HORIZONTAL)
    some, short = (DECADES, ALL) if full else (DECADES[::2], SHORT)
    rare = DECADES if full else DECADES[3::3]
    hundreds = (StateKind, DECADES[2:], ALL) if full else (ordinary[:2], DECADES[3::3], ("float64",))
    plan: list[tuple[Iterable[StateKind], int, tuple[float, ...], tuple[str, ...], tuple[str, ...]]] = [
        (StateKind, 5, DECADES, every, ALL),
        (StateKind, 2, some, every, ALL),
        (StateKind, 5, DECADES, ours, ("float64",)),
        (ordinary[:2] if present() else (), 5, DECADES, present(), ("float64",)),
        ((StateKind.STRAIGHT,), 5, some, ("absolute positions", "relative positions"), short),
        (StateKind if full else ordinary, 50, rare, few, short),
        (hundreds[0], 500, hundreds[1], few, hundreds[2]),
    ]
    for kinds, bars, ratios, formulations, arithmetics in plan:
        for kind, ratio in itertools.product(kinds, ratios):
            if bars * ratio <= REACH:
                arguments = (EvaluationCase(kind, bars, ratio), formulations, arithmetics)
                yield RoundoffTask("evaluation", f"{kind}, {bars} bars, {ratio:.0e}", rows_of, arguments)


def longitudes() -> Iterator[RoundoffTask]:
    """Errors by sector of the longitude."""
    for kind in (StateKind.GENERIC, StateKind.STRAIGHT):
        arguments = (EvaluationCase(kind, 5, 1e-5, 256), ("relative", "absolute"), SHORT)
        yield RoundoffTask("longitudes", f"longitudes, {kind}", longitude_rows, arguments)


def trajectories(full: bool) -> list[RoundoffTask]:
    """One orbit, at many steps and tolerances."""
    ratios = DECADES[1::1] if full else (1e-3, 1e-5, 1e-7, 1e-9)
    family = ScaledScene(load_scene(SCENE), ratios, 32)
    finest = {("rk4", "float64"): 13 if full else 9, ("rk4", "float32"): 7, ("dop853", "float64"): 7 if full else 6,
              ("dop853", "float32"): 4}  # fmt: skip
    found = []
    for (method, arithmetic), last in finest.items():
        for name, power in itertools.product(COORDINATES, range(1, last + 1)):
            if method == "rk4" and power > 8 and name != "absolute" and not full:
                continue  # truncation, which is the same in all coordinates, still rules there
            title = f"{name}, {arithmetic}, {method}, {2**power * family.samples} steps"
            arguments = (arithmetic, name, method, 2**power)
            found.append(RoundoffTask("trajectories", title, equal_step_rows, arguments, family))
    exponents = {"float64": range(3, 16, 1 if full else 2), "float32": range(2, 8)}
    for name, (arithmetic, powers) in itertools.product(COORDINATES, exponents.items()):
        rtols = tuple(10.0**-k for k in powers)
        title = f"{name}, {arithmetic}, dop853, own steps"
        found.append(RoundoffTask("trajectories", title, chosen_step_rows, (arithmetic, name, rtols), family))
    return found[::-1]  # the longest first


def growths(full: bool) -> list[RoundoffTask]:
    """Many orbits, at a step where truncation is below round-off."""
    orbits, ratios = (32, (1e-3, 1e-5, 1e-7)) if full else (5, (1e-3, 1e-5))
    family = ScaledScene(load_scene(SCENE), ratios, 32, orbits, 4 * orbits)
    return [
        RoundoffTask(
            "growth", f"{name}, float64, {orbits} orbits", growth_rows, ("float64", name, "dop853", 64), family
        )
        for name in COORDINATES
    ]


def engines(full: bool) -> list[RoundoffTask]:
    """Other engines, in both frames; an engine that is not installed gives a single row with the reason."""
    ratios = DECADES[1:8] if full else (1e-3, 1e-5, 1e-7)
    family = ScaledScene(load_scene(SCENE), ratios, 32, FULL_PART if full else PART)
    found = []
    for name, values in (SWEEPS | FULL_SWEEPS if full else SWEEPS).items():
        runs = [(0, values[0])] if ENGINES[name].missing else itertools.product(range(len(ratios)), values)
        for size, value in runs:
            title = f"{name}, {ratios[size]:.0e}, {value:g}"
            found.append(RoundoffTask("engines", title, engine_rows, (name, size, value), family))
    return found
