"""Bars that turn their other face to the wind or the Sun: found in a motion, left out of a comparison with a reason."""

from __future__ import annotations

import dataclasses
import functools
import math
import re
from typing import TYPE_CHECKING

import numpy as np
import pytest

from adapters.common.face_reversal import Incidence, first_reversal, reverses_twice, unsupported_motion
from adapters.engine import AccuracyParameter, Engine, Setting, UnsupportedMotionError
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from barchain import api
from barchain.solutions.reference import establish, with_perturbed_start
from reports.results.outcome import Outcome
from scenarios import Axes, Gravity, Impulse, Scene, load_scene
from scenarios.effect_types import End
from tests.support import solutions
from tests.support.changed import lasting, under
from tests.support.generic_scenes import of_bars

if TYPE_CHECKING:
    from pathlib import Path

    from adapters.trajectory import Array

EQUAL_STEPS = {
    "exudyn",
    "exudyn-index3",
    "exudyn-absolute",
    "exudyn-absolute-index3",
    "exudyn-tree",
    "mujoco",
}
"""Engines that state the limit; pymunk's second order bears the kink"""


@functools.cache
def one_bar(effect: str) -> Scene:
    """Scene of a single bar far from everything, in sunlight or in air that turns."""
    plain = of_bars(load_scene("basics/free_rotation"), 1)
    if effect == "sunlight":
        light = load_scene("effects/solar_pressure").effects.solar_pressure
        assert light is not None
        return under(plain, solar_pressure=dataclasses.replace(light, width_m=(0.05,), sun_rate_rad_s=1e-3))
    drag = load_scene("effects/drag").effects.drag
    assert drag is not None
    return under(plain, drag=dataclasses.replace(drag, width_m=(0.05,), rotation_rad_s=7e-5))


def motion(scene: Scene, t_s: Array, tilt: Array, rate: Array) -> Trajectory:
    """Motion along a circle of a bar that is tilted by an angle (n,) against what it faces, which itself turns."""
    n, r = 1e-3, 7e6
    com = r * np.stack([np.cos(n * t_s), np.sin(n * t_s)], axis=-1)
    velocity = n * r * np.stack([-np.sin(n * t_s), np.cos(n * t_s)], axis=-1)
    light = scene.effects.solar_pressure
    if light is None:
        towards, turning = n * t_s + 0.5 * math.pi, n  # the air meets it along its track
    else:
        towards, turning = light.sun_longitude_rad + light.sun_rate_rad_s * t_s, light.sun_rate_rad_s
    return Trajectory(t_s, com, velocity, (towards - tilt)[:, None], (turning - rate)[:, None])


def test_lowest_points_between_samples_are_those_of_the_cubic() -> None:
    rng, n = np.random.default_rng(5), 2_000
    ends, slopes = rng.uniform(0.01, 1.0, (2, n)), rng.normal(0.0, 4.0, (2, n))
    s = np.linspace(0.0, 1.0, 1001)[:, None]
    cubic = (2 * s**3 - 3 * s**2 + 1) * ends[0] + (s**3 - 2 * s**2 + s) * slopes[0]
    cubic += (3 * s**2 - 2 * s**3) * ends[1] + (s**3 - s**2) * slopes[1]
    lowest = cubic.min(axis=0)
    clear = np.abs(lowest) > 1e-4  # looked at in a thousand places only
    for face in (1.0, -1.0):
        incidence = Incidence("it", face * ends, face * slopes / 10.0, np.full((2, n), 1e-12))
        found = reverses_twice(incidence, np.array([0.0, 10.0]))[0]
        np.testing.assert_array_equal(found[clear], lowest[clear] < 0.0)
    assert 0.2 < np.mean(lowest < 0.0) < 0.8


@pytest.mark.parametrize("effect", ["sunlight", "wind"])
def test_a_bar_that_turns_its_other_face_is_named_with_the_samples_around(effect: str) -> None:
    scene, t = one_bar(effect), np.linspace(0.0, 1000.0, 101)
    said = first_reversal(scene, motion(scene, t, 1e-3 * (t - 434.0), np.full_like(t, 1e-3)))
    assert said is not None
    towards = "Sun" if effect == "sunlight" else "wind"
    assert said.startswith(f"bar 1 turns its other face to the {towards} between t = 430 s and 440 s")
    assert first_reversal(scene, motion(scene, t, 0.1 + 1e-3 * t, np.full_like(t, 1e-3))) is None


@pytest.mark.parametrize("effect", ["sunlight", "wind"])
@pytest.mark.parametrize("depth", [1e-3, 1e-6, -1e-6, -1e-3])
def test_a_face_that_turns_over_and_back_between_two_samples_is_seen(effect: str, depth: float) -> None:
    """The tilt is a parabola with its lowest point, -depth, between two samples; at them it is 1e-2 and more."""
    scene, t = one_bar(effect), np.linspace(0.0, 1000.0, 101)
    tilt, rate = 4e-4 * (t - 435.0) ** 2 - depth, 8e-4 * (t - 435.0)
    seen = motion(scene, t, np.clip(tilt, None, 1.0), np.where(tilt < 1.0, rate, 0.0))
    assert first_reversal(scene, seen) is None
    said = unsupported_motion(scene, seen)
    assert (said is not None) is (depth > 0.0)
    if said:
        assert "between t = 430 s and 440 s" in said


