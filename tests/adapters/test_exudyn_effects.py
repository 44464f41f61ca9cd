"""Effects in Exudyn's engines: loads against formulas in many digits, order of convergence, jumps, rejections."""

from __future__ import annotations

import dataclasses
import functools
from typing import TYPE_CHECKING, Any

import mpmath as mp
import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Engine, Setting, UnsupportedMotionError
from adapters.exudyn.adapter import Exudyn, ExudynAbsolute, ExudynAbsoluteIndex3, ExudynIndex3, ExudynTree
from adapters.exudyn.effects import jump_steps, sizes
from adapters.exudyn.frames import BarMotion, frame_of, turned
from adapters.exudyn.loads import Loading
from adapters.exudyn.solver import RestartSegments, method_for, steps_of
from adapters.exudyn.time_inputs import Steps
from scenarios import Gravity, Scene, load_scene
from tests.support import solutions
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


def with_effects(name: str, **changes: Any) -> Scene:
    scene = load_scene(f"effects/{name}")
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **changes))


def shortened(scene: Scene, duration_s: float, samples: int) -> Scene:
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration_s, samples=samples))


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


def field(scene: Scene, x: Any, y: Any) -> list[Any]:
    """Acceleration of a mass point by the fields beside the central one, in many digits."""
    found = [mp.mpf(0), mp.mpf(0)]
    flat = scene.effects.oblateness
    if flat:
        b = mp.mpf(scene.central_body.mu_m3_s2) * flat.j2 * mp.mpf(flat.radius_m) ** 2 / 2
        found = [f - 3 * b * c / mp.hypot(x, y) ** 5 for f, c in zip(found, (x, y), strict=True)]
    for body in scene.effects.third_body:
        angle = mp.mpf(body.longitude_rad) + mp.mpf(body.rate_rad_s) * AT_S
        far = [body.distance_m * mp.cos(angle), body.distance_m * mp.sin(angle)]
        away = mp.hypot(x - far[0], y - far[1])
        found = [
            f - body.mu_m3_s2 * ((c - g) / away**3 + g / mp.mpf(body.distance_m) ** 3)
            for f, c, g in zip(found, (x, y), far, strict=True)
        ]
    return found


def along_bar(scene: Scene, pull: Any, bar: int = 0) -> tuple[list[float], float]:
    """Force and torque (about the centre) of a pull per mass along a uniform bar."""
    half, mass = mp.mpf(scene.chain.length_m[bar]) / 2, scene.chain.mass_kg[bar]
    c, s = mp.cos(ANGLE), mp.sin(ANGLE)

    def at(k: int, turn: bool) -> Any:
        def density(place: Any) -> Any:
            x, y = pull(mp.mpf(PLACE_M[0]) + place * c, mp.mpf(PLACE_M[1]) + place * s)
            return place * (c * y - s * x) if turn else (x, y)[k]

        return mass * mp.quad(density, [-half, 0, half]) / (2 * half)

    return [float(at(0, False)), float(at(1, False))], float(at(0, True))


def second_moment(scene: Scene, field_of: Any, bar: int = 0) -> tuple[list[float], float]:
    """Point force and the second moment's, J/m for the mean square along the bar: by differences in many digits."""
    inertia, mass = mp.mpf(scene.chain.inertia_kg_m2[bar]), scene.chain.mass_kg[bar]
    c, s = mp.cos(ANGLE), mp.sin(ANGLE)
    h = mp.mpf(1)

    def at(place: Any) -> tuple[Any, Any]:
        x, y = field_of(mp.mpf(PLACE_M[0]) + place * c, mp.mpf(PLACE_M[1]) + place * s)
        return mp.mpf(x), mp.mpf(y)

    before, here, after = at(-h), at(mp.mpf(0)), at(h)
    force = [mass * b + inertia * (a - 2 * b + d) / h**2 / 2 for a, b, d in zip(before, here, after, strict=True)]
    slope = [(d - a) / (2 * h) for a, d in zip(before, after, strict=True)]
    return [float(f) for f in force], float(inertia * (c * slope[1] - s * slope[0]))


