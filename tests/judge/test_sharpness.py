"""How sharp the comparison is: small faults are seen, and odd scenes raise no false alarm."""

import functools

import numpy as np
import pytest

import barchain.solutions.reference
from adapters.common.equal_steps import finer_setting
from adapters.engine import AccuracyParameter, Setting
from adapters.exudyn.adapter import Exudyn, ExudynIndex3, ExudynTree
from adapters.exudyn.noise import engine_noise
from adapters.exudyn.solver import method_for
from adapters.rebound.adapter import Rebound
from adapters.reference.numpy_engines import Reference, ReferenceAbsolute
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.metrics.quantities import differences, drifts
from barchain.runs.job import RunResult
from barchain.solutions.reference import densely_sampled, with_perturbed_start
from reports.results.outcome import Outcome
from scenarios import change_scene, load_scene
from tests.judge.trust_cases import lasting
from tests.support.solutions import run, solution_of


@functools.cache
def both(engine, scene, value=None):
    setting = engine.sweep.setting(value)
    finer = finer_setting(scene, engine.sweep, setting)
    return engine().run(scene, setting), engine().run(scene, finer)


def judged(engine, solution, change=lambda seen: seen, value=None):
    """Verdict of an engine whose two runs are faulty alike."""
    main, finer = (RunResult(Outcome.PASS, trajectory=change(seen)) for seen in both(engine, solution.scene, value))
    return judge("x", engine, engine.sweep.setting(value), Evidence(main, finer), solution)


def out(verdict, metric=None):
    """Quantities that did not pass."""
    return {
        r["quantity"]
        for r in verdict.rows
        if r["outcome"] not in ("pass", "reported") and metric in (None, r["metric"])
    }


@pytest.fixture(scope="module")
def steep():
    return lasting("paper/fig15", 0.3, 61)


@pytest.fixture(scope="module")
def free():
    return lasting("basics/two_bars_free", 0.2, 101)


def test_the_velocity_of_a_particle_is_judged_by_the_predicted_departure(steep):
    solution = solution_of(steep)
    assert judged(Rebound, solution).outcome is Outcome.PASS
    wrong = judged(Rebound, solution, lambda s: s.replace(com_velocity_m_s=s.com_velocity_m_s + 1e-6))
    assert "com_velocity" in out(wrong, "normalised_error")


@pytest.mark.slow
def test_the_reference_is_consistent_with_itself_at_every_setting():
    solution = solution_of(lasting("paper/fig15", 0.15, 31))
    for engine in (Reference, ReferenceAbsolute):
        for value in engine.sweep.values[:-1]:
            found = out(judged(engine, solution, value=value), "normalised_error")
            assert not found, (engine.__name__, value)


def test_two_runs_that_meet_where_both_are_off_are_explained_by_a_few_steps_requests(steep):
    """Chosen steps leave errors of any sign: here the finer run happens to agree with the coarser."""
    solution, rtol = solution_of(steep), 1e-8
    off = solution.trajectory.replace(angle_rad=solution.trajectory.angle_rad + 5 * rtol)
    same = RunResult(Outcome.PASS, trajectory=off)
    found = judge("x", Reference, Setting(AccuracyParameter.RTOL, rtol), Evidence(same, same), solution)
    assert "attitude" not in out(found, "normalised_error")


@pytest.mark.slow
def test_a_manoeuvre_between_few_samples_is_no_false_alarm():
    """Three samples inside, on an ellipse."""
    chain = {"bars": 3, "mass_kg": [100.0, 60.0, 30.0], "length_m": [10.0, 20.0, 5.0], "angle_deg": [60.0, 70.0, 80.0]}
    turn = {"bar": 3, "amplitude_deg": 45.0, "duration_s": 60.0, "start_s": 300.0}
    changes = {"orbit": {"speed_factor": 1.2}, "run": {"duration_s": 500.0, "samples": 26}}
    effects = {"prescribed_rotation": [turn | {"frame": "local_horizontal", "actuator": "external"}]}
    scene = change_scene(load_scene("paper/fig17"), changes | {"chain": chain, "effects": effects})
    assert densely_sampled(scene).run.duration_s / (densely_sampled(scene).run.samples - 1) <= 60.0 / 20
    assert out(judged(Exudyn, solution_of(scene))) == set()
    assert "torque" in out(judged(Exudyn, solution_of(scene, dense=False)))  # as seen from the scene's own samples


def test_a_bar_that_is_hard_to_turn_is_no_false_alarm():
    """It has a thousand times the inertia of its length."""
    chain = {"bars": 3, "mass_kg": 100.0, "length_m": 10.0, "inertia_kg_m2": [1.0, 1e6, 10.0], "rate_factor": 1.0}
    changes = {"chain": chain | {"angle_deg": [60.0, 70.0, 80.0]}, "run": {"orbits": 0.1, "samples": 51}}
    scene = change_scene(load_scene("paper/fig05"), changes)
    assert out(judged(ExudynTree, solution_of(scene))) == set()
    assert out(judged(Exudyn, solution_of(scene))) == set()


def test_a_swing_of_an_end_body_that_samples_pass_over_is_no_false_alarm():
    scene = lasting("published/tips", 0.4, 161)  # 16 s between samples, and swings of 37 to 60 s
    assert out(judged(Exudyn, solution_of(scene))) == set()


