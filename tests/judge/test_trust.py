"""A pass means right: nothing that an engine's run gives decides where it stops being judged."""

import dataclasses
import functools

import numpy as np
import pytest

from adapters.common.equal_steps import finer_setting
from adapters.engine import AccuracyParameter, Coordinates, Setting
from adapters.exudyn.adapter import Exudyn, ExudynAbsolute
from adapters.pymunk.adapter import Pymunk
from adapters.reference.numpy_engines import Reference
from adapters.trajectory import Observable
from barchain.judge.checks.between_segments import fault_between_segments
from barchain.judge.checks.digits import rounded_values
from barchain.judge.checks.restart import declared_noise_rad, restart_segments
from barchain.judge.comparison.compare import judge
from barchain.judge.declared_noise import believed_steps, bounded
from barchain.judge.error_model import ErrorModel
from barchain.judge.evidence import TURNED_RAD, Evidence, perturbed, turned_back
from barchain.judge.local_errors import step_constant
from barchain.judge.scales import scales
from barchain.metrics.quantities import differences
from barchain.run.job import ROUNDOFF_ROLES, Role, RunResult
from barchain.run.trajectory_checks import fault
from barchain.solutions.reference import establish, with_perturbed_start
from barchain.solutions.sampling import MOST_TURNED_RAD, closely_sampled
from reports.tables.outcome import Outcome
from scenarios import load_scene

SETTING = Setting(AccuracyParameter.RTOL, 1e-8)


def run(scene, rtol):
    return Reference().run(scene, Setting(AccuracyParameter.RTOL, rtol))


def lasting(name, orbits, samples):
    scene = load_scene(name)
    return dataclasses.replace(
        scene, run=dataclasses.replace(scene.run, duration_s=orbits * scene.period_s, samples=samples)
    )


@functools.cache
def solution_of(scene):
    return establish(scene, run(scene, 1e-13), run(scene, 1e-12), run(with_perturbed_start(scene), 1e-13))


@pytest.fixture(scope="module")
def chaotic():
    """Three orbits of the horizontal chain: at this setting its attitude can be predicted for about one."""
    return solution_of(lasting("paper/fig05", 3.0, 121))


@pytest.fixture(scope="module")
def unmodified(chaotic):
    return run(chaotic.scene, 1e-8), run(chaotic.scene, 1e-9)


def judged(solution, main, finer, engine=Reference, setting=SETTING, **more):
    evidence = Evidence(RunResult(Outcome.PASS, trajectory=main), RunResult(Outcome.PASS, trajectory=finer), **more)
    return judge("x", engine, setting, evidence, solution)


def value(verdict, quantity, metric):
    return next(r["value"] for r in verdict.rows if (r["quantity"], r["metric"]) == (quantity, metric))


def garbage(seen, share, *, growing, seed):
    """Nonsense from a share of the run on: 1400 km, radians, several newtons."""
    rng = np.random.default_rng(seed)
    reached = np.clip((seen.t_s / seen.t_s[-1] - share) / (1.0 - share), 0.0, 1.0)
    weight = 1e-9 * np.expm1(reached * np.log(1e9)) if growing else (reached > 0.0).astype(float)

    def disturbed(values, size):
        pushed = size * rng.uniform(0.5, 1.5, values.shape) * rng.choice([-1.0, 1.0], values.shape)
        return values + weight.reshape(-1, *[1] * (values.ndim - 1)) * pushed

    return seen.replace(
        com_m=disturbed(seen.com_m, 1.4e6),
        com_velocity_m_s=disturbed(seen.com_velocity_m_s, 1e3),
        angle_rad=disturbed(seen.angle_rad, 1.0),
        rate_rad_s=disturbed(seen.rate_rad_s, 1e-3),
        reaction_N=disturbed(seen.reaction_N, 5.0),
    )


@pytest.mark.slow
def test_an_unmodified_run_is_judged_to_its_end_far_beyond_what_can_be_predicted(chaotic, unmodified):
    verdict = judged(chaotic, *unmodified)
    assert verdict.outcome is Outcome.PASS
    limit_s = next(r["limit_s"] for r in verdict.rows if r["quantity"] == "attitude")
    assert 0.3 < limit_s / chaotic.scene.period_s < 2.0
    assert value(verdict, "run", "judged_share") == 1.0
    assert value(verdict, "attitude", "restart_ratio") < 1.0


class NoisyReference(Reference.__mro__[1]):  # the abstract base of the NumPy forms
    """Says that it is as noisy as its results are large."""

    title, coordinates, coordinate_set = "noisy", Coordinates.RELATIVE, "minimal"

    @classmethod
    def noise(cls, scene, setting, t_s):
        return {"reaction": 1e9, "attitude": 1e9, "rate": 1e9, "com": 1e12, "com_velocity": 1e9}


