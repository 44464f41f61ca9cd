"""Misprints of the paper: place, printed and correct form, expected effect."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Misprint(StrEnum):
    """Misprints of the paper; :mod:`reference_impl.paper.form` keeps a chosen set of them."""

    TORQUE_SIGN = "torque_sign"
    BETA_DENOMINATOR = "beta_denominator"
    W_THIRD_ROW = "w_third_row"
    S2_SIGN = "s2_sign"
    B_INDICES = "b_indices"
    CONTROL_IDENTITY = "control_identity"
    HALF_LENGTH = "half_length"
    STABILITY_TEXT = "stability_text"


class MisprintConsequence(StrEnum):
    """Consequence of a misprint for the computed motion."""

    WRONG_REACTIONS = "wrong reactions"
    WRONG_LOCAL_ANGLES = "right reactions, wrong phi''"
    NOT_SOLVABLE = "not solvable as printed"
    TEXT_ONLY = "text only"


@dataclass(frozen=True)
class Erratum:
    """A misprint's entry in the table."""

    place: str
    """Equation or passage of the paper"""
    printed: str
    right: str
    effect: MisprintConsequence
    expected: float | None
    """Order of the relative error of the reactions in a generic state; None: not quantifiable"""
    reason: str


ERRATA: dict[Misprint, Erratum] = {
    Misprint.TORQUE_SIGN: Erratum(
        "(17), (B.7)",
        "-3 sin(phi) cos(phi)/rho^3",
        "+3 sin(phi) cos(phi)/rho^3",
        MisprintConsequence.WRONG_REACTIONS,
        1e-1,
        "phi counts from the horizontal; with the minus the horizontal bar would be the stable one",
    ),
    Misprint.BETA_DENOMINATOR: Erratum(
        "(B.6), beta_j",
        "(Y_j1^2 + Y_j2^2)^2 below",
        "(Y_j1^2 + Y_j2^2) below; gamma_j keeps its square",
        MisprintConsequence.WRONG_LOCAL_ANGLES,
        0.0,
        "the joints see theta'' = phi'' + omega'', in which beta_j cancels; both terms are off by opposite amounts",
    ),
    Misprint.W_THIRD_ROW: Erratum(
        "table of W (B), third row",
        "alpha_j",
        "(lambda_j/mu_j) alpha_j",
        MisprintConsequence.WRONG_REACTIONS,
        1e-5,
        "lambda_j times (B.5), where T_j'' holds the reactions over mu_j; alpha_j is of order epsilon",
    ),
    Misprint.S2_SIGN: Erratum(
        "(C.5), second component of S",
        "-(1/2) gamma_j cos(theta_j)",
        "+(1/2) gamma_j cos(theta_j)",
        MisprintConsequence.WRONG_REACTIONS,
        1e-1,
        "gamma_j goes with the unit vector across the bar, (-sin, cos); it vanishes on a circular orbit",
    ),
    Misprint.B_INDICES: Erratum(
        "(C.9)",
        "S(j,1) - S(j-1,1)",
        "S(j-1,2) - S(j,1)",
        MisprintConsequence.WRONG_REACTIONS,
        1.0,
        "the joint ties the right end of bar j-1 to the left end of bar j, as (C.7) says",
    ),
    Misprint.CONTROL_IDENTITY: Erratum(
        "(26), (27)",
        "an identity of full width for the control forces",
        "one column for each prescribed motion, in the row of the angle its torque turns",
        MisprintConsequence.NOT_SOLVABLE,
        None,
        "3N+2 control forces stand against one equation for each prescribed motion",
    ),
    Misprint.HALF_LENGTH: Erratum(
        "(17), (19), table of W (B), (C.1)-(C.5)",
        "1/2 for every bar",
        "l_j/(2 l) where lengths differ",
        MisprintConsequence.WRONG_REACTIONS,
        1e-1,
        "all bars are taken as long as the characteristic length l; nothing changes where they are",
    ),
    Misprint.STABILITY_TEXT: Erratum(
        "section 6, example (a)",
        "even multiples of pi/2 stable, odd ones unstable",
        "odd multiples (radial) stable, even ones (horizontal) unstable",
        MisprintConsequence.TEXT_ONLY,
        None,
        "the paper's own figures agree with this",
    ),
}
