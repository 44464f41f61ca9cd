"""Engines against the reference and closed forms, all by the same tests: what each may err stands beside its name."""

import dataclasses
import functools
import math
from itertools import pairwise

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.kepler import propagate
from adapters.engine import EngineError, Setting
from adapters.ida.chain import Form, RedundantChain
from adapters.registry import ENGINES
from scenarios import Gravity, load_scene
from tests.support.generic_scenes import generic, of_bars, solution, solution_at_start, steep, worst
from tests.support.slow import left_to_later
from tests.support.step_order import JUMPING, SMOOTH, by_steps, effect_scene, errors

EPS = np.finfo(float).eps
IDA = ("ida-index1", "ida-index2", "ida-ggl", "ida-index3")
IN_JOINT_ANGLES = ("pinocchio", "drake", "dart")


def of_those_here(*cases):
    """Parameters of cases whose engines are installed; an engine's name comes first."""
    there = {name for name, registration in ENGINES.items() if registration.missing is None}
    return [case for case in cases if (case if isinstance(case, str) else case[0]) in there]


@functools.lru_cache(16)
def run(engine, scene, value):
    loaded = ENGINES[engine].load()
    return loaded().run(scene, Setting(loaded.sweep.parameter, value))


def built(engine, scene):
    made = ENGINES[engine].load()()
    made.build(scene, made.sweep.setting())
    return made


def start_of_mujoco(scene):
    """Its mass matrix is in joint angles: three digits or four are lost for unequal bars."""
    import mujoco

    # two samples an instant apart: what is read at the first is the initial state's
    engine = built("mujoco", dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=1e-3, samples=2)))
    engine.simulate()
    engine.seen = engine.seen[:1]
    reaction = engine.read().reaction_N[0]
    mass = np.zeros((scene.bars + 2,) * 2)
    mujoco.mj_fullM(engine.model, engine.data, mass)
    unit = np.sqrt(np.diag(mass))  # metres and radians apart
    lost = 4.0 * EPS * float(np.linalg.cond(mass / np.outer(unit, unit)))
    return np.cumsum(engine.data.qacc[2:]), reaction, lost


def start_in_joint_angles(engine, scene):
    made = built(engine, scene)
    rate = made.chain.rate(0.0, made.problem.y0)
    return np.cumsum(rate[-scene.bars :]), made.chain.reactions(made.problem.y0), 100.0 * EPS


def start_of_ida(scene):
    chain = RedundantChain(scene, Form.INDEX_1)
    y, slopes = chain.consistent(0.0, chain.start(initial_state(scene)) / chain.units)
    angular = (slopes * chain.units * chain.rate)[chain.v][-scene.bars :]
    return angular, (y * chain.units)[chain.reactions].reshape(2, -1).T, 100.0 * EPS


STARTS = {
    "mujoco": start_of_mujoco,
    "ida-index1": start_of_ida,
    **{engine: functools.partial(start_in_joint_angles, engine) for engine in IN_JOINT_ANGLES},
}
"""Angular accelerations and reactions of an engine at t = 0, and what share of the largest may be lost"""


@pytest.mark.parametrize("engine", of_those_here(*STARTS))
@pytest.mark.parametrize("gravity", list(Gravity))
@pytest.mark.parametrize("size", [1.0, 1e-4])
def test_accelerations_and_reactions_are_the_references_to_round_off(size, gravity, engine):
    for seed in range(3):
        scene = generic(seed, size=size, gravity=gravity)
        angular, reaction, lost = STARTS[engine](scene)
        true = solution_at_start(scene)
        assert lost < 1e-11
        assert worst(angular, true.angle_rad_s2) < lost * np.abs(true.angle_rad_s2).max()
        assert worst(reaction, true.reaction_N) < lost * np.abs(true.reaction_N).max()


@pytest.mark.parametrize(
    ("engine", "bars"), of_those_here(("mujoco", 200), ("pinocchio", 100), ("drake", 50), ("dart", 50))
)
def test_reactions_of_long_chains_lose_no_more_than_a_rounding_a_bar(engine, bars):
    scene = of_bars(steep(), bars)
    true = solution_at_start(scene).reaction_N
    assert worst(STARTS[engine](scene)[1], true) < 16.0 * EPS * bars * np.abs(true).max()


