"""Mistakes in the equations of motion are named by what an engine's own motion has that the right equations lack."""

import dataclasses
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from adapters.common.equal_steps import finer_setting
from adapters.common.initial_state import initial_state
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from barchain.conform.scenes import STAGES, TOGETHER
from barchain.judge.diagnosis.diagnose import diagnose
from barchain.judge.diagnosis.motion.balance import motion_of
from barchain.judge.diagnosis.motion.numbers import numbers
from barchain.judge.diagnosis.motion.others import others
from barchain.judge.diagnosis.motion.quadrature import quadrature
from barchain.judge.diagnosis.motion.residual import Residual
from barchain.judge.diagnosis.own_motion import OwnMotion, densely
from barchain.judge.diagnosis.trials import motion_from
from barchain.judge.equations import Equations
from barchain.judge.scales import scales
from barchain.solutions.reference import closely_sampled
from reference_impl.model.complex_vectors import as_vectors
from reference_impl.model.effect import EffectState
from reference_impl.model.state import State
from scenarios import Scene, load_scene, make_scene
from scenarios.toml.scene_tables import EARTH_MU_M3_S2
from tests.diagnosis.planting import diagnosis_of_scene, unequal_chain
from tests.support.kernel import needs_kernel
from tests.support.slow import one_in
from tests.support.solutions import run, solution_of

pytestmark = needs_kernel
SCENE = unequal_chain()
LITTLE = 0.013
"""A departure that no slip gives"""
LOADED = (
    "drag_alone", "solar_pressure_alone", "third_body_alone", "joint_springs_alone", "thrust_body", "impulse_alone",
    "prescribed_orbital", "oblateness_alone",
)  # fmt: skip
EFFECTS_TOGETHER = sorted((name.removeprefix("conform/") for name in STAGES[TOGETHER]), key="one_bar_loads".__eq__)
"""The one that takes longest last"""


def loaded(name: str) -> Scene:
    """Scene of conformance, at the samples of a comparison."""
    return closely_sampled(load_scene(f"conform/{name}"))


@pytest.mark.parametrize(
    "name", ["drag_alone", "oblateness_alone", "slender_alone", "solar_shadow_alone", "thrust_body", "together_6"]
)
def test_loads_of_all_states_at_once_are_those_that_the_reference_has_at_each(name: str) -> None:
    scene = load_scene(f"conform/{name}")
    motion = motion_of(run(scene, 1e-9))
    at_once, s = Equations(scene, motion.states), motion.states
    vectors = map(as_vectors, (s.com, s.velocity, at_once.place, at_once.drift))
    rows = zip(s.t_s.tolist(), *vectors, s.angle, s.rate, s.unit, strict=True)
    model = at_once.model
    alone = [EffectState(model, t, State(c, v, a, w, d, e), u) for t, c, v, d, e, a, w, u in rows]
    assert any(load.acts.any() for load in at_once.effects)
    for effect, load in zip(model.effects, at_once.effects, strict=True):
        common, difference, angular = (
            np.array(x) for x in zip(*(effect.accelerations(at, None) for at in alone), strict=True)
        )
        own = common, model.mass_kg * difference, model.inertia_kg_m2 * angular
        for a, b in zip(load, own, strict=True):
            assert a.shape == b.shape
            assert np.abs(a - b).max() <= 1e-12 * np.abs(b).max()


@pytest.mark.parametrize("breaks", [(), (0.25, 0.731)])
def test_integrals_between_samples_are_right_to_the_last_digits_beside_breaks_too(breaks: tuple[float, ...]) -> None:
    t = np.linspace(0.0, 1.0, 81)
    rule = quadrature(t, breaks)
    edges = np.array([0.0, *breaks, 1.0])

    def value(x: np.ndarray, piece: np.ndarray) -> np.ndarray:
        return np.cos(5.0 * x) + piece

    def integral(a: float, b: float) -> float:
        cuts = [a, *(e for e in breaks if a < e < b), b]
        piece = [np.searchsorted(edges, 0.5 * (x + y)) - 1 for x, y in itertools.pairwise(cuts)]
        return sum((np.sin(5.0 * y) - np.sin(5.0 * x)) / 5.0 + p * (y - x)
                   for x, y, p in zip(cuts[:-1], cuts[1:], piece, strict=True))  # fmt: skip

    found = rule.integral(value(t[rule.rows], rule.piece)[:, None])[:, 0]
    right = [integral(a, b) for a, b in itertools.pairwise(t)]
    assert np.abs(found - right).max() < 1e-9 / len(t)


