"""The track of an engine that follows a particle is judged to the end of a chaotic scene."""

import dataclasses

import numpy as np
import pytest

from adapters.common.equal_steps import finer_setting
from adapters.rebound.adapter import Rebound
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.metrics.model_difference import com_displacement
from barchain.runs.job import RunResult
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.reference import closely_sampled
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.judge.trust_cases import value
from tests.support.solutions import solution_of

pytest.importorskip("rebound")
SCENE = load_scene("paper/fig05")


def test_the_departure_of_five_chaotic_bars_from_a_particle_is_seen_in_the_track():
    """56 mm in an orbit: a particle has no attitude that could part from the solution's, which is exact to the end."""
    solution, setting = shipped_solution(SCENE), Rebound.sweep.setting()
    scene = solution.scene
    runs = [Rebound().run(scene, each) for each in (setting, finer_setting(scene, Rebound.sweep, setting))]

    def verdict(moved_m):
        moved = (RunResult(Outcome.PASS, trajectory=run.replace(com_m=run.com_m + moved_m)) for run in runs)
        return judge("rebound", Rebound, setting, Evidence(*moved), solution)

    departure = com_displacement(scene, solution.trajectory).vector_m
    right = verdict(0.0)
    assert right.outcome is Outcome.PASS
    assert value(right, "com", "detection_limit") * np.linalg.norm(solution.trajectory.com_m[0]) < 1e-3
    assert np.linalg.norm(departure, axis=1).max() > 0.05
    assert verdict(departure).outcome is Outcome.INCONSISTENT


def judged_alone(scene, solution):
    setting = Rebound.sweep.setting()
    runs = [Rebound().run(scene, each) for each in (setting, finer_setting(scene, Rebound.sweep, setting))]
    return judge(
        "rebound", Rebound, setting, Evidence(*(RunResult(Outcome.PASS, trajectory=r) for r in runs)), solution
    )


def test_a_particle_that_falls_to_the_surface_is_judged():
    solution = solution_of(closely_sampled(load_scene("hard/vertical_fall")))
    assert judged_alone(solution.scene, solution).outcome is Outcome.PASS


def test_a_solution_that_has_lost_the_attitude_leaves_the_track_no_more_room_than_any_attitude_does():
    """Errors of many radians stand behind the limit of a solution that is no certified one."""
    solution = shipped_solution(SCENE)
    half_s = 0.5 * solution.limit_s
    lost = np.where(solution.trajectory.t_s > half_s, 80.0, solution.error["attitude"])
    vague = dataclasses.replace(solution, error=solution.error | {"attitude": lost}, limit_s=half_s)
    unsure = dataclasses.replace(solution, limit_s=half_s)
    limits = [value(judged_alone(s.scene, s), "com", "detection_limit") for s in (vague, unsure)]
    assert limits[0] == pytest.approx(limits[1], rel=1e-6)


def test_the_prediction_knows_the_attitude_no_better_than_the_judging_solution():
    solution = shipped_solution(SCENE)
    vague = {name: np.full_like(error, 0.1) for name, error in solution.error.items()}
    setting = Rebound.sweep.setting()
    run = Rebound().run(solution.scene, setting)
    evidence = Evidence(*(RunResult(Outcome.PASS, trajectory=run) for _ in range(2)))
    sharp = judge("rebound", Rebound, setting, evidence, solution)
    blunt = judge("rebound", Rebound, setting, evidence, dataclasses.replace(solution, error=vague))
    assert value(blunt, "com", "detection_limit") > 1e3 * value(sharp, "com", "detection_limit")