@pytest.mark.parametrize("absolute", [False, True])
@pytest.mark.parametrize("length_m", [1.0, 100.0, 20e3, 1e6])
def test_the_exact_bar_is_the_integral_along_it_to_all_digits(absolute: bool, length_m: float) -> None:
    scene = load_scene("effects/slender")
    n = scene.bars
    inertia = tuple(m * length_m**2 / 12.0 for m in scene.chain.mass_kg)
    scene = dataclasses.replace(
        scene, chain=dataclasses.replace(scene.chain, length_m=(length_m,) * n, inertia_kg_m2=inertia)
    )
    mu = mp.mpf(scene.central_body.mu_m3_s2)
    centre = mp.mpf(PLACE_M[0]), mp.mpf(PLACE_M[1])

    def pull(x: Any, y: Any) -> tuple[Any, Any]:
        return tuple(
            mu * (z / mp.hypot(*centre) ** 3 - c / mp.hypot(x, y) ** 3) for z, c in zip(centre, (x, y), strict=True)
        )

    with mp.workdps(50):
        force, torque = along_bar(scene, pull)
    found, turning = extra_load(scene, absolute=absolute)
    # a place near a rotating frame, turned into its axes and back, has lost a few units of the last digit of 1e6 m
    np.testing.assert_allclose(found, force, rtol=0, atol=200 * EPS * np.hypot(*force))
    assert turning == pytest.approx(torque, rel=200 * EPS)


@pytest.mark.parametrize("absolute", [False, True])
@pytest.mark.parametrize("name", ["oblateness", "third_body"])
@pytest.mark.parametrize("gravity", [Gravity.POINT, Gravity.GRADIENT, Gravity.QUADRUPOLE, Gravity.SLENDER])
def test_fields_are_their_formulas_in_many_digits(name: str, gravity: Gravity, absolute: bool) -> None:
    scene, alone = (
        with_effects(name, gravity=gravity),
        with_effects(name, gravity=gravity, oblateness=None, third_body=()),
    )
    bare, bare_torque = np.zeros(2), 0.0
    if gravity.has_potential and gravity.turns:
        bare, bare_torque = extra_load(alone, absolute=absolute)
    with mp.workdps(60):
        force, torque = second_moment(scene, functools.partial(field, scene))
        point = [scene.chain.mass_kg[0] * float(f) for f in field(scene, mp.mpf(PLACE_M[0]), mp.mpf(PLACE_M[1]))]
    found, turning = extra_load(scene, absolute=absolute)
    expected = np.array(force if gravity.turns and gravity.has_potential else point)
    # a step of 1 m in the differences leaves out (1 m/r)² of the second moment; bare gravity's is subtracted
    atol = 400 * EPS * max(np.hypot(*point), np.hypot(*bare))
    np.testing.assert_allclose(found - bare, expected, rtol=0, atol=atol)
    if gravity.turns:
        assert turning - bare_torque == pytest.approx(torque, rel=1e-12, abs=400 * EPS * abs(bare_torque))


@pytest.mark.parametrize("absolute", [False, True])
def test_the_quadrupole_is_the_second_moment_in_the_central_field(absolute: bool) -> None:
    scene = load_scene("effects/quadrupole")
    mu = mp.mpf(scene.central_body.mu_m3_s2)
    with mp.workdps(60):
        force, _ = second_moment(scene, lambda x, y: (-mu * x / mp.hypot(x, y) ** 3, -mu * y / mp.hypot(x, y) ** 3))
        r3 = mp.hypot(*map(mp.mpf, PLACE_M)) ** 3
        point = [-mu * scene.chain.mass_kg[0] * mp.mpf(c) / r3 for c in PLACE_M]
        # differences again: the moment's part of the force is one of 1e-6 of it
        moment = [float(mp.mpf(f) - p) for f, p in zip(force, point, strict=True)]
    found, _ = extra_load(scene, absolute=absolute)
    np.testing.assert_allclose(found, moment, rtol=0, atol=4 * EPS * float(mp.hypot(*point)))


def test_air_is_the_integral_of_what_pushes_each_piece() -> None:
    scene = load_scene("effects/drag")
    drag = scene.effects.drag
    assert drag is not None
    with mp.workdps(40):
        c, s = mp.cos(ANGLE), mp.sin(ANGLE)
        x, y = map(mp.mpf, PLACE_M)
        wind = [mp.mpf(VELOCITY_M_S[0]) + drag.rotation_rad_s * y, mp.mpf(VELOCITY_M_S[1]) - drag.rotation_rad_s * x]
        v, t, w = c * wind[1] - s * wind[0], c * wind[0] + s * wind[1], mp.mpf(RATE) - drag.rotation_rad_s
        r = mp.hypot(x, y)
        height = r - scene.central_body.radius_m - drag.altitude_m
        density = drag.density_kg_m3 * mp.exp(-height / drag.scale_height_m)
        slope = (c * x + s * y) / (r * drag.scale_height_m)

        def push(place: Any) -> Any:
            return -drag.width_m[0] / 2 * density * (1 - slope * place) * mp.sign(v) * (v + place * w)

        half = mp.mpf(scene.chain.length_m[0]) / 2
        cn, ct = drag.normal_coefficient, drag.tangential_coefficient
        normal = mp.quad(lambda p: push(p) * cn * (v + p * w), [-half, half])
        along = mp.quad(lambda p: push(p) * ct * t, [-half, half])
        torque = float(mp.quad(lambda p: p * push(p) * cn * (v + p * w), [-half, half]))
        force = [float(c * along - s * normal), float(s * along + c * normal)]
    for absolute in (False, True):
        found, turning = extra_load(scene, absolute=absolute)
        # a radius in its last digit is 1e-9 m, over a scale height of 45 km
        np.testing.assert_allclose(found, force, rtol=0, atol=1e-12 * np.hypot(*force))
        assert turning == pytest.approx(torque, rel=1e-11)


