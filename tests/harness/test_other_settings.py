"""A run that fails or takes long tells what may help: a setting that the scene asks for, or another engine."""

from __future__ import annotations

import re
from typing import Any

import pytest

from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.registry import COMPILED, find_engine
from barchain import api, make_scene
from barchain.runs import other_settings
from barchain.runs.other_settings import default_engine, failure_advice, quicker_advice
from reports.results.outcome import Outcome

needs_kernel = pytest.mark.skipif(bool(find_engine(COMPILED).missing), reason="the compiled reference is not built")
TABLES: dict[str, Any] = {
    "title": "Stiff joints",
    "source": "test",
    "orbit": {"altitude_m": 500e3},
    "chain": {"bars": 4, "mass_kg": 100.0, "length_m": 20.0, "angle_deg": [10.0, 20.0, 30.0, 45.0]},
    "effects": {"joint_spring_damper": {"stiffness_N_m_rad": 1e7}},
    "run": {"orbits": 0.001, "samples": 3},
}
STIFF = make_scene(TABLES)
SOFT = make_scene({name: table for name, table in TABLES.items() if name != "effects"})


def steps(value: float) -> Setting:
    return Setting(AccuracyParameter.STEPS_PER_ORBIT, value)


def test_a_failure_at_stiff_joints_advises_steps_that_follow_them() -> None:
    said = failure_advice(STIFF, "pymunk", steps(2000.0), Outcome.FAILED)
    found = re.search(r"steps_per_orbit=(\d+)", said)
    assert found is not None
    assert "springs" in said
    assert failure_advice(STIFF, "pymunk", steps(float(found[1])), Outcome.FAILED).find("steps_per_orbit") < 0


def test_a_failure_that_no_step_explains_advises_none() -> None:
    assert "steps_per_orbit" not in failure_advice(SOFT, "pymunk", steps(2000.0), Outcome.FAILED)
    assert failure_advice(STIFF, "pymunk", steps(2000.0), Outcome.MISSING) == ""


@needs_kernel
def test_the_advised_steps_carry_an_engine_that_failed() -> None:
    with pytest.raises(EngineError, match="--set steps_per_orbit=") as failed:
        api.simulate(STIFF, "pymunk", steps_per_orbit=10000)
    advised = re.search(r"steps_per_orbit=(\d+)", str(failed.value))
    assert advised is not None
    assert len(api.simulate(STIFF, "pymunk", steps_per_orbit=float(advised[1])).t_s) == 3


def test_a_comparison_tells_with_a_failed_run_the_steps_that_may_carry_it() -> None:
    found = api.compare([STIFF], engines=["pymunk"], settings={"pymunk": {"steps_per_orbit": 10000}})
    reasons = [reason for reason in found.metrics.reason if "may do" in reason]
    assert reasons
    assert all("--set steps_per_orbit=" in reason for reason in reasons)


@needs_kernel
def test_a_run_is_that_of_the_compiled_reference_where_it_is_built() -> None:
    assert api.simulate(SOFT).engine == COMPILED
    assert api.simulate(SOFT, condition=True).condition is not None


def test_without_the_compiled_reference_a_run_is_that_of_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(other_settings, "compiled_can", lambda _: False)
    assert default_engine(SOFT) == "reference"
    assert quicker_advice(SOFT, "reference", 60.0) == ""


@needs_kernel
def test_a_long_run_of_numpy_names_the_compiled_form() -> None:
    assert COMPILED in quicker_advice(SOFT, "reference", 33.0)
    assert quicker_advice(SOFT, "reference", 1.0) == quicker_advice(SOFT, COMPILED, 33.0) == ""


def test_a_swing_that_is_too_fast_for_the_steps_is_told_with_steps_that_follow_it() -> None:
    found = api.compare(["published/tips"], engines=["exudyn-tree"], settings={"exudyn-tree": {"steps_per_orbit": 400}})
    reasons = [reason for reason in found.metrics.reason if "may do" in reason]
    assert found.outcomes["published/tips", "exudyn-tree"] is Outcome.FAILED
    assert reasons
    assert all("the scene's fastest motion lets it be" in reason for reason in reasons)
