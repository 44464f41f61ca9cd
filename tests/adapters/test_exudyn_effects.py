"""Effects in Exudyn's engines: loads against formulas in many digits, order of convergence, jumps, rejections."""

from __future__ import annotations

import dataclasses
import functools
from typing import TYPE_CHECKING

import mpmath as mp
import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Engine, Setting, UnsupportedMotionError
from adapters.exudyn.adapter import Exudyn, ExudynAbsolute, ExudynAbsoluteIndex3, ExudynIndex3, ExudynTree
from adapters.exudyn.frames import BarMotion, frame_of, turned
from adapters.exudyn.loads import Loading
from adapters.exudyn.solver import method_for
from scenarios import Gravity, Scene, load_scene
from tests.adapters.exact_loads import exact_bar, exact_effects, vector
from tests.support import solutions
from tests.support.changed import lasting, under, with_chain
from tests.support.slow import one_in

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory

ENGINES = (Exudyn, ExudynIndex3, ExudynAbsolute, ExudynAbsoluteIndex3, ExudynTree)
REDUNDANT = ENGINES[:4]
SUPPORTED = ["drag", "joint_springs", "oblateness", "quadrupole", "slender", "solar_pressure", "third_body", "thrust"]
EPS = float(np.finfo(float).eps)
PLACE_M = np.array([6.9e6, -1.1e6])  # from the centre of the body, inertial axes
VELOCITY_M_S = np.array([1500.0, 7100.0])
ANGLE, RATE = 0.83, 1.4e-3
AT_S = 613.0


def extra_load(scene: Scene, *, absolute: bool, bar: int = 0) -> tuple[np.ndarray, float]:
    """What the effects add at the place above, in inertial axes."""
    frame = frame_of(scene, absolute=absolute)
    loading = Loading(scene, frame)
    loading.framed = False  # gravity's and the frame's own loads are tested with the paper's scenes
    t = np.array([AT_S])
    axes = frame.at(t)
    place, motion = axes.relative(
        PLACE_M[None, None] - axes.origin_m[:, None], (VELOCITY_M_S - axes.origin_velocity_m_s)[:, None]
    )
    turn = ANGLE - axes.turn_rad
    (x, y), (vx, vy) = place[0].T, motion[0].T
    m = BarMotion(x, y, vx, vy, np.cos(turn), np.sin(turn), RATE - axes.rate_rad_s)
    fx, fy, torque = loading.on(bar, m, list(loading.time_inputs(t, t).T), np)
    force = turned(np.array([fx[0], fy[0]]), axes.turn_rad[0])
    return force, 0.0 if torque is None else float(torque[0])


def exact_load(scene: Scene, bar: int = 0) -> tuple[np.ndarray, float]:
    """Force and torque of the effects at that place, in fifty digits."""
    one = exact_bar(scene, bar, complex(*PLACE_M), complex(*VELOCITY_M_S), ANGLE, RATE)
    with mp.workdps(50):
        pull, spin = exact_effects(scene, [one] * scene.bars, bar, AT_S)
        return vector(pull * one.mass), float(spin * one.inertia)


@pytest.mark.parametrize("absolute", [False, True])
@pytest.mark.parametrize("length_m", [1.0, 100.0, 20e3, 1e6])
def test_the_exact_bar_is_the_integral_along_it_to_all_digits(absolute: bool, length_m: float) -> None:
    scene = load_scene("effects/slender")
    n = scene.bars
    inertia = tuple(m * length_m**2 / 12.0 for m in scene.chain.mass_kg)
    scene = with_chain(scene, length_m=(length_m,) * n, inertia_kg_m2=inertia)
    force, torque = exact_load(scene)
    found, turning = extra_load(scene, absolute=absolute)
    # a place near a rotating frame, turned into its axes and back, has lost a few units of the last digit of 1e6 m
    np.testing.assert_allclose(found, force, rtol=0, atol=200 * EPS * np.hypot(*force))
    assert turning == pytest.approx(torque, rel=200 * EPS)


