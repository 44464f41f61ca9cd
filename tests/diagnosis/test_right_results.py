"""Nothing is named for a result inside its tolerances, for noise, or for low accuracy."""

from itertools import product

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from barchain.judge.diagnosis.diagnose import diagnose
from barchain.judge.diagnosis.verdicts import (
    diagnosed_verdict,
    diagnosis_of_verdict,
    needs_diagnosis,
    verdict_tolerance,
)
from barchain.metrics.quantities import QUANTITY_OF, arrays
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.judging import solution_engine
from barchain.solutions.reference import closely_sampled
from scenarios import load_scene
from tests.diagnosis.planting import RTOL, runs_of, unequal_chain, verdict_on
from tests.support.slow import one_in, rows
from tests.support.solutions import run, solution_of

SCENE = unequal_chain()
CORE = ("basics/libration", "basics/two_bars_free", "basics/point_chain", "basics/kepler_circular")


def test_places_that_scatter_about_their_velocities_are_noise_and_those_that_swing_are_none() -> None:
    right, rng = solution_of(SCENE).trajectory, np.random.default_rng(2)
    size = {"com": SCENE.radius0_m, "com_velocity": 1e4, "attitude": 1.0, "rate": SCENE.fastest_rate_rad_s}
    tolerance = {q: np.full(len(right.t_s), 1e-9 * s) for q, s in size.items()}
    noisy = right.replace(
        com_m=right.com_m * (1.0 + 1e-6 * rng.standard_normal(right.com_m.shape)),
        angle_rad=right.angle_rad + 1e-6 * rng.standard_normal(right.angle_rad.shape),
        reaction_N=None,
    )
    found = diagnose(SCENE, noisy, solution_of(SCENE), tolerance)
    assert not found.explanations, str(found)
    assert "the output has noise" in str(found)
    swinging = 1e-6 * np.sin(2.0 * np.pi * right.t_s / right.t_s[-1])
    swung = right.replace(com_m=right.com_m * (1.0 + swinging[:, None]), reaction_N=None)
    said = str(diagnose(SCENE, swung, solution_of(SCENE), tolerance))
    assert "positions differ from the integrals of the velocities" in said
    assert "noise" not in said


@pytest.mark.parametrize(
    ("name", "engine"),
    one_in(7, rows(product(CORE, ["reference-fast", "exudyn", "rebound", "pymunk", "exudyn-tree"]))),
)
def test_a_right_result_has_no_diagnosis(engine: str, name: str) -> None:
    if ENGINES[engine].missing:
        pytest.skip(str(ENGINES[engine].missing))
    scene, loaded = load_scene(name), ENGINES[engine].load()
    solved = shipped_solution(scene)
    if loaded.unsupported(scene) or loaded.unsupported_motion(scene, solved.fine):
        return
    main, finer = runs_of(engine, scene)
    found = diagnose(scene, main, solved, verdict_tolerance(verdict_on(main, finer, solved, engine)))
    assert not found.explanations, str(found)
    assert not found.parts, str(found)


def noisy(times: float, seed: int) -> tuple[Trajectory, dict[str, np.ndarray]]:
    """The right result with noise of some tolerances in every value, and the tolerances."""
    right, solved = run(SCENE, RTOL), solution_of(SCENE)
    tolerance = dict(verdict_tolerance(verdict_on(right, run(SCENE, 0.1 * RTOL), solved)))
    rng, changes = np.random.default_rng(seed), {}
    for field, values in arrays(solved.trajectory).items():
        size = tolerance[QUANTITY_OF[field]] if QUANTITY_OF[field] in tolerance else np.zeros(len(right.t_s))
        size = np.where(np.isfinite(size), size, 0.0).reshape(-1, *[1] * (values.ndim - 1))
        changes[field] = values + times * size * rng.uniform(-1.0, 1.0, values.shape)
    return right.replace(**changes), tolerance


@pytest.mark.parametrize(("times", "seed"), one_in(8, rows(product([0.5, 1.0, 2.0, 5.0, 1e3], [1, 2, 3]))))
def test_noise_names_nothing(times: float, seed: int) -> None:
    result, tolerance = noisy(times, seed)
    found = diagnose(SCENE, result, solution_of(SCENE), tolerance)
    assert not found.explanations, str(found)
    assert not found.parts, str(found)


@pytest.mark.parametrize("rtol", one_in(2, [1e-3, 1e-6]))
def test_low_accuracy_is_no_mistake(rtol: float) -> None:
    solved, setting = solution_of(SCENE), Setting(AccuracyParameter.RTOL, RTOL)
    verdict = verdict_on(run(SCENE, rtol), run(SCENE, 0.1 * rtol), solved, solution_engine(), setting=setting)
    found = diagnose(SCENE, run(SCENE, rtol), solved, verdict_tolerance(verdict))
    assert not found.explanations, str(found)


def test_a_passing_verdict_stays_as_it_is() -> None:
    solved, main = solution_of(SCENE), run(SCENE, RTOL)
    verdict = verdict_on(main, run(SCENE, 0.1 * RTOL), solved)
    assert not needs_diagnosis(verdict)
    assert diagnosed_verdict(verdict, main, solved) is verdict


def test_a_result_with_missing_numbers_is_wrong_and_unexplained() -> None:
    right, solved = run(SCENE, RTOL), solution_of(SCENE)
    tolerance = verdict_tolerance(verdict_on(right, run(SCENE, 0.1 * RTOL), solved))
    broken = right.reaction_N.copy()
    broken[3:] = np.nan
    found = diagnose(SCENE, right.replace(reaction_N=broken), solved, tolerance)
    assert [w.quantity for w in found.wrong] == ["reaction"]
    assert not found.explanations


def test_what_is_silent_about_all_wrong_samples_explains_none() -> None:
    """Central differences say nothing at both ends, and a delay nothing at one."""
    right, solved = run(SCENE, RTOL), solution_of(SCENE)
    size = np.abs(right.rate_rad_s).max()
    tolerance = {"rate": np.full(len(right.t_s), 0.1 * size)}  # differences of the samples are inside it
    tolerance["rate"][1:] = np.inf
    wrong = right.rate_rad_s.copy()
    wrong[[0, -1]] += 1e3 * size
    found = diagnose(SCENE, right.replace(rate_rad_s=wrong), solved, tolerance)
    assert [w.quantity for w in found.wrong] == ["rate"]
    assert not found.explanations, str(found)
    assert not found.parts, str(found)


def test_another_scene_than_the_solution_s_is_rejected() -> None:
    solved = solution_of(SCENE)
    with pytest.raises(ValueError, match="not of"):
        diagnose(unequal_chain(samples=51), run(SCENE, RTOL), solved, {})


@pytest.mark.parametrize("name", one_in(9, ["two_bars_free", "one_bar_point", "one_bar_gradient"]))
@pytest.mark.parametrize("rtol", one_in(3, [1e-12, 3e-13, 1e-13]))
def test_a_fixed_tolerance_is_no_mistake_of_the_scene(name: str, rtol: float) -> None:
    """The tolerance of an altered scene's run is wider than the request, and many altered scenes move alike."""
    scene = closely_sampled(load_scene(f"conform/{name}"))
    solved, setting = shipped_solution(scene), Setting(AccuracyParameter.RTOL, 1e-14)
    main = run(scene, rtol)
    verdict = verdict_on(main, main, solved, solution_engine(), setting=setting)
    if not needs_diagnosis(verdict):
        return
    found = diagnosis_of_verdict(verdict, main, solved)
    assert not found.explanations, str(found)
    assert not found.parts, str(found)
