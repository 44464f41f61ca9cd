"""An engine is examined at a setting at which the whole of a scene is judged point by point."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import pytest

from adapters.engine import AccuracyParameter, AccuracySweep
from adapters.mujoco.adapter import Mujoco
from adapters.pymunk.adapter import Pymunk
from adapters.reference.compiled_engine import ReferenceFast
from barchain.conform.checks import CheckState
from barchain.conform.errors_at_settings import judged_declarations
from barchain.conform.physics import main_and_finer, scene_check
from barchain.conform.scenes import MOST_FINER, STAGES, from_default_on, lasts, scene_of, setting_of
from barchain.conform.target import examined
from tests.support.slow import one_in

if TYPE_CHECKING:
    from adapters.engine import Setting
    from scenarios import Scene

pytest.importorskip("mujoco")
NAME, END_S = "conform/thrust_inertial", 500.0


class SecondOrder(Mujoco):
    """Declares less than it has: the bound of its error is wide."""

    order = 2.0


class FirstOrder(Mujoco):
    """Declares far less than it has."""

    order = 1.0


class LostThrust(SecondOrder):
    """Thrusts are lost after a while."""

    def build(self, scene: Scene, setting: Setting) -> None:
        """Build without the later part of each thrust."""
        cut = tuple(dataclasses.replace(t, times_s=(0.0, END_S), force_N=t.force_N[:2]) for t in scene.effects.thrust)
        super().build(dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, thrust=cut)), setting)


class Multistep(ReferenceFast):
    """Needs a hundredth of the request for a finer run."""

    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-6, 1e-8), 1e-4, finer_rtol=0.01)


def test_a_finer_setting_is_a_tenth_of_the_request_whatever_the_second_run_needs() -> None:
    assert [setting.value for setting in from_default_on(Multistep.declarations())] == pytest.approx([1e-4, 1e-5])


def test_the_default_is_taken_where_right_runs_agree_for_most_of_the_scene() -> None:
    assert lasts(Mujoco.declarations(), Mujoco.sweep.setting(), scene_of(NAME))
    assert setting_of(Mujoco.declarations(), scene_of(NAME)) == Mujoco.sweep.setting()


def test_a_finer_setting_is_taken_where_the_default_does_not_reach_so_far() -> None:
    default, scene = Pymunk.sweep.setting(), scene_of("conform/three_bars_free")
    assert not lasts(Pymunk.declarations(), default, scene)
    assert setting_of(Pymunk.declarations(), scene) == Pymunk.sweep.finer(default)
    assert lasts(Pymunk.declarations(), Pymunk.sweep.finer(default), scene)


@pytest.mark.parametrize("name", one_in(5, [name for scenes in STAGES.values() for name in scenes]))
def test_no_setting_is_far_finer_than_the_default(name: str) -> None:
    assert setting_of(FirstOrder.declarations(), scene_of(name)).value <= MOST_FINER * FirstOrder.sweep.default


@pytest.mark.exhaustive
def test_a_declared_order_that_is_far_too_low_asks_for_no_finer_setting_than_the_measured_one() -> None:
    low, right = examined(f"{__name__}:FirstOrder"), examined("mujoco")
    assert Mujoco.order - 1.0 <= (judged_declarations(low).order or 0.0) <= Mujoco.order
    assert judged_declarations(right) == right.declarations
    scene = scene_of(NAME)
    assert setting_of(low.declarations, scene) != setting_of(judged_declarations(low), scene) == Mujoco.sweep.setting()


@pytest.mark.exhaustive
@pytest.mark.parametrize(("engine", "state"), [("SecondOrder", CheckState.PASSED), ("LostThrust", CheckState.FAILED)])
def test_a_thrust_that_is_lost_fails_at_a_low_order_too_and_the_right_engine_passes(
    engine: str, state: CheckState
) -> None:
    given = examined(f"{__name__}:{engine}")
    check = scene_check(given, NAME, main_and_finer(given, [NAME])[NAME])
    assert check.state is state, check.words
