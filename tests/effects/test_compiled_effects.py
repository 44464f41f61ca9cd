"""Effects in compiled code against the NumPy reference: evaluation by evaluation, step by step, event by event."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from adapters.common.reference_model import chain_model
from adapters.reference.compiled_engine import ReferenceFast
from adapters.reference.numpy_engines import Reference
from adapters.trajectory import Trajectory
from barchain.runs.executors import LocalProcesses
from barchain.studies.distributions import VariationError
from barchain.studies.ensemble.study import ensemble
from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.effects.joint_torque import JointTorqueEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.slender import SlenderBarEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.effects.thrust import ThrustEffect
from reference_impl.model import relative
from reference_impl.model.arrays import Array
from reference_impl.model.effect import ChainEffect
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.state import Accelerations
from scenarios import Scene, change_scene, load_scene, scene_names
from tests.effects.effect_sizes import sizes
from tests.reference.laws import LAWS
from tests.support.compiled_evaluation import compiled_accelerations
from tests.support.joint_roundoff import MU, RADIUS, C, Case, U, case, forward, joint_bound, magnitudes, sums
from tests.support.kernel import needs_kernel
from tests.support.slow import one_in

pytestmark = needs_kernel
BARS, NOW_S = 5, 25.0


def effect(name: str, random: np.random.Generator) -> ChainEffect:
    """One effect at sizes where none is lost beside the others."""
    width = random.uniform(0.05, 2.0, BARS)
    joints, angle, second = BARS - 1, random.uniform(-3.0, 3.0), bool(random.integers(2))
    made = {
        "quadrupole": QuadrupoleEffect,
        "slender": SlenderBarEffect,
        "oblateness": lambda: OblatenessEffect(0.5 * MU * 1.08e-3 * RADIUS**2, True, second),
        "oblateness_point": lambda: OblatenessEffect(0.5 * MU * 1.08e-3 * RADIUS**2, False, False),
        "third_body": lambda: ThirdBodyEffect(4.9e12, 3.8e8, angle, 2.7e-6, True, second),
        "drag": lambda: DragEffect(1e-10, RADIUS + 300e3, 6e5, 7.3e-5, width, 2.2, 1.8),
        "solar_pressure": lambda: SolarPressureEffect(4.5e-6, angle, 2e-7, width, 0.3, RADIUS),
        "joint_spring_damper": lambda: JointSpringDamperEffect(*random.uniform(0.0, 1e3, (3, joints))),
        "joint_torque": lambda: JointTorqueEffect(np.array([0.0, 20.0, 20.0, 90.0]), np.array([0.1, 5.0, 2.0, 3.0]), 2),
        "thrust": lambda: ThrustEffect(np.array([0.0, 20.0, 90.0]), np.array([0.1, 5.0, 2.0]), 2, -1.0, second, 0.7),
    }  # fmt: skip
    return made[name]()


ALONE = (
    "quadrupole", "slender", "oblateness", "oblateness_point", "third_body", "drag", "solar_pressure",
    "joint_spring_damper", "joint_torque", "thrust",
)  # fmt: skip
TOGETHER = (
    ("oblateness", "thrust", "thrust"),
    ("third_body", "joint_spring_damper", "third_body", "drag"),
    ("slender", "oblateness", "third_body", "drag", "solar_pressure", "joint_spring_damper", "joint_torque", "thrust"),
)


def acted_on(names: tuple[str, ...], seed: int, gravity: str, decades: float = 0.5, laws=()) -> Case:
    c = case(seed, BARS, gravity, decades, laws)
    random = np.random.default_rng(seed)
    return Case(replace(c.model, effects=tuple(effect(name, random) for name in names)), c.state)


def allowed(c: Case, a: Accelerations, t_s: float) -> tuple[Array, Array, float]:
    """Rounding of reactions (N-1,), angular accelerations (N,) and that of the centre of mass, between both codes.

    Unit vectors are two units in the last place apart, 4 u each, on both sides of the joints' system.
    """
    m, size, plain = c.model, sizes(c, t_s), magnitudes(c, a)
    ends = size.acceleration + m.half_m * size.spin
    opening = 2.0 * 4.0 * (joint_bound(c, a) + C * U * (ends[1:] + ends[:-1]))
    reaction = forward(c, opening)
    levers = sums(np.repeat(reaction[:, None], 2, axis=1))[0][:, 0] * m.lever
    com = float(np.linalg.norm(a.com_m_s2)) + size.common + float(size.acceleration.max())
    return reaction, levers + 4.0 * C * U * (plain.angular + size.spin), C * U * com + m.bars * U * plain.tide


@pytest.mark.parametrize("gravity", ["point", "gradient"])
@pytest.mark.parametrize("seeds", [range(10), pytest.param(range(100, 490), marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize("names", [*((name,) for name in ALONE), *TOGETHER], ids="+".join)
def test_one_evaluation_is_the_references_to_round_off(names: tuple[str, ...], seeds: range, gravity: str) -> None:
    """As without effects; what they add enters each residual by its own terms, `tests.effects.effect_sizes`."""
    for seed in seeds:
        c = acted_on(names, seed, gravity)
        m = c.model
        a, b = relative.accelerations(m, NOW_S, c.state), compiled_accelerations(m, NOW_S, c.state)
        reaction, angular, com = allowed(c, a, NOW_S)
        assert np.all(np.linalg.norm(a.reaction_N - b.reaction_N, axis=1) <= reaction)
        assert np.all(np.abs(a.angle_rad_s2 - b.angle_rad_s2) <= angular)
        assert np.linalg.norm(a.com_m_s2 - b.com_m_s2) <= com


@pytest.mark.parametrize("form", [relative.accelerations, compiled_accelerations], ids=["numpy", "compiled"])
@pytest.mark.parametrize("names", TOGETHER[1:], ids="+".join)
def test_a_law_against_the_local_horizontal_holds_whatever_acts(names: tuple[str, ...], form: Callable) -> None:
    """What moves the bar sideways turns its horizontal: theta'' - omega'' of what came out is the law's.

    Gravity's share of omega'' cancels to the rounding of gravity over the distance.
    """
    laws = LAWS["two at once"]
    for seed in range(5):
        c = acted_on(names, seed, "gradient", laws=laws)
        s, found = c.state, form(c.model, NOW_S, c.state)
        size, plain = sizes(c, NOW_S), magnitudes(c, found)
        for p in laws:
            z, v = s.com_m + s.position_m[p.bar], s.com_velocity_m_s + s.velocity_m_s[p.bar]
            pull = found.com_m_s2 + found.position_m_s2[p.bar]
            r2 = z @ z
            law = p.acceleration_rad_s2(NOW_S)
            turn = 2.0 * (z @ v) * (z[0] * v[1] - z[1] * v[0]) / r2**2
            omega = (z[0] * pull[1] - z[1] * pull[0]) / r2 - turn
            left = found.angle_rad_s2[p.bar] - (omega if p.frame == "local_horizontal" else 0.0)
            terms = plain.angular + size.spin + (plain.pull + size.acceleration) / np.sqrt(r2)
            scale = terms.max() + (np.linalg.norm(pull) + size.common) / np.sqrt(r2) + 2.0 * (v @ v) / r2
            assert abs(left - law) <= 4.0 * C * U * scale


def alike(scene: Scene, rtol: float = 1e-9) -> tuple:
    """Both runs, their steps and samples the same, their states as far apart as rounding grows."""
    setting = Reference.sweep.setting(rtol)
    theirs, mine = Reference().run(scene, setting), ReferenceFast().run(scene, setting)
    assert mine.info["steps"] == theirs.info["steps"]
    np.testing.assert_array_equal(mine.t_s, theirs.t_s)
    # C roundings of each step, grown like gravity's fastest instability, e^(sqrt 3 n t)
    span_s, steps = scene.run.duration_s, theirs.info["steps"]
    amplification = np.exp(np.sqrt(3.0) * scene.mean_motion_rad_s * span_s)
    angular, com = accelerations_apart(scene, theirs)
    for name, pushed in (
        ("com_m", 0.5 * com * span_s**2), ("com_velocity_m_s", com * span_s), ("angle_rad", 0.5 * angular * span_s**2),
    ):  # fmt: skip
        a, b = getattr(theirs, name), getattr(mine, name)
        assert np.abs(a - b).max() <= amplification * (C * U * steps * np.abs(a).max() + pushed), name
    return theirs, mine


def accelerations_apart(scene: Scene, trajectory: Trajectory) -> tuple[float, float]:
    """Largest rounding of angular accelerations and that of the centre of mass, at any sample: it acts all the time."""
    model, found = chain_model(scene), []
    for t, *parts in zip(
        trajectory.t_s,
        trajectory.com_m,
        trajectory.com_velocity_m_s,
        trajectory.angle_rad,
        trajectory.rate_rad_s,
        strict=True,
    ):
        c = Case(model, consistent_state(model, *parts))
        found.append(allowed(c, relative.accelerations(model, t, c.state), t)[1:])
    return max(float(angular.max()) for angular, _ in found), max(com for _, com in found)


HELD_UP = {"effects/tether_bodies"}
"""Light bars between heavy bodies: round-off, which differs, decides on some steps"""


@pytest.mark.parametrize("name", one_in(4, [n for n in scene_names() if n.startswith("effects/") and n not in HELD_UP]))
def test_it_takes_the_references_steps_and_blows(name: str) -> None:
    scene = load_scene(name)
    theirs, mine = alike(replace(scene, run=replace(scene.run, duration_s=0.3 * scene.run.duration_s, samples=14)))
    if theirs.impulse_N_s is None:
        assert mine.impulse_N_s is None
        return
    worst = np.abs(theirs.impulse_N_s).max()
    assert worst > 0.0
    np.testing.assert_allclose(mine.impulse_N_s, theirs.impulse_N_s, rtol=0.0, atol=1e-9 * worst)


def test_the_shadow_is_entered_and_left_when_the_reference_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """To what the interpolants of both, some 1e-13 apart, leave of an instant: 1e-9 of a step of minutes."""
    from reference_impl.integrate.discrete_modes import DiscreteModes

    found: list[list[float]] = []
    plain = DiscreteModes.apply_event

    def noted(self, exact, t_s, step_s) -> tuple:
        met = plain(self, exact, t_s, step_s)
        found[-1].append(met[0])
        return met

    monkeypatch.setattr(DiscreteModes, "apply_event", noted)
    scene = load_scene("effects/solar_shadow")
    for kind in (Reference, ReferenceFast):
        found.append([])
        kind().run(scene, kind.sweep.setting(1e-9))
    assert len(found[0]) >= 2
    np.testing.assert_allclose(found[1], found[0], rtol=0.0, atol=1e-7)


def test_what_is_seen_on_a_jump_is_what_was_before_it() -> None:
    """Samples on a thrust's ends and on an impulse: reactions of both references are the same ones."""
    scene = load_scene("effects/everything")
    scene = replace(scene, run=replace(scene.run, duration_s=600.0, samples=121))
    jumps = [t for t in scene.effects.breaks_s if t in scene.times_s]
    assert jumps
    theirs, mine = alike(scene)
    on = np.isin(mine.t_s, jumps)
    worst = np.abs(theirs.reaction_N).max()
    assert np.abs(mine.reaction_N[on] - theirs.reaction_N[on]).max() <= 1e-9 * worst