class JustBelieved(NoisyReference):
    """Declares rates just less noisy than is believed: with that in the start, no restart could predict anything."""

    @classmethod
    def noise(cls, scene, setting, t_s):
        return {"rate": 0.0099 * scene.fastest_rate_rad_s}


def test_declared_noise_of_rates_does_not_switch_off_restarts(chaotic, unmodified):
    late = (unmodified[0].t_s > 0.5 * unmodified[0].t_s[-1])[:, None]
    drawn = np.random.default_rng(3).uniform(-3.0, 3.0, unmodified[0].angle_rad.shape)
    wild = unmodified[0].replace(angle_rad=unmodified[0].angle_rad + late * drawn)
    assert not judged(chaotic, wild, unmodified[1], engine=JustBelieved).outcome.ok
    assert judged(chaotic, *unmodified, engine=JustBelieved).outcome is Outcome.PASS


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


def test_round_off_since_the_start_makes_no_later_sample_unpredictable(chaotic, unmodified):
    """It is part of the state that the engine goes on from; amplified, it emptied every segment after five orbits."""
    errors = ErrorModel(Reference, SETTING, chaotic, unmodified[0])
    assert errors.floor["rate"][-1] > 1e3 * errors.floor["rate"][0]
    assert declared_noise_rad(errors, errors.n - 1) == 0.0


def test_an_engine_that_shows_more_than_it_declares_is_malformed_and_judged_by_what_it_shows(chaotic, unmodified):
    class TrackOnly(NoisyReference):
        observables = frozenset({Observable.COM})
        noise = Reference.noise

    said = fault(chaotic.scene, TrackOnly, unmodified[0])
    assert said is not None
    assert said[0] is Outcome.MALFORMED
    assert "does not declare: attitude" in said[1]
    wrong = [garbage(s, 0.9, growing=False, seed=1) for s in unmodified]
    assert not judged(chaotic, *wrong, engine=TrackOnly).outcome.ok


def test_samples_that_no_segment_covers_answer_for_themselves(chaotic, unmodified):
    main = unmodified[0]
    errors = ErrorModel(Reference, SETTING, chaotic, main)
    first = int(np.count_nonzero(main.t_s <= errors.limit_s)) - 1
    few = restart_segments(errors, main, first)[:1]
    assert fault_between_segments(errors, main, few, first, extra={}) is None
    at = (np.arange(len(main.t_s)) == 100)[:, None]
    turned = main.replace(angle_rad=main.angle_rad + 3.0 * at)
    pushed = main.replace(reaction_N=main.reaction_N * np.where(at, -1.0, 1.0)[..., None])
    assert "increment" in fault_between_segments(errors, turned, few, first, extra={})[2]
    assert "own state" in fault_between_segments(errors, pushed, few, first, extra={})[2]


@pytest.mark.slow
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
@pytest.mark.parametrize("which", ["main", "finer", "both"])
@pytest.mark.parametrize("share", [0.25, 0.5, 0.9])
def test_garbage_from_any_instant_on_in_either_run_does_not_pass(chaotic, unmodified, share, which, growing):
    main, finer = unmodified
    if which in ("main", "both"):
        main = garbage(main, share, growing=growing, seed=1)
    if which in ("finer", "both"):
        finer = garbage(finer, share, growing=growing, seed=2)
    assert not judged(chaotic, main, finer).outcome.ok


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
    chain = chaotic.scene.chain
    heavy = dataclasses.replace(chain, mass_kg=(*chain.mass_kg[:-1], 1.1 * chain.mass_kg[-1]))
    wrong = dataclasses.replace(chaotic.scene, chain=heavy)
    assert not judged(chaotic, run(wrong, 1e-8), run(wrong, 1e-9), engine=Boasting).outcome.ok


def test_declared_noise_counts_up_to_a_hundredth_of_each_quantity(chaotic):
    n, most = len(chaotic.amplification), 1e-2 * scales(chaotic)["reaction"]
    dying = np.geomspace(1e9, 1e-30, n)
    assert bounded({"reaction": dying}, scales(chaotic))["reaction"].max() == most
    assert np.all(bounded({"reaction": np.full(n, 0.9 * most)}, scales(chaotic))["reaction"] == 0.9 * most)
    assert not bounded({"reaction": np.full(n, 1e9)}, scales(chaotic))["reaction"].any()


@pytest.mark.slow
def test_an_engine_that_declares_any_noise_does_not_pass_with_a_wrong_mass(chaotic):
    scene = chaotic.scene
    heavy = dataclasses.replace(scene.chain, mass_kg=(*scene.chain.mass_kg[:-1], 1.1 * scene.chain.mass_kg[-1]))
    wrong = dataclasses.replace(scene, chain=heavy)
    verdict = judged(chaotic, run(wrong, 1e-8), run(wrong, 1e-9), engine=NoisyReference)
    assert verdict.outcome is Outcome.UNSUPPORTED
    assert "declares" in verdict.rows[0]["reason"]


