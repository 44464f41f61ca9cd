"""Formulations of the reactions: relative coordinates, absolute coordinates, and Newton's law from known motion.

Gravity is the paper's: a point force at each bar's centre and the gradient torque of eq. (17).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.precision.chain import (
    AbsoluteState,
    ChainAccelerations,
    ChainParameters,
    RelativeState,
    directions,
    dot,
)
from reference_impl.precision.joints import solve

if TYPE_CHECKING:
    from reference_impl.precision.arithmetic import Arithmetic, Values


def tidal_accelerations(
    a: Arithmetic, bars: ChainParameters, com_m: Values, position_m: Values
) -> tuple[Values, Values, Values]:
    """Gravity at the bars minus that at the centre of mass (2, N, B), its mean, and gravity at the centre (2, B).

    Encke's method, as in :mod:`reference_impl.model.gravity`: no two large numbers are subtracted.
    """
    com = com_m[:, None]
    r2 = dot(com, com)
    change = a.expm1(-1.5 * a.log1p(dot(2.0 * com + position_m, position_m) / r2))
    pull = -bars.mu_m3_s2 / (r2 * a.sqrt(r2))
    difference = pull * (position_m * (1.0 + change) + com * change)
    return difference, (difference * bars.weight).sum(axis=1), (pull * com)[:, 0]


def relative(a: Arithmetic, bars: ChainParameters, state: RelativeState) -> ChainAccelerations:
    """Relative formulation, eqs. (9)-(15), (21)-(24)."""
    difference, mean, field = tidal_accelerations(a, bars, state.com_m, state.position_m)
    place, local = state.com_m[:, None] + state.position_m, difference - mean[:, None]
    return coupled_accelerations(a, bars, state.angle_rad, state.rate_rad_s, place, local, field + mean)


def absolute(a: Arithmetic, bars: ChainParameters, state: AbsoluteState) -> ChainAccelerations:
    """Absolute formulation, eqs. (8), (15), (19); differs from :func:`relative` in the coordinates only."""
    field = point_field(a, bars, state.place_m)
    return coupled_accelerations(
        a, bars, state.angle_rad, state.rate_rad_s, state.place_m, field, (field * bars.weight).sum(axis=1)
    )


def point_field(a: Arithmetic, bars: ChainParameters, place_m: Values) -> Values:
    """Gravity at positions from the body's centre, eq. (8), (2, N, B)."""
    r2 = dot(place_m, place_m)
    return -bars.mu_m3_s2 / (r2 * a.sqrt(r2)) * place_m


def coupled_accelerations(
    a: Arithmetic,
    bars: ChainParameters,
    angle_rad: Values,
    rate_rad_s: Values,
    place_m: Values,
    field_m_s2: Values,
    com: Values,
) -> ChainAccelerations:
    """Reactions and accelerations of bars with closed joints in a given field."""
    along, across = directions(a, angle_rad)
    spin = gradient_angular_accelerations(a, bars, place_m, along, across)
    end = bars.half_m * (spin * across - rate_rad_s * rate_rad_s * along)
    right = (field_m_s2[:, 1:] - field_m_s2[:, :-1]) - (end[:, :-1] + end[:, 1:])
    reaction = solve(bars, across, right)
    none = 0.0 * (reaction if reaction.size else field_m_s2)[:, :1]  # of a single bar there is no reaction
    after, before = np.concatenate([reaction, none], axis=1), np.concatenate([none, reaction], axis=1)
    angular = spin + bars.lever * dot(across, after + before)
    return ChainAccelerations(reaction, angular, field_m_s2 + bars.inverse_mass * (after - before), com)


def gradient_angular_accelerations(
    a: Arithmetic, bars: ChainParameters, place_m: Values, along: Values, across: Values
) -> Values:
    """K_j/J_j of eq. (17), (N, B), rad/s²; zero of point masses."""
    if not bars.gradient:
        return 0.0 * along[0]
    r2 = dot(place_m, place_m)
    return 3.0 * (bars.mu_m3_s2 / (r2 * a.sqrt(r2))) * dot(along, place_m) * (dot(across, place_m) / r2)


def newton_reactions(bars: ChainParameters, unexplained_m_s2: Values) -> Values:
    """Reactions (2, N-1, B) from known accelerations minus gravity (2, N, B), eq. (8).

    R_j is the sum of m_k times that difference over k <= j: Newton's second law, bar by bar from the free end.
    """
    return np.cumsum(bars.mass_kg * unexplained_m_s2, axis=1)[:, :-1]
