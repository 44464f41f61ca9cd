"""Floor of an engine that nobody can look into: how far its results spread where its inputs differ by two ulps.

Every variant has start values and masses two units in the last place away. Most are turned by a small angle and turned
back besides: no physics knows of that angle, and every digit does. The others stay in the scene's own axes: an engine
that rounds its inputs to single precision gives the same numbers there.

The floor of a channel is the largest spread over what the scene amplifies until then, so that chaos is not counted as
round-off. The margin is that of the largest of n absolute errors of one normal distribution: a further error exceeds
margin times the largest with a probability of 1e-6.
"""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from scipy.optimize import brentq
from scipy.special import erf, erfc

from barchain.judge.evidence import turned, turned_back
from barchain.judge.noise_to_declare import ROUNDINGS
from barchain.judge.scales import MAX_NOISE_SHARE, kepler_growth, scales
from barchain.metrics.quantities import TRACK, differences
from barchain.runs.asking import declarations_of
from barchain.runs.cases import Case, Known, Shared, Task
from barchain.runs.choices import choose_setting
from barchain.runs.job import TIME_LIMIT_S, Job, Role
from barchain.runs.left_out import cannot
from barchain.runs.tasks import limit_of, run_task
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.judging import SolutionFailedError, solution_case
from barchain.solutions.reference import PERTURBATION_RAD
from barchain.studies.roundoff.evaluation import quantiles
from reports.results.comparison import PARTED_RAD
from reports.results.outcome import Outcome
from scenarios.channels import WORDS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from adapters.engine import Coordinates
    from adapters.registry import Registration
    from adapters.trajectory import Array, Trajectory
    from barchain.runs.job import RunResult
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

    Rows = list[dict[str, Any]]

REPEATS, SAME_AXES, TURNED = 2, 8, 24
"""Runs of the scene itself again; variants in its own axes; variants in turned axes, whose spread counts"""
SEED, ULPS = 14, 2.0
TURN_RAD = 2e-5
"""Largest turn: some hundred units in the last place of single precision"""
CHANCE = 1e-6
"""Of a further run beyond the tolerance"""
UNIT_ROUNDOFF = {"double": 2.0**-53, "single": 2.0**-24}
LEAST_ROUNDINGS = 0.25
NOT_TOLD = "not told"
MOST_AMPLIFIED = PARTED_RAD / PERTURBATION_RAD
"""Largest amplification that counts: the perturbed run of a solution in double precision shows no larger one"""
FEWEST = 12
"""Variants in turned axes that must have come to their end"""
INSTANTS = 60
"""Of the spread over time"""


@dataclass(frozen=True)
class Variant:
    """The scene again, or one of its variants."""

    scene: Scene
    turn_rad: float = 0.0
    """Of its axes; 0 in the scene's own"""
    repetition: int = 0
    """From 1 for the scene again, without a change"""


def variants(scene: Scene) -> list[Variant]:
    """The scene again, its variants in its own axes, and those in turned axes; the same in every study."""
    found = [Variant(scene, repetition=k + 1) for k in range(REPEATS)]
    for k in range(SAME_AXES + TURNED):
        rng = np.random.default_rng([SEED, k])
        other = two_ulps_away(scene, rng)
        turn_rad = float(TURN_RAD * rng.choice((-1.0, 1.0)) * rng.uniform(0.5, 1.0))
        found.append(Variant(other) if k < SAME_AXES else Variant(turned(other, turn_rad), turn_rad))
    return found


def two_ulps_away(scene: Scene, rng: np.random.Generator) -> Scene:
    """`scene` with masses, angles, rates, height and speed of the start two units in the last place away.

    Angles and rates are sums of numbers of the order of 1, whose units count for smaller ones too.
    """

    def moved(values: Sequence[float], least: float = 0.0) -> tuple[float, ...]:
        signs = rng.choice((-1.0, 1.0), len(values))
        return tuple(float(v + s * ULPS * np.spacing(max(abs(v), least))) for v, s in zip(values, signs, strict=True))

    chain, orbit = scene.chain, scene.orbit
    (altitude_m,) = moved([orbit.altitude_m], scene.radius0_m)
    (speed_factor,) = moved([orbit.speed_factor])
    chain = dataclasses.replace(
        chain, mass_kg=moved(chain.mass_kg), angle_rad=moved(chain.angle_rad, 1.0),
        rate_factor=moved(chain.rate_factor, 1.0),
    )  # fmt: skip
    orbit = dataclasses.replace(orbit, altitude_m=altitude_m, speed_factor=speed_factor)
    return dataclasses.replace(scene, chain=chain, orbit=orbit)


