"""Chains in lanes: the accelerations and steps of one chain at a time, and no bit from a lane's neighbours."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from barchain.studies.ensemble.population import batch, populate
from barchain.studies.ensemble.variation import parse
from reference_impl.kernel import layout
from reference_impl.kernel.batch import rows_of, run_batch, run_lanes, run_members
from reference_impl.kernel.layout import ARRIVED, GIVEN_BACK
from reference_impl.kernel.library import evaluate_in_lanes, lane_count
from reference_impl.model import relative
from scenarios import load_scene
from tests.support.changed import lasting
from tests.support.joint_roundoff import C, U, case, forward, joint_bound, magnitudes, sums
from tests.support.kernel import MISSING, needs_kernel

if TYPE_CHECKING:
    from reference_impl.kernel.batch import Batch
    from reference_impl.model.arrays import Array
    from tests.support.joint_roundoff import Case

pytestmark = needs_kernel
WIDTH = 8 if MISSING else lane_count()
RTOL = 1e-8
SPREAD = ("angle_deg[*]=normal(5, 3)", "mass_kg[2]=lognormal(100, 0.2)", "altitude_m=normal(4e5, 1e3)")


def drawn(name: str, runs: int, *vary: str, rtol: float = RTOL, samples: int = 11, orbits: float = 0.2):
    scene = load_scene(name)
    scene = lasting(scene, orbits * scene.period_s, samples)
    variations = tuple(parse(text, scene.bars) for text in vary or SPREAD)
    return batch(populate(scene, variations, runs, seed=1), rtol), scene.times_s


def segment(t_s: Array) -> Array:
    return np.array([[t_s[0], t_s[-1]]])


def rates_in_lanes(cases: list[Case]) -> Array:
    """Rates (lanes, 2N+4) of one case in each lane."""
    chains = [layout.compiled_chain(c.model) for c in cases]
    bars, runs = cases[0].model.bars, len(cases)
    states = [c.state for c in cases]
    y0 = np.array([layout.pack(s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s) for s in states])
    members = layout.BatchMembers(
        np.array([c.mu_m3_s2 for c in chains]), chains[0].gravity, np.concatenate([c.bars for c in chains]),
        np.zeros((0, 8)), (), np.zeros((runs, 3)), y0, np.ones_like(y0),
    )  # fmt: skip
    rates = np.zeros((runs, 2 * bars + 4))
    evaluate_in_lanes(members, rates, np.zeros((runs, 2, bars - 1)))
    return rates


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    bars=st.integers(1, 30),
    gravity=st.sampled_from(["none", "point", "gradient"]),
    decades=st.sampled_from([0.0, 2.0]),
)
def test_an_evaluation_in_every_lane_is_the_references_to_round_off(seed, bars, gravity, decades) -> None:
    """Both keep a joint's residual within `joint_bound`: their reactions differ by twice that through the joints."""
    cases = [case(seed + lane, bars, gravity, decades) for lane in range(WIDTH)]
    rates, n = rates_in_lanes(cases), bars
    for lane, c in enumerate(cases):
        a = relative.accelerations(c.model, 0.0, c.state)
        com_allowed = C * U * np.linalg.norm(a.com_m_s2) + bars * U * magnitudes(c, a).tide
        assert np.linalg.norm(rates[lane, 2 * n + 2 :] - a.com_m_s2) <= com_allowed
        np.testing.assert_array_equal(rates[lane, :n], c.state.rate_rad_s)
        # unit vectors two units in the last place apart, 4 u each, on both sides of the system
        allowed = forward(c, 2.0 * 4.0 * joint_bound(c, a)) if bars > 1 else np.zeros(0)
        levers = sums(np.repeat(allowed[:, None], 2, axis=1))[0][:, 0] * c.model.half_m / c.model.inertia_kg_m2
        difference = np.abs(rates[lane, n + 2 : 2 * n + 2] - a.angle_rad_s2)
        assert np.all(difference <= levers + 4.0 * C * U * magnitudes(c, a).angular)


def test_a_chain_has_the_same_bits_in_any_lane_beside_any_neighbours_in_any_part_on_any_thread() -> None:
    whole, t_s = drawn("paper/fig13", 3 * WIDTH + 5)
    together, runs = run_lanes(whole, t_s), len(whole.mu_m3_s2)
    order = np.random.default_rng(3).permutation(runs)
    parts = [order[:1], order[1 : WIDTH + 3], order[WIDTH + 3 :]]
    with ThreadPoolExecutor(2) as pool:
        apart = list(pool.map(lambda rows: run_lanes(rows_of(whole, rows), t_s), parts))
    for rows, found in zip(parts, apart, strict=True):
        for name, values in found._asdict().items():
            np.testing.assert_array_equal(values, getattr(together, name)[rows])