@pytest.mark.parametrize(
    ("engine", "rtol", "speeds"),
    of_those_here(("pinocchio", 1e-12, (0.9, 1.0, 1.1, 1.6)), ("drake", 1e-11, (1.1,)), ("dart", 1e-11, (1.1,))),
)
def test_runs_agree_with_the_reference(engine, rtol, speeds):
    for speed in speeds:
        scene = steep(orbits=0.5, name="paper/fig15", speed_factor=speed, longitude_rad=2.5)
        for channel in ("angle_rad", "rate_rad_s", "reaction_N"):
            found, true = getattr(run(engine, scene, rtol), channel), getattr(solution(scene), channel)
            # a step asks for rtol and takes some radians: a few dozen steps, of RK5 some 300 of either sign
            assert worst(found, true) < 100.0 * rtol * max(1.0, np.abs(true).max())


@pytest.mark.parametrize(
    ("engine", "scene", "coarsest", "ratio"),
    of_those_here(
        ("pinocchio", "paper/fig05", 1e-6, (50.0, 150.0)),
        # RK5 gains somewhat less: it propagates the fifth order and estimates the error of the fourth
        ("drake", "paper/fig13", 1e-6, (30.0, 300.0)),
        ("dart", "paper/fig13", 1e-6, (30.0, 300.0)),
        *((engine, "paper/fig13", 1e-5, (10.0, 1000.0)) for engine in IDA[:3]),
    ),
)
def test_a_tenth_of_the_tolerance_is_a_tenth_of_the_error(engine, scene, coarsest, ratio):
    scene = steep(name=scene)
    tolerances = (coarsest, 1e-2 * coarsest, 1e-4 * coarsest)
    error = [worst(run(engine, scene, rtol).angle_rad, solution(scene).angle_rad) for rtol in tolerances]
    for coarse, fine in pairwise(error):
        assert ratio[0] < coarse / fine < ratio[1]


@pytest.mark.parametrize(
    ("engine", "value"), of_those_here(("mujoco", 1000), ("pinocchio", 1e-12), ("drake", 1e-11), ("dart", 1e-11))
)
def test_the_centre_of_mass_follows_kepler_where_there_is_but_one_bar(engine, value):
    for name in (
        ("kepler_circular", "kepler_elliptic", "kepler_hyperbolic") if engine == "mujoco" else ("kepler_elliptic",)
    ):
        scene = load_scene(f"basics/{name}")
        start = np.array([scene.radius0_m, 0.0]), np.array([0.0, scene.speed0_m_s])
        place, _ = propagate(scene.central_body.mu_m3_s2, *start, scene.times_s)
        found = run(engine, scene, value)
        if engine == "mujoco":  # in a frame that falls along Kepler's orbit
            allowed = 4.0 * EPS * scene.speed0_m_s * scene.run.duration_s + np.spacing(np.abs(place).max())
        else:
            # the track is integrated with the chain: rtol of the radius in each step, run along it by 1 + 3 n t
            run_along = 1.0 + 3.0 * 2.0 * np.pi * scene.run.duration_s / scene.step_period_s
            allowed = value * scene.radius0_m * found.info["steps"] * run_along
        assert worst(found.com_m, place) < allowed
        assert found.reaction_N.shape == (scene.run.samples, 0, 2)


@pytest.mark.parametrize(
    ("engine", "value", "allowed_s"),
    of_those_here(
        ("mujoco", 2000, None),  # a step
        ("pinocchio", 1e-10, 2e-6),  # as printed
        ("drake", 1e-10, 2e-6),
        ("dart", 1e-10, 2e-6),
        # kilometres a second: 1e-7 of the radius in each of some hundred steps
        *((engine, 1e-7, 0.1) for engine in IDA),
        # metres a millisecond: 1e-9 of the radius in some steps
        *((engine, 1e-9, 1e-3) for engine in ("scipy-dop853", "scipy-radau", "cvode-adams", "cvode-bdf")),
    ),
)
def test_a_fall_ends_at_the_surface(engine, value, allowed_s):
    scene = steep(orbits=0.2, samples=28, name="paper/fig15", speed_factor=0.0)
    found, true = run(engine, scene, value), solution(scene)
    instant, expected = (float(t.ended.split()[-2]) for t in (found, true))
    assert "a bar reached the surface" in found.ended
    assert abs(instant - expected) < (allowed_s or 1.01 * found.info["dt_s"])
    assert len(found.t_s) == len(found.angle_rad) == len(found.reaction_N) == len(true.t_s) < scene.run.samples


