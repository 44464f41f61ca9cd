"""A pass means right: what an engine declares is believed up to a bound only."""

import dataclasses

import numpy as np
import pytest

from adapters.exudyn.adapter import Exudyn
from adapters.pymunk.adapter import Pymunk
from adapters.reference.numpy_engines import Reference
from adapters.trajectory import Observable
from barchain.judge.local_errors import step_constant
from barchain.judge.scales import believed_noise, believed_steps, scales
from barchain.runs.job import RunResult
from barchain.runs.trajectory_checks import fault
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.judge.trust_cases import (
    SETTING,
    JustBelieved,
    NoisyReference,
    garbage,
    judged,
    three_settings,
    with_a_heavier_bar,
)
from tests.support.solutions import run, solution_of

NOISE_RAD = 3e-6


@pytest.fixture(scope="module")
def free():
    return solution_of(load_scene("conform/three_bars_free"))


@pytest.mark.slow
def test_declared_noise_of_rates_does_not_switch_off_restarts(chaotic, unmodified):
    late = (unmodified[0].t_s > 0.5 * unmodified[0].t_s[-1])[:, None]
    drawn = np.random.default_rng(3).uniform(-3.0, 3.0, unmodified[0].angle_rad.shape)
    wild = unmodified[0].replace(angle_rad=unmodified[0].angle_rad + late * drawn)
    assert not judged(chaotic, wild, unmodified[1], engine=JustBelieved).outcome.ok
    assert judged(chaotic, *unmodified, engine=JustBelieved).outcome is Outcome.PASS


def test_an_engine_that_shows_more_than_it_declares_is_malformed_and_judged_by_what_it_shows(chaotic, unmodified):
    class TrackOnly(NoisyReference):
        observables = frozenset({Observable.COM})
        noise = Reference.noise

    said = fault(chaotic.scene, TrackOnly, unmodified[0])
    assert said[0] is Outcome.MALFORMED
    assert "does not declare: attitude" in said[1]
    wrong = [garbage(s, 0.9, growing=False, seed=1) for s in unmodified]
    assert not judged(chaotic, *wrong, engine=TrackOnly).outcome.ok


def test_a_count_of_steps_that_no_method_takes_widens_nothing(chaotic):
    sloppy = [run(chaotic.scene, rtol) for rtol in (1e-5, 1e-6)]
    lying = [dataclasses.replace(seen, info=seen.info | {"steps": 1e9}) for seen in sloppy]
    assert believed_steps(SETTING, chaotic, 1e9) == 0.0
    assert believed_steps(SETTING, chaotic, 500.0) == 500.0
    assert not judged(chaotic, *lying).outcome.ok


@pytest.mark.slow
def test_a_declared_error_constant_counts_up_to_ten_and_makes_no_room_for_a_wrong_mass(chaotic):
    class Boasting(NoisyReference):
        step_constant = 1e6
        noise = Reference.noise

    assert step_constant(Boasting) == 10.0
    wrong = with_a_heavier_bar(chaotic.scene)
    assert not judged(chaotic, run(wrong, 1e-8), run(wrong, 1e-9), engine=Boasting).outcome.ok


def test_declared_noise_counts_up_to_a_hundredth_of_each_quantity(chaotic):
    n, most = len(chaotic.amplification), 1e-2 * scales(chaotic)["reaction"]
    dying = np.geomspace(1e9, 1e-30, n)
    assert believed_noise({"reaction": dying}, scales(chaotic))["reaction"].max() == most
    assert np.all(believed_noise({"reaction": np.full(n, 0.9 * most)}, scales(chaotic))["reaction"] == 0.9 * most)
    assert not believed_noise({"reaction": np.full(n, 1e9)}, scales(chaotic))["reaction"].any()
    assert not believed_noise({"com": np.full(n, 6e4)}, scales(chaotic))["com"].any()  # a track, to a millionth


@pytest.mark.slow
def test_an_engine_that_declares_any_noise_does_not_pass_with_a_wrong_mass(chaotic):
    """Noise of samples excuses no drift: the balance about the centre of mass shows the mass."""
    wrong = with_a_heavier_bar(chaotic.scene)
    verdict = judged(chaotic, run(wrong, 1e-8), run(wrong, 1e-9), engine=NoisyReference)
    assert verdict.outcome is Outcome.INCONSISTENT
    drifting = {row["quantity"] for row in verdict.rows if row["outcome"] == Outcome.EXCEEDS_BOUND}
    assert drifting == {"energy_about_com", "angular_momentum_about_com"}