@pytest.mark.slow
def test_what_a_fast_start_leaves_in_undamped_multipliers_is_no_false_alarm_after_dampers_slowed_the_motion():
    free_flyer = solution_of(load_scene("effects/free_flyer"))
    assert "reaction" not in out(judged(Exudyn, free_flyer))


@pytest.mark.exhaustive
def test_a_straight_track_is_exact_but_for_rounding(free):
    solution = solution_of(free)
    for engine in (Reference, Exudyn, Rebound):
        assert out(judged(engine, solution)) == set()
        assert "com" in out(judged(engine, solution, lambda s: s.replace(com_m=s.com_m + 1e-5)), "normalised_error")


def opened_places(seen):
    """Every bar a little farther from the one before."""
    aside = 1e-9 * np.arange(seen.position_m.shape[1])[:, None] * np.array([1.0, 0.0])
    return seen.replace(position_m=seen.position_m + aside - aside.mean(axis=0))


@pytest.mark.slow
def test_joints_put_in_place_are_judged_by_rounding_and_not_by_the_step(steep):
    solution = solution_of(steep)
    assert out(judged(ExudynIndex3, solution)) == set()
    assert "gap" in out(judged(ExudynIndex3, solution, opened_places))
    # what index 2 opens by is within its own bound
    assert "gap" not in out(judged(Exudyn, solution, opened_places))


def off_centre(seen, off):
    """The bars beside the centre of mass, and the engine says so."""
    places = None if seen.position_m is None else seen.position_m + np.array([off, 0.0])
    return seen.replace(com_residual_m=seen.com_residual_m + off, position_m=places)


def test_the_centre_of_mass_residual_is_judged_by_the_rounding_of_a_sum(steep):
    solution = solution_of(steep)
    for engine, off in ((Reference, 1e-11), (ReferenceAbsolute, 1e-6)):
        assert out(judged(engine, solution)) == set()
        assert "com_residual" in out(judged(engine, solution, functools.partial(off_centre, off=off)))


@pytest.mark.slow
def test_energy_may_drift_by_what_the_finer_setting_changes_and_no_more(free):
    solution = solution_of(free)
    for engine in (Reference, Exudyn):
        assert out(judged(engine, solution)) == set()

    def damped(seen):  # the same at both settings, far inside the bound of a hundred times looser steps
        return seen.replace(rate_rad_s=seen.rate_rad_s * (1 - 1e-4 * np.linspace(0, 1, len(seen.t_s)))[:, None])

    assert {"energy", "angular_momentum"} <= out(judged(Exudyn, solution, damped), "drift")


@pytest.mark.exhaustive
def test_the_bound_of_a_tree_follows_the_motion_and_not_the_chains_fastest_mode(steep):
    solution = solution_of(steep)
    assert out(judged(ExudynTree, solution)) == set()
    main, finer = both(ExudynTree, steep)
    changed = main.replace(angle_rad=main.angle_rad + 2e-10)
    found = judge(
        "x",
        ExudynTree,
        ExudynTree.sweep.setting(),
        Evidence(RunResult(Outcome.PASS, trajectory=changed), RunResult(Outcome.PASS, trajectory=finer)),
        solution,
    )
    assert "attitude" in out(found, "bound_ratio")


def test_a_manoeuvre_stirs_index_3_by_its_own_bar_and_one_order_less_than_the_start():
    """With the whole chain's forces at each end, forty of the largest torques on the paper's slew were allowed."""
    scene = load_scene("paper/fig17")
    times = np.linspace(0.0, 200.0, 401)
    method = method_for(scene, explicit=False, index3=True, absolute=False)
    noise = engine_noise(scene, scene.step_period_s / 5000, method, times)["torque"]
    largest = 0.4995  # N m, the slew's torque in the reference solution
    assert noise.max() < 0.2 * largest


def test_the_tracks_response_to_attitude_is_that_of_a_run_perturbed_far_enough_to_be_seen(steep, monkeypatch):
    solution = solution_of(steep)
    monkeypatch.setattr(
        barchain.solutions.reference, "PERTURBATION_RAD", 1e-3
    )  # a thousandth of a metre: above the track's own error
    apart = differences(solution.trajectory, run(with_perturbed_start(steep), 1e-13))
    seen = apart["com"][-1] / np.maximum.accumulate(apart["attitude"])[-1]
    assert solution.response["com"][-1] == pytest.approx(seen, rel=0.2)


def test_a_chain_of_points_keeps_its_energy_and_angular_momentum_with_the_tidal_part(monkeypatch):
    scene = lasting("basics/point_chain", 0.5, 31)
    found = drifts(scene, run(scene, 1e-12))
    assert found["energy"].max() < 1e-11
    assert found["angular_momentum"].max() < 1e-11
    assert {r["quantity"] for r in judged(Reference, solution_of(scene)).rows} >= {"energy", "angular_momentum"}
    monkeypatch.setattr("barchain.metrics.quantities.invariants.tidal_energy", lambda *_: 0.0)
    assert drifts(scene, run(scene, 1e-12))["energy"].max() > 1e-11
