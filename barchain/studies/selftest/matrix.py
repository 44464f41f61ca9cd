"""The kill matrix: controls and known faults in every scene, and on request the smallest sizes that are detected.

A cell holds the results of all checks on one fault in one scene, and tells whether a fault that none detects changes
anything at all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from adapters.common.reference_model import chain_model
from adapters.engine import EngineError
from adapters.registry import find_own_engine
from barchain.judge.scales import MACHINE_EPSILON, ROUNDINGS
from barchain.judge.verdict import Verdict
from barchain.record.scene_description import scene_words
from barchain.runs.asking import declarations_of
from barchain.runs.cases import run_cases
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import Role
from barchain.solutions.reference_run import NUMPY
from barchain.studies.selftest.faults.catalogue import CONTROLS, FIXED_SCENES, UNMODIFIED, find
from barchain.studies.selftest.faults.fault import FaultGroup
from barchain.studies.selftest.scenes import STAGES, find_scene
from barchain.studies.selftest.trial import SceneRuns, Trial, judged
from reference_impl.model import relative
from reference_impl.model.kinematics import consistent_state
from reports.results.outcome import Outcome
from reports.results.selftest import CAUGHT, FILES, KILLED, MISSED, FaultOutcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from adapters.trajectory import Array
    from barchain.judge.verdict import Row
    from barchain.record.study_store import StudyStore
    from barchain.runs.call import CallFailedError
    from barchain.runs.cases import Case
    from barchain.runs.executors import Executor
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.faults.fault import Fault, Size
    from barchain.studies.selftest.trial import TrialRuns
    from barchain.studies.study import Reporter
    from reports.results.files import StudyFiles
    from scenarios import Scene

    Reading = dict[str, Any]
    Edge = tuple[float | None, str, float | None]

HOST = "reference"
OCTAVES = 44  # below the natural size: 6e-14 of it, with the natural 1 % less than a rounding of the faulty value
CHECKS = {
    "normalised_error": "normalised_error",
    "bound_ratio": "bound",
    "finer_bound_ratio": "bound",
    "restart_ratio": "restarted",
    "own_state_ratio": "own_state",
    "extrapolation_ratio": "extrapolated",
    "drift": "drift",
    "judged_share": "judged_share",
}
"""Metrics that judge, and the names of their checks; `max` is judged as `bound_ratio`"""
COMPARED = ("com_m_s2", "angle_rad_s2", "reaction_N", "torque_N_m")
"""Results of the equations by which a fault is proven invisible"""


class SelftestError(EngineError):
    """Raised where a run fails that the self-test can't go on without."""


@dataclass(frozen=True)
class FaultCell:
    """Outcome of one fault in one scene."""

    fault: Fault
    scene: str
    fate: FaultOutcome
    reason: str
    """Reason why it survives, is invisible or changes nothing"""
    readings: tuple[Reading, ...] = ()
    """Columns of the table of readings: a quantity under a check"""

    @property
    def worst(self) -> Reading | None:
        """Check with the largest ratio, of those that detect the fault if there are any."""
        return max(self.readings, key=lambda r: (bool(r["killed"]), r["quantity"] == "run", r["ratio"]), default=None)

    @property
    def killer(self) -> Reading | None:
        """Check that detects the fault; None if none does."""
        return self.worst if self.fate is FaultOutcome.KILLED else None


@dataclass(frozen=True)
class Matrix:
    """All cells."""

    cells: tuple[FaultCell, ...]

    @property
    def unkilled(self) -> tuple[str, ...]:
        """Names of faults inserted somewhere, detected nowhere, and not proven invisible."""
        killed = {c.fault.name for c in self.cells if c.fate is FaultOutcome.KILLED}
        survives = dict.fromkeys(c.fault.name for c in self.cells if c.fate is FaultOutcome.SURVIVES)
        return tuple(name for name in survives if name in FIXED_SCENES and name not in killed)

    @property
    def wrong(self) -> tuple[FaultCell, ...]:
        """False alarms, and faults that are not inserted as they are meant."""
        return tuple(c for c in self.cells if c.fate in (FaultOutcome.FALSE_ALARM, FaultOutcome.BROKEN))

    @property
    def passed(self) -> bool:
        """Whether every detectable fault is detected, and no unmodified engine is rejected."""
        return not self.unkilled and not self.wrong


