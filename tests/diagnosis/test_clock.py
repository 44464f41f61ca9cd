"""Effects of a run that goes on: an engine that lets their clock begin anew is told so."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import pytest

from scenarios import go_on, load_scene
from tests.diagnosis.planting import diagnosis_of_scene
from tests.support.kernel import needs_kernel
from tests.support.solutions import run

if TYPE_CHECKING:
    from scenarios import Scene

pytestmark = needs_kernel


@pytest.mark.parametrize("name", ["conform/joint_torque_alone", "effects/thrust_table"])
def test_an_engine_whose_effects_begin_anew_in_a_run_that_goes_on_has_the_clock_named(name: str) -> None:
    first = load_scene(name)
    motion = dataclasses.replace(run(first, 1e-12), run_scene=first)
    middle_s = float(motion.t_s[len(motion.t_s) // 3])
    rest = {"run": {"duration_s": first.run.duration_s - middle_s, "samples": 67}}
    second = go_on(first, motion.state(middle_s), rest)

    def anew(scene: Scene) -> Scene:
        return dataclasses.replace(scene, effects=first.effects)

    assert "not on the clock that has begun before" in str(diagnosis_of_scene(second, anew))
