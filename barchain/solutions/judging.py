"""Solution that judges a scene: its runs, and the solution from their results.

It is the certified solution that comes with barchain, else the reference's, or on request one that heyoka makes here in
quadruple precision. Of heyoka's runs the one at the tightest tolerance is the solution; its difference from a looser
run bounds its error. The runs differ in tolerance and not in precision; docs/explanation/certified_solutions.md gives
the reasons. Two runs from perturbed starts show the error amplification. The first is perturbed as for a reference
solution. In a chaotic scene it parts entirely once errors have grown 1e8 times. The second is perturbed by 1e-18, below
double precision, and stays linear until 1e16 times.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, Setting
from adapters.heyoka import CLOSE_START, CLOSE_START_RAD
from adapters.reference import CLOSE_START_RAD as WIDE_CLOSE_START_RAD
from adapters.registry import COMPILED, ENGINES, WIDE
from barchain.metrics.model_difference import track_response
from barchain.metrics.quantities import TRACK, differences, largest, own_rate
from barchain.runs.estimate import estimated_run_s
from barchain.runs.job import CERTIFIED_ROLES, SOLUTION_ROLES, Job, Role, RunResult
from barchain.solutions.certified_file import moved
from barchain.solutions.reference import (
    FINE_RTOL,
    PERTURBATION_RAD,
    ROUNDED,
    SOLUTION_CHECK_RTOL,
    SOLUTION_RTOL,
    UNIT_ROUNDOFF,
    WIDE_CHECK_RTOL,
    WIDE_RTOL,
    ReferenceSolution,
    SolutionSource,
    amplification_of,
    densely_sampled,
    divergence_instant_s,
    establish,
    sensitivity,
    with_perturbed_start,
)
from barchain.solutions.reference_run import NUMPY, solution_engine
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from adapters.registry import Registration
    from adapters.trajectory import Array, Trajectory
    from barchain.runs.cases import Case, Task
    from scenarios import Scene

CERTIFIED_RTOL, CERTIFIED_CHECK_RTOL = 1e-30, 1e-28
PRECISION = f"real128, tolerance {CERTIFIED_RTOL:g}, against real128, tolerance {CERTIFIED_CHECK_RTOL:g}"
MOST_WIDE_BARS, MOST_BAR_SECONDS = 24, 0.1
"""Size of a scene up to which runs in extended precision take seconds: bars, and bars times the estimated seconds of a
run in double precision (measured: 0.3 to 3 s where the product is 0.002 to 0.04)"""
CERTIFIER = "heyoka-quad"
MOST_RADIANS = 5000.0
"""Largest run for which heyoka makes a judging solution, radians of the fastest rate: some two minutes a run"""
MOST_BARS = 12
"""Largest chain for which heyoka compiles within seconds"""
WORDS = {
    SolutionSource.SHIPPED: "certified solution that comes with barchain",
    SolutionSource.HEYOKA: "certified solution, run for this comparison",
    SolutionSource.REFERENCE: "reference solution, run for this comparison",
}
"""Origin of a judging solution in words"""
HEYOKA = "adapters.heyoka."


class SolutionFailedError(RuntimeError):
    """A run for a scene's reference solution failed; the message gives the reason in one line."""


def judging_engine(scene: Scene) -> str:
    """Engine of a scene's reference solution: extended precision where its runs take seconds."""
    if solution_engine() == NUMPY or scene.bars > MOST_WIDE_BARS or ENGINES[WIDE].declarations().unsupported(scene):
        return solution_engine()
    return WIDE if scene.bars * estimated_run_s(scene) < MOST_BAR_SECONDS else COMPILED


