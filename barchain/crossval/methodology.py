"""Methodology beside the runs: the paper's misprints, derivations of tolerances, limitations of the harness."""

from __future__ import annotations

import dataclasses
from typing import Any

from barchain.judge.tolerances import TOLERANCES
from reference_impl.paper.misprint_effects import misprint_effects


def misprints() -> list[dict[str, Any]]:
    """The paper's misprints with the effect of each, measured on a generic state just now."""
    return [dataclasses.asdict(row) for row in misprint_effects()]


def tolerance_rows() -> list[dict[str, str]]:
    """Every tolerance with its derivation, for the report."""
    return [{"quantity": t.quantity, "what": t.name, "value": t.value, "derivation": t.derivation} for t in TOLERANCES]


def limitations() -> list[str]:
    """Limitations of the comparison, one sentence or two each."""
    return [
        "The motion is planar. The central body's field is spherical unless a scene has its oblateness (J2).",
        "Effects are as docs/effects defines them: a cylindrical shadow that darkens the whole chain at once, an "
        "exponential atmosphere without shading of one bar by another, third bodies on fixed circles.",
        "The paper's gravity gradient has a torque without its counterpart in the force. No method then conserves "
        "energy and angular momentum to O((l/r)²), and they are not judged.",
        "Error estimates come from double precision. On chaotic scenes they end at the predictability limit. Beyond it "
        "a run is compared with the reference restarted from the run's own states.",
        "A scene's facts name the solution that judges it. Where that is a reference solution, the rows of the "
        "reference's forms show convergence, not independence; where it is a certified solution, those of heyoka do.",
        "Index 3 starts with multipliers off by first order in the step and damps that error in some 50 steps. The "
        "tolerance of its first reactions includes that error.",
        "Joint gaps and the distance of the bars' weighted centre from the centre of mass are computed from the places "
        "and angles that an engine gives of its bars, and the engine's reported values must agree. Where an engine "
        "gives no places of its own, they are as reported: joints that do not hold then show in the attitude.",
        "An engine that follows only the centre of mass is judged on the track alone.",
        "Wall times are from worker processes running side by side: they tell orders of magnitude, not rankings.",
    ]