@pytest.mark.parametrize("absolute", [False, True])
def test_light_and_thrust_push_as_their_pages_say(absolute: bool) -> None:
    scene = load_scene("effects/solar_pressure")
    light = scene.effects.solar_pressure
    assert light is not None
    sun_angle = light.sun_longitude_rad + light.sun_rate_rad_s * AT_S
    sun = np.array([np.cos(sun_angle), np.sin(sun_angle)])
    u, n = np.array([np.cos(ANGLE), np.sin(ANGLE)]), np.array([-np.sin(ANGLE), np.cos(ANGLE)])
    k = abs(n @ sun)
    face = n * np.sign(n @ sun)
    area = light.width_m[1] * scene.chain.length_m[1]
    expected = -light.pressure_Pa * area * k * ((1 - light.reflectivity) * sun + 2 * light.reflectivity * k * face)
    found, torque = extra_load(scene, absolute=absolute, bar=1)
    np.testing.assert_allclose(found, expected, rtol=0, atol=20 * EPS * np.hypot(*expected))
    assert torque == 0.0
    scene = load_scene("effects/thrust")
    for thrust in scene.effects.thrust:
        direction = thrust.direction_rad + (ANGLE if thrust.axes == "body" else 0.0)
        force = thrust.force_N[0] * np.array([np.cos(direction), np.sin(direction)])
        arm = thrust.end.sign * 0.5 * scene.chain.length_m[thrust.bar - 1] * u
        found, torque = extra_load(scene, absolute=absolute, bar=thrust.bar - 1)
        np.testing.assert_allclose(found, force, rtol=0, atol=20 * EPS * thrust.force_N[0])
        assert torque == pytest.approx(arm[0] * force[1] - arm[1] * force[0], rel=50 * EPS)


def solution(name: str) -> Trajectory:
    return solutions.run(halved(name), 1e-13)


def halved(name: str) -> Scene:
    scene = load_scene(f"effects/{name}")
    # in the light, bars keep their faces to the Sun for a while only
    return shortened(scene, 4000.0 if name == "solar_pressure" else 0.5 * scene.run.duration_s, 11)


def error(found: Trajectory, name: str, what: str) -> float:
    return float(np.abs(getattr(found, what) - getattr(solution(name), what)).max())


@pytest.mark.parametrize("name", one_in(9, SUPPORTED))
def test_halving_the_step_quarters_the_error_against_the_reference(name: str) -> None:
    scene = halved(name)
    coarse, fine = (Exudyn().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, k)) for k in (800, 1600))
    ratio = (float(fine.info["steps"]) / float(coarse.info["steps"])) ** 2
    for what in ("angle_rad", "reaction_N"):
        assert error(coarse, name, what) / error(fine, name, what) == pytest.approx(ratio, rel=0.1)


@pytest.mark.parametrize("name", one_in(6, SUPPORTED))
def test_the_tree_agrees_with_the_reference_to_nine_digits(name: str) -> None:
    found = ExudynTree().run(halved(name), Setting(AccuracyParameter.STEPS_PER_ORBIT, 800))
    for what in ("angle_rad", "reaction_N", "com_m"):
        assert error(found, name, what) < 1e-9 * float(np.abs(getattr(solution(name), what)).max())


@pytest.mark.parametrize("engine", [ExudynIndex3, ExudynAbsolute, ExudynAbsoluteIndex3])
@pytest.mark.parametrize("name", one_in(8, SUPPORTED))
def test_every_engine_carries_the_effects_with_second_order(engine: type[Engine], name: str) -> None:
    scene = halved(name)
    coarse, fine = (engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, k)) for k in (1000, 2000))
    ratio = (float(fine.info["steps"]) / float(coarse.info["steps"])) ** 2
    assert error(coarse, name, "angle_rad") / error(fine, name, "angle_rad") == pytest.approx(ratio, rel=0.1)