@pytest.mark.parametrize("absolute", [False, True])
@pytest.mark.parametrize("name", ["oblateness", "third_body"])
@pytest.mark.parametrize("gravity", [Gravity.POINT, Gravity.GRADIENT, Gravity.QUADRUPOLE, Gravity.SLENDER])
def test_fields_are_their_potentials_in_many_digits(name: str, gravity: Gravity, absolute: bool) -> None:
    scene = under(load_scene(f"effects/{name}"), gravity=gravity)
    alone = under(load_scene(f"effects/{name}"), gravity=gravity, oblateness=None, third_body=())
    extended = gravity.has_potential and gravity.turns
    bare, bare_torque = extra_load(alone, absolute=absolute) if extended else (np.zeros(2), 0.0)
    with mp.workdps(60):
        (force, torque), (other, other_torque) = exact_load(scene), exact_load(alone)
    found, turning = extra_load(scene, absolute=absolute)
    # bare gravity's is subtracted
    atol = 400 * EPS * max(np.hypot(*(force - other)), np.hypot(*bare))
    np.testing.assert_allclose(found - bare, force - other, rtol=0, atol=atol)
    if gravity.turns:
        expected = pytest.approx(torque - other_torque, rel=1e-12, abs=400 * EPS * abs(bare_torque))
        assert turning - bare_torque == expected


@pytest.mark.parametrize("absolute", [False, True])
@pytest.mark.parametrize(
    ("name", "bar", "share", "torque_share"),
    [
        # the moment's part of the force is 1e-6 of gravity's
        ("quadrupole", 0, 0.0, 0.0),
        # a radius in its last digit is 1e-9 m, over a scale height of 45 km
        ("drag", 0, 1e-12, 1e-11),
        ("solar_pressure", 1, 20 * EPS, 0.0),
        ("thrust", 0, 20 * EPS, 50 * EPS),
        ("thrust", 2, 20 * EPS, 50 * EPS),
    ],
)
def test_an_effect_pushes_as_its_elements_or_its_potential_say(
    name: str, bar: int, share: float, torque_share: float, absolute: bool
) -> None:
    scene = load_scene(f"effects/{name}")
    (force, torque), (found, turning) = exact_load(scene, bar), extra_load(scene, absolute=absolute, bar=bar)
    weight = scene.central_body.mu_m3_s2 * scene.chain.mass_kg[bar] / np.hypot(*PLACE_M) ** 2
    atol = 4 * EPS * weight if name == "quadrupole" else share * np.hypot(*force)
    np.testing.assert_allclose(found, force, rtol=0, atol=atol)
    assert turning == pytest.approx(torque, rel=torque_share, abs=0.0)
    assert force.any()


def shorter(name: str) -> Scene:
    scene = load_scene(f"effects/{name}")
    if name == "thrust_table":  # whose thrusts start and end
        return scene
    # in the light, bars keep their faces to the Sun for a while only
    return lasting(scene, 4000.0 if name == "solar_pressure" else 0.5 * scene.run.duration_s, 11)


def error(found: Trajectory, name: str, what: str) -> float:
    return float(np.abs(getattr(found, what) - getattr(solutions.run(shorter(name), 1e-13), what)).max())


@pytest.mark.parametrize("engine", REDUNDANT)
@pytest.mark.parametrize("name", one_in(8, [*SUPPORTED, "thrust_table"]))
def test_halving_the_step_quarters_the_error_against_the_reference(engine: type[Engine], name: str) -> None:
    scene = shorter(name)
    coarse, fine = (engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, k)) for k in (1000, 2000))
    ratio = (float(fine.info["steps"]) / float(coarse.info["steps"])) ** 2
    reactions = engine is Exudyn and name != "thrust_table"  # without transients at the start and at jumps
    for what in ("angle_rad", "reaction_N")[: 1 + reactions]:
        assert error(coarse, name, what) / error(fine, name, what) == pytest.approx(ratio, rel=0.1)


@pytest.mark.parametrize("name", one_in(4, [*SUPPORTED, "thrust_table"]))
def test_the_tree_agrees_with_the_reference_to_nine_digits(name: str) -> None:
    scene = shorter(name)
    found = ExudynTree().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 800))
    for what in ("angle_rad", "reaction_N", "com_m"):
        assert error(found, name, what) < 1e-9 * float(np.abs(getattr(solutions.run(scene, 1e-13), what)).max())
    if name == "thrust_table":
        assert error(found, name, "angle_rad") < 1e-10


