"""Register of all tolerances of a verdict: value, derivation, and the test of each.

The report's methodology and the tables in `docs/explanation/` (verdicts, comparison) are generated here
(`python -m pictures --only pages`).
"""

from __future__ import annotations

from dataclasses import dataclass

from adapters.heyoka import CLOSE_START_RAD
from barchain.judge.checks.beyond_limit import MAX_EMPTY_SHARE
from barchain.judge.checks.restart import CONSECUTIVE, SCATTERED
from barchain.judge.checks.up_to_limit import PERSISTING_SHARE
from barchain.judge.discontinuities import LARGEST, ON_ORBIT
from barchain.judge.local_errors import MAX_STEP_CONSTANT, error_constant
from barchain.judge.residuals import HIGHER_ORDER_SHARE, MAX_MEASURED_SHARE
from barchain.judge.scales import (
    LOWEST_ORDER,
    MAX_ATTITUDE_NOISE_RAD,
    MAX_NOISE_SHARE,
    MAX_TRACK_NOISE_SHARE,
    NORM_SLACK,
    ROUNDINGS,
    SPREAD_FACTOR,
    STEPS_SLACK,
)
from barchain.judge.verdict import MIN_JUDGED_SHARE
from barchain.solutions.judging import CERTIFIED_CHECK_RTOL, CERTIFIED_RTOL
from barchain.solutions.reference import (
    FINE_PER_RADIAN,
    PERTURBATION_RAD,
    RICHARDSON,
    ROUNDED,
    ROUNDED_ALIKE,
    SOLUTION_CHECK_RTOL,
    SOLUTION_RTOL,
    WIDE_CHECK_RTOL,
    WIDE_RTOL,
)
from reports.results.comparison import PARTED_RAD


@dataclass(frozen=True)
class Tolerance:
    """One part of the tolerances, and its derivation."""

    quantity: str
    """Quantities that it applies to"""
    name: str
    value: str
    """Number or formula; u is the unit round-off, n the mean motion, h the step, p the order"""
    derivation: str
    tested_by: str
    """Test in ``tests/judge`` that fails if this part is too wide or too narrow"""


@dataclass(frozen=True)
class Safeguard:
    """Bound of something that an engine controls and that would widen its tolerances."""

    widened_by: str
    bound: str
    fault: str
    """Fault that tests the bound"""
    tested_by: str
    """Test that makes the fault, in ``tests/judge`` or ``tests/harness``"""


def plain(value: float) -> str:
    """Number as text, without a leading zero in its exponent: ``1e-6``."""
    return f"{value:g}".replace("e-0", "e-")


