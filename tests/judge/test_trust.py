"""A pass means right: nothing that an engine's run gives decides where it stops being judged."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from adapters.engine import Coordinates
from adapters.exudyn.adapter import Exudyn
from adapters.reference.numpy_engines import Reference
from adapters.trajectory import Observable
from barchain.judge.checks.beyond_limit import energy_finding, fault_between_segments, kinetic_ratio
from barchain.judge.checks.restart import declared_noise_rad, restart_segments
from barchain.judge.error_model import ErrorModel
from barchain.runs.job import RunResult
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.judge.trust_cases import (
    SETTING,
    NoisyReference,
    cut,
    garbage,
    judged,
    three_settings,
    value,
)
from tests.support.solutions import run, solution_of


@pytest.mark.exhaustive
def test_an_unmodified_run_is_judged_to_its_end_far_beyond_what_can_be_predicted(chaotic, unmodified):
    verdict = judged(chaotic, *unmodified)
    assert verdict.outcome is Outcome.PASS
    limit_s = next(r["limit_s"] for r in verdict.rows if r["quantity"] == "attitude")
    assert 0.3 < limit_s / chaotic.scene.period_s < 2.0
    assert value(verdict, "run", "judged_share") == 1.0
    assert value(verdict, "attitude", "restart_ratio") < 1.0


@pytest.mark.exhaustive
@pytest.mark.parametrize("every", [1, 20])
def test_round_off_of_absolute_coordinates_excuses_no_nonsense_beyond_the_limit(chaotic, unmodified, every):
    class FromTheEarthsCentre(NoisyReference):
        coordinates = Coordinates.ABSOLUTE
        noise = Reference.noise

    late = ((unmodified[0].t_s > 0.7 * unmodified[0].t_s[-1]) & (np.arange(len(unmodified[0].t_s)) % every == 0))[
        :, None
    ]
    wild = unmodified[0].replace(
        angle_rad=unmodified[0].angle_rad + late * np.random.default_rng(3).uniform(1.0, 3.0, late.shape)
    )
    assert judged(chaotic, wild, unmodified[1], engine=FromTheEarthsCentre).outcome is Outcome.EXCEEDS_BOUND


@pytest.mark.slow
def test_round_off_since_the_start_makes_no_later_sample_unpredictable(chaotic, unmodified):
    """It is part of the state that the engine goes on from; amplified, it emptied every segment after five orbits."""
    errors = ErrorModel(Reference, SETTING, chaotic, unmodified[0])
    assert errors.floor["rate"][-1] > 1e3 * errors.floor["rate"][0]
    assert declared_noise_rad(errors, errors.n - 1) == 0.0


@pytest.mark.exhaustive
def test_the_tide_on_open_joints_is_allowed_in_restarts_and_nothing_else_is(chaotic, unmodified):
    """Two halves of a radial chain that stand d farther apart pull by 0.75 n² m d more; the rest stays strict."""
    main, opened_m = unmodified[0], 1e-3
    gaps = np.full((len(main.t_s), chaotic.scene.bars - 1), opened_m / (chaotic.scene.bars - 1))

    def allowed(gap_m, places=main.angle_rad):
        seen = main.replace(gap_m=gap_m, position_m=None if places is None else np.zeros((*places.shape, 2)))
        errors = ErrorModel(Reference, SETTING, chaotic, seen)
        first = int(np.count_nonzero(main.t_s <= errors.limit_s)) - 1
        return restart_segments(errors, seen, first)[0].allowed

    closed, opened = allowed(None), allowed(gaps)
    pull = 0.75 * chaotic.scene.mean_motion_rad_s**2 * chaotic.scene.mass_kg * opened_m
    added = opened["reaction"] - closed["reaction"]
    assert np.all((pull < added) & (added < 5.0 * pull))
    assert all(np.array_equal(opened[name], closed[name]) for name in ("attitude", "rate"))
    reported = allowed(gaps, places=None)  # without places that show them
    assert np.array_equal(reported["reaction"], closed["reaction"])


def test_samples_that_no_segment_covers_answer_for_themselves(chaotic, unmodified):
    main = unmodified[0]
    errors = ErrorModel(Reference, SETTING, chaotic, main)
    first = int(np.count_nonzero(main.t_s <= errors.limit_s)) - 1
    few = restart_segments(errors, main, first)[:1]
    assert fault_between_segments(errors, main, few, first, extra={}) is None
    at = (np.arange(len(main.t_s)) == 100)[:, None]
    turned = main.replace(angle_rad=main.angle_rad + 3.0 * at)
    pushed, lost = (main.replace(reaction_N=main.reaction_N * np.where(at, x, 1.0)[..., None]) for x in (-1.0, np.nan))
    assert "otherwise than its rates" in fault_between_segments(errors, turned, few, first, extra={})[2]
    assert "own state" in fault_between_segments(errors, pushed, few, first, extra={})[2]
    assert "inf times" in fault_between_segments(errors, lost, few, first, extra={})[2]


@pytest.mark.exhaustive
def test_an_impulse_beyond_the_limit_is_followed_and_no_later_segment_lacks_its_channel():
    chain = load_scene("paper/fig05")
    blow = load_scene("effects/impulse").effects.impulse[0]
    run_ = dataclasses.replace(chain.run, duration_s=2.5 * chain.period_s, samples=101)
    at_s = float(np.linspace(0.0, run_.duration_s, 101)[60])
    effects = dataclasses.replace(chain.effects, impulse=(dataclasses.replace(blow, at_s=at_s),))
    solution = solution_of(dataclasses.replace(chain, run=run_, effects=effects))
    runs = [run(solution.scene, rtol) for rtol in (1e-8, 1e-9)]
    verdict = judged(solution, *runs)
    assert verdict.outcome is Outcome.PASS
    assert next(r["limit_s"] for r in verdict.rows if r["quantity"] == "attitude") < at_s


@pytest.mark.parametrize("growing", [False, True], ids=["sudden", "growing"])
@pytest.mark.parametrize(("share", "which"), [(0.25, "both"), (0.5, "finer"), (0.9, "main")])
def test_garbage_from_any_instant_on_in_either_run_does_not_pass(chaotic, unmodified, share, which, growing):
    main, finer = unmodified
    if which in ("main", "both"):
        main = garbage(main, share, growing=growing, seed=1)
    if which in ("finer", "both"):
        finer = garbage(finer, share, growing=growing, seed=2)
    verdict = judged(chaotic, main, finer)
    assert not verdict.outcome.ok
    assert growing or which != "both" or verdict.further_runs == ()


@pytest.mark.parametrize(
    "change",
    [
        lambda s, late: s.replace(angle_rad=s.angle_rad + late[:, None] * 1.0),
        lambda s, late: s.replace(rate_rad_s=s.rate_rad_s * (1.0 + 0.5 * late[:, None])),
        lambda s, late: s.replace(reaction_N=-s.reaction_N * late[:, None, None] + s.reaction_N * ~late[:, None, None]),
        lambda s, late: s.replace(com_m=s.com_m + 100.0 * late[:, None]),
    ],
    ids=["angles", "rates", "reactions", "track"],
)
def test_one_wrong_channel_beyond_the_predictability_limit_is_seen(chaotic, unmodified, change):
    """Attitudes have parted there, yet each segment follows from the engine's own state before it."""
    late = unmodified[0].t_s > 2.5 * chaotic.scene.period_s
    main, finer = (change(seen, late) for seen in unmodified)
    assert not judged(chaotic, main, finer).outcome.ok


