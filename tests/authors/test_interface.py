"""The public interface for authors of engines: complete, documented, and right against the reference."""

from __future__ import annotations

import inspect
import math

import numpy as np
import pytest

from adapters.reference.numpy_engines import Reference
from barchain import engine as kit
from pictures.pages.interface_tables import engine_interface
from scenarios import Gravity, Scene, load_scene
from tests.support.changed import lasting, on_orbit, under, with_chain

EPS = np.finfo(float).eps
RNG = np.random.default_rng(5)


def unequal_chain() -> Scene:
    """Three unequal bars that turn at unequal rates."""
    scene = with_chain(
        load_scene("paper/fig05"),
        mass_kg=(70.0, 20.0, 110.0),
        length_m=(40.0, 100.0, 70.0),
        inertia_kg_m2=(9e3, 2e4, 5e4),
        angle_rad=(1.0, 0.3, -2.0),
        rate_factor=(1.0, -2.0, 0.5),
    )
    return on_orbit(scene, longitude_rad=0.7)


def still_frame(scene: Scene) -> kit.FrameState:
    start = kit.initial_state(scene)
    return kit.FrameState(*start.com_m.tolist(), *start.com_velocity_m_s.tolist())


INTERFACE = engine_interface()


def test_every_public_name_is_there_once_and_in_the_table_of_the_docstring() -> None:
    assert len(kit.__all__) == len(set(kit.__all__))
    assert all(hasattr(kit, name) for name in kit.__all__)
    assert all(f"`{name}`" in str(kit.__doc__) for name in kit.__all__)


@pytest.mark.parametrize("name", [n for n in kit.__all__ if n[0].isupper() and inspect.isclass(getattr(kit, n))])
def test_every_field_and_declaration_of_a_public_class_is_in_the_tables(name: str) -> None:
    section = INTERFACE.partition(f"\n## `{name}`\n")[2].partition("\n## ")[0]
    own = inspect.get_annotations(getattr(kit, name))
    assert not [field for field in own if not field.startswith("_") and f"| `{field}` |" not in section]


@pytest.mark.parametrize("name", [n for n in kit.__all__ if inspect.isfunction(getattr(kit, n))])
def test_every_public_function_documents_parameters_and_result(name: str) -> None:
    text, called = str(inspect.getdoc(getattr(kit, name))), inspect.signature(getattr(kit, name))
    assert "Returns\n-------" in text
    assert all(word in text.partition("Parameters\n----------")[2] for word in called.parameters)


def test_a_state_and_its_track_come_back_from_its_joint_coordinates() -> None:
    scene = unequal_chain()
    start, length = kit.initial_state(scene), np.array(scene.chain.length_m)
    q, q_t = kit.to_joint_coordinates(length, start)
    bars = kit.from_joint_coordinates(length, q[None], q_t[None])
    for mine, theirs in (
        (bars.position_m, start.position_m),
        (bars.velocity_m_s, start.velocity_m_s),
        (bars.angle_rad, start.angle_rad),
        (bars.rate_rad_s, start.rate_rad_s),
    ):
        assert np.abs(mine[0] - theirs).max() <= 16 * EPS * np.abs(theirs).max()
    com, velocity = bars.track(np.array(scene.chain.mass_kg), start.com_m[None], start.com_velocity_m_s[None])
    assert np.abs(com[0] - start.com_m).max() <= 2 * np.spacing(scene.radius0_m)
    assert np.abs(velocity[0] - start.com_velocity_m_s).max() <= 2 * np.spacing(scene.speed0_m_s)