TOLERANCES = (
    Tolerance(
        "all", "certified solution", f"rtol = {CERTIFIED_RTOL:g}",
        "heyoka in quadruple precision; its difference from the run at "
        f"rtol = {CERTIFIED_CHECK_RTOL:g} bounds its error, and {ROUNDED:g} roundings to double precision are added",
        "test_a_fault_in_the_references_own_equations_is_caught_by_the_certified_solution_and_not_by_itself",
    ),
    Tolerance(
        "all", "reference solution", f"rtol = {WIDE_RTOL:g} in extended precision, {SOLUTION_RTOL:g} in double",
        "for scenes without a certified solution: the reference at its smallest rtol; its difference from the run at "
        f"rtol = {WIDE_CHECK_RTOL:g} ({ROUNDED_ALIKE:g} times, as both may be rounding), in double "
        f"{SOLUTION_CHECK_RTOL:g}, bounds its error; the roundings that both share are added",
        "test_the_reference_is_consistent_with_itself_at_every_setting",
    ),
    Tolerance(
        "all", "Richardson factor", f"{RICHARDSON:g}",
        "the error of the main run of a method of order p >= 1 is at most 1/(1 - 2^-p) times the change between the "
        "settings, the finer of which halves the step",
        "test_a_shift_common_to_both_settings_is_inconsistent",
    ),
    Tolerance(
        "all", "round-off floor", f"{ROUNDINGS:g} u sqrt(steps) G(t)",
        "a random walk of the steps' roundings (u r/l in absolute coordinates), times the measured error "
        "amplification G",
        "test_a_straight_track_is_exact_but_for_rounding",
    ),
    Tolerance(
        "all", "error amplification G(t)",
        f"initial angles and rates perturbed by 0.5 to 1 times {PERTURBATION_RAD:g} (rad; relative to the orbital "
        "rate)",
        "a second run: the perturbation is far above the error of the solution, and its growth is linear up to 1e8 "
        f"times; in extended precision another run perturbed by 1e-16, linear up to 1e14 times, and in quadruple by "
        f"{CLOSE_START_RAD}, up to 1e16 times",
        "test_a_perturbed_run_starts_at_its_distance_and_shows_the_amplification_of_the_horizontal_chain",
    ),
    Tolerance(
        "all", "predictability limit", f"{PARTED_RAD:g} rad",
        "the last sample at which the expected-error bound of the attitude is below this value: error amplification of "
        "the judging solution times the errors that the method promises; the engine's own runs do not enter",
        "test_runs_that_are_unstable_each_in_its_own_way_do_not_pass",
    ),
    Tolerance(
        "all", "beyond the limit", f"{CONSECUTIVE} consecutive and {SCATTERED} scattered restarts",
        "the reference restarts from the engine's last good sample and is compared as far as the restart can be "
        "predicted; the track of the centre of mass, gaps and invariants are judged over the whole run",
        "test_garbage_from_any_instant_on_in_either_run_does_not_pass",
    ),
    Tolerance(
        "all", "least judged share", f"{MIN_JUDGED_SHARE:.0%} of the run",
        "agreement over a shorter share says nothing about the scene",
        "test_an_engine_without_rates_is_not_passed_on_the_predictable_part_alone",
    ),
    Tolerance(
        "all", "declared noise", f"{MAX_NOISE_SHARE:g} of the scale",
        f"transient noise is cut off there (attitude: {plain(MAX_ATTITUDE_NOISE_RAD)} rad, track: "
        f"{plain(MAX_TRACK_NOISE_SHARE)} of the scale); noise that is larger at the end of the run is not believed",
        "test_declared_noise_counts_up_to_a_hundredth_of_each_quantity",
    ),
    Tolerance(
        "all", "measured round-off", f"{SPREAD_FACTOR:g} times the spread of four runs",
        "the main run and three runs at its setting in slightly turned frames, from starts perturbed in their last "
        "digits; made where a verdict is in doubt",
        "test_an_engine_in_relative_coordinates_can_not_pass_as_limited_by_round_off",
    ),
    Tolerance(
        "attitude, rate, reaction, com", "extrapolation",
        f"{HIGHER_ORDER_SHARE:g} of the change between settings",
        "terms of higher order in Richardson's extrapolation of two runs; a larger error must be there at a third "
        f"setting too, at {PERSISTING_SHARE:g} of its size or more",
        "test_noise_and_offsets_far_below_a_second_order_method_s_own_error_are_seen",
    ),
    Tolerance(
        "all", "faces within equal steps", f"{LARGEST:g} h^2 times the jump of the acceleration's slope",
        "largest error of a second-order step across it; over several faces a random walk, on an orbit "
        f"{ON_ORBIT:g} times as much",
        "test_equal_steps_pass_wherever_turning_faces_fall_into_them",
    ),
    Tolerance(
        "pointwise", "expected-error bound, fixed steps", f"{NORM_SLACK:g} C h^p",
        f"C h^p times the integral of |theta^(p+1)| G(t)/G(s), C = 1/{1 / error_constant(2):.0f} (second order) or "
        f"1/{1 / error_constant(6):.0f} (sixth); the perturbed run's measured response carries it into rates, "
        "reactions and track; the slack covers norms and stages",
        "test_the_bound_of_a_tree_follows_the_motion_and_not_the_chains_fastest_mode",
    ),
    Tolerance(
        "pointwise", "expected-error bound, chosen steps", f"{NORM_SLACK:g} rtol",
        "the requested error in each step, one step for each radian of the chain's fastest rate, amplified alike; the "
        "error is a sum of steps of any sign, so that this slack is added to the explained error too. Errors in stiff "
        "joints that are damped live for the time in which these decay; the other motion counts its own radians",
        "test_an_engine_worse_than_its_setting_promises_exceeds_the_bound_though_its_error_is_explained",
    ),
    Tolerance(
        "pointwise", "derivatives", f"{FINE_PER_RADIAN:g} samples a radian",
        "derivatives of the judging solution come from a run sampled so densely, and more densely in a manoeuvre; a "
        "restart has samples of its own, however long the run is",
        "test_a_manoeuvre_between_few_samples_is_no_false_alarm",
    ),
    Tolerance(
        "pointwise", "derivatives above the third", "theta''' r^(p-2)",
        "r^2 is the fifth over the third derivative, r at least the bars' own rate; where bars fold through each other "
        "the motion has poles in complex time far closer than a radian, and derivatives grow by the inverse of that "
        "time; samples half a step apart give r of each instant, others the largest of the run",
        "test_where_bars_fold_a_restart_is_as_uncertain_as_a_method_of_sixth_order_is_wrong",
    ),
    Tolerance(
        "com", "expected-error bound", "n^2 rtol r, or C h^p of its third derivative",
        "an error made at s has grown along the track 1 + 3 n (t - s) times by t; in a straight line it has not: there "
        "methods that choose their steps leave t^2/2 times the range of the forces at most, nothing of constant ones",
        "test_a_straight_track_is_exact_but_for_rounding",
    ),
    Tolerance(
        "com velocity", "expected-error bound", "n times the track's",
        "a displaced centre of mass moves at the orbit's rate, at its largest v/r",
        "test_the_velocity_of_a_particle_is_judged_by_the_predicted_departure",
    ),
    Tolerance(
        "com", "model difference", "12 pi r (l/r)^2 an orbit on fig05",
        "a chain's centre of mass leaves a particle's track; the departure is integrated along the judging "
        "solution's attitude and subtracted, and only its uncertainty (interpolation, next order) is allowed",
        "test_the_chains_centre_of_mass_leaves_keplers_orbit_as_the_square_of_its_length",
    ),
    Tolerance(
        "com", "parted attitudes", "the integral of a(s) (3 (t - s) + 8/n) ds",
        "beyond the predictability limit accelerations that depend on the attitude differ by their whole strength a(s) "
        "along the orbit: drag and light by the force face on, thrusts in a bar's axes by twice their own. A velocity "
        "step dv moves the track by 3 t dv along the orbit and 8 dv/n beside it (Hill), (1 + e)/(1 - e) times that on "
        "ellipses",
        "test_opposite_thrusts_move_the_track_by_less_than_the_bound_and_not_by_far_less",
    ),
    Tolerance(
        "gap", "bound", f"{NORM_SLACK:g} h^2",
        "index 2 leaves C h² times the third derivative of a bar's end, impulses h²/2 times its second; chosen steps "
        "leave rtol l each",
        "test_joints_put_in_place_are_judged_by_rounding_and_not_by_the_step",
    ),
    Tolerance(
        "reaction, torque, rate", "engine's noise", "declared by its adapter",
        "errors that shrink with no step: tolerance of Newton's iterations, numerical differentiation, impulses over a "
        "step (u r m/h² in absolute coordinates), the start-up transient of index 3",
        "test_a_manoeuvre_stirs_index_3_by_its_own_bar_and_one_order_less_than_the_start",
    ),
    Tolerance(
        "gap", "joints in place", "Newton's residual + u L N",
        "index 3 closes the joints in every step: the tolerance of its iterations and rounding remain",
        "test_joints_put_in_place_are_judged_by_rounding_and_not_by_the_step",
    ),
    Tolerance(
        "com residual", "bound", f"{ROUNDINGS:g} u L sqrt(N)",
        "rounding of a sum of places, of radii in absolute coordinates: nothing is integrated",
        "test_the_centre_of_mass_residual_is_judged_by_the_rounding_of_a_sum",
    ),
    Tolerance(
        "energy, angular momentum", "bound", "the smaller of two",
        "quadratic and bilinear in their factors: four times the relative bounds of rates, attitude and track; and "
        "twice the change to the finer setting, beside round-off",
        "test_energy_may_drift_by_what_the_finer_setting_changes_and_no_more",
    ),
)  # fmt: skip

