"""Right engines on drawn scenes on which a judge or an engine once failed: air, light, bars that fold."""

import dataclasses
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from adapters.common.equal_steps import step_s
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, Setting
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES
from adapters.trajectory import Array, Trajectory
from barchain.judge.checks.restart import RTOL, directions, restarted_solution
from barchain.judge.local_errors import LocalErrors, resolving_s, truncation_errors
from barchain.judge.scales import NORM_SLACK
from barchain.metrics.quantities import differences
from barchain.runs.executors import LocalProcesses
from barchain.solutions.at_times import restarted_run
from barchain.solutions.reference import ReferenceSolution, closely_sampled, establish, with_perturbed_start
from benchmarks.random_campaign.campaign import on_scene
from reference_impl.integrate.simulate import Simulation
from reports.results.comparison import PARTED_RAD
from scenarios import Scene, load_scene
from tests.support.here import result_of

SCENES = Path(__file__).with_name("random_scenes")


def outcomes(scene: Scene, engine: str) -> list[str]:
    """Outcomes of an unmodified engine, with the further runs that its verdict asks for."""
    return [trial.outcome for trial in result_of(on_scene(scene, [engine]), LocalProcesses(1))]


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("name", "engine", "outcome"),
    [
        ("light_chain_in_air", "reference-fast", "pass"),  # air gives it more energy than the judging solution ever has
        ("kinks_and_equal_steps", "pymunk", "pass"),  # a force whose slope jumps: no regular fall with the step
        ("four_bars_that_fold", "exudyn-tree", "pass"),
        ("six_bars_that_fold", "exudyn-tree", "too_coarse"),  # a twentieth can be judged
        ("two_bars_for_fifty_orbits", "heyoka", "pass"),
    ],
)
def test_a_right_engine_is_not_accused(name: str, engine: str, outcome: str) -> None:
    if ENGINES[engine].missing:
        pytest.skip(ENGINES[engine].missing)
    assert outcomes(load_scene(SCENES / f"{name}.toml"), engine) == [outcome]


def test_equal_steps_pass_wherever_turning_faces_fall_into_them() -> None:
    """The difference of two settings was 1/1.5 of the error that explains it: each had its own luck with ten faces."""
    scene = load_scene("conform/one_bar_loads")
    effects = scene.effects
    thrust = dataclasses.replace(effects.thrust[1], force_N=(0.002, 0.0015), times_s=(705.2115, 1800.54))
    light = dataclasses.replace(effects.solar_pressure, shadow=False)
    other = dataclasses.replace(effects, thrust=(effects.thrust[0], thrust), solar_pressure=light)
    assert outcomes(dataclasses.replace(scene, effects=other), "pymunk") == ["pass"]


@pytest.mark.slow
def test_scipys_solvers_see_a_face_that_is_shown_for_half_a_step() -> None:
    """Watched at the ends of steps alone, one such face cost 0.014 rad here."""
    scene = load_scene(SCENES / "faces_for_half_a_step.toml")
    setting = Setting(AccuracyParameter.RTOL, 1e-10)
    found, right = (ENGINES[name].load()().run(scene, setting) for name in ("scipy-dop853", "reference-fast"))
    assert differences(found, right)["attitude"].max() < 1e-4


TREE = ENGINES["exudyn-tree"].load()
STEPS = Setting(AccuracyParameter.STEPS_PER_ORBIT, 400)
SPREAD_RAD = 3e-5
INTERVALS = 9
"""Sample intervals of the stretch"""
STAGES = (0.0, 1 / 3, 2 / 3, 1 / 3, 5 / 6, 1 / 6, 1.0)
COUPLING = (
    (), (1 / 3,), (0.0, 2 / 3), (1 / 12, 1 / 3, -1 / 12), (25 / 48, -55 / 24, 35 / 48, 15 / 8),
    (3 / 20, -11 / 24, -1 / 8, 1 / 2, 1 / 10), (-261 / 260, 33 / 13, 43 / 156, -118 / 39, 32 / 195, 80 / 39),
)  # fmt: skip
WEIGHTS = (13 / 200, 0.0, 11 / 40, 11 / 40, 4 / 25, 4 / 25, 13 / 200)
"""Butcher's method of seven stages and sixth order"""


def stretch(solution: ReferenceSolution) -> Trajectory:
    """Stretch of a run of 56 orbits that begins just before two bars fold; the first sample counts."""
    found, n = solution.trajectory, INTERVALS + 1
    return found.samples(slice(0, n)).replace(
        com_m=np.tile([7197159.797391271, 11560303.025204014], (n, 1)),
        com_velocity_m_s=np.tile([-3133.031640775942, 3731.2142136016105], (n, 1)),
        angle_rad=np.tile([3.5279901412835315, 1.6516295664645781, 3.39467022187425, 1.735559460919184], (n, 1)),
        rate_rad_s=np.tile([0.00436050245624252, 0.0120328230851377, 0.0004954616000192, -0.000572732358249], (n, 1)),
    )


@pytest.fixture(scope="module")
def long_run() -> ReferenceSolution:
    """Solution of the first stretch of the long run, in the scene of the whole."""
    scene = closely_sampled(load_scene(SCENES / "four_bars_that_fold.toml"))
    end_s = float(scene.times_s[INTERVALS])
    short = dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=end_s, samples=INTERVALS + 1))
    engine = ENGINES["reference"].load()

    def run(of: Scene, rtol: float) -> Trajectory:
        found: Trajectory = engine().run(of, Setting(AccuracyParameter.RTOL, rtol))
        return found

    found = establish(short, run(short, 1e-13), run(short, 1e-12), run(with_perturbed_start(short), 1e-13))
    return dataclasses.replace(found, scene=scene)