def test_an_engine_without_rates_is_not_passed_on_the_predictable_part_alone(chaotic, unmodified):
    class NoRates(NoisyReference):
        observables = Reference.observables - {Observable.RATE}
        noise = Reference.noise

    main, finer = (seen.replace(rate_rad_s=None) for seen in unmodified)
    assert judged(chaotic, main, finer, engine=NoRates).outcome is Outcome.NOTHING_COMPARED


def test_runs_that_are_unstable_each_in_its_own_way_do_not_pass(chaotic, unmodified):
    """The old way to a green cell: two runs that part early are not compared any more."""
    grown = np.expm1(np.linspace(0.0, 12.0, len(unmodified[0].t_s)))[:, None] * 1e-5
    main = unmodified[0].replace(angle_rad=unmodified[0].angle_rad + grown)
    finer = unmodified[1].replace(angle_rad=unmodified[1].angle_rad - 3.0 * grown)
    assert not judged(chaotic, main, finer).outcome.ok


@pytest.mark.parametrize("samples", [1, 30])
def test_a_finer_run_that_ends_early_does_not_shorten_what_is_judged(chaotic, unmodified, samples):
    wrong = garbage(unmodified[0], samples / 121, growing=False, seed=1)
    assert judged(chaotic, wrong, cut(unmodified[1], samples)).outcome is Outcome.INCOMPLETE
    assert judged(chaotic, cut(unmodified[0], samples), unmodified[1]).outcome is Outcome.INCOMPLETE


@pytest.mark.slow
def test_a_finest_run_that_ends_early_or_failed_is_no_evidence(steep):
    setting, runs = three_settings(Exudyn, steep.scene)
    own = np.abs(runs[0].angle_rad - runs[1].angle_rad).max()
    wrong = [seen.replace(angle_rad=seen.angle_rad + 0.3 * own) for seen in runs]
    for finest in (RunResult(Outcome.PASS, trajectory=cut(wrong[2], 1)), RunResult(Outcome.NOT_FINITE, "", wrong[2])):
        assert not judged(steep, *wrong[:2], Exudyn, setting, finest=finest).outcome.ok


def test_a_run_that_can_not_be_compared_costs_its_own_row(chaotic, unmodified):
    odd = dataclasses.replace(unmodified[0], info=None)
    assert judged(chaotic, odd, unmodified[1]).outcome is Outcome.FAILED


@pytest.mark.parametrize(("times", "outcome"), [(3.0, Outcome.PASS), (5.0, Outcome.EXCEEDS_BOUND)])
def test_bars_that_turn_more_than_twice_as_fast_as_is_possible_are_wrong_where_nothing_is_predicted(
    chaotic, unmodified, times, outcome
):
    """Kinetic energy goes as the square of the rates: twice every rate is four times the largest energy."""
    main, finer = unmodified
    faster = main.replace(rate_rad_s=main.rate_rad_s * np.sqrt(times / kinetic_ratio(main, chaotic)))
    beyond = SimpleNamespace(scene=chaotic.scene, main=faster, finer=finer, solution=chaotic)
    assert energy_finding(beyond).outcome is outcome