@pytest.mark.parametrize("effect", ["sunlight", "wind"])
def test_a_bar_that_is_edge_on_all_the_time_has_no_face_to_turn(effect: str) -> None:
    scene, t = one_bar(effect), np.linspace(0.0, 1000.0, 101)
    rounding = 1e-15 * np.random.default_rng(1).choice([-1.0, 1.0], len(t))
    assert unsupported_motion(scene, motion(scene, t, rounding, np.zeros_like(t))) is None


def test_slopes_beside_a_blow_are_not_relied_on() -> None:
    """The tilt falls until an impulse turns it: the cubic through both ends of that interval would swing below."""
    scene, t = one_bar("sunlight"), np.linspace(0.0, 100.0, 11)
    rate = np.where(t <= 50.0, -1e-2, 1e-2)
    seen = motion(scene, t, 1e-3 + 1e-2 * np.abs(t - 50.0), rate)
    assert "between t = 50 s and 60 s" in (unsupported_motion(scene, seen) or "")
    blow = Impulse(1, End.RIGHT, Axes.BODY, 0.0, 1.0, 50.0)
    assert unsupported_motion(under(scene, impulse=(blow,)), seen) is None


def test_a_scene_without_air_and_light_has_nothing_to_face() -> None:
    scene, t = load_scene("basics/free_rotation"), np.linspace(0.0, 1000.0, 101)
    assert unsupported_motion(scene, motion(one_bar("wind"), t, np.sin(t), np.cos(t))) is None


@functools.cache
def lit() -> Scene:
    """Bars that turn their other faces to the Sun, one after the other; no shadow."""
    scene = load_scene("effects/solar_shadow")
    light = scene.effects.solar_pressure
    assert light is not None
    scene = under(scene, solar_pressure=dataclasses.replace(light, shadow=False))
    return dataclasses.replace(lasting(scene, 0.2 * scene.run.duration_s, 41), name="lit")


def reference(scene: Scene) -> Trajectory:
    return solutions.run(scene, 1e-9)


def test_engines_of_equal_steps_do_not_support_it_and_the_others_do() -> None:
    said = {name: r.load().unsupported_motion(lit(), reference(lit())) for name, r in ENGINES.items() if not r.missing}
    assert {name for name, reason in said.items() if reason} == EQUAL_STEPS & said.keys()
    solution = establish(lit(), reference(lit()), reference(lit()), reference(with_perturbed_start(lit())))
    assert ENGINES["exudyn"].load().unsupported_motion(lit(), solution.fine) == said["exudyn"]
    assert Reference.unsupported_motion(lit(), solution.fine) is None


@pytest.mark.parametrize("name", ["exudyn", "exudyn-tree", "exudyn-absolute", "mujoco"])
def test_a_run_by_itself_ends_with_an_error_where_the_reference_solution_has_it(name: str) -> None:
    if ENGINES[name].missing:
        pytest.skip("not installed")
    engine: type[Engine] = ENGINES[name].load()
    with pytest.raises(UnsupportedMotionError, match=r"other face to the .*Sun .*t = ") as caught:
        engine().run(lit(), Setting(AccuracyParameter.STEPS_PER_ORBIT, 500))
    said = unsupported_motion(lit(), reference(lit()))
    assert said is not None
    _, end = instants(said)
    assert instants(str(caught.value))[-1] == pytest.approx(end, abs=lit().run.duration_s / (lit().run.samples - 1))


def instants(said: str) -> list[float]:
    """Instants in a sentence, s."""
    return [float(t) for t in re.findall(r"([0-9.]+) s\b", said)]


@pytest.mark.slow
def test_a_comparison_leaves_such_engines_out_with_the_bar_and_the_instant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = api.compare([lit()], ["reference", "exudyn-tree", "pymunk"], tmp_path)
    assert result.outcomes["lit", "exudyn-tree"] is Outcome.UNSUPPORTED
    assert {result.outcomes["lit", name] for name in ("reference", "pymunk")} == {Outcome.PASS}
    [reason] = result.metrics.query("engine == 'exudyn-tree' and scene == 'lit'").reason
    assert re.match(
        r"bar 1 turns its other face to the Sun between t = \S+ s and \S+ s, within one of the equal steps", reason
    )
    assert not result.passed  # it was named


def test_what_does_not_turn_is_compared_as_before() -> None:
    drag = load_scene("effects/drag")
    assert drag.effects.gravity is Gravity.GRADIENT
    assert unsupported_motion(drag, reference(drag)) is None
