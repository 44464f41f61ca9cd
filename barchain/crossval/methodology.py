"""What is known beside the runs: the paper's misprints, how tolerances come about, what the harness can't do."""

from __future__ import annotations

import dataclasses
from typing import Any

from barchain.judge import tolerances as t
from barchain.judge.checks.extrapolation import SHARE
from barchain.judge.comparison import LEAST_JUDGED
from barchain.judge.declared_noise import MOST_NOISE
from barchain.judge.local_errors import ROUNDINGS
from barchain.judge.roundoff_limit import SPREAD
from barchain.solutions.reference import (
    FINE_PER_RADIAN,
    PARTED_RAD,
    PERTURBATION_RAD,
    RICHARDSON,
    SOLUTION_CHECK_RTOL,
    SOLUTION_RTOL,
)
from reference_impl.paper.misprint_effects import misprint_effects


def misprints() -> list[dict[str, Any]]:
    """The paper's misprints with the effect of each, measured on a generic state just now."""
    return [dataclasses.asdict(row) for row in misprint_effects()]


def tolerances() -> list[dict[str, str]]:
    """Every tolerance with its derivation, for the report."""
    rows = [
        ("all", "solution", f"rtol = {SOLUTION_RTOL:g}",
         f"the reference at its tightest; its difference from rtol = {SOLUTION_CHECK_RTOL:g} bounds its error"),
        ("all", "Richardson factor", f"{RICHARDSON:g}",
         "a method of order p >= 1 whose finer setting halves the step is off by at most 1/(1 - 2^-p) of its change"),
        ("all", "round-off floor", f"{ROUNDINGS:g} u sqrt(steps) G(t)",
         "a random walk of the steps' roundings (u r/l in absolute coordinates), amplified by the measured growth G"),
        ("all", "growth G(t)", f"twin started {PERTURBATION_RAD:g} rad aside",
         "a truth's twin: far above the truth's own error, and linear until it has grown 1e8 times"),
        ("all", "predictability limit", f"{PARTED_RAD:g} rad",
         "the last sample at which the expected-error bound of the attitude is below this: growth of the reference "
         "solution times the errors that the method promises; the engine's own runs have no say in it"),
        ("all", "beyond the limit", "the reference restarted",
         "from the engine's last good sample, as far as that can be predicted, and again; the track of the centre of "
         "mass, gaps and invariants are judged over the whole run"),
        ("all", "least judged", f"{LEAST_JUDGED:.0%} of the run",
         "agreement over a shorter share says nothing about the scene"),
        ("all", "declared noise", f"{MOST_NOISE:g} of the scale",
         "what dies away is cut off there; noise that is larger at the end of the run is not believed"),
        ("all", "measured round-off", f"{SPREAD:g} times the spread of four runs",
         "the same setting in turned frames, from starts moved in their last digits; made where a verdict is in doubt"),
        ("attitude, rate, reaction, com", "extrapolation", f"{SHARE:g} of the change between settings",
         "what Richardson's extrapolation of two runs may be off by; more must be there at a third setting, too"),
        ("pointwise", "band, fixed steps", f"{t.NORM_SLACK:g} C h^p",
         "C h^p times the integral of |theta^(p+1)| G(t)/G(s), C = 1/8 (second order) or 1/5040 (sixth), carried "
         "into rates, reactions and track by the twin's measured response; the slack covers norms and stages"),
        ("pointwise", "band, chosen steps", f"{t.NORM_SLACK:g} rtol",
         "the requested error in each step, one step for each radian of the chain's fastest rate, carried alike; "
         "its error is a sum of steps of any sign, so that the slack explains besides what two runs estimate"),
        ("pointwise", "derivatives", f"{FINE_PER_RADIAN:g} samples a radian",
         "those of the truth are taken from a run sampled so closely, and more closely in a manoeuvre"),
        ("com", "bound", "n^2 rtol r, or C h^p of its third derivative",
         "what is made at s has run on along the track, 1 + 3 n (t - s) times, by t; in a straight line nothing is"),
        ("com velocity", "bound", "n times the track's",
         "a displaced centre of mass goes round at the orbit's rate, at its largest v/r"),
        ("com", "model difference", "12 pi r (l/r)^2 an orbit on fig05",
         "a chain's centre of mass leaves a particle's track; integrated along the truth's attitude, taken out, and "
         "only its uncertainty (interpolation, next order) allowed"),
        ("gap", "bound", f"{t.NORM_SLACK:g} h^2",
         "index 2 leaves C h² times the third derivative of a bar's end, impulses h²/2 of its second; chosen steps "
         "rtol l each"),
        ("reaction, torque, rate", "engine's noise", "declared by its adapter",
         "what shrinks with no step: where Newton stops, numerical differentiation, impulses over a step (u r m/h² in "
         "absolute coordinates), the start-up transient of index 3"),
        ("gap", "joints in place", "Newton's residual + u L N",
         "index 3 puts the ends together in every step: what is left is where its iterations stop, and rounding"),
        ("identity", "bound", f"{ROUNDINGS:g} u L sqrt(N)",
         "a sum of places, of radii in absolute coordinates: nothing is integrated"),
        ("energy, angular momentum", "bound", "the less of both",
         "quadratic and bilinear in what they are made of: four times the relative bands of rates, attitude and track; "
         "and twice the change to the finer setting, beside round-off"),
    ]  # fmt: skip
    return [dict(zip(("quantity", "what", "value", "derivation"), row, strict=True)) for row in rows]


def limitations() -> list[str]:
    """What a reader should know before relying on a number."""
    return [
        "The motion is planar, and the central body's field spherical unless a scene has its oblateness (J2).",
        "Effects are as docs/effects defines them: a cylindrical shadow that darkens the whole chain at once, an "
        "exponential atmosphere without shading of one bar by another, third bodies on circles that nothing moves.",
        "The paper's gravity gradient has a torque without its counterpart in the force: energy and angular momentum "
        "are then conserved by no method, to O((l/r)²), and are not judged.",
        "Error estimates and the reference solution come from double precision. On chaotic scenes they end at the "
        "predictability limit; beyond it a run is compared with the reference restarted from the run's own states.",
        "The reference is compared with a tighter run of itself: its row shows convergence, not independence.",
        "Index 3 starts with multipliers off by first order in the step and damps that in some 50 steps: its first "
        "reactions are judged by a tolerance that says so.",
        "Joint gaps and the distance of the bars' weighted centre from the centre of mass are computed from the places "
        "and angles that an engine gives of its bars, and what it reports of them must agree. Where an engine gives no "
        "places of its own, they are as reported: joints that do not hold then show in the attitude.",
        "An engine that follows only the centre of mass is judged on that alone.",
        "Wall times are from worker processes running side by side: they tell orders of magnitude, not rankings.",
    ]