def test_bar_accelerations_are_the_time_derivative_of_velocities() -> None:
    length, (q, q_t, q_tt), dt = np.array([40.0, 100.0, 70.0]), RNG.uniform(-1.0, 1.0, (3, 1, 5)), 1e-5
    after, before = (
        kit.from_joint_coordinates(length, q + s * q_t + 0.5 * s * s * q_tt, q_t + s * q_tt).velocity_m_s
        for s in (dt, -dt)
    )
    seen = kit.bar_accelerations(length, q, q_t, q_tt)
    assert seen == pytest.approx((after - before) / (2.0 * dt), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("on_next_bar", [True, False])
@pytest.mark.parametrize("components", [2, 3])
def test_a_reaction_is_the_same_from_a_wrench_in_any_axes_and_on_either_bar(on_next_bar: bool, components: int) -> None:
    reaction, axes = RNG.uniform(-1.0, 1.0, (4, 2)), RNG.uniform(-3.0, 3.0, 4)
    c, s = np.cos(axes), np.sin(axes)
    there = np.stack([c * reaction[:, 0] + s * reaction[:, 1], c * reaction[:, 1] - s * reaction[:, 0]], axis=-1)
    given = np.column_stack([-there if on_next_bar else there, np.full((4, components - 2), 7.0)])
    found = kit.reaction_from_wrench(given, on_next_bar=on_next_bar, axes_rad=axes)
    assert np.abs(found - reaction).max() <= 4 * EPS


def test_a_wrench_with_its_moment_is_rejected() -> None:
    with pytest.raises(ValueError, match=r"shape \(4, 6\), expected"):
        kit.reaction_from_wrench(np.zeros((4, 6)), on_next_bar=True)


@pytest.mark.parametrize("gravity", [Gravity.POINT, Gravity.GRADIENT, Gravity.SLENDER])
def test_forces_and_newtons_law_give_the_reactions_of_the_reference(gravity: Gravity) -> None:
    scene = under(unequal_chain(), gravity=gravity)
    start, length, mass = kit.initial_state(scene), np.array(scene.chain.length_m), np.array(scene.chain.mass_kg)
    forces = kit.ChainForces(scene)
    force, torque = forces(still_frame(scene), start.position_m, start.angle_rad, start.velocity_m_s, start.rate_rad_s)
    q, q_t = kit.to_joint_coordinates(length, start)
    width = len(q)
    reach = kit.bar_accelerations(length, np.tile(q, (width, 1)), np.zeros((width, width)), np.eye(width))
    turn = kit.bar_angles(np.eye(width))
    (bias,) = kit.bar_accelerations(length, q[None], q_t[None], np.zeros((1, width)))
    inertia = np.einsum("aji,bji,j->ab", reach, reach, mass) + turn * np.array(scene.chain.inertia_kg_m2) @ turn.T
    push = np.einsum("aji,ji->a", reach, force - mass[:, None] * bias) + turn @ torque
    (motion,) = kit.bar_accelerations(length, q[None], q_t[None], np.linalg.solve(inertia, push)[None])
    found = kit.reactions_from_motion(mass, motion, force)
    expected = Reference().run(lasting(scene, 1.0, 2)).reaction_N
    assert expected is not None
    assert np.abs(found - expected[0]).max() <= 1e-11 * np.abs(expected[0]).max()


def test_forces_in_a_falling_frame_keep_their_digits_where_whole_forces_lose_them() -> None:
    scene = unequal_chain()
    start = kit.initial_state(scene)
    bars = start.position_m, start.angle_rad, start.velocity_m_s, start.rate_rad_s
    falling, _ = kit.ChainForces(scene)(still_frame(scene), *bars)
    whole, _ = kit.ChainForces(scene, falling=False)(
        kit.FrameState(0.0, 0.0), start.com_m + start.position_m, *bars[1:]
    )
    share = np.array(scene.chain.mass_kg)[:, None] * scene.central_body.mu_m3_s2 / scene.radius0_m**3
    apart = np.abs(falling - (whole + share * start.com_m)).max()
    assert 0.0 < apart <= 16 * EPS * np.abs(whole).max()
    assert np.abs(falling).max() < 1e-4 * np.abs(whole).max()


@pytest.mark.parametrize("name", ["basics/kepler_elliptic", "effects/oblateness", "basics/free_rotation"])
def test_an_integrated_frame_falls_along_the_frames_own_track(name: str) -> None:
    from scipy.integrate import solve_ivp

    scene = load_scene(name)
    start, end = kit.initial_state(scene), 0.2 * scene.period_s
    y0 = np.concatenate([start.com_m, start.com_velocity_m_s])
    own = solve_ivp(kit.fall_rate(scene), (0.0, end), y0, method="DOP853", rtol=1e-12, atol=1e-6).y[:, -1]
    origin, drift = kit.free_fall(scene, start, np.array([0.0, end]))
    assert np.abs(own[:2] - origin[-1]).max() <= 1e-9 * scene.radius0_m
    assert np.abs(own[2:] - drift[-1]).max() <= 1e-9 * scene.speed0_m_s


def test_accuracy_counts_in_radii_longest_bars_radians_and_the_fastest_rate() -> None:
    scene = unequal_chain()
    unit = kit.accuracy_scales(scene)
    assert unit.track_m == scene.radius0_m
    assert unit.length_m == 100.0
    assert unit.rate_rad_s == pytest.approx(2.0 * scene.orbital_rate_rad_s)
    assert unit.joint_coordinates(3) == pytest.approx(
        np.array([100.0, 100.0, 1.0, 1.0, 1.0, 100.0 * unit.rate_rad_s, 100.0 * unit.rate_rad_s]
                 + 3 * [unit.rate_rad_s])
    )  # fmt: skip


@pytest.mark.parametrize(
    ("angle", "height"), [(0.0, 90.0), (math.pi / 2, math.hypot(100.0, 0.0)), (math.pi / 4, 50.0 * math.sqrt(2.0))]
)
def test_the_height_of_a_bar_is_that_of_its_nearest_point(angle: float, height: float) -> None:
    # a bar of 20 m at 100 m from the centre, and one at 45 degrees whose foot of the perpendicular is inside it
    length = np.array([20.0 if angle != math.pi / 4 else 400.0])
    found = kit.least_height_m(1.0, length, np.array([[100.0, 0.0]]), np.array([angle]))
    assert found == pytest.approx(height - 1.0)


def test_a_bar_at_the_surface_raises_unless_it_is_a_trial_state() -> None:
    scene = unequal_chain()
    start = kit.initial_state(scene)
    bars = start.position_m, start.angle_rad, start.velocity_m_s, start.rate_rad_s
    low = kit.FrameState(scene.central_body.radius_m + 1.0, 0.0)
    with pytest.raises(kit.LandedError):
        kit.ChainForces(scene)(low, *bars)
    kit.ChainForces(scene, surface=False)(low, *bars)
