"""The certified solution's equations: another derivation, every precision, the surface, and breaks of laws."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, EngineError, Setting, SettingError
from adapters.heyoka.adapter import Heyoka, HeyokaLong, HeyokaQuad
from adapters.heyoka.compiled import DOUBLE, QUAD, symbols
from adapters.heyoka.equations import backward_step
from adapters.heyoka.run import HeyokaRun
from adapters.heyoka.structure import structure_of, units_of
from barchain.metrics.quantities import differences
from barchain.runs.choices import choose_setting
from reference_impl.model import relative
from reference_impl.model.state import Accelerations
from scenarios import load_scene
from tests.adapters.heyoka_state import certified_accelerations, compiled
from tests.reference.paper_chains import AGREEMENT, LAWS, chain, disagreement, grip
from tests.support import solutions
from tests.support.arbiter import judge
from tests.support.changed import lasting, on_orbit, under
from tests.support.slow import slow_but

U = 2.0**-53


@pytest.mark.parametrize(
    ("laws", "bars", "gravity"),
    [
        *((laws, bars, "gradient") for laws in LAWS for bars in (1, 2, 5)),
        ("both ends", 4, "none"),
        ("both ends", 4, "point"),
    ],
)
def test_accelerations_reactions_and_torques_are_the_references_to_its_round_off(laws, bars, gravity):
    for seed in range(12):
        model, state = chain(seed, bars, equal=bool(seed % 2), laws=laws)
        model = dataclasses.replace(model, gravity=gravity)
        theirs, mine = relative.accelerations(model, 25.0, state), certified_accelerations(model, 25.0, state)
        if gravity == "none":  # a share of nothing is no number
            assert not mine.com_m_s2.any()
            theirs, mine = (dataclasses.replace(a, com_m_s2=np.ones(2)) for a in (theirs, mine))
        assert disagreement(model, state, mine, theirs) < AGREEMENT / grip(model, state)


@pytest.mark.parametrize("laws", LAWS)
def test_they_are_those_of_an_independent_derivation_in_fifty_digits(laws):
    """What is left is the arbiter's input: bars' places rounded to double, u of the chain's length."""
    model, state = chain(22, 5, equal=False, laws=laws)
    verdict = judge(model, 25.0, state)
    centre = model.weight @ verdict.place_m_s2
    judged = Accelerations(centre, verdict.angle_rad_s2, verdict.relative_m_s2, verdict.reaction_N, verdict.torque_N_m)
    assert disagreement(model, state, certified_accelerations(model, 25.0, state), judged) < AGREEMENT / grip(
        model, state
    )


def test_double_loses_no_more_than_the_reference_does():
    model, state = chain(3, 12, equal=False, laws="none")
    exact = certified_accelerations(model, 25.0, state)
    for found in (certified_accelerations(model, 25.0, state, DOUBLE), relative.accelerations(model, 25.0, state)):
        assert disagreement(model, state, found, exact) < AGREEMENT


def test_the_symmetric_step_is_the_general_one(monkeypatch):
    model, state = chain(5, 5, equal=False, laws="none")
    short = certified_accelerations(model, 25.0, state)
    monkeypatch.setattr(
        "adapters.heyoka.equations.backward_step_free",
        lambda bar, beyond: backward_step(bar, beyond, None, motor=False, pushed=False),
    )
    forget()
    general = certified_accelerations(model, 25.0, state)
    forget()
    # both in real128: nothing but their rounding to double is left
    np.testing.assert_allclose(general.angle_rad_s2, short.angle_rad_s2, rtol=4 * U)
    np.testing.assert_allclose(general.reaction_N, short.reaction_N, rtol=4 * U)


def forget():
    symbols.cache_clear()
    compiled.cache_clear()


HARDLY_GROWING = ("paper/fig13", "paper/fig17", "basics/two_bars_free", "basics/kepler_hyperbolic")