@dataclass(frozen=True)
class SelftestStudy:
    """Scenes, faults and their host."""

    scenes: tuple[Scene, ...]
    faults: tuple[Fault, ...]
    host: str = HOST
    smallest: bool = False
    """Whether the smallest detected size of each continuous fault is looked for"""
    executor: Executor = ALL_CORES
    left_out: dict[str, str] = field(default_factory=dict)
    """Scenes that the host does not support, with the reason"""
    files: ClassVar[StudyFiles] = FILES

    def record(self) -> dict[str, Any]:
        """Host, scenes and faults in words."""
        return {
            "host": self.host,
            "roles": [str(Role.MAIN), str(Role.FINER)],
            "scenes": {s.name: scene_words(s) | {"effects": sorted(s.needs)} for s in self.scenes},
            "faults": {
                f.name: {
                    "words": f.words,
                    "stands_for": f.stands_for,
                    "group": str(f.group),
                    "natural": f.size.natural if f.size else None,
                    "none": f.size.none if f.size else None,
                    "unit": f.size.unit if f.size else "",
                    "invisible": f.invisible,
                }
                for f in (*CONTROLS.values(), *self.faults)
            },
        }

    def run(self, store: StudyStore, reporter: Reporter) -> Matrix:
        """Try every fault in every scene; what is there when it is interrupted is kept.

        Raises
        ------
        SelftestError
            If a reference solution or a run of the unmodified engine fails.
        """
        scenes = {scene.name: SceneRuns(scene, NUMPY) for scene in self.scenes}
        with reporter.counted("reference solutions", len(scenes)) as done:
            for _ in run_cases(((name, established(one, self.host)) for name, one in scenes.items()), self.executor):
                done(1)
        chosen = {f.name for f in self.faults}
        names = [*CONTROLS, *(name for name in FIXED_SCENES if name in chosen)]
        trials = [Trial(scene, self.host, name) for name in names for scene in self.scenes]
        cells = dict[int, FaultCell]()
        with reporter.counted("faults", len(trials)) as done:
            cases = ((k, tried(scenes[trial.scene.name], trial)) for k, trial in enumerate(trials))
            try:
                for k, found in run_cases(cases, self.executor):
                    cells[k] = found
                    done(1)
            except KeyboardInterrupt:
                if cells:
                    write_cells(store, cells.values())
                raise
        result = Matrix(tuple(cells[k] for k in range(len(trials))))
        write_cells(store, result.cells)
        store.record.update(passed=result.passed, unkilled=list(result.unkilled))
        if self.smallest:
            store.write_record()
            self.look_for_smallest(result, scenes, store, reporter)
        return result

    def look_for_smallest(
        self, tried_all: Matrix, scenes: dict[str, SceneRuns], store: StudyStore, reporter: Reporter
    ) -> None:
        """Bisect the size of each continuous fault that was inserted, and add the sizes to the rows."""
        sized = [(one, one.fault.size) for one in tried_all.cells if one.fault.size and one.readings]
        most = (math.ceil(math.log2(OCTAVES + 1 + max(1, highest_power(size)))) for _, size in sized)
        with reporter.counted("sizes", sum(most)) as done:

            def edge(one: FaultCell, size: Size) -> Case[Edge]:
                scene = scenes[one.scene]

                def killer(at: float) -> Case[Reading | None]:
                    found = yield from tried(scene, Trial(scene.scene, self.host, one.fault.name, at))
                    done(1)
                    return found.killer

                return detection_edge(size, one.killer, killer)

            edges = dict(run_cases(((k, edge(*pair)) for k, pair in enumerate(sized)), self.executor))
        for k, (one, _) in enumerate(sized):
            caught, quantity, missed = edges[k]
            where: dict[str, Any] = {"scene": one.scene, "engine": self.host, "fault": one.fault.name}
            if caught is not None:
                store.summary.add(CAUGHT, caught, text=quantity, **where)
            if missed is not None:
                store.summary.add(MISSED, missed, **where)