def solution_jobs(scene: Scene, engine: str | None = None) -> list[Job]:
    """Runs of the reference for a scene's reference solution.

    Parameters
    ----------
    scene : Scene
    engine : str, optional
        Form of the reference; that of :func:`judging_engine` by default.
    """
    name = engine or judging_engine(scene)

    def job(of: Scene, rtol: float, role: Role, form: str = name, options: tuple[str, ...] = ()) -> Job:
        return Job(of, form, ENGINES[form], Setting(AccuracyParameter.RTOL, rtol), role, options)

    if name == WIDE:
        return [
            job(scene, WIDE_RTOL, Role.SOLUTION, options=("judging",)),
            job(scene, WIDE_CHECK_RTOL, Role.SOLUTION_CHECK, options=("judging",)),
            job(with_perturbed_start(scene), WIDE_CHECK_RTOL, Role.PERTURBED_START, options=("judging",)),
            job(densely_sampled(scene), FINE_RTOL, Role.FINE, COMPILED),
            job(scene, WIDE_RTOL, Role.CLOSE_START, options=("judging", "close_start")),
        ]
    return [
        job(scene, SOLUTION_RTOL, Role.SOLUTION),
        job(scene, SOLUTION_CHECK_RTOL, Role.SOLUTION_CHECK),
        job(with_perturbed_start(scene), SOLUTION_RTOL, Role.PERTURBED_START),
        job(densely_sampled(scene), FINE_RTOL, Role.FINE),
    ]


def solution_of(scene: Scene, runs: Mapping[Role, RunResult], engine: str | None = None) -> ReferenceSolution:
    """Reference solution of a scene from the runs of :func:`solution_jobs`.

    Raises
    ------
    SolutionFailedError
        If one failed.
    """
    wide = (engine or judging_engine(scene)) == WIDE
    seen = completed(runs, (*SOLUTION_ROLES, Role.CLOSE_START) if wide else SOLUTION_ROLES)
    return establish(scene, *seen, close_rad=WIDE_CLOSE_START_RAD)


def completed(runs: Mapping[Role, RunResult], roles: Sequence[Role]) -> list[Trajectory]:
    """Trajectories of all roles in their order.

    Raises
    ------
    SolutionFailedError
        If one of the runs failed.
    """
    failed = [runs[role].reason for role in roles if runs[role].outcome is not Outcome.PASS]
    if failed:  # usually for the same reason, which is then given once
        raise SolutionFailedError("; ".join(dict.fromkeys(failed)))
    seen = [runs[role].trajectory for role in roles]
    return [t for t in seen if t is not None]


def certified_jobs(scene: Scene) -> list[Job]:
    """Runs of heyoka for the certified solution of a scene at its own samples."""

    def job(of: Scene, rtol: float, role: Role, *options: str) -> Job:
        setting = Setting(AccuracyParameter.RTOL, rtol)
        return Job(of, CERTIFIER, ENGINES[CERTIFIER], setting, role, options)

    return [
        job(densely_sampled(scene), CERTIFIED_RTOL, Role.FINE),
        job(scene, CERTIFIED_CHECK_RTOL, Role.SOLUTION_CHECK),
        job(with_perturbed_start(scene), CERTIFIED_CHECK_RTOL, Role.PERTURBED_START),
        job(scene, CERTIFIED_CHECK_RTOL, Role.CLOSE_START, CLOSE_START),
    ]


def affordable(scene: Scene) -> bool:
    """Whether quadruple precision takes minutes at most on a scene, by its number of bars and its fastest rate."""
    turned = scene.run.duration_s * max(own_rate(scene), abs(scene.spring_rate_rad_s))
    return scene.bars <= MOST_BARS and turned <= MOST_RADIANS


