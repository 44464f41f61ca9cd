"""A pass means right: errors above the detection limit, and values with too few digits, are seen."""

import dataclasses

import numpy as np
import pytest

from adapters.exudyn.adapter import Exudyn, ExudynAbsolute
from adapters.pymunk.adapter import Pymunk
from barchain.judge.checks.whole_run import rounded_values
from barchain.judge.evidence import TURNED_RAD, perturbed, turned, turned_back
from barchain.judge.scales import scales
from barchain.metrics.quantities import differences
from barchain.runs.job import ROUNDOFF_ROLES, RunResult
from barchain.solutions.reference import MOST_TURNED_RAD, closely_sampled
from reports.results.outcome import Outcome
from scenarios import change_scene, load_scene
from tests.judge.trust_cases import judged, lasting, three_settings, value
from tests.support.solutions import run, solution_of

DISTANCE_M = {"moon": 384.4e6, "sun": 149597870.7e3}
"""Their tides move a bar of 100 m by as little as round-off does"""
RADIAL = {"chain": {"angle_deg": 90.0}, "run": {"orbits": 0.25, "samples": 26}}
"""One bar standing upright on a circular orbit"""
AT_REST = {
    "chain": {"mass_kg": 10.0, "length_m": 10.0, "angle_deg": 0.0, "rate_factor": 0.0},
    "run": {"duration_s": 100.0, "samples": 21},
}
"""Two bars at rest in free space"""


@pytest.mark.slow
def test_a_run_equal_to_its_finer_one_bit_for_bit_is_no_estimate_of_zero(chaotic, unmodified):
    """Too little tells the finer run from the main one; the method's own request explains what is off."""
    verdict = judged(chaotic, unmodified[0], unmodified[0])
    assert verdict.outcome is Outcome.PASS or verdict.further_runs


def test_an_error_above_the_detection_limit_is_called_and_its_tenth_need_not_be():
    solution = solution_of(lasting("paper/fig15", 0.3, 61))
    main, finer = run(solution.scene, 1e-8), run(solution.scene, 1e-9)
    right = judged(solution, main, finer)
    limit = value(right, "reaction", "detection_limit")
    assert all(0.0 < value(right, quantity, "detection_limit") < 1.0 for quantity in ("com", "attitude", "rate"))
    size = 1.01 * limit * scales(solution)["reaction"]
    for at in (5, 30, 60):
        wrong = []
        for seen in (main, finer):
            reaction = seen.reaction_N.copy()
            reaction[at, 0, 0] += size
            wrong.append(seen.replace(reaction_N=reaction))
        assert not judged(solution, *wrong).outcome.ok


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


@pytest.mark.slow
def test_a_turned_scene_turned_back_is_the_scene_itself():
    """Every effect's directions turn with the frame; what is left are the last digits that the start was moved by."""
    scene = lasting("effects/everything", 0.05, 21)
    scene = dataclasses.replace(
        scene, effects=dataclasses.replace(scene.effects, thrust=(), impulse=(), prescribed_rotation=())
    )
    straight = run(scene, 1e-12)
    for turn in (0.739, 2.0, -1.1):
        apart = differences(turned_back(run(turned(scene, turn), 1e-12), turn), straight)
        assert apart["attitude"].max() < 1e-10
        assert apart["com"].max() < 1e-4
        assert apart["reaction"].max() < 1e-10 * max(1.0, np.abs(straight.reaction_N).max())


@pytest.mark.exhaustive
def test_a_mistaken_direction_in_inertial_axes_is_no_round_off():
    """Such an engine gives another result in each frame, as round-off does."""

    def with_bodies(scene, change):
        bodies = tuple(dataclasses.replace(b, **change(b)) for b in scene.effects.third_body)
        return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, third_body=bodies))

    def mistaken(scene):
        return with_bodies(scene, lambda _: {"longitude_rad": 0.0})

    scene = with_bodies(load_scene("conform/third_body_alone"), lambda b: {"distance_m": DISTANCE_M[b.name]})
    main, finer = (run(mistaken(scene), rtol) for rtol in (1e-12, 1e-13))
    others = tuple(turned_back(run(mistaken(perturbed(scene, k)), 1e-12), a) for k, a in enumerate(TURNED_RAD))
    assert not judged(solution_of(scene), main, finer, perturbed=others).outcome.ok