def test_ensembles_carry_what_is_smooth() -> None:
    """A copy that varies by nothing is the scene's own run; starts made for all copies at once differ by roundings.

    Those of the start's rates act over the whole run, n t of them; those of a step in each; gravity lets both grow.
    """
    scene = load_scene("effects/oblateness")
    same = f"altitude_m=normal({scene.orbit.altitude_m!r}, 0)"
    found = ensemble(scene, [same], runs=2, orbits=0.2, samples=5, rtol=1e-9, executor=LocalProcesses(1))
    alone = ReferenceFast().run(found.scene, ReferenceFast.sweep.setting(1e-9))
    without = replace(found.scene, effects=replace(scene.effects, oblateness=None))
    turned = found.scene.mean_motion_rad_s * found.scene.run.duration_s
    worst = C * U * (turned + alone.info["steps"]) * np.exp(np.sqrt(3.0) * turned) * np.abs(alone.angle_rad).max()
    assert (found.runs.outcome == "finished").all()
    assert np.abs(found.angle_rad - alone.angle_rad).max() <= worst
    assert np.abs(ReferenceFast().run(without).angle_rad - alone.angle_rad).max() > 1e3 * worst  # it acts


@pytest.mark.parametrize("name", ["thrust", "joint_torque"])
def test_ensembles_carry_tables_in_time_whose_instants_are_outside_the_run(name: str) -> None:
    """A copy that varies by nothing is the scene's own run: a force that never jumps acts from start to end."""
    thrust = load_scene("effects/thrust")
    motor = {"joint": 1, "times_s": [0.0, 9000.0], "torque_N_m": [0.01, 0.02]}
    changes = {"joint_torque": [motor], "thrust": []} if name == "joint_torque" else {}
    scene = change_scene(thrust, {"effects": changes, "run": {"orbits": 0.1, "samples": 5}})
    same = f"altitude_m=normal({scene.orbit.altitude_m!r}, 0)"
    found = ensemble(scene, [same], runs=2, samples=5, rtol=1e-9, executor=LocalProcesses(1))
    alone, without = (
        ReferenceFast().run(one, ReferenceFast.sweep.setting(1e-9))
        for one in (found.scene, replace(found.scene, effects=replace(scene.effects, thrust=(), joint_torque=())))
    )
    acts = np.abs(alone.angle_rad - without.angle_rad).max()
    assert np.abs(found.angle_rad - alone.angle_rad).max() <= 1e-6 * acts  # both runs make the same steps


@pytest.mark.parametrize("name", ["drag", "joint_torque"])
def test_ensembles_refuse_faces_and_tables_in_time_that_jump_inside_the_run(name: str) -> None:
    motor = {"joint": 1, "times_s": [100.0, 200.0], "torque_N_m": [0.01, 0.02]}
    changes = {"effects": {"joint_torque": [motor]}} if name == "joint_torque" else {}
    scene = change_scene(load_scene("effects/thrust" if changes else "effects/drag"), changes)
    with pytest.raises(VariationError, match=rf"ensembles do not support {name} .*`barchain sweep`"):
        ensemble(scene, ["angle_deg=normal(0, 1)"], runs=2)
