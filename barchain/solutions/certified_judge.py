"""Certified solution of a scene as a judge: error bars, error amplification and dense samples, from heyoka's runs.

The finer run in quadruple precision is the solution; its difference from a looser run bounds its error
(:mod:`barchain.solutions.certified_run`). Two runs from perturbed starts show the error amplification. The first is
perturbed as for a reference solution. In a chaotic scene it parts entirely once errors have grown 1e8 times. The
second is perturbed by 1e-18, below double precision, and stays linear until 1e16 times.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, Setting
from adapters.heyoka.adapter import CLOSE_START, CLOSE_START_RAD
from adapters.registry import ENGINES
from barchain.metrics.model_difference import track_response
from barchain.metrics.quantities import differences
from barchain.metrics.rates import own_rate
from barchain.runs.job import Job, Role
from barchain.solutions.certified_run import CERTIFIED_CHECK_RTOL, CERTIFIED_RTOL, PRECISION, error_bar
from barchain.solutions.certified_table import moved
from barchain.solutions.reference import (
    PERTURBATION_RAD,
    ReferenceSolution,
    SolutionSource,
    amplification_of,
    densely_sampled,
    divergence_instant_s,
    sensitivity,
    with_perturbed_start,
)

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from scenarios import Scene

CERTIFIER = "heyoka-quad"
MOST_RADIANS = 5000.0
"""Largest run for which heyoka makes a judging solution, radians of the fastest rate: some two minutes a run"""
MOST_BARS = 12
"""Largest chain for which heyoka compiles within seconds"""


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
        if name in parted and name not in ("com", "com_velocity"):
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


def with_samples(fine: Trajectory, solution: Trajectory, every: int) -> Trajectory:
    """Dense samples, of which every `every`-th is the solution's own."""
    changed = {}
    for name, values in vars(fine).items():
        if isinstance(values, np.ndarray):
            changed[name] = values.copy()
            changed[name][::every] = getattr(solution, name)
    return fine.replace(**changed)
