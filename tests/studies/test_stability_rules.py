"""Outcomes of the stability study: a faulty engine for each one reaches it, and laws of growth are found."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.judge.compare import judge
from barchain.metrics.model_difference import com_displacement, track_response
from barchain.runs.job import Job, Role, RunResult, failure
from barchain.runs.run import run_job
from barchain.solutions.reference import with_perturbed_start
from barchain.studies.stability.evidence import evidence
from barchain.studies.stability.plan import settings
from barchain.studies.stability.rules import EngineRuns, finding, judged_evidence, law, linear_rate
from reports.results.outcome import Outcome
from reports.results.stability import TABLES, Stability
from scenarios import load_scene
from tests.support import faulty_engines, solutions
from tests.support.slow import one_in, rows
from tests.support.stability_engines import (
    FALLS,
    FREE,
    OPENED,
    BlowsUp,
    CanNotFactor,
    Drifts,
    EndsAtOnce,
    Lands,
    Loose,
    RunsAway,
    WillNot,
    WorseWithFiner,
    registration,
    scene,
)

if TYPE_CHECKING:
    from pathlib import Path

    from adapters.trajectory import Array
    from barchain.metrics.model_difference import Displacement
    from tests.support.faulty_engines import Faulty


def seen_of(engine: type[Faulty], name: str) -> EngineRuns:
    """Runs of a faulty engine, made as a worker makes them."""
    own = settings(scene(name), "faulty", engine.declarations())
    jobs = {role: Job(scene(name), "faulty", registration(engine), s, role) for role, s in own.items()}
    runs = {role: run_job(job) for role, job in jobs.items()}
    known, declared = solutions.solution_of(scene(name)), engine.declarations()
    verdicts = {
        role: judge("faulty", declared, own[role], evidence, known) for role, evidence in judged_evidence(runs).items()
    }
    return EngineRuns(scene(name), "faulty", declared, own, runs, known, verdicts=verdicts)


CASES = [
    (faulty_engines.Unmodified, FREE, Stability.STABLE, ""),
    (faulty_engines.Unmodified, FALLS, Stability.STABLE, ""),
    (Drifts, FREE, Stability.DRIFTING, "gap: "),
    (Loose, FREE, Stability.INACCURATE, "times the expected-error bound at t = "),
    (faulty_engines.IgnoresJoints, FREE, Stability.INACCURATE, "joint 1 is open"),
    (BlowsUp, FREE, Stability.UNSTABLE, "kinetic energy"),
    (RunsAway, FALLS, Stability.UNSTABLE, "grew"),
    (WorseWithFiner, FREE, Stability.UNSTABLE, "a finer setting makes the attitude's error 10"),
    (faulty_engines.GivesUp, FREE, Stability.FAILED, "step size became zero"),
    (EndsAtOnce, FREE, Stability.FAILED, "apart from the reference"),
    (faulty_engines.ReturnsNan, FREE, Stability.FAILED, "not finite"),
    (faulty_engines.StopsEarly, FREE, Stability.FAILED, "gave no reason"),
    (WillNot, FREE, Stability.REJECTED, "too light"),
    (CanNotFactor, FREE, Stability.FAILED, "not positive definite"),
    (Lands, FREE, Stability.FAILED, "apart from the reference"),
]


@pytest.mark.parametrize(("engine", "name", "outcome", "words"), one_in(3, rows(CASES)))
def test_each_outcome_is_reached_by_an_engine_made_for_it(
    engine: type[Faulty], name: str, outcome: Stability, words: str, tmp_path: Path
) -> None:
    engine_runs = seen_of(engine, name)
    found = finding(engine_runs)
    assert found.stability is outcome, found
    assert words in found.reason
    assert not found.slow
    rows = evidence(engine_runs)
    assert [r["level"] for r in rows] == ["coarse", "default", "finer"]
    assert set().union(*rows) <= set(TABLES["evidence"].columns)


def test_a_drift_says_how_it_grows() -> None:
    found = finding(seen_of(Drifts, FREE))
    assert found.quantity == "gap"
    assert found.law.exponent == pytest.approx(1.5, abs=0.01)
    assert found.law.at_end == pytest.approx(OPENED, rel=1e-3)


def test_a_time_out_is_a_failure_that_hangs_on_the_machine_and_without_a_truth_nothing_is_stable() -> None:
    engine_runs = seen_of(faulty_engines.Unmodified, FREE)
    late = engine_runs.runs | {Role.FINER: failure(Outcome.TIMED_OUT, "no result within 60 s")}
    found = finding(dataclasses.replace(engine_runs, runs=late))
    assert (found.stability, found.slow) == (Stability.FAILED, True)
    assert found.reason == "no result within 60 s (at its finer setting)"
    assert finding(dataclasses.replace(engine_runs, solution=None)).stability is Stability.FAILED


def test_a_refusal_is_said_while_building_and_nowhere_else() -> None:
    def made(engine: type[Faulty]) -> RunResult:
        job = Job(scene(FREE), "faulty", registration(engine), engine.sweep.setting(), Role.MAIN)
        return run_job(job)

    assert made(WillNot).rejected
    assert not made(CanNotFactor).rejected
    assert not made(faulty_engines.GivesUp).rejected  # an EngineError, but of its steps


def test_a_small_departure_grows_at_the_linear_rate_of_a_pendulum_in_the_tide() -> None:
    found = linear_rate(solutions.solution_of(scene(FALLS)))
    n = scene(FALLS).mean_motion_rad_s
    # the perturbed run differs in angle and rate, and its decaying part e^-√3nt is below 1 % from growth 10 on
    assert found[0] == pytest.approx(np.sqrt(3.0) * n, rel=0.01)


@pytest.mark.slow
def test_a_track_seen_less_than_once_a_radian_is_bounded_and_not_interpolated() -> None:
    long = load_scene("hard/long_1000")

    def displaced(samples: int) -> tuple[Displacement, Array]:
        run = dataclasses.replace(long.run, duration_s=3.0 * long.period_s, samples=samples)
        of = dataclasses.replace(long, run=run)
        engine_runs = solutions.run(of, 1e-10)
        aside = solutions.run(with_perturbed_start(of), 1e-10)
        return com_displacement(of, engine_runs), track_response(of, engine_runs, aside)["com"]

    (close, moved), (far, most) = displaced(301), displaced(4)
    assert not far.vector_m.any()
    assert (np.linalg.norm(close.vector_m[::100], axis=1) <= far.uncertainty_m).all()
    assert (moved[::100] <= most).all()


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_a_law_is_found_from_what_follows_it(exponent: float) -> None:
    t = np.linspace(0.0, 1e6, 2001)
    wobble = 1.0 + 0.05 * np.sin(40.0 * np.log1p(t))
    found = law(t, 1e-9 * wobble * (t / t[-1]) ** exponent)
    assert found.low - 0.03 <= exponent <= found.high + 0.03
    assert found.exponent == pytest.approx(exponent, abs=0.05)


def test_nothing_is_fitted_to_nothing() -> None:
    t = np.linspace(0.0, 1.0, 101)
    assert law(t, np.zeros(101)) is None
    assert law(t[:3], t[:3]) is None
    assert law(t, np.ones(101)).exponent == 0.0