@pytest.mark.parametrize("engine", of_those_here(*IN_JOINT_ANGLES))
def test_a_state_that_is_not_finite_is_an_error(engine):
    made = built(engine, generic(1))
    made.problem.y0[6] = np.nan
    with pytest.raises(EngineError, match="not finite"):
        made.simulate()


def some_of(share, engines, names):
    """Pairs of engines and effects: in the default run each engine has some effects, and each effect some engine."""
    there = of_those_here(*engines)
    pairs = [(k + j, engine, name) for k, engine in enumerate(there) for j, name in enumerate(names)]
    return left_to_later((pytest.param(*pair), k % share == share - 1) for k, *pair in pairs)


BY_STEPS = {"pymunk": (2.0, 0.3, 0.2, 20), "pymunk-absolute": (2.0, 0.3, 0.2, 4), "mujoco": (4.0, 0.6, 0.4, 4)}
"""Order with what may be off, share of the scene, and steps in a sample: of more, errors drown in places' rounding"""


@pytest.mark.parametrize(("engine", "name"), some_of(3, BY_STEPS, SMOOTH + JUMPING))
def test_every_effect_is_carried_to_the_methods_order(engine, name):
    """Against the reference: twice the steps leave 1/4 or 1/16, with events and impulses."""
    order, off, share, steps = BY_STEPS[engine]
    scene, loaded = effect_scene(name, share), ENGINES[engine].load()
    coarse, fine = (errors(by_steps(loaded, scene, n), scene) for n in (steps, 2 * steps))
    assert ("impulse_N_s" in fine) == (name == "impulse")
    for channel, error in fine.items():
        assert math.log2(coarse[channel] / error) == pytest.approx(order, abs=off), channel


BY_TOLERANCE = {
    "pinocchio": (1.0, 1e-12, 200.0 * 1e-12),
    "drake": (1.0, 1e-11, 200.0 * 1e-11),
    "dart": (1.0, 1e-11, 200.0 * 1e-11),
    **dict.fromkeys(IDA, (0.1, 1e-7, 50.0 * 1e-4)),
}
"""Share of the scene, request and error in units of a channel's size: of some hundred steps; another law would show"""


@pytest.mark.parametrize(("engine", "name"), some_of(5, BY_TOLERANCE, (*SMOOTH, *JUMPING, "solar_pressure")))
def test_every_effect_is_carried_to_the_accuracy_asked_for(engine, name):
    share, rtol, allowed = BY_TOLERANCE[engine]
    scene = effect_scene(name, share)
    found, true = run(engine, scene, rtol), solution(scene)
    for channel, error in errors(found, scene).items():
        size = max(np.abs(getattr(true, channel)).max(), 1e-30)  # before a blow there is no impulse
        assert error < allowed * max(size, channel == "angle_rad" and engine not in IDA), channel


@pytest.mark.parametrize(
    ("engine", "name", "words"),
    of_those_here(
        ("pymunk", "paper/fig17", "not follow a law"),
        ("pymunk-absolute", "paper/fig17", "not follow a law"),
        ("mujoco", "paper/fig17", "soft"),
        ("pinocchio", "paper/fig17", "takes torques"),
        ("drake", "paper/fig17", "law"),
        ("dart", "paper/fig17", "law"),
        ("exudyn-tree", "paper/fig17", "constraint"),
        ("pymunk", "effects/solar_shadow", "shadow's edge"),
        ("mujoco", "effects/solar_shadow", "shadow's edge"),
        *((engine, "effects/solar_shadow", "depend on the motion") for engine in IN_JOINT_ANGLES),
    ),
)
def test_what_an_engine_can_not_do_is_said_with_a_reason(engine, name, words):
    assert words in ENGINES[engine].load().unsupported(load_scene(name))


@pytest.mark.parametrize("engine", of_those_here("pymunk", "mujoco"))
def test_events_within_a_step_are_rejected(engine):
    assert "midway between two" in ENGINES[engine].load().unsupported(effect_scene("thrust_table", 0.9975))
