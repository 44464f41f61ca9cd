"""Advice for runs that are too long or too coarse: who follows its figures can be judged."""

from __future__ import annotations

import dataclasses
import math
import re
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.reference.numpy_engines import Reference
from barchain import load_scene
from barchain.judge.checks.more_judged import beyond_any_setting, finer, next_sample, until_share
from barchain.judge.error_model import ErrorModel
from barchain.judge.written import Declared
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.reference import at_own_samples, closely_sampled
from tests.support.kernel import needs_kernel

if TYPE_CHECKING:
    from barchain.solutions.reference import ReferenceSolution

COARSE = 1e-4


def fig05(samples: int) -> ReferenceSolution:
    """Certified solution of five bars over five orbits, whose errors grow 5e8 times, at fewer samples."""
    solution = shipped_solution(closely_sampled(load_scene("paper/fig05")))
    assert solution is not None
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