def establish_certified(
    scene: Scene, fine: Trajectory, check: Trajectory, perturbed: Trajectory, close: Trajectory
) -> ReferenceSolution:
    """Certified solution of a scene from its runs of heyoka.

    Parameters
    ----------
    scene : Scene
    fine : Trajectory
        At the tightest tolerance and the samples of :func:`densely_sampled`.
    check : Trajectory
        At a looser tolerance.
    perturbed : Trajectory
        From the start of :func:`with_perturbed_start`.
    close : Trajectory
        From a start perturbed by :data:`CLOSE_START_RAD`.
    """
    every = (densely_sampled(scene).run.samples - 1) // (scene.run.samples - 1)
    own = fine.samples(slice(None, None, every))
    t_s = scene.times_s[: len(own.t_s)]  # dense instants differ from them in their last bits
    solution, _ = moved(scene, own, {}, t_s, t_s - own.t_s)
    _, error = moved(scene, own, error_bar(solution, check), t_s, t_s - own.t_s)
    parted = differences(solution, perturbed)
    n = min(len(x.t_s) for x in (solution, check, perturbed, close))
    response = sensitivity(parted | track_response(scene, solution, perturbed), n, 0.0)
    for name, other in sensitivity(differences(solution, close), n, PERTURBATION_RAD).items():
        if name in parted and name not in TRACK:
            response[name] = np.maximum(response[name], other)  # another direction, once it exceeds round-off
    return ReferenceSolution(
        scene,
        solution,
        with_samples(fine, solution, every),
        {name: bar[:n] for name, bar in error.items()},
        amplification_of(solution, perturbed, close, float(CLOSE_START_RAD))[:n],
        response,
        divergence_instant_s(solution, check),
        SolutionSource.HEYOKA,
        PRECISION,
    )


def error_bar(fine: Trajectory, check: Trajectory) -> dict[str, Array]:
    """Bound of the error of `fine`, (n,) for each quantity, never falling.

    The looser run's error is at least the difference of the runs less the finer run's error, which is far smaller.
    The difference therefore bounds the finer run's error. Rounding of both runs to double is added.
    """
    apart = differences(fine, check)
    rounding = {name: ROUNDED * UNIT_ROUNDOFF * size for name, size in largest(fine).items()}
    return {name: np.maximum.accumulate(d) + rounding[name][: len(d)] for name, d in apart.items()}


def with_samples(fine: Trajectory, solution: Trajectory, every: int) -> Trajectory:
    """Dense samples, of which every `every`-th is the solution's own."""
    changed = {}
    for name, values in vars(fine).items():
        if isinstance(values, np.ndarray):
            changed[name] = values.copy()
            changed[name][::every] = getattr(solution, name)
    return fine.replace(**changed)


def why_not_certified(scene: Scene) -> str:
    """Reason why no certified solution of a scene can be made here; empty if it can."""
    certifier = ENGINES[CERTIFIER]
    if certifier.missing:
        return certifier.missing
    if not affordable(scene):
        return f"{CERTIFIER} would take too long, allowed: {MOST_BARS} bars, {MOST_RADIANS:g} rad of the fastest rate"
    return certifier.declarations().unsupported(scene) or ""


def judging_jobs(scene: Scene, source: SolutionSource, engine: str | None = None) -> list[Job]:
    """Runs for a solution that has to be made."""
    return certified_jobs(scene) if source is SolutionSource.HEYOKA else solution_jobs(scene, engine)


def solution_case(
    scene: Scene,
    run: Callable[[Job], Task],
    source: SolutionSource = SolutionSource.REFERENCE,
    engine: str | None = None,
) -> Case[ReferenceSolution]:
    """Solution that judges a scene, as a case that makes its runs.

    Parameters
    ----------
    scene : Scene
    run : callable
        Task of a run.
    source : SolutionSource
        Kind of solution to be made.
    engine : str, optional
        Form of the reference, as for :func:`solution_jobs`.

    Raises
    ------
    SolutionFailedError
        If a run failed.
    """
    jobs = judging_jobs(scene, source, engine)
    made = yield [run(job) for job in jobs]
    runs = dict(zip((job.role for job in jobs), made, strict=True))
    if source is SolutionSource.HEYOKA:
        return establish_certified(scene, *completed(runs, CERTIFIED_ROLES))
    return solution_of(scene, runs, engine)


def shares_equations(registration: Registration, source: SolutionSource) -> bool:
    """Whether an engine steps the equations that the judging solution was made with: agreement shows its arithmetic."""
    return registration.target.startswith(HEYOKA) if source.certified else registration.ours