@pytest.mark.parametrize("name", slow_but(HARDLY_GROWING, ["basics/two_bars_free"]))
def test_the_three_precisions_agree_to_the_coarsest_one(name):
    """A short run: 1e-15 a step in double, 10 000 roundings of it at most, on scenes that hardly grow."""
    scene = lasting(load_scene(name), 600.0, 5)
    finest = HeyokaQuad().run(scene, Setting(AccuracyParameter.RTOL, 1e-24))
    for engine, rtol in ((Heyoka, 1e-15), (HeyokaLong, 1e-18)):
        apart = differences(engine().run(scene, Setting(AccuracyParameter.RTOL, rtol)), finest)
        assert apart["attitude"].max() <= 1e4 * U
        assert apart["com"].max() <= 1e4 * U * scene.radius0_m
    assert (
        differences(HeyokaLong().run(scene, Setting(AccuracyParameter.RTOL, 1e-18)), finest)["attitude"].max() <= 32 * U
    )


@pytest.mark.parametrize("rtol", slow_but([1e-6, 1e-9, 1e-12], [1e-9]))
def test_errors_are_what_is_asked_for(rtol):
    scene = lasting(load_scene("paper/fig13"), 3000.0, 5)
    solution = HeyokaQuad().run(scene, Setting(AccuracyParameter.RTOL, 1e-24))
    seen = Heyoka().run(scene, Setting(AccuracyParameter.RTOL, rtol))
    # each step may err by rtol; the librating chain of growth below 100 carries that on
    assert differences(seen, solution)["attitude"].max() <= 100.0 * rtol * float(seen.info["steps"])


@pytest.mark.parametrize(
    ("name", "speed_factor", "duration_s"), [("paper/fig13", 0.0, 600.0), ("paper/fig05", 0.98, 3000.0)]
)
def test_a_run_ends_where_the_references_does_and_says_so_alike(name, speed_factor, duration_s):
    """By an end of a bar (falling steeply) or between its ends (a horizontal bar sags below its ends)."""
    scene = lasting(on_orbit(load_scene(name), speed_factor=speed_factor), duration_s)
    assert structure_of(scene).lands
    seen, solution = Heyoka().run(scene, Setting(AccuracyParameter.RTOL, 1e-15)), solutions.run(scene, 1e-13)
    assert seen.ended == solution.ended != ""
    assert len(seen.t_s) == len(solution.t_s) < scene.run.samples


def test_no_step_straddles_a_break_of_a_law_and_samples_at_breaks_are_seen_once():
    scene = lasting(load_scene("paper/fig17"), 120.0, 13)
    law = dataclasses.replace(scene.effects.prescribed_rotation[0], start_s=30.0)  # breaks at 30 (a sample) and 90
    late = dataclasses.replace(law, bar=2, start_s=41.0, duration_s=33.0)  # at 41 and 74, between samples
    scene = under(scene, prescribed_rotation=(law, late))
    run = HeyokaRun(scene, scene.times_s, QUAD, 1e-20)
    assert len(run.segments) == 5
    run.walk()
    seen = run.trajectory()
    np.testing.assert_array_equal(seen.t_s, scene.times_s)
    solution = solutions.run(scene, 1e-13)
    for name, apart in differences(seen, solution).items():
        sizes = {"com": scene.radius0_m, "com_velocity": scene.speed0_m_s, "rate": scene.fastest_rate_rad_s}
        assert apart.max() <= 1e-11 * sizes.get(name, 1.0)  # 100 steps at 1e-13


def test_units_are_powers_of_two_so_that_nothing_is_rounded():
    units = units_of(load_scene("paper/fig17"))
    assert all(np.frexp(x)[0] == 0.5 for x in (units.length_m, units.time_s))


def test_a_state_that_is_no_number_is_told_and_not_returned():
    scene = load_scene("basics/two_bars_free")
    run = HeyokaRun(scene, scene.times_s, DOUBLE, 1e-12)
    run.start[4] = np.nan
    with pytest.raises(EngineError, match="heyoka stopped"):
        run.walk()


def test_settings_go_as_far_as_the_precision_does():
    assert choose_setting("heyoka-quad", {"rtol": 1e-30}).value == 1e-30
    with pytest.raises(SettingError, match="allowed"):
        choose_setting("heyoka", {"rtol": 1e-17})