def check_noise(scene: Scene, run: Callable[[Scene, Any], Trajectory], settings: tuple[Any, Any]) -> None:
    """Check that the dense runs of a right engine leave noise in every block."""
    scene, twice = densely(scene, run(scene, settings[0]))
    main, finer = motion_of(run(scene, settings[0])), motion_of(run(twice, settings[1]).samples(slice(None, None, 2)))
    found = Residual(finer, scene, main)
    assert found.consistent
    assert not found.wrong, found.ratios


@pytest.mark.parametrize(
    "name", ["three_bars_gradient", "eccentric", "com_share_alone", *one_in(2, LOADED), *one_in(3, EFFECTS_TOGETHER)]
)
def test_the_right_motion_leaves_noise(name: str) -> None:
    check_noise(loaded(name), run, (1e-9, 1e-10))


@pytest.mark.parametrize("engine", one_in(2, ["exudyn-tree", "pymunk", "mujoco", "pinocchio"]))
def test_a_right_engine_of_another_library_leaves_noise(engine: str) -> None:
    if ENGINES[engine].missing:
        pytest.skip(str(ENGINES[engine].missing))
    loaded_engine = ENGINES[engine].load()
    scene, setting = loaded("three_bars_gradient"), loaded_engine.sweep.setting()
    settings = setting, finer_setting(scene, loaded_engine.sweep, setting)
    check_noise(scene, lambda s, setting: loaded_engine().run(s, setting), settings)


def check_scene_named(scene: Scene, name: str, altered: Scene) -> None:
    """Check that an engine that takes another scene for the given one gets that named."""

    def change(given: Scene) -> Scene:
        return dataclasses.replace(
            altered, run=dataclasses.replace(given.run, duration_s=altered.run.duration_s)
        )  # samples as asked

    found = diagnosis_of_scene(scene, change)
    assert (name,) in found.names, f"{name}: {found}"


CHAIN = ("mass_kg-2", "length_m-1", "inertia_kg_m2", "length_m-with-inertia-3", "gravitational-parameter")
EFFECTS = (
    ("oblateness_alone", "oblateness-j2"), ("drag_alone", "drag-tangential_coefficient"),
    ("impulse_alone", "impulse-3-impulse_N_s"), ("prescribed_orbital", "prescribed_rotation-1-amplitude_rad"),
    ("solar_pressure_alone", "solar_pressure-reflectivity"), ("together_7", "thrust-1-direction_rad"),
)  # fmt: skip
OTHERS = (
    ("three_bars_gradient", "masses-in-reversed-order"), ("three_bars_gradient", "inertia-slender"),
    ("together_7", "thrusts-of-positive-size"), ("thrust_body", "thrust-2-on-bar-2"),
    ("impulse_alone", "impulse-2-missing"), ("joint_springs_alone", "springs-rest-at-start"),
    ("thrust_body", "thrusts-at-other-end"), ("solar_pressure_alone", "sunlight-with-shadow"),
    ("prescribed_orbital_joint", "prescribed-rotation-by-external-actuator"),
    ("eleven_bars_loads", "bars-by-first-digit"), ("drag_alone", "drag-density-that-grows"),
    ("com_share_alone", "centres-midway"), ("com_share_alone", "centres-from-right"),
)  # fmt: skip


@pytest.mark.parametrize("name", one_in(3, CHAIN))
def test_a_wrong_number_of_the_chain_is_named(name: str) -> None:
    number = next(n for n in numbers(SCENE) if n.name == name)
    check_scene_named(SCENE, name, number.change(LITTLE))


