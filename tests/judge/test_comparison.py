"""The comparison itself: it explains what it should, and nothing else; its register of tolerances."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from adapters.trajectory import Trajectory
from barchain.judge.tolerances import SAFEGUARDS, TOLERANCES
from barchain.metrics.model_difference import com_displacement
from barchain.metrics.quantities import conserved, differences
from barchain.solutions.reference import PERTURBATION_RAD, divergence_instant_s, with_perturbed_start
from barchain.studies.comparison.run import tolerance_rows
from reports.results.comparison import PARTED_RAD
from reports.results.outcome import Outcome
from scenarios import Actuator, load_scene
from tests.judge.trust_cases import judged, lasting
from tests.support.slow import one_in, rows
from tests.support.solutions import run, solution_of


@pytest.fixture(scope="module")
def scene():
    return lasting("paper/fig15", 1.0, 101)


@pytest.fixture(scope="module")
def solution(scene):
    return solution_of(scene)


@pytest.fixture(scope="module")
def honest(scene):
    return run(scene, 1e-8), run(scene, 1e-9)


def outcomes(solution, main, finer):
    verdict = judged(solution, main, finer)
    return verdict, {(r["quantity"], r["metric"]): Outcome(r["outcome"]) for r in verdict.rows}


def test_an_honest_engine_passes_in_every_quantity(solution, honest):
    verdict, found = outcomes(solution, *honest)
    assert verdict.outcome is Outcome.PASS
    assert {q for q, _ in found} - {"run"} == {
        "com",
        "com_velocity",
        "attitude",
        "rate",
        "reaction",
        "gap",
        "com_residual",
        "energy_about_com",
        "angular_momentum_about_com",
    }


NAMES = {
    "angle_rad": "attitude",
    "rate_rad_s": "rate",
    "reaction_N": "reaction",
    "com_m": "com",
    "com_velocity_m_s": "com_velocity",
}


@pytest.mark.parametrize("quantity", NAMES)
def test_a_shift_common_to_both_settings_is_inconsistent(solution, honest, quantity):
    """Different physics does not shrink with the step: the two error estimates can't explain it."""
    main, finer = (seen.replace(**{quantity: getattr(seen, quantity) * (1 + 1e-4)}) for seen in honest)
    _, found = outcomes(solution, main, finer)
    assert found[NAMES[quantity], "normalised_error"] is Outcome.INCONSISTENT


def test_an_engine_worse_than_its_setting_promises_exceeds_the_bound_though_its_error_is_explained(scene, solution):
    main, finer = run(scene, 1e-4), run(scene, 1e-5)
    _, found = outcomes(solution, main, finer)
    assert found["attitude", "normalised_error"] is Outcome.PASS
    assert found["attitude", "max"] is Outcome.EXCEEDS_BOUND


def test_the_predictability_limit_is_the_last_instant_before_two_runs_part():
    t = np.linspace(0.0, 9.0, 10)
    com = np.zeros((10, 2))
    a = Trajectory(t, com, com, angle_rad=np.zeros((10, 1)))
    apart = np.zeros((10, 1))
    apart[6:] = 2 * PARTED_RAD
    assert divergence_instant_s(a, a) == 9.0
    assert divergence_instant_s(a, a.replace(angle_rad=apart)) == 5.0


def test_a_finer_run_that_parts_from_the_main_one_is_a_fault_and_no_limit(solution, honest):
    main, finer = honest
    verdict, _ = outcomes(solution, main, finer.replace(angle_rad=finer.angle_rad + np.linspace(0, 1, 101)[:, None]))
    assert verdict.outcome is Outcome.EXCEEDS_BOUND


def test_a_perturbed_run_starts_at_its_distance_and_shows_the_amplification_of_the_horizontal_chain():
    scene = lasting("paper/fig05", 1.0, 101)
    apart = differences(run(scene, 1e-12), run(with_perturbed_start(scene), 1e-12))["attitude"]
    assert 0.5 * PERTURBATION_RAD <= apart[0] <= PERTURBATION_RAD
    # the slowest unstable mode of a horizontal chain, the rigid one, grows as exp(sqrt(3) n t): 5.3e4 an orbit
    assert apart[-1] / apart[0] > np.exp(np.sqrt(3) * 2 * np.pi) / 10


@pytest.mark.parametrize(("name", "factor"), one_in(2, rows([("paper/fig05", 12 * np.pi), ("steep", 72.4207)])))
def test_the_chains_centre_of_mass_leaves_keplers_orbit_as_the_square_of_its_length(name, factor):
    """Known in the limit of short bars: 12 pi r (l/r)² an orbit for the horizontal chain, 72.42 at 80 degrees."""
    base = lasting("paper/fig05", 1.0, 101)
    angle = np.deg2rad(0.0 if name == "paper/fig05" else 80.0)
    lengths, sizes = np.array([25.0, 50.0, 100.0]), []
    for length in lengths:
        chain = dataclasses.replace(
            base.chain,
            length_m=(length,) * 5,
            inertia_kg_m2=(100 * length**2 / 12,) * 5,
            angle_rad=(angle,) * 5,
        )
        scene = dataclasses.replace(base, chain=chain)
        seen, looser = run(scene, 1e-13), run(scene, 1e-12)
        own_error = np.linalg.norm(seen.com_m - looser.com_m, axis=1).max()
        predicted = com_displacement(scene, seen)
        kepler = scene.radius0_m * np.stack(
            [np.cos(scene.mean_motion_rad_s * seen.t_s), np.sin(scene.mean_motion_rad_s * seen.t_s)], axis=1
        )
        found = np.linalg.norm(seen.com_m - kepler, axis=1)
        assert (
            np.abs(found - np.linalg.norm(predicted.vector_m, axis=1)).max() < predicted.uncertainty_m[-1] + own_error
        )
        sizes.append(found[-1])
    assert np.polyfit(np.log(lengths), np.log(sizes), 1)[0] == pytest.approx(2.0, abs=0.02)
    assert sizes[0] == pytest.approx(factor * base.radius0_m * (25.0 / base.radius0_m) ** 2, rel=5e-3)


def test_invariants_are_claimed_only_where_the_effects_conserve_them():
    keeps = {
        name: conserved(load_scene(name)) for name in ("paper/fig05", "basics/free_rotation", "basics/kepler_elliptic")
    }
    assert not keeps["paper/fig05"].energy  # the paper's gradient torque has no counterpart in the force
    assert keeps["basics/free_rotation"].relative
    assert keeps["basics/kepler_elliptic"].angular_momentum
    slew = load_scene("paper/fig17")
    motor = dataclasses.replace(slew.effects.prescribed_rotation[0], actuator=Actuator.JOINT)
    free = dataclasses.replace(
        slew.effects, gravity=load_scene("basics/free_rotation").effects.gravity, prescribed_rotation=(motor,)
    )
    inside = conserved(dataclasses.replace(slew, effects=free))
    assert inside.angular_momentum
    assert not inside.energy


ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", sorted({entry.tested_by for entry in (*TOLERANCES, *SAFEGUARDS)}))
def test_every_test_that_the_register_names_exists(name: str) -> None:
    files = [*ROOT.glob("tests/judge/*.py"), *ROOT.glob("tests/harness/*.py")]
    assert any(f"def {name}(" in path.read_text(encoding="utf-8") for path in files)


def test_the_report_shows_every_tolerance() -> None:
    assert [row["derivation"] for row in tolerance_rows()] == [t.derivation for t in TOLERANCES]