def test_declared_noise_in_one_quantity_is_no_excuse_for_an_error_in_another(chaotic, unmodified):
    class Noisy(NoisyReference):
        @classmethod
        def noise(cls, scene, setting, t_s):
            return {"reaction": 1e9}

    off = unmodified[0].angle_rad + 1e-3 * unmodified[0].t_s[:, None] / unmodified[0].t_s[-1]
    assert not judged(chaotic, *(s.replace(angle_rad=off) for s in unmodified), engine=Noisy).outcome.ok
    loud = [s.replace(reaction_N=1.5 * s.reaction_N) for s in unmodified]
    assert judged(chaotic, *loud, engine=Noisy).outcome is Outcome.UNSUPPORTED
    assert not judged(chaotic, *(s.replace(angle_rad=off) for s in loud), engine=Noisy).outcome.ok
    assert judged(chaotic, *unmodified, engine=Noisy).outcome is Outcome.PASS


@pytest.mark.parametrize("engine", [pytest.param(Exudyn, marks=pytest.mark.slow), Pymunk])
def test_noise_and_offsets_far_below_a_second_order_method_s_own_error_are_seen(steep, engine):
    setting, runs = three_settings(engine, steep.scene)
    rng = np.random.default_rng(5)
    own = np.abs(runs[0].angle_rad - runs[1].angle_rad).max()
    drawn = 0.3 * own * (runs[0].t_s / runs[0].t_s[-1])[:, None] ** 2

    def verdict(change):
        main, finer, finest = (change(seen) for seen in runs)
        return judged(steep, main, finer, engine, setting, finest=RunResult(Outcome.PASS, trajectory=finest))

    def noisy(seen):
        scale = 0.3 * np.abs(runs[0].reaction_N - runs[1].reaction_N).max()
        return seen.replace(reaction_N=seen.reaction_N + scale * rng.uniform(-1.0, 1.0, seen.reaction_N.shape))

    assert verdict(lambda seen: seen).outcome is Outcome.PASS
    assert not verdict(lambda seen: seen.replace(angle_rad=seen.angle_rad + drawn)).outcome.ok
    assert not verdict(noisy).outcome.ok


def test_an_engine_that_declares_no_attitude_but_reactions_is_no_particle(chaotic, unmodified):
    class NoAttitude(NoisyReference):
        observables = frozenset({Observable.COM, Observable.RATE, Observable.REACTION})
        noise = Reference.noise

    main, finer = (seen.replace(angle_rad=None) for seen in unmodified)
    assert judged(chaotic, main, finer, engine=NoAttitude).outcome is Outcome.NOTHING_COMPARED


def test_noise_declared_for_the_start_alone_does_not_loosen_restarts(chaotic, unmodified):
    class LoudAtFirst(NoisyReference):
        @classmethod
        def noise(cls, scene, setting, t_s):
            return {"rate": (t_s == 0.0).astype(float)}

    rng = np.random.default_rng(4)
    late = (unmodified[0].t_s > 2.0 * chaotic.scene.period_s)[:, None]
    main = unmodified[0].replace(
        angle_rad=unmodified[0].angle_rad + late * rng.uniform(-3, 3, unmodified[0].angle_rad.shape)
    )
    assert not judged(chaotic, main, unmodified[1], engine=LoudAtFirst).outcome.ok


def test_declared_noise_of_angles_counts_in_energy_and_angular_momentum(free):
    class Shaking(NoisyReference):
        @classmethod
        def noise(cls, scene, setting, t_s):
            return {"attitude": np.full(len(t_s), NOISE_RAD)}

    runs = [run(free.scene, rtol) for rtol in (1e-9, 1e-10)]
    shaken = NOISE_RAD * np.random.default_rng(3).uniform(-1.0, 1.0, runs[0].angle_rad.shape)
    shaken[0] = 0.0
    noisy = [seen.replace(angle_rad=seen.angle_rad + shaken) for seen in runs]
    assert judged(free, *noisy, engine=Shaking).outcome is Outcome.PASS
    assert not judged(free, *noisy).outcome.ok
