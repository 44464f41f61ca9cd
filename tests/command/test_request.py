"""The request of a run says all of a scene, and its schema describes every key."""

import json

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.engine import AccuracyParameter, Setting
from adapters.request import Request, request_schema, result_schema, run_request, scene_of
from scenarios import load_scene
from scenarios.effect_equations import LAWS
from scenarios.effect_types import COM_SHARE, all_effect_names
from scenarios.load import scene_names

RTOL, STEPS = Setting(AccuracyParameter.RTOL, 1e-10), Setting(AccuracyParameter.STEPS_PER_ORBIT, 1000.0)


@pytest.mark.parametrize("name", [n for n in scene_names() if not n.startswith("hard/bars")])
def test_a_request_brings_back_its_scene_to_the_last_bit(name):
    scene = load_scene(name)
    text = json.dumps(run_request(scene, RTOL), allow_nan=False)
    assert scene_of(Request.model_validate_json(text)).digest == scene.digest


@pytest.mark.parametrize("name", ["paper/fig05", "effects/everything", "effects/slews"])
def test_start_samples_and_laws_are_those_of_the_scene(name):
    scene = load_scene(name)
    asked, state = run_request(scene, STEPS), initial_state(scene)
    assert np.array_equal(asked["start"]["angle_rad"], state.angle_rad)
    assert np.array_equal(asked["start"]["rate_rad_s"], state.rate_rad_s)
    assert np.array_equal(asked["sample_times_s"], scene.times_s)
    assert set(asked["laws"]) == set(asked["scene"]["effects"])


def test_a_velocity_of_zero_has_no_sign():
    start = run_request(load_scene("basics/two_bars_free"), RTOL)["start"]
    assert str(start["com_velocity_m_s"][0]) == "0.0"


def test_an_equal_step_fills_the_time_between_samples():
    scene = load_scene("paper/fig05")
    step = run_request(scene, STEPS)["setting"]["step_s"]
    steps = (scene.times_s[1] - scene.times_s[0]) / step
    assert steps == pytest.approx(round(steps), abs=1e-9)
    assert run_request(scene, RTOL)["setting"]["step_s"] is None


def test_every_effect_has_a_law():
    kinds = {
        name if name.startswith("gravity.") else name.partition(".")[0] for name in all_effect_names() - {COM_SHARE}
    }
    assert kinds == set(LAWS)


def tables(schema):
    return [schema, *schema.get("$defs", {}).values()]


@pytest.mark.parametrize("schema", [request_schema(), result_schema()], ids=["request", "result"])
def test_the_schema_describes_every_key(schema):
    bare = [key for table in tables(schema) for key, about in table.get("properties", {}).items()
            if "description" not in about]  # fmt: skip
    assert not bare


def test_a_request_is_valid_by_its_schema():
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(run_request(load_scene("effects/everything"), RTOL), request_schema())