def test_a_known_value_in_place_of_the_scenes_is_the_same_value_in_another_scene() -> None:
    scenes = load_scene("conform/three_bars_point"), load_scene("conform/one_bar_point")
    there, here = (next(n for n in numbers(s) if n.name == "gravitational-parameter") for s in scenes)
    right, other = (scene.central_body.mu_m3_s2 for scene in scenes)
    assert right != other == EARTH_MU_M3_S2
    assert here.as_in(there, EARTH_MU_M3_S2 / right - 1.0) == pytest.approx(0.0, abs=1e-15)
    assert here.as_in(there, LITTLE) == LITTLE


def test_a_wrong_engine_that_ends_early_is_diagnosed_up_to_its_end() -> None:
    wrong = next(n for n in numbers(SCENE) if n.name == "mass_kg-2").change(LITTLE)

    def ended(scene: Scene, rtol: float) -> Trajectory:
        whole = run(dataclasses.replace(wrong, run=scene.run), rtol)
        return whole.samples(slice(2 * len(whole.t_s) // 3))

    own = OwnMotion(SCENE, ended(SCENE, 1e-9), lambda one, two: (ended(one, 1e-9), ended(two, 1e-10)))
    assert ("mass_kg-2",) in [e.names for e in own.explaining]


@pytest.mark.parametrize("case", one_in(4, EFFECTS, "-".join))
def test_a_wrong_number_of_an_effect_is_named(case: tuple[str, str]) -> None:
    scene, name = loaded(case[0]), case[1]
    number = next(n for n in numbers(scene) if n.name == name)
    check_scene_named(scene, name, number.change(LITTLE))


@pytest.mark.parametrize("case", one_in(6, OTHERS, "-".join))
def test_another_scene_is_named(case: tuple[str, str]) -> None:
    scene, name = loaded(case[0]), case[1]
    check_scene_named(scene, name, next(a.scene for a in others(scene) if a.name == name))


def test_a_mistake_that_the_reactions_have_too_is_named_without_words_on_parts_of_the_motion() -> None:
    """Slow joints beside a thrust: sums of reactions over intervals tell less than the reactions at the samples."""
    thrust = {"bar": 1, "end": "left", "direction_deg": 60.0, "force_N": 0.05, "start_s": 260.0, "duration_s": 100.0}
    moving = {"joint": 2, "times_s": [50.0, 250.0, 400.0], "angle_deg": [20.0, 80.0, 35.0]}
    scene = make_scene(
        {
            "title": "Arm with a thrust", "source": "made up",
            "orbit": {"position_m": [6184397.3, -3231505.2], "velocity_m_s": [3498.3432, 6699.8261]},
            "chain": {
                "bars": 4, "mass_kg": [120.0, 18.0, 12.0, 7.0], "length_m": [2.5, 1.8, 1.4, 1.1],
                "angle_from": "inertial", "angle_rad": [-1.01734, -1.38103, -0.22868, -1.07002],
                "rate_rad_s": [4.7e-5, -0.0012122, 0.0052928, 0.0062665],
            },
            "effects": {
                "gravity": "quadrupole", "thrust": [thrust],
                "joint_spring_damper": {
                    "stiffness_N_m_rad": [0.05, 0.03, 0.008], "damping_N_m_s_rad": [1.2, 0.5, 0.2],
                    "rest_deg": [-30.0, 20.0, -50.0], "set_point": [moving],
                },
            },
            "run": {"start_s": 200.0, "duration_s": 400.0, "samples": 81},
        }
    )  # fmt: skip
    (number,) = (n for n in numbers(scene) if n.name == "mass_kg-with-inertia-3")
    wrong = motion_from(number.change(0.05), initial_state(scene), scene.times_s)
    solution = solution_of(scene)
    tolerance = {q: np.full(len(wrong.t_s), 1e-9 * size) for q, size in scales(solution).items()}
    found = diagnose(scene, wrong, solution, tolerance)
    assert (number.name,) in found.names, str(found)
    assert "alone" not in str(found)
