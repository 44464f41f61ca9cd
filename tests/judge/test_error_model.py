"""What an error model knows of an engine, and its advice for runs that are too long or too coarse."""

import dataclasses
import math
import pickle
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Coordinates, Setting
from adapters.reference.numpy_engines import Reference
from barchain.judge.checks.more_judged import beyond_any_setting, finer, next_sample, until_share
from barchain.judge.error_model import ErrorModel
from barchain.judge.local_errors import requested_errors, truncation_errors
from barchain.judge.written import Declared
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.reference import ReferenceSolution, at_own_samples, closely_sampled
from scenarios import load_scene
from tests.support.kernel import needs_kernel
from tests.support.solutions import run, solution_of

SETTING = Setting(AccuracyParameter.RTOL, 1e-8)


@pytest.fixture(scope="module")
def solution() -> ReferenceSolution:
    scene = load_scene("paper/fig15")
    scene = dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=0.1 * scene.period_s, samples=21))
    return solution_of(scene)


def test_a_model_goes_to_another_process_and_keeps_its_numbers(solution: ReferenceSolution) -> None:
    errors = ErrorModel(Reference.declarations(), SETTING, solution, run(solution.scene, 1e-8))
    floor = errors.floor["attitude"]
    there = pickle.loads(pickle.dumps(errors))
    assert (there.floor["attitude"] == floor).all()


def test_joint_coordinates_in_absolute_places_have_the_errors_of_angles_and_the_roundings_of_the_radius(
    solution: ReferenceSolution,
) -> None:
    """The centre of mass follows from the angles, and shares their errors; a place rounds as its distance does."""
    scene, made = solution.scene, Reference.declarations()
    equal = Setting(AccuracyParameter.STEPS_PER_ORBIT, 2000.0)

    def model(coordinates: Coordinates) -> ErrorModel:
        return ErrorModel(
            dataclasses.replace(made, coordinates=coordinates), SETTING, solution, run(scene, SETTING.value)
        )

    both, joints, places = map(model, (Coordinates.ABSOLUTE_JOINT, Coordinates.JOINT, Coordinates.ABSOLUTE))
    assert both.place_m == places.place_m == scene.radius0_m
    assert both.rounding_rad == places.rounding_rad > 1e3 * joints.rounding_rad
    asked = [requested_errors(each.engine, SETTING, solution, 0.0).com_rate for each in (both, joints, places)]
    assert (asked[0] == asked[1]).all()
    assert (asked[0] > asked[2]).all()
    stepped = dataclasses.replace(both.engine, order=4.0), dataclasses.replace(places.engine, order=4.0)
    shared, alone = (truncation_errors(each, equal, solution) for each in stepped)
    assert (shared.attitude_rate == alone.attitude_rate).all()
    assert (shared.com_rate > alone.com_rate).all()


COARSE = 1e-4


def fig05(samples: int) -> ReferenceSolution:
    """Certified solution of five bars over five orbits, whose errors grow 5e8 times, at fewer samples."""
    solution = shipped_solution(closely_sampled(load_scene("paper/fig05")))
    run = dataclasses.replace(solution.scene.run, samples=samples)
    return at_own_samples(solution, dataclasses.replace(solution.scene, run=run))


def model(samples: int, rtol: float) -> ErrorModel:
    """Error model of the reference at a request."""
    solution = fig05(samples)
    return ErrorModel(Reference, Setting(AccuracyParameter.RTOL, rtol), solution, solution.trajectory)


@needs_kernel
def test_who_follows_the_advice_on_samples_or_on_the_request_can_predict_the_next_sample() -> None:
    said = next_sample(model(6, COARSE))
    more = re.search(r"at least (\d+) samples", said)
    request = re.search(r"rtol=(\S+)", said.partition("what would help")[2])
    assert more or request
    if more:
        enough = next(n for n in (11, 21, 26, 51, 101, 126, 251, 501) if n >= int(more[1]))
        assert next_sample(model(enough, COARSE)) == ""
    if request:
        assert next_sample(model(6, float(request[1]))) == ""


@needs_kernel
def test_samples_that_the_judging_solution_itself_can_not_predict_are_beyond_any_setting() -> None:
    right = fig05(6)
    assert beyond_any_setting(right) == ""
    assert "samples" in beyond_any_setting(dataclasses.replace(right, limit_s=0.0))


def growing(**members: Any) -> Any:
    """Errors that grow a hundredfold in each of ten intervals of 10 s."""
    t_s = np.linspace(0.0, 100.0, 11)
    setting = Setting(AccuracyParameter.STEPS_PER_ORBIT, 1000)
    made = {"t_s": t_s, "amplification": 100.0 ** (t_s / 10.0), "setting": setting, "engine": SimpleNamespace(order=2),
            "attitude_rad": 1e-5 * 100.0 ** (t_s / 10.0)}  # fmt: skip
    return SimpleNamespace(**made | members)


def test_a_run_as_short_as_the_judged_part_asks_for() -> None:
    """A twentieth of 100 s is a tenth of 50 s."""
    assert "a run of at most 50 s" in until_share(growing(), 10.0, 0.05, 0.1)
    assert until_share(growing(), 0.0, 0.0, 0.1) == ""


@pytest.mark.parametrize("ratio", [4.0, 100.0])
def test_steps_and_requests_are_as_much_finer_as_errors_have_to_fall(ratio: float) -> None:
    (said,) = finer(growing(), ratio)
    assert math.sqrt(ratio) <= float(said.partition("=")[2]) / 1000.0 < 2.0 * math.sqrt(ratio)
    (said,) = finer(growing(setting=Setting(AccuracyParameter.RTOL, 1e-9)), ratio)
    assert 1.0 <= 1e-9 / float(said.partition("=")[2]) / ratio < 3.0
    (said,) = finer(growing(setting=Declared().setting), ratio)
    assert "two files" in said