SAFEGUARDS = (
    Safeguard(
        "early divergence of the engine's two runs",
        "the predictability limit follows from the reference's error amplification and the method's promise",
        "garbage from 25, 50 and 90 % on, in the main run, the finer run, or both",
        "test_garbage_from_any_instant_on_in_either_run_does_not_pass",
    ),
    Safeguard(
        "difference of the engine's two runs, as error estimate",
        "the expected-error bound holds besides; the finer run is judged alike",
        "a finer run that parts from the main run",
        "test_a_finer_run_that_parts_from_the_main_one_is_a_fault_and_no_limit",
    ),
    Safeguard(
        "a finer run identical to the main run, bit for bit",
        "such a run estimates nothing: perturbed runs measure round-off, or the verdict stands",
        "the main run given twice",
        "test_a_run_equal_to_its_finer_one_bit_for_bit_is_no_estimate_of_zero",
    ),
    Safeguard(
        '`info["steps"]`',
        f"believed up to {STEPS_SLACK:g} `rtol^(-1/{LOWEST_ORDER + 1:g})` steps in a radian of the fastest rate, else "
        "not used",
        "rtol × 1000 and 1e9 steps",
        "test_a_count_of_steps_that_no_method_takes_widens_nothing",
    ),
    Safeguard(
        "declared noise",
        f"cut off at {MAX_NOISE_SHARE:g} of the quantity's scale; noise larger at the end is not used; a larger error "
        "makes `unsupported` at most",
        "noise declared as large as the results",
        "test_an_engine_that_declares_any_noise_does_not_pass_with_a_wrong_mass",
    ),
    Safeguard(
        "measured round-off",
        f"up to {NORM_SLACK:g} times the floor of the engine's coordinates counts towards a pass; towards "
        "`roundoff_limited` counts the largest rounding of places in absolute coordinates, and "
        f"{plain(MAX_MEASURED_SHARE)} of a quantity's scale in others",
        "unseeded noise in every run",
        "test_an_engine_in_relative_coordinates_can_not_pass_as_limited_by_round_off",
    ),
    Safeguard(
        "`step_constant` of a method that chooses its steps",
        f"believed up to {MAX_STEP_CONSTANT:g} requests a step",
        "a wrong mass and a constant of a million",
        "test_a_declared_error_constant_counts_up_to_ten_and_makes_no_room_for_a_wrong_mass",
    ),
    Safeguard(
        "round-off since the start, in restarts",
        "does not count: it is part of the state that a segment starts from",
        "a floor that grows a thousandfold in the run",
        "test_round_off_since_the_start_makes_no_later_sample_unpredictable",
    ),
    Safeguard(
        "declared noise of rates, in restarts",
        f"counts up to {plain(MAX_ATTITUDE_NOISE_RAD)} rad; a setting is `too_coarse` if more than "
        f"{MAX_EMPTY_SHARE:.0%} of its segments can predict nothing",
        "rate noise just below the believed size",
        "test_declared_noise_of_rates_does_not_switch_off_restarts",
    ),
    Safeguard(
        "channels that are returned but not declared",
        "the run is `malformed`",
        "an engine that declares its track alone",
        "test_an_engine_that_shows_more_than_it_declares_is_malformed_and_judged_by_what_it_shows",
    ),
    Safeguard(
        "declared coordinates",
        "absolute coordinates have a floor of u r/l, which the detection limit states; errors beyond the floor are "
        "`roundoff_limited` at most",
        "a faulty engine that declares absolute coordinates",
        "test_round_off_of_absolute_coordinates_excuses_no_nonsense_beyond_the_limit",
    ),
    Safeguard(
        "`ended`, of any run",
        "within one sample of the reference, or within the instants that errors of track and attitude explain",
        "an end at a quarter of the run",
        "test_a_finer_run_that_ends_early_does_not_shorten_what_is_judged",
    ),
    Safeguard(
        "gaps and residuals reported as 0",
        "computed from the bars' positions where the engine returns them, else marked as reported",
        "bars whose positions open the joints",
        "test_joints_put_in_place_are_judged_by_rounding_and_not_by_the_step",
    ),
    Safeguard(
        "motion of the engine (rates for bounds of gap and energy)",
        "taken from the judging solution",
        "rates that lose a part over the run",
        "test_energy_may_drift_by_what_the_finer_setting_changes_and_no_more",
    ),
    Safeguard(
        "few samples",
        "the comparison samples more densely",
        "noise after t = 0 on five samples",
        "test_five_samples_over_two_chaotic_orbits_are_judged_and_not_only_the_first",
    ),
    Safeguard(
        "missing rates, so that no restart is possible",
        "nothing is judged beyond the limit, and the verdict is no pass",
        "a chaotic run without rates",
        "test_an_engine_without_rates_is_not_passed_on_the_predictable_part_alone",
    ),
    Safeguard(
        "rejection of every scene",
        "an engine compared on no scene is a failure, if it was named or had several scenes",
        "an engine that supports nothing",
        "test_an_engine_compared_on_no_scene_is_a_failure_if_it_was_named",
    ),
)