def margin(runs: int, chance: float = CHANCE) -> float:
    """Factor over the largest of some absolute normal errors that a further one exceeds with a probability."""
    x, step = np.linspace(0.0, 12.0, 24_001, retstep=True)
    largest = runs * erf(x / np.sqrt(2.0)) ** (runs - 1) * np.sqrt(2.0 / np.pi) * np.exp(-0.5 * x * x)
    return float(brentq(lambda k: float((erfc(k * x / np.sqrt(2.0)) * largest).sum() * step) - chance, 0.5, 1e3))


def floor_rows(
    solution: ReferenceSolution, coordinates: Coordinates, main: Trajectory, runs: Sequence[tuple[Variant, Trajectory]]
) -> Rows:
    """Rows of the tables `floors` and `spread` of an engine, each with its table, from all runs that came to their end.

    `solution` tells what the scene amplifies.
    """
    apart = [differences(main, turned_back(run, v.turn_rad)) for v, run in runs if v.turn_rad]
    again = [differences(main, run) for v, run in runs if v.repetition]
    same = [differences(main, run) for v, run in runs if not v.turn_rad and not v.repetition]
    n = min(len(solution.amplification), *(len(d["com"]) for d in (*apart, *again)))
    t_s, size, factor, rows = main.t_s[:n], scales(solution), margin(len(apart)), list[dict[str, Any]]()
    kept = solution.amplification[:n] <= MOST_AMPLIFIED
    for quantity in apart[0]:
        grown = kepler_growth(solution.scene, t_s) if quantity in TRACK else solution.amplification[:n]
        each = np.array([d[quantity][:n] for d in apart])
        repeats = max((float((d[quantity][:n] / grown)[kept].max()) for d in again), default=0.0)
        own = quantiles((each / grown)[:, kept].max(axis=1))
        floor, whole = max(own["largest"], repeats), factor * float(each.max())
        if whole > MAX_NOISE_SHARE * size[quantity]:
            whole = np.nan  # the variants part
        rows.append({"table": "floors", "quantity": quantity, "repeats": repeats} | own | {
            "floor": floor, "tolerance": factor * floor, "rtol": factor * floor / size[quantity],
            "run_tolerance": whole, "run_rtol": whole / size[quantity], "scale": size[quantity],
        })  # fmt: skip
        for k in np.unique(np.linspace(1, n - 1, INSTANTS).astype(int)):
            at = {"orbits": float(t_s[k] / solution.scene.period_s), "grown": float(grown[k])}
            rows.append({"table": "spread", "quantity": quantity} | at | quantiles(each[:, k]))
    floors = {row["quantity"]: row for row in rows if row["table"] == "floors"}
    kind, reason = told(solution, coordinates, floors, same)
    return [row | {"class": kind, "reason": reason} for row in rows]


def told(
    solution: ReferenceSolution, coordinates: Coordinates, floors: dict[str, Any], same: list[dict[str, Array]]
) -> tuple[str, str]:
    """Class of precision and its reason, from rows by channel and from variants in the scene's own axes.

    In absolute coordinates differences of positions lose digits, so that the track tells, which is none; else the
    angles do. The median tells: a step that is chosen otherwise makes a large spread now and then.
    """
    quantity = "com" if coordinates.absolute or "attitude" not in floors else "attitude"
    row, angle = floors[quantity], solution.trajectory.angle_rad
    share = row["median"] / row["scale"]
    turns = 1.0 if quantity == "com" or angle is None else max(1.0, float(np.abs(angle).max()))
    silent = sum(not d[quantity][1:].any() for d in same)  # an adapter may take the start from its inputs
    kind, reason = precision_class(share, silent, len(same), turns)
    if row["floor"] > margin(int(row["members"])) * row["q95"]:
        reason += f"; a few variants spread {row['floor'] / row['median']:.0f} times as far, by other steps"
    return kind, f"over what the scene amplifies, {WORDS[quantity]} spread by {share:.2g} of their size, {reason}"