def selftest_study(
    scenes: Iterable[str] = (), faults: Iterable[str] = (), host: str = HOST, **how: Any
) -> SelftestStudy:
    """Self-test on scenes by name or file, eight short ones by default, with faults by name, all by default.

    Further arguments are fields of the study. Faults in the code itself need the reference as host.

    Raises
    ------
    SceneError, UnknownFaultError, UnknownEngineError
        For a scene, a fault or an engine that does not exist.
    ClusterError
        For a Dask cluster that can't be used.
    """
    engine = declarations_of(find_own_engine(host))
    chosen = [find(n, FIXED_SCENES) for n in dict.fromkeys(faults or FIXED_SCENES) if n not in CONTROLS]
    loaded = list(map(find_scene, dict.fromkeys(scenes or STAGES)))
    reasons = {s.name: engine.unsupported(s) for s in loaded}
    able = tuple(s for s in loaded if not reasons[s.name])
    left_out = {name: reason for name, reason in reasons.items() if reason}
    study = SelftestStudy(able, tuple(chosen), host, left_out=left_out, **how)
    study.executor.check()
    return study


def established(scene: SceneRuns, host: str) -> Case[None]:
    """Find a scene's reference solution, and make the runs of the unmodified engine: all faults need them.

    Raises
    ------
    SelftestError
        If a run of either failed.
    """
    solution, *made = yield [scene.solution, *map(scene.run_of, Trial(scene.scene, host).jobs())]
    if isinstance(solution, str):
        raise SelftestError(f"{scene.scene.name}: {solution}")
    for result in made:
        if result.trajectory is None:
            raise SelftestError(f"{host} can't be run on {scene.scene.name}: {result.reason}")


def write_cells(store: StudyStore, cells: Iterable[FaultCell]) -> None:
    """Write the tables of cells; of several readings of a quantity by a check the one that rejects, or the largest."""
    fates, readings = [], []
    for cell in cells:
        named = {"fault": cell.fault.name, "scene": cell.scene}
        fates.append(named | {"fate": str(cell.fate), "why": cell.reason})
        worst: dict[tuple[str, str], Reading] = {}
        for one in (r for r in cell.readings if r["killed"] or np.isfinite(r["ratio"])):
            place = one["quantity"], one["check"]
            worst[place] = max(worst.get(place, one), one, key=lambda r: (bool(r["killed"]), r["ratio"]))
        readings += [named | one for one in worst.values()]
    store.write("fates", fates)
    store.write("readings", readings)


def tried(scene: SceneRuns, trial: Trial) -> Case[FaultCell]:
    """Outcome of a fault, or of a control; its verdict rests on the first runs, and takes no further ones."""
    (solution,) = yield [scene.solution]
    reason = trial.left_out(solution)
    if reason:
        return FaultCell(find(trial.fault), trial.scene.name, FaultOutcome.NOTHING, reason)
    runs = yield from scene.runs_of(trial, solution)
    verdict = yield from judged(runs)
    return cell(runs, verdict)


def cell(runs: TrialRuns, verdict: Verdict | CallFailedError) -> FaultCell:
    """Result of a trial."""
    fault, scene = find(runs.trial.fault), runs.trial.scene.name
    if not isinstance(verdict, Verdict):
        return FaultCell(fault, scene, FaultOutcome.BROKEN, f"no verdict: {verdict}")
    found = tuple(r for row in verdict.rows if (r := reading(row)) is not None)
    return FaultCell(fault, scene, *fate_of(runs, fault, verdict, found), found)


def reading(row: Row) -> Reading | None:
    """Result of one row; None of rows that do not judge.

    The ratio is that of the value found to the allowed one; infinite where a check knows no more or less.
    """
    outcome = Outcome(row["outcome"])
    killed = not outcome.ok or outcome is Outcome.TOO_COARSE
    if row["metric"] == "outcome":
        check, ratio = str(outcome), np.inf if killed else 0.0
    elif row["metric"] not in CHECKS or row["value"] is None:
        return None
    elif row["metric"] == "judged_share":  # a lower bound, and no measure of how near a fault is to its detection
        if not killed:
            return None
        check, ratio = CHECKS[row["metric"]], np.inf
    else:
        value, allowed = float(row["value"]), float(row["tolerance"])
        check, ratio = CHECKS[row["metric"]], 0.0 if value == 0.0 else value / allowed if allowed else np.inf
    said = {"quantity": row["quantity"], "check": check, "ratio": ratio}
    return said | {"killed": KILLED if killed else "", "reason": row["reason"]}