def growth(whole: Batch, t_s: Array, by_rad: float) -> float:
    """Growth of a difference of the angles at the start, over all chains and samples."""
    bars = whole.bars.shape[2]
    moved = whole.y0.copy()
    moved[:, :bars] += by_rad * np.resize([1.0, -1.0], bars)
    apart = run_lanes(whole._replace(y0=moved), t_s).angle_rad - run_lanes(whole, t_s).angle_rad
    return float(np.nanmax(np.abs(apart)) / by_rad)


@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_every_chain_takes_the_steps_that_it_takes_alone(rtol: float) -> None:
    """The angles differ by C roundings of each step in both runs, grown as differences at the start grow."""
    whole, t_s = drawn("paper/fig05", WIDTH + 2, "angle_deg=normal(0, 1)", rtol=rtol, orbits=1.0)
    lanes, alone = run_lanes(whole, t_s), run_batch(whole, t_s, segment(t_s))
    np.testing.assert_array_equal(lanes.code, ARRIVED)
    np.testing.assert_array_equal(lanes.steps, alone.steps)
    np.testing.assert_array_equal(lanes.evaluations, alone.evaluations)
    rounding = 2.0 * C * U * alone.steps.max() * np.abs(alone.angle_rad).max()
    allowed = rounding * growth(whole, t_s, 1e-7)
    assert np.abs(lanes.angle_rad - alone.angle_rad).max() <= allowed
    sizes = np.nanmax(alone.reaction_N)
    assert np.abs(lanes.reaction_N - alone.reaction_N).max() <= allowed * sizes / np.abs(alone.angle_rad).max()


@pytest.mark.parametrize("samples", [2, WIDTH, 200])
def test_samples_do_not_depend_on_their_number(samples: int) -> None:
    """An instant has the same bits among few samples and among many, at a step's end too."""
    few, t_s = drawn("paper/fig13", WIDTH, samples=samples)
    many = np.sort(np.concatenate([t_s, 0.5 * (t_s[1:] + t_s[:-1])]))
    found, finer = run_lanes(few, t_s), run_lanes(few, many)
    np.testing.assert_array_equal(found.angle_rad, finer.angle_rad[:, ::2])
    np.testing.assert_array_equal(found.reaction_N, finer.reaction_N[:, ::2])


def test_a_chain_that_may_touch_the_surface_is_given_back_and_its_neighbours_are_not() -> None:
    whole, t_s = drawn("paper/fig09", 2 * WIDTH, orbits=0.5)
    falling = np.arange(len(whole.y0)) % 5 == 2
    slow = whole.y0.copy()
    slow[falling, 2 * whole.bars.shape[2] + 2 :] *= 0.1
    found, sound = run_lanes(whole._replace(y0=slow), t_s), run_lanes(whole, t_s)
    np.testing.assert_array_equal(found.code == GIVEN_BACK, falling)
    assert np.isnan(found.angle_rad[falling]).all()
    np.testing.assert_array_equal(found.angle_rad[~falling], sound.angle_rad[~falling])


def test_chains_that_lanes_do_not_serve_run_one_after_another() -> None:
    whole, t_s = drawn("paper/fig13", WIDTH)
    bars = whole.bars.copy()
    bars[3, [layout.ILL_CONDITIONED, layout.REFINED]] = 1.0
    mixed = whole._replace(bars=bars)
    found, alone = run_members(mixed, t_s, segment(t_s)), run_batch(mixed, t_s, segment(t_s))
    lanes = run_lanes(whole, t_s)
    np.testing.assert_array_equal(found.angle_rad[3], alone.angle_rad[3])
    np.testing.assert_array_equal(np.delete(found.angle_rad, 3, axis=0), np.delete(lanes.angle_rad, 3, axis=0))
    np.testing.assert_array_equal(found.code, ARRIVED)


def test_angles_beyond_the_sine_of_the_lanes_are_given_back() -> None:
    whole, t_s = drawn("paper/fig13", 3)
    y0 = whole.y0.copy()
    y0[1, 0] += 2e5 * np.pi
    np.testing.assert_array_equal(run_lanes(whole._replace(y0=y0), t_s).code, [ARRIVED, GIVEN_BACK, ARRIVED])