@pytest.mark.slow
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


@pytest.mark.exhaustive
def test_an_engine_in_relative_coordinates_can_not_pass_as_limited_by_round_off(chaotic, unmodified):
    """However noisy its runs are: coordinates as small as the chain leave no room."""
    rng = np.random.default_rng(3)

    def noisy(seen):
        return seen.replace(reaction_N=seen.reaction_N + 1e-4 * rng.normal(size=seen.reaction_N.shape))

    verdict = judged(
        chaotic, noisy(unmodified[0]), noisy(unmodified[1]), perturbed=tuple(noisy(unmodified[0]) for _ in TURNED_RAD)
    )
    assert verdict.outcome not in (Outcome.PASS, Outcome.ROUNDOFF_LIMITED)


@pytest.mark.parametrize(("finest", "outcome"), [(0.02, Outcome.PASS), (1.498, Outcome.ROUNDOFF_LIMITED)])
def test_scatter_of_chosen_steps_is_no_round_off_if_finer_settings_reduce_it(chaotic, unmodified, finest, outcome):
    """Runs that perturbed steps move by their own error; a still finer run tells the cause."""
    main = unmodified[0]
    explained = judged(chaotic, *unmodified).series["reaction_tolerance"].fillna(0.0).to_numpy()[:, None, None]
    right = chaotic.trajectory.reaction_N[: len(main.t_s)]

    def moved(share):
        return main.replace(reaction_N=right + share * explained / np.sqrt(2.0))  # both components alike

    final = judged(
        chaotic, moved(1.5), moved(1.499), perturbed=tuple(moved(share) for share in (-1.0, 0.5, -0.3)),
        finest=RunResult(Outcome.PASS, trajectory=moved(finest)),
    )  # fmt: skip
    row = next(r for r in final.rows if (r["quantity"], r["metric"]) == ("reaction", "normalised_error"))
    assert row["outcome"] == outcome


def test_a_comparison_looks_closely_enough_and_keeps_a_scene_s_own_instants():
    scene = lasting("paper/fig05", 2.0, 5)
    close = closely_sampled(scene)
    spacing = close.run.duration_s / (close.run.samples - 1)
    assert spacing * scene.orbital_rate_rad_s <= MOST_TURNED_RAD
    assert set(scene.times_s) <= set(close.times_s)
    assert closely_sampled(lasting("paper/fig05", 1.0, 101)).run.samples == 101


@pytest.mark.exhaustive
def test_five_samples_over_two_chaotic_orbits_are_judged_and_not_only_the_first():
    solution = solution_of(closely_sampled(lasting("paper/fig05", 2.0, 5)))
    main, finer = run(solution.scene, 1e-8), run(solution.scene, 1e-9)
    assert value(judged(solution, main, finer), "run", "judged_share") == 1.0
    noise = np.random.default_rng(1).normal(size=main.angle_rad.shape) * (main.t_s > 0.0)[:, None]
    assert not judged(solution, main.replace(angle_rad=main.angle_rad + 0.1 * noise), finer).outcome.ok


@pytest.mark.parametrize(
    ("name", "changes", "engine"),
    [("libration", RADIAL, Exudyn), ("two_bars_free", AT_REST, Pymunk), ("two_bars_free", AT_REST, Exudyn)],
)
def test_exact_decimals_and_rest_accuse_nobody(name, changes, engine):
    """3.6 degrees between samples are no rounding, and of no motion nothing is lost."""
    solution = solution_of(change_scene(load_scene(f"basics/{name}"), changes))
    setting, runs = three_settings(engine, solution.scene)
    assert judged(solution, runs[0], runs[1], engine, setting).outcome is Outcome.PASS