def fate_of(runs: TrialRuns, fault: Fault, verdict: Verdict, found: tuple[Reading, ...]) -> tuple[FaultOutcome, str]:
    """Outcome of a trial, with the reason where no check detects the fault: whether it changes anything."""
    killed = any(r["killed"] for r in found)
    if verdict.outcome is Outcome.FAILED and not fault.expected_failure:
        return FaultOutcome.BROKEN, found[0]["reason"]
    if fault.group is FaultGroup.CONTROL:
        return (FaultOutcome.FALSE_ALARM if killed else FaultOutcome.CLEAN), ""
    if killed:
        return FaultOutcome.KILLED, ""
    near = max(found, key=lambda r: float(r["ratio"]))
    said = (
        f"uses at most {near['ratio']:.2g} of what is allowed ({near['quantity'].replace('_', ' ')}, {near['check']})"
    )
    if not fault.invisible:
        return FaultOutcome.SURVIVES, said
    moved = moved_beyond_rounding(runs.solution, fault, runs.trial.inserted_size)
    if moved > 1.0:
        return FaultOutcome.SURVIVES, f"{said}; not invisible: changes the equations by {moved:.2g} of their rounding"
    return (
        FaultOutcome.INVISIBLE,
        f"{fault.invisible}; measured: at most {moved:.2g} of the equations' own rounding",
    )


def moved_beyond_rounding(solution: ReferenceSolution, fault: Fault, size: float) -> float:
    """Largest change of the equations' results by a fault, over their round-off.

    This is the numerical proof of invisibility, at every state of the reference solution. All that a run shows follows
    from the accelerations, reactions and torques of the states it goes through. Trajectories themselves tell less: the
    first steps are chosen by an error estimate that is nothing but rounding, and two runs whose equations differ in the
    last digit part by what their steps then leave.

    The control's own rounding is what it differs by from the relative formulation, beside a few units in the last
    place of the largest value: sums such as phi'' + omega'' round the parts, which are larger than the sum.
    """
    faulty, control = evaluated(solution, fault, size), evaluated(solution, CONTROLS[fault.like], 0.0)
    unmodified = evaluated(solution, CONTROLS[UNMODIFIED], 0.0)
    shares = [0.0]
    for name, right in control.items():
        allowed = ROUNDINGS * MACHINE_EPSILON * largest(right) + largest(right - unmodified[name])
        apart = largest(faulty[name] - right)
        shares.append(0.0 if apart == 0.0 else apart / allowed)
    return max(shares)


def evaluated(solution: ReferenceSolution, fault: Fault, size: float) -> dict[str, Array]:
    """Results of the equations with a fault in the code, at the reference solution's samples."""
    model, seen = chain_model(solution.scene), solution.trajectory
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    moving = zip(seen.t_s, seen.com_m, seen.com_velocity_m_s, seen.angle_rad, seen.rate_rad_s, strict=True)
    with fault.within(size):
        found = [relative.accelerations(model, t, consistent_state(model, *state)) for t, *state in moving]
    return {name: np.array([getattr(a, name) for a in found]) for name in COMPARED}


def largest(values: Array) -> float:
    """Largest absolute value; 0 for an empty array."""
    return float(np.abs(values).max(initial=0.0))


def highest_power(size: Size) -> int:
    """Largest power of two of a natural size that is tried."""
    if size.most is None:
        return 0
    return max(0, round(math.log2((size.most - size.none) / (size.natural - size.none))))


def detection_edge(size: Size, natural: Reading | None, killer: Callable[[float], Case[Reading | None]]) -> Case[Edge]:
    """Smallest size known to be detected with the quantity that detects it, and largest known to be missed.

    Sizes are the natural one times powers of two, counted from that of no fault. Where the natural one is missed, the
    largest is tried; then the edge is bisected to a factor of two.

    Parameters
    ----------
    size : Size
    natural : Reading or None
        Check that detects the fault at its natural size.
    killer : callable
        Case with the check that detects the fault at a size, or None.
    """
    caught, missed, by = (None, 0, None) if natural is None else (0, None, natural)
    power: int | None = highest_power(size) if natural is None and highest_power(size) else None
    while True:
        if caught is not None:
            low = -OCTAVES - 1 if missed is None else missed
            power = (caught + low) // 2 if caught - low > 1 else None
        if power is None:
            break
        found = yield from killer(size.none + (size.natural - size.none) * 2.0**power)
        if found is None:
            missed, power = power, None
        else:
            caught, by = power, found
    at = [None if k is None else size.none + (size.natural - size.none) * 2.0**k for k in (caught, missed)]
    return at[0], by["quantity"] if by else "", at[1]
