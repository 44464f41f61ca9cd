"""The paper's misprints as faults: its own form in place of the right-hand side, with one misprint left in."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING
from unittest.mock import patch

from barchain.studies.selftest.faults import reasons
from barchain.studies.selftest.faults.fault import Fault, FaultGroup
from reference_impl.model import relative
from reference_impl.paper.form import paper_accelerations, solve
from reference_impl.paper.matrices import longitudes
from reference_impl.paper.misprints import ERRATA, Misprint
from reference_impl.paper.state import paper_state, units_of

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager

    from barchain.studies.selftest.faults.fault import CodeChange, NotApplicable
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import Modes
    from reference_impl.model.state import Accelerations, State
    from scenarios import Scene

FORM = "paper-form"
MISPRINT = {
    Misprint.TORQUE_SIGN: reasons.papers_own,
    Misprint.BETA_DENOMINATOR: reasons.papers_own,
    Misprint.W_THIRD_ROW: reasons.first_of(reasons.papers_own, reasons.joints),
    Misprint.S2_SIGN: reasons.first_of(reasons.papers_own, reasons.joints),
    Misprint.B_INDICES: reasons.first_of(reasons.papers_own, reasons.joints),
    Misprint.CONTROL_IDENTITY: reasons.first_of(
        reasons.papers_own, reasons.needs("prescribed_rotation", "prescribed rotation")
    ),
    Misprint.HALF_LENGTH: reasons.first_of(reasons.papers_own, reasons.joints, reasons.unequal),
}
BETA_PROOF = (
    "theta'' = phi'' + omega'' is what turns the bars and what the joints see, and beta_j enters both parts with "
    "opposite signs: it cancels as long as no phi'' is prescribed"
)


def paper_form(*as_printed: Misprint) -> CodeChange:
    """The paper's form as right-hand side."""

    def wrong(model: ChainModel, t_s: float, state: State, modes: Modes | None = None, **how: bool) -> Accelerations:
        del modes, how
        return paper_accelerations(model, t_s, state, frozenset(as_printed))

    return replacing(wrong)


def replacing(wrong: Callable[..., Accelerations]) -> CodeChange:
    """Other accelerations."""

    def within(size: float) -> AbstractContextManager[object]:
        del size
        return patch.object(relative, "accelerations", wrong)

    return within


def local_angles(model: ChainModel, t_s: float, state: State, modes: Modes | None = None, **how: bool) -> Accelerations:
    """Paper's form with beta_j as printed, for whoever integrates phi and takes omega from the places."""
    del modes, how
    units = units_of(model, state.com_m)
    found = solve(model, t_s, state, units, frozenset({Misprint.BETA_DENOMINATOR}))
    right = longitudes(paper_state(model, state, units), frozenset())
    angle = found.bars[:, 2] + right.acceleration(found.bars[:, :2], found.X_acceleration[-2:])
    printed = paper_accelerations(model, t_s, state, frozenset({Misprint.BETA_DENOMINATOR}))
    return dataclasses.replace(printed, angle_rad_s2=angle / units.time_s**2)


def quarter_turn(scene: Scene, size: float) -> Scene:
    """Chain set up a quarter turn away."""
    turned = tuple(a + size * math.pi / 2 for a in scene.chain.angle_rad)
    return dataclasses.replace(scene, chain=dataclasses.replace(scene.chain, angle_rad=turned))


def misprint(which: Misprint, nothing: NotApplicable) -> Fault:
    """Fault of one misprint."""
    entry = ERRATA[which]
    return Fault(
        f"misprint-{which.value.replace('_', '-')}",
        f"{entry.place}: {entry.printed}, right: {entry.right}",
        entry.reason,
        FaultGroup.PAPER,
        code=paper_form(which),
        nothing=nothing,
        like=FORM,
        expected_failure=which is Misprint.CONTROL_IDENTITY,
        invisible=BETA_PROOF if which is Misprint.BETA_DENOMINATOR else "",
    )


CONTROL = Fault(
    FORM,
    "the paper's own form with every misprint put right",
    "no fault",
    FaultGroup.CONTROL,
    code=paper_form(),
    nothing=reasons.papers_own,
)
FAULTS = (
    *(misprint(which, nothing) for which, nothing in MISPRINT.items()),
    Fault(
        "misprint-beta-in-phi",
        "(B.6) as printed, phi integrated and the longitude taken from the places",
        "theta = phi + omega - 90° with an omega'' that is not the one in phi''",
        FaultGroup.PAPER,
        code=replacing(local_angles),
        nothing=reasons.first_of(reasons.papers_own, reasons.central_pull),
        like=FORM,
    ),
    Fault(
        "misprint-stability-text",
        "the chain set up as section 6 words it, a quarter turn from where it is meant",
        "even multiples of 90° printed as stable, odd ones are",
        FaultGroup.PAPER,
        scene=quarter_turn,
        nothing=reasons.gravity,
    ),
)