@pytest.mark.parametrize("engine", ENGINES)
def test_a_sample_at_a_jump_shows_what_was_just_before_it(engine: type[Engine]) -> None:
    scene = load_scene("effects/thrust_table")
    late = dataclasses.replace(scene.effects.thrust[1], times_s=(400.0, 1000.0))
    scene = lasting(under(scene, thrust=(late,)), 1200.0, 13)
    found = engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 2000))
    exact = solutions.run(scene, 1e-12)
    assert found.reaction_N is not None
    assert exact.reaction_N is not None
    np.testing.assert_array_equal(found.t_s, scene.times_s)
    # a thrust of 0.05 N would show as much in the joints; index 3's transient at t = 0 is of first order
    off = np.abs(found.reaction_N - exact.reaction_N).max(axis=(1, 2))
    assert max(off[4], off[10]) < 2e-3


def test_events_within_equal_steps_are_rejected_with_a_reason() -> None:
    for engine in ENGINES:
        assert "edge" in (engine.unsupported(load_scene("effects/solar_shadow")) or "")
        assert "impulse" in (engine.unsupported(load_scene("effects/impulse")) or "")
    odd = dataclasses.replace(
        load_scene("effects/thrust_table").effects.thrust[0], times_s=(105.0, 295.0, 605.3, 815.0)
    )
    assert all(
        "605.3" in (engine.unsupported(under(load_scene("effects/thrust_table"), thrust=(odd,))) or "")
        for engine in ENGINES
    )
    slews = load_scene("effects/slews").effects.prescribed_rotation[:1]
    both = under(load_scene("effects/thrust_table"), prescribed_rotation=slews)
    assert all("wrong accelerations" in (engine.unsupported(both) or "") for engine in REDUNDANT)


@pytest.mark.parametrize("engine", [Exudyn, ExudynTree])
def test_a_bar_that_turns_its_other_face_ends_the_run_with_a_reason(engine: type[Engine]) -> None:
    scene = load_scene("effects/solar_shadow")
    light = scene.effects.solar_pressure
    assert light is not None
    scene = under(load_scene("effects/solar_shadow"), solar_pressure=dataclasses.replace(light, shadow=False))
    with pytest.raises(UnsupportedMotionError, match=r"other face to the Sun between t = "):
        engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 500))


def test_newtons_tolerance_knows_how_far_effects_take_the_chain() -> None:
    plain, flat = load_scene("paper/fig13"), load_scene("effects/oblateness")
    none = under(load_scene("effects/oblateness"), oblateness=None)
    find = functools.partial(method_for, explicit=False, index3=True, absolute=False)
    assert find(flat).residual_N > 100.0 * find(none).residual_N
    assert find(plain).residual_N < 1e-9


@pytest.mark.parametrize("name", ["oblateness", "tip_masses"])
def test_what_is_left_at_a_trees_free_end_is_the_rounding_it_declares(name: str) -> None:
    scene = load_scene(f"effects/{name}")
    setting = ExudynTree.sweep.setting()
    declared = ExudynTree.noise(scene, setting, scene.times_s)["reaction"]
    assert float(ExudynTree().run(scene, setting).info["free_end_N"]) < float(np.max(declared))


@pytest.mark.exhaustive
@pytest.mark.parametrize("engine", REDUNDANT[:2])
def test_a_prescribed_rotation_goes_on_beside_other_effects(engine: type[Engine]) -> None:
    slews, flat = load_scene("effects/slews"), load_scene("effects/oblateness").effects.oblateness
    moon = load_scene("effects/third_body").effects.third_body[:1]
    scene = lasting(under(slews, gravity=Gravity.QUADRUPOLE, oblateness=flat, third_body=moon), 300.0, 7)
    exact = solutions.run(scene, 1e-12)
    assert exact.angle_rad is not None
    errors = []
    for k in (10000, 20000):
        found = engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, k))
        assert found.angle_rad is not None
        errors.append(float(np.abs(found.angle_rad - exact.angle_rad).max()))
    assert 3.4 < errors[0] / errors[1] < 4.6