def steps_of_sixth_order(solution: ReferenceSolution, start: Trajectory) -> Array:
    """Angles after one sample interval by a method of sixth order, (N,) rad."""
    first = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
    state = [values[0] for values in first if values is not None]
    motion = Simulation(chain_model(solution.scene), *state, rtol=RTOL)
    h, y = step_s(solution.scene, STEPS.value), motion.y0
    for k in range(round(start.t_s[1] / h)):
        slopes: list[Array] = []
        for c, row in zip(STAGES, COUPLING, strict=True):
            moved = sum((a * slope for a, slope in zip(row, slopes, strict=True)), np.zeros_like(y))
            slopes.append(motion.coordinates.rhs(h * (k + c), y + h * moved))
        y = y + h * sum((b * slope for b, slope in zip(WEIGHTS, slopes, strict=True)), np.zeros_like(y))
    found: Array = motion.coordinates.unpack(y).angle_rad
    return found


def local_errors(solution: ReferenceSolution, start: Trajectory) -> tuple[LocalErrors, ReferenceSolution]:
    restarted = restarted_solution(
        solution,
        start,
        0,
        start.t_s[: INTERVALS + 1],
        RTOL,
        SPREAD_RAD,
        partial(resolving_s, TREE, STEPS, solution.scene),
    )
    return truncation_errors(TREE, STEPS, restarted), restarted


def test_where_bars_fold_a_restart_is_as_uncertain_as_a_method_of_sixth_order_is_wrong(
    long_run: ReferenceSolution,
) -> None:
    """With as many samples as a run of 56 orbits can afford, ten times the estimate was a sixtieth of this error."""
    start = stretch(long_run)
    right = restarted_run(long_run.scene, start, 0, start.t_s, 1e-12)
    wrong = np.abs(steps_of_sixth_order(long_run, start) - right.angle_rad[1]).max()
    assert wrong > 5e-5  # in 22 steps
    local, restarted = local_errors(long_run, start)
    expected = local.attitude(restarted.trajectory.t_s, restarted.amplification)[1]
    assert wrong < expected < 3.0 * NORM_SLACK * wrong


def test_a_fold_does_not_make_the_quiet_motion_uncertain_that_follows(long_run: ReferenceSolution) -> None:
    """Errors of single steps were 3e-10 to 5e-5 rad in this stretch."""
    made = local_errors(long_run, stretch(long_run))[0].attitude_rate
    assert made.min() < 1e-4 * made.max()


def test_derivatives_in_a_restart_do_not_depend_on_the_length_of_the_run(long_run: ReferenceSolution) -> None:
    whole = long_run.scene.run
    shorter = dataclasses.replace(whole, duration_s=whole.duration_s / 20.0, samples=whole.samples // 20 + 1)
    short_run = dataclasses.replace(long_run, scene=dataclasses.replace(long_run.scene, run=shorter))
    assert shorter.times_s[1] == pytest.approx(whole.times_s[1])
    start = stretch(long_run)
    long, short = (local_errors(solution, start)[0].attitude_rate for solution in (long_run, short_run))
    assert long == pytest.approx(short)


def test_a_restart_ends_where_its_own_error_may_have_parted_it_from_the_truth(long_run: ReferenceSolution) -> None:
    """A restart that went on was 0.08 rad off, where 2e-5 rad of a right engine's error were to be judged."""
    start, resolving = stretch(long_run), partial(resolving_s, TREE, STEPS, long_run.scene)
    coarse, fine = (
        restarted_solution(long_run, start, 0, start.t_s[: INTERVALS + 1], rtol, SPREAD_RAD, resolving)
        for rtol in (1e-5, RTOL)
    )
    known = coarse.trajectory.t_s <= coarse.limit_s
    assert coarse.limit_s < fine.limit_s
    assert differences(coarse.trajectory, fine.trajectory)["attitude"][known].max() < PARTED_RAD


def test_a_restart_measures_the_growth_of_errors_in_more_than_one_direction(long_run: ReferenceSolution) -> None:
    """One direction grew by 70 here, errors of the angles alone by 350 to 1700."""
    scene, n = load_scene(SCENES / "two_bars_for_fifty_orbits.toml"), 58
    t = np.linspace(0.0, 1.38 * scene.period_s, n)
    short = dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=scene.period_s, samples=n))
    start = (
        Reference()
        .run(short, Setting(AccuracyParameter.RTOL, 1e-6))
        .replace(
            t_s=t,
            com_m=np.tile([3054448.37083736, -5994691.74800533], (n, 1)),
            com_velocity_m_s=np.tile([6858.146686228636, 3494.400689380172], (n, 1)),
            angle_rad=np.tile([1153.728777061372, -75.19875652275917], (n, 1)),
            rate_rad_s=np.tile([0.005668531805675019, 0.002009665528700923], (n, 1)),
        )
    )
    right = restarted_run(scene, start, 0, t, 1e-13)
    tried = [np.stack([d, np.zeros(2)]) for d in np.random.default_rng(1).uniform(-1.0, 1.0, (6, 2))]
    grown = []
    for moved in tried:
        apart = differences(right, restarted_run(scene, start, 0, t, 1e-13, 1e-10 * moved))["attitude"]
        grown.append(apart.max() / apart[0])
    found = [differences(right, restarted_run(scene, start, 0, t, 1e-13, 1e-10 * d))["attitude"] for d in directions(2)]
    most = max(d.max() / d[0] for d in found)
    assert max(grown) < 3.0 * most
    own = restarted_solution(
        dataclasses.replace(long_run, scene=scene), start, 0, start.t_s[:n], 1e-13, 1e-10, lambda _: 60.0
    )
    assert own.amplification.max() == pytest.approx(most, rel=0.1)