def precision_class(share: float, silent: int, tried: int, largest: float = 1.0) -> tuple[str, str]:
    """Class of precision of a spread relative to a quantity's size, and the reason.

    Up to :data:`~barchain.judge.noise_to_declare.ROUNDINGS` roundings of one sign add up in a run; `largest` is the
    largest value over that size, as angles of many turns are rounded to their own last digit. An iteration that
    stops early leaves as much as single precision does, but tells inputs apart that differ by two ulps of a double:
    `silent` of the variants that were tried give the same numbers.
    """
    for kind, unit in UNIT_ROUNDOFF.items():
        if LEAST_ROUNDINGS * unit <= share <= ROUNDINGS * unit * largest:
            reason = f"{max(1.0, share / unit):.0f} roundings of a {kind}"
            if kind == "double":
                return kind, reason
            if 2 * silent > tried:
                return kind, f"{reason}; {silent} of {tried} inputs two ulps of a double away give the same numbers"
            return NOT_TOLD, f"{reason}, or an iteration that stops there: inputs two ulps of a double away count"
    return NOT_TOLD, f"neither up to {ROUNDINGS:g} roundings of a double nor of a single"


@dataclass(frozen=True)
class FloorTask:
    """Floor of one engine in one scene."""

    title: str
    job: Job
    """Run of the scene"""
    solution: Shared | Known
    """What the scene amplifies; a text is the reason why that is not known"""
    table: ClassVar[str] = "floors"

    def case(self, note: Callable[[str], None]) -> Case[Rows | str]:
        """Rows, or why there are none; an engine that does not do the scene itself is asked for nothing more."""
        wanted, number = variants(self.job.scene), itertools.count(1)

        def told_of(_: RunResult) -> None:
            note(f"{self.title}: {next(number)} of {len(wanted)} variants")

        main, known = yield [run_of(self.job), self.solution]
        if main.trajectory is None or main.outcome is not Outcome.PASS:
            return f"{main.outcome}: {main.reason}"
        if isinstance(known, str):
            return known
        made = yield [run_of(dataclasses.replace(self.job, scene=v.scene), v.repetition, told_of) for v in wanted]
        pairs = zip(wanted, made, strict=True)
        runs = [(v, run.trajectory) for v, run in pairs if run.outcome is Outcome.PASS and run.trajectory is not None]
        bad = [f"{run.outcome}: {run.reason}" for run in made if run.outcome is not Outcome.PASS]
        said = f"{len(bad)} of {1 + len(made)} runs {bad[0]}" if bad else ""
        if sum(v.turn_rad != 0.0 for v, _ in runs) < FEWEST:
            return said
        head = {"scene": self.job.scene.name, "engine": self.job.engine, "setting": str(self.job.setting)}
        coordinates = declarations_of(self.job.registration).coordinates
        rows = floor_rows(known, coordinates, main.trajectory, runs)
        return [row | head | {"reason": "; ".join(filter(None, [row["reason"], said]))} for row in rows]


def run_of(job: Job, repetition: int = 0, kept: Callable[[RunResult], None] | None = None) -> Task:
    """Run within the usual time."""
    return run_task(job, limit_of(job, TIME_LIMIT_S), kept=kept, repetition=repetition)


def solution_of(scene: Scene) -> Case[ReferenceSolution | str]:
    """Solution that tells what a scene amplifies, or why there is none."""
    try:
        return (yield from solution_case(scene, run_of))
    except SolutionFailedError as error:
        return f"the reference solution could not be run ({error})"


def floor_tasks(
    scenes: Iterable[Scene], engines: dict[str, Registration], settings: Mapping[str, Mapping[str, float]]
) -> tuple[list[FloorTask], dict[str, str]]:
    """Tasks of all pairs of a scene and an engine that supports it, and the others with their reasons."""
    tasks, left_out = [], {}
    chosen = {name: choose_setting(name, settings.get(name, {}), engines) for name in engines}
    for scene in scenes:
        shipped = shipped_solution(scene)
        solution = Shared(solution_of(scene)) if shipped is None else Known(shipped)
        for name, registration in engines.items():
            out = cannot(scene, name, registration)
            if out is None:
                job = Job(scene, name, registration, chosen[name], Role.MAIN)
                tasks.append(FloorTask(f"{scene.name}, {name}", job, solution))
            else:
                left_out[f"{name} in {scene.name}"] = out.reason
    return tasks, left_out
