"""Each known mistake, alone in a result, is named, and no other one."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import pytest

from barchain.judge.diagnosis.altered_scenes import defaults, equations, events, simplified
from barchain.judge.diagnosis.altered_scenes.catalogue import SCENES
from barchain.judge.diagnosis.diagnose import Diagnosis, diagnose
from barchain.judge.diagnosis.readings.catalogue import READINGS, TIMINGS
from barchain.judge.diagnosis.search import BRIEF, FULL, ONE_ENGINE
from barchain.judge.diagnosis.verdicts import verdict_tolerance
from scenarios import Scene, load_scene
from tests.diagnosis.planting import RTOL, planted, solution, unequal_chain, verdict_on
from tests.support.slow import one_in, slow_but, thinned

if TYPE_CHECKING:
    from barchain.judge.diagnosis.mistake import Mistake, SceneMistake

SCENE = unequal_chain()
WITHOUT_TRACE = {"torque-sign", "torques-in-kn-m", "impulses-in-kn-s", "impulses-of-each-interval", "torques-twice",
                 "central-body-earth", "initial-rates-all-positive",
                 "torques-half", "torques-in-reversed-order", "angles-with-other-turns", "mu-egm"}  # fmt: skip
"""Mistakes that alter nothing in this scene: it has no torques and no impulses, and takes its mu from EGM2008"""
UNUSUAL = {"oblateness": "oblateness_alone", "drag": "drag_alone", "sunlight": "solar_pressure_alone",
           "third-body": "third_body_alone", "thrust": "thrust_body", "impulse": "impulse_alone",
           "springs": "joint_springs_alone",
           "rotation-all-horizontal": "prescribed_inertial", "rotation-all-external": "prescribed_orbital_joint",
           "rotation": "prescribed_orbital"}  # fmt: skip
"""Scenes whose keys have other values than the defaults, by the effect"""
OF_EQUATIONS = {m: "" for m in SCENES if m.model is not None} | {
    m: f"conform/{scene}" for m in equations.MISTAKES for name, scene in UNUSUAL.items() if m.name.startswith(name)
}
"""Mistakes in the equations, with a scene in which they show; the one of this module without"""
OF_SCENES = dataclasses.replace(BRIEF, equation_run_s=0.0)
"""Search without runs of altered equations, which take long"""
OF_EVENTS = [m for m in events.MISTAKES if m.name.endswith(("-sample-after", "-start", "-end", "-along"))]
LOADED = {
    "effects/thrust_table": ("thrust",),
    "effects/drag": ("drag",),
    "effects/impulse": ("impulse",),
    "effects/oblateness": ("oblateness",),
    "effects/third_body": ("third-body",),
    "effects/solar_shadow": ("sun", "solar-pressure"),
    "effects/joint_springs": ("springs", "dampers", "joint-spring-damper"),
    "effects/slews": ("rotation", "prescribed-rotation"),
}
"""Scenes with an effect, and the beginnings of the names of the mistakes in it"""


def diagnosis_of(scene: Scene, mistake: Mistake, effort: object = BRIEF) -> Diagnosis | None:
    """Diagnosis of a result with a mistake; None if the result is that without the mistake."""
    main, finer = (planted(scene, mistake, rtol) for rtol in (RTOL, 0.1 * RTOL))
    if main is None or finer is None:
        return None
    solved = solution(scene)
    tolerance = verdict_tolerance(verdict_on(main, finer, solved))
    return diagnose(scene, main, solved, tolerance, effort)  # type: ignore[arg-type]


def check_named(scene: Scene, mistake: Mistake, effort: object = BRIEF) -> None:
    """Check that the first explanation is the mistake, and that the others leave equal residuals."""
    found = diagnosis_of(scene, mistake, effort)
    assert found is not None
    assert (mistake.name,) in found.names, str(found)


IN_SCENES = [m for m in SCENES if m.model is None and m.name not in WITHOUT_TRACE]


@pytest.mark.parametrize("mistake", [m for m in READINGS if m.name.startswith("impulses")], ids=lambda m: m.name)
def test_a_mistake_of_reading_impulses_is_named_where_there_are_some(mistake: Mistake) -> None:
    check_named(load_scene("effects/impulse"), mistake)


@pytest.mark.parametrize("mistake", one_in(5, [m for m in READINGS if m.name not in WITHOUT_TRACE], lambda m: m.name))
def test_a_mistake_of_reading_is_named_alone(mistake: Mistake) -> None:
    found = diagnosis_of(SCENE, mistake)
    assert found is not None
    assert found.names == {(mistake.name,)}, str(found)


@pytest.mark.parametrize("mistake", one_in(6, TIMINGS, lambda m: m.name))
def test_late_and_early_samples_are_named_alone(mistake: Mistake) -> None:
    found = diagnosis_of(SCENE, mistake)
    assert found is not None
    assert found.names == {(mistake.name,)}, str(found)


@pytest.mark.parametrize("mistake", one_in(6, IN_SCENES, lambda m: m.name))
def test_a_mistake_in_the_scene_is_named_alone(mistake: SceneMistake) -> None:
    found = diagnosis_of(SCENE, mistake)
    if found is None:
        assert mistake.scene is not None
        assert mistake.scene(SCENE) == SCENE
    else:
        assert found.names == {(mistake.name,)}, str(found)


@pytest.mark.parametrize("mistake", [m for m, scene in OF_EQUATIONS.items() if not scene], ids=lambda m: m.name)
def test_a_mistake_in_the_equations_is_named(mistake: SceneMistake) -> None:
    check_named(SCENE, mistake, FULL)


@pytest.mark.parametrize("mistake", [
    pytest.param(m, id=m.name, marks=pytest.mark.slow if m.name.startswith("springs") else pytest.mark.exhaustive)
    for m, scene in OF_EQUATIONS.items() if scene
])  # fmt: skip
def test_a_mistake_in_the_equations_of_an_effect_is_named(mistake: SceneMistake) -> None:
    check_named(load_scene(OF_EQUATIONS[mistake]), mistake, ONE_ENGINE)


@pytest.mark.parametrize("mistake", one_in(5, [*defaults.MISTAKES, *simplified.MISTAKES, *OF_EVENTS], lambda m: m.name))
def test_a_key_that_is_ignored_and_a_sample_after_an_event_are_named(mistake: SceneMistake) -> None:
    scene = next((scene for effect, scene in UNUSUAL.items() if mistake.name.startswith(effect)), "three_bars_gradient")
    check_named(load_scene(f"conform/{scene}"), mistake, OF_SCENES)


@pytest.mark.parametrize("name", sorted(WITHOUT_TRACE))
def test_a_mistake_that_alters_nothing_is_not_named(name: str) -> None:
    mistake = next(m for m in (*READINGS, *SCENES) if m.name == name)
    found = diagnosis_of(SCENE, mistake)
    assert found is None or (found.inside_tolerances and not found.names)


def test_impulses_that_are_left_out_are_named() -> None:
    scene = load_scene("effects/impulse")
    missing = next(m for m in SCENES if m.name == "impulse-missing")
    main, finer = (planted(scene, missing, rtol) for rtol in (RTOL, 0.1 * RTOL))
    assert main is not None
    assert finer is not None
    main, finer = (t.replace(impulse_N_s=0.0 * t.reaction_N) for t in (main, finer))
    tolerance = verdict_tolerance(verdict_on(main, finer, solution(scene)))
    assert diagnose(scene, main, solution(scene), tolerance, BRIEF).names == {("impulse-missing",)}


@pytest.mark.parametrize("name", thinned(3, slow_but(LOADED, ())))
def test_mistakes_in_an_effect_are_named_or_indistinguishable(name: str) -> None:
    scene = load_scene(name)
    for mistake in (m for m in SCENES if m.name.startswith(LOADED[name])):
        found = diagnosis_of(scene, mistake, ONE_ENGINE)
        if found is not None and not found.inside_tolerances:
            assert (mistake.name,) in found.names, f"{mistake.name}: {found}"