@pytest.mark.parametrize("engine", one_in(3, ENGINES))
def test_a_thrust_that_starts_and_ends_keeps_the_order(engine: type[Engine]) -> None:
    scene = load_scene("effects/thrust_table")
    exact = solutions.run(scene, 1e-13)
    assert engine.order is not None
    coarse, fine = (engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, k)) for k in (1000, 2000))
    assert coarse.angle_rad is not None
    assert fine.angle_rad is not None
    assert exact.angle_rad is not None
    errors = [float(np.abs(t.angle_rad - exact.angle_rad).max()) for t in (coarse, fine)]
    if engine is ExudynTree:
        assert max(errors) < 1e-10
    else:
        ratio = (float(fine.info["steps"]) / float(coarse.info["steps"])) ** 2
        assert errors[0] / errors[1] == pytest.approx(ratio, rel=0.1)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_sample_at_a_jump_shows_what_was_just_before_it(engine: type[Engine]) -> None:
    scene = load_scene("effects/thrust_table")
    late = dataclasses.replace(scene.effects.thrust[1], times_s=(400.0, 1000.0))
    scene = dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, thrust=(late,)))
    scene = shortened(scene, 1200.0, 13)
    found = engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 2000))
    exact = solutions.run(scene, 1e-12)
    assert found.reaction_N is not None
    assert exact.reaction_N is not None
    np.testing.assert_array_equal(found.t_s, scene.times_s)
    # a thrust of 0.05 N would show as much in the joints; index 3's transient at t = 0 is of first order
    off = np.abs(found.reaction_N - exact.reaction_N).max(axis=(1, 2))
    assert max(off[4], off[10]) < 2e-3


def test_rows_of_the_pieces_are_the_samples_once_each() -> None:
    segments = RestartSegments(Steps(0.5, 24), 6, (0, 9, 12, 24))
    assert segments.stride == 3
    rows = [
        (first + segments.stride * np.flatnonzero(segments.samples(first, (last - first) // 3 + 1))).tolist()
        for first, last in ((0, 9), (9, 12), (12, 24))
    ]
    assert rows == [[0, 6], [12], [18, 24]]


def test_a_thrusts_size_is_that_of_the_line_it_is_asked_for() -> None:
    scene = load_scene("effects/thrust_table")
    thrust = scene.effects.thrust[0]
    at, before, after = np.array([815.0]), np.array([810.0]), np.array([820.0])
    assert sizes(thrust, at, before)[0] == pytest.approx(thrust.force_N[-1], rel=10 * EPS)
    assert sizes(thrust, at, after)[0] == 0.0
    steps = steps_of(scene, 1000)
    assert [round(i * steps.size_s, 6) for i in jump_steps(scene, steps)] == [105.0, 405.0, 815.0, 1105.0]


def test_events_within_equal_steps_are_rejected_with_a_reason() -> None:
    for engine in ENGINES:
        assert "edge" in (engine.unsupported(load_scene("effects/solar_shadow")) or "")
        assert "impulse" in (engine.unsupported(load_scene("effects/impulse")) or "")
    odd = dataclasses.replace(
        load_scene("effects/thrust_table").effects.thrust[0], times_s=(105.0, 295.0, 605.3, 815.0)
    )
    assert all("605.3" in (engine.unsupported(with_effects("thrust_table", thrust=(odd,))) or "") for engine in ENGINES)
    slews = load_scene("effects/slews").effects.prescribed_rotation[:1]
    both = with_effects("thrust_table", prescribed_rotation=slews)
    assert all("wrong accelerations" in (engine.unsupported(both) or "") for engine in REDUNDANT)


@pytest.mark.parametrize("engine", [Exudyn, ExudynTree])
def test_a_bar_that_turns_its_other_face_ends_the_run_with_a_reason(engine: type[Engine]) -> None:
    scene = load_scene("effects/solar_shadow")
    light = scene.effects.solar_pressure
    assert light is not None
    scene = with_effects("solar_shadow", solar_pressure=dataclasses.replace(light, shadow=False))
    with pytest.raises(UnsupportedMotionError, match=r"other face to the Sun between t = "):
        engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 500))


def test_newtons_tolerance_knows_how_far_effects_take_the_chain() -> None:
    plain, flat = load_scene("paper/fig13"), load_scene("effects/oblateness")
    none = with_effects("oblateness", oblateness=None)
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
    effects = dataclasses.replace(slews.effects, gravity=Gravity.QUADRUPOLE, oblateness=flat, third_body=moon)
    scene = shortened(dataclasses.replace(slews, effects=effects), 300.0, 7)
    exact = solutions.run(scene, 1e-12)
    assert exact.angle_rad is not None
    errors = []
    for k in (10000, 20000):
        found = engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, k))
        assert found.angle_rad is not None
        errors.append(float(np.abs(found.angle_rad - exact.angle_rad).max()))
    assert 3.4 < errors[0] / errors[1] < 4.6