def test_declared_noise_in_one_quantity_is_no_excuse_for_an_error_in_another(chaotic, unmodified):
    class Noisy(NoisyReference):
        @classmethod
        def noise(cls, scene, setting, t_s):
            return {"reaction": 1e9}

    off = unmodified[0].angle_rad + 1e-3 * unmodified[0].t_s[:, None] / unmodified[0].t_s[-1]
    assert not judged(chaotic, *(s.replace(angle_rad=off) for s in unmodified), engine=Noisy).outcome.ok
    loud = [s.replace(reaction_N=1.5 * s.reaction_N) for s in unmodified]
    assert judged(chaotic, *loud, engine=Noisy).outcome is Outcome.UNSUPPORTED
    assert judged(chaotic, *unmodified, engine=Noisy).outcome is Outcome.PASS


def test_a_run_equal_to_its_finer_one_bit_for_bit_is_no_estimate_of_zero(chaotic, unmodified):
    """Too little tells the finer run from the main one; the method's own request explains what is off."""
    verdict = judged(chaotic, unmodified[0], unmodified[0])
    assert verdict.outcome is Outcome.PASS or verdict.further_runs


def test_every_quantity_states_a_detection_limit_and_a_scene_of_second_order_a_coarser_one(chaotic, unmodified):
    fine = judged(chaotic, *unmodified)
    for quantity in ("com", "attitude", "rate", "reaction"):
        assert 0.0 < value(fine, quantity, "detection_limit") < 1.0


def test_an_error_above_the_detection_limit_is_called_and_its_tenth_need_not_be():
    solution = solution_of(lasting("paper/fig15", 0.3, 61))
    main, finer = run(solution.scene, 1e-8), run(solution.scene, 1e-9)
    limit = value(judged(solution, main, finer), "reaction", "detection_limit")
    size = 1.01 * limit * scales(solution)["reaction"]
    for at in (5, 30, 60):
        wrong = []
        for seen in (main, finer):
            reaction = seen.reaction_N.copy()
            reaction[at, 0, 0] += size
            wrong.append(seen.replace(reaction_N=reaction))
        assert not judged(solution, *wrong).outcome.ok


@pytest.fixture(scope="module")
def steep():
    return solution_of(lasting("paper/fig15", 0.3, 61))


def three_settings(engine, scene):
    main = engine.sweep.setting()
    finer = finer_setting(scene, engine.sweep, main)
    finest = finer_setting(scene, engine.sweep, finer)
    return main, [engine().run(scene, s) for s in (main, finer, finest)]


@pytest.mark.slow
@pytest.mark.parametrize("engine", [Exudyn, Pymunk])
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


@pytest.mark.parametrize(
    ("channel", "said", "rounded"),
    [
        ("com_m", "1e-3", lambda v: np.round(v, 3)),
        ("angle_rad", "1e-6 of degrees", lambda v: np.radians(np.round(np.degrees(v), 6))),
        ("reaction_N", "single precision", lambda v: v.astype(np.float32).astype(float)),
    ],
)
def test_values_with_too_few_digits_are_told_by_their_form(steep, channel, said, rounded):
    seen = run(steep.scene, 1e-8)
    assert rounded_values(seen) is None
    assert said in rounded_values(seen.replace(**{channel: rounded(getattr(seen, channel))}))


def test_a_turned_scene_turned_back_is_the_scene_itself():
    """Every effect's directions turn with the frame; what is left are the last digits that the start was moved by."""
    scene = lasting("effects/everything", 0.05, 21)
    scene = dataclasses.replace(
        scene, effects=dataclasses.replace(scene.effects, thrust=(), impulse=(), prescribed_rotation=())
    )
    straight = run(scene, 1e-12)
    for number, turn in enumerate(TURNED_RAD):
        apart = differences(turned_back(run(perturbed(scene, number), 1e-12), turn), straight)
        assert apart["attitude"].max() < 1e-10
        assert apart["com"].max() < 1e-4
        assert apart["reaction"].max() < 1e-10 * max(1.0, np.abs(straight.reaction_N).max())


