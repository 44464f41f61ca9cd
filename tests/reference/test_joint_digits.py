"""Reactions and steps keep nearly all digits where joint systems or coordinates lose many."""

from dataclasses import replace

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.reference.compiled_engine import ReferenceFast
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from barchain.solutions.judging import solution_engine
from benchmarks.random_campaign.scenes import draw
from reference_impl.model.chain import ChainModel
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.relative import accelerations
from reference_impl.precision import formulations
from reference_impl.precision.arithmetic import EXACT, exact_numbers
from reference_impl.precision.chain import ChainParameters, consistent_chain_state
from scenarios import Scene, load_scene
from tests.support.compiled_evaluation import refined_reactions

MU_M3_S2, RADIUS_M = 3.986004418e14, 6728e3
KEPT = 64.0 * np.finfo(float).eps
"""Of the largest reaction: a few roundings of what is summed along 500 bars, as a random walk"""
KINDS = [
    "straight",
    "straight alternating",
    "bent alternating",
    "straight tip",
    "counter-rotating",
    "bent compact",
    "straight compact",
]


def chain(kind: str, bars: int) -> tuple[ChainModel, np.ndarray, np.ndarray]:
    """Model, angles from the inertial axis and rates over the orbit's."""
    mass, angle, factor = np.full(bars, 100.0), np.full(bars, np.radians(80.0)), np.ones(bars)
    if "alternating" in kind:
        mass[1::2] = 1e-4
    if "tip" in kind:
        mass[-1] = 1e9
    if "counter-rotating" in kind:
        factor = 1e3 * (-1.0) ** np.arange(bars)
    if "bent" in kind:
        angle = np.random.default_rng(bars).uniform(-np.pi, np.pi, bars)
    length = np.full(bars, 10.0)
    gyration2 = 1e-8 * length**2 if "compact" in kind else length**2 / 12.0
    return ChainModel(MU_M3_S2, mass, length, mass * gyration2, "gradient"), angle, factor


@pytest.mark.parametrize("bars", [5, 500])
@pytest.mark.parametrize("kind", KINDS)
def test_reactions_keep_their_digits_whatever_the_condition_number(kind: str, bars: int) -> None:
    model, angle, factor = chain(kind, bars)
    com, rate = np.array([RADIUS_M * 0.6, RADIUS_M * 0.8]), np.sqrt(MU_M3_S2 / RADIUS_M**3) * factor
    state = consistent_state(model, com, np.zeros(2), angle, rate)
    with exact_numbers():
        own = [EXACT.cast(v[:, None]) for v in (model.mass_kg, model.length_m, model.inertia_kg_m2)]
        exact = ChainParameters(EXACT.cast(np.array([MU_M3_S2])), *own)
        given = [EXACT.cast(v[:, None]) for v in (com, angle, rate)]
        found = (
            formulations.relative(EXACT, exact, consistent_chain_state(EXACT, exact, *given))
            .reaction_N[..., 0]
            .astype(float)
            .T
        )
    for reaction in (accelerations(model, 0.0, state).reaction_N, refined_reactions(model, state)):
        assert np.abs(reaction - found).max() < KEPT * np.abs(found).max()


def test_joints_lost_in_rounding_are_said_to_be_and_those_at_its_edge_are_kept() -> None:
    """Entries 1e14 apart: five bars keep their digits, of five hundred nothing is left."""
    for bars, lost in ((5, False), (500, True)):
        model, angle, factor = chain("straight alternating compact", bars)
        state = consistent_state(model, np.array([RADIUS_M, 0.0]), np.zeros(2), angle, 1e-3 * factor)
        if lost:
            with pytest.raises(np.linalg.LinAlgError, match="not positive definite in double precision"):
                accelerations(model, 0.0, state)
            with pytest.raises(np.linalg.LinAlgError, match="not positive definite in double precision"):
                refined_reactions(model, state)
        else:
            of_both = accelerations(model, 0.0, state).reaction_N, refined_reactions(model, state)
            np.testing.assert_allclose(*of_both, rtol=1e-12, atol=1e-14 * np.abs(of_both[0]).max())


@pytest.mark.parametrize("engine", [Reference, ReferenceFast])
def test_no_request_makes_steps_shrink_to_the_rounding_of_angles(engine: type) -> None:
    """At a tenth of the error the eighth order takes 1.33 times the steps; light bars used to take a thousand times."""
    scene = load_scene("hard/masses_alternating")
    scene = replace(scene, run=replace(scene.run, duration_s=0.1 * scene.run.duration_s))
    coarse, fine = (engine().run(scene, engine.sweep.setting(rtol)).info["steps"] for rtol in (1e-11, 1e-14))
    assert fine <= 2.0 * 1.34**3 * coarse


@pytest.mark.parametrize("engine", [Reference, ReferenceFast])
def test_where_samples_are_taken_changes_no_bit_of_a_run(engine: type) -> None:
    scene = load_scene("hard/masses_alternating_light_ends")
    short = replace(scene.run, duration_s=0.05 * scene.run.duration_s)
    ends = [
        engine().run(replace(scene, run=replace(short, samples=n)), engine.sweep.setting(1e-13)).angle_rad[-1]
        for n in (2, 11, 201)
    ]
    assert (ends[0] == ends[1]).all()
    assert (ends[0] == ends[2]).all()


def moved(scene: Scene, engine: str) -> Trajectory:
    """Run of a form of the reference."""
    run = ENGINES[engine].load()()
    run.build(scene, Setting(AccuracyParameter.RTOL, 1e-12))
    run.simulate()
    return run.read()


def test_short_bars_on_soft_springs_are_as_accurate_as_round_off_in_absolute_coordinates_allows() -> None:
    """Eight bars of 0.1 to 0.2 m: the error estimate of long steps was 2000 times too small, the attitude 6e-5 rad off.

    A step is held to 6e-8 rad (4 roundings of the radius over the shortest bar) by its root mean square over 48
    components, so that one angle may have 4e-7 rad of a step, and 118 such steps 5e-6 rad as a random walk.
    """
    scene = draw(7192)
    right, absolute = moved(scene, solution_engine()), moved(scene, "reference-absolute")
    assert np.abs(absolute.angle_rad - right.angle_rad).max() < 5e-6
