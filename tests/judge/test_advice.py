"""Advice for runs that are too long or too coarse: its figures make more of a run predictable."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from barchain.judge.advice import after_restarts, until_next_sample, until_share

STEPS = Setting(AccuracyParameter.STEPS_PER_ORBIT, 1000)


def model(**members: Any) -> Any:
    """Errors that grow a hundredfold in each of ten intervals of 10 s."""
    t_s = np.linspace(0.0, 100.0, 11)
    growth = 100.0 ** (t_s / 10.0)
    run = SimpleNamespace(duration_s=100.0, samples=11)
    return SimpleNamespace(**{
        "t_s": t_s, "amplification": growth, "attitude_rad": 1e-3 * growth, "floor_rad": 1e-12 * growth,
        "scene": SimpleNamespace(run=run), "setting": STEPS, "engine": SimpleNamespace(order=2.0),
        "local": SimpleNamespace(immediate={"rate": np.full(11, 1e-3)}),
    } | members)  # fmt: skip


def test_samples_and_steps_that_predict_the_next_sample() -> None:
    """1e-3 rad grows to 1e-2 rad in half an interval; at a tenth of 0.1 rad the whole interval is predicted."""
    assert until_next_sample(model()) == "; what would help: at least 21 samples, or steps_per_orbit=3.2e+03"


def test_a_request_falls_as_the_error() -> None:
    asked = until_next_sample(model(setting=Setting(AccuracyParameter.RTOL, 1e-9), engine=SimpleNamespace(order=None)))
    assert asked.endswith("or rtol=1e-10")


def test_no_setting_helps_against_round_off_or_samples_beyond_any_setting() -> None:
    right = model()
    assert "steps" not in until_next_sample(model(floor_rad=right.attitude_rad))
    assert "no setting predicts so far" in until_next_sample(
        model(attitude_rad=np.full(11, 1.0), floor_rad=np.ones(11))
    )


def test_a_run_as_short_as_the_judged_part_asks_for() -> None:
    """A twentieth of 100 s is a tenth of 50 s."""
    assert "a run of at most 50 s" in until_share(model(), 10.0, 0.05, 0.1)
    assert until_share(model(), 0.0, 0.0, 0.1) == ""


@pytest.mark.parametrize("limit_s", [20.0, 50.0])
def test_samples_after_which_a_wrong_rate_has_not_grown_too_far(limit_s: float) -> None:
    said = after_restarts(model(), limit_s)
    samples = int(said.split("at least ")[1].split(" samples")[0])
    spacing_s = 100.0 / (samples - 1)
    assert f"a run of at most {limit_s:g} s" in said
    assert 1e-3 * spacing_s * 100.0 ** (spacing_s / 10.0) <= 1e-2 * 1.001