def test_an_engine_in_absolute_coordinates_that_round_off_ruins_is_limited_and_neither_wrong_nor_right():
    scene = lasting("paper/fig15", 0.2, 41)
    chain = dataclasses.replace(
        scene.chain,
        length_m=tuple(1e-3 * length for length in scene.chain.length_m),
        inertia_kg_m2=tuple(1e-6 * j for j in scene.chain.inertia_kg_m2),
    )
    scene = dataclasses.replace(scene, chain=chain)
    solution, (setting, runs) = solution_of(scene), three_settings(ExudynAbsolute, scene)
    first = judged(solution, runs[0], runs[1], ExudynAbsolute, setting)
    assert not first.outcome.ok
    assert set(first.further_runs) >= set(ROUNDOFF_ROLES)
    others = tuple(turned_back(ExudynAbsolute().run(perturbed(scene, k), setting), a) for k, a in enumerate(TURNED_RAD))
    final = judged(
        solution, runs[0], runs[1], ExudynAbsolute, setting,
        perturbed=others, finest=RunResult(Outcome.PASS, trajectory=runs[2]),
    )  # fmt: skip
    assert final.outcome is Outcome.ROUNDOFF_LIMITED
    assert any("digits are left" in r["reason"] for r in final.rows)


def test_an_engine_in_relative_coordinates_can_not_pass_as_limited_by_round_off(chaotic, unmodified):
    """However noisy its runs are: coordinates as small as the chain leave no room."""
    rng = np.random.default_rng(3)

    def noisy(seen):
        return seen.replace(reaction_N=seen.reaction_N + 1e-4 * rng.normal(size=seen.reaction_N.shape))

    verdict = judged(
        chaotic, noisy(unmodified[0]), noisy(unmodified[1]), perturbed=tuple(noisy(unmodified[0]) for _ in TURNED_RAD)
    )
    assert verdict.outcome not in (Outcome.PASS, Outcome.ROUNDOFF_LIMITED)


def test_garbage_requests_no_further_runs(chaotic, unmodified):
    wrong = [garbage(seen, 0.25, growing=False, seed=k) for k, seen in enumerate(unmodified)]
    assert judged(chaotic, *wrong).further_runs == ()
    assert Role.FINEST not in judged(chaotic, *wrong).further_runs


def test_a_comparison_looks_closely_enough_and_keeps_a_scene_s_own_instants():
    scene = lasting("paper/fig05", 2.0, 5)
    close = closely_sampled(scene)
    spacing = close.run.duration_s / (close.run.samples - 1)
    assert spacing * scene.orbital_rate_rad_s <= MOST_TURNED_RAD
    assert set(scene.times_s) <= set(close.times_s)
    assert closely_sampled(lasting("paper/fig05", 1.0, 101)).run.samples == 101


@pytest.mark.slow
def test_five_samples_over_two_chaotic_orbits_are_judged_and_not_only_the_first():
    solution = solution_of(closely_sampled(lasting("paper/fig05", 2.0, 5)))
    main, finer = run(solution.scene, 1e-8), run(solution.scene, 1e-9)
    assert value(judged(solution, main, finer), "run", "judged_share") == 1.0
    noise = np.random.default_rng(1).normal(size=main.angle_rad.shape) * (main.t_s > 0.0)[:, None]
    assert not judged(solution, main.replace(angle_rad=main.angle_rad + 0.1 * noise), finer).outcome.ok


def cut(seen, samples, ended="a bar reached the surface"):
    rows = {name: v[:samples] for name, v in vars(seen).items() if isinstance(v, np.ndarray)}
    return dataclasses.replace(seen, **rows, ended=ended)


@pytest.mark.parametrize("samples", [1, 2, 30])
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


def test_a_run_that_can_not_be_compared_costs_its_own_row(chaotic, unmodified):
    odd = dataclasses.replace(unmodified[0], info=None)
    assert judged(chaotic, odd, unmodified[1]).outcome is Outcome.FAILED


def test_a_track_may_not_be_declared_noisier_than_a_millionth(chaotic):
    n = len(chaotic.amplification)
    assert not bounded({"com": np.full(n, 6e4)}, scales(chaotic))["com"].any()


RADIAL = """
title = "One bar standing upright on a circular orbit"
source = "made up"
[orbit]
altitude_m = 350e3
[chain]
bars = 1
mass_kg = 100.0
length_m = 100.0
angle_deg = 90.0
rate_factor = 1.0
[run]
orbits = 0.25
samples = 26
"""
AT_REST = """
title = "Two bars at rest in free space"
source = "made up"
[orbit]
altitude_m = 350e3
[chain]
bars = 2
mass_kg = 10.0
length_m = 10.0
angle_deg = 0.0
rate_factor = 0.0
[effects]
gravity = "none"
[run]
duration_s = 100.0
samples = 21
"""


@pytest.mark.parametrize(("text", "engine"), [(RADIAL, Exudyn), (AT_REST, Pymunk), (AT_REST, Exudyn)])
def test_exact_decimals_and_rest_accuse_nobody(tmp_path, text, engine):
    """3.6 degrees between samples are no rounding, and of no motion nothing is lost."""
    (tmp_path / "scene.toml").write_text(text)
    solution = solution_of(load_scene(tmp_path / "scene.toml"))
    setting, runs = three_settings(engine, solution.scene)
    assert judged(solution, runs[0], runs[1], engine, setting).outcome is Outcome.PASS
