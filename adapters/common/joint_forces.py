"""Reactions of barchain from the forces that a library gives for its joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array


def reaction_from_wrench(force_N: Array, *, on_next_bar: bool, axes_rad: Array | float = 0.0) -> Array:
    """Force on bar j from bar j+1 in inertial axes, from the force of a joint's wrench.

    A wrench is a force and a moment. Its force is the same at every point of reference, so that the moment and the
    point are not needed. A spatial wrench may begin with its moment: give the force alone.

    Parameters
    ----------
    force_N : ndarray, shape (..., 2) or (..., 3)
        Components along the wrench's own axes; a third one, normal to the plane, is left out.
    on_next_bar : bool
        True if the force acts on bar j+1, as on the child of a joint tree that starts at bar 1. False if it acts on
        bar j.
    axes_rad : float or ndarray, shape (...)
        Angle of the wrench's first axis from the inertial z1 axis, counter-clockwise: 0 for inertial axes, a bar's
        angle for its body axes.

    Returns
    -------
    ndarray, shape (..., 2)

    Raises
    ------
    ValueError
        If the last axis of `force_N` holds neither two nor three components.
    """
    if force_N.shape[-1] not in (2, 3):
        raise ValueError(f"force_N has shape {force_N.shape}, expected (..., 2) or (..., 3)")
    sign = -1.0 if on_next_bar else 1.0
    c, s = sign * np.cos(axes_rad), sign * np.sin(axes_rad)
    first, second = force_N[..., 0], force_N[..., 1]
    return np.stack([c * first - s * second, s * first + c * second], axis=-1)


def reactions_from_motion(mass_kg: Array, acceleration_m_s2: Array, force_N: Array) -> Array:
    """Force on each bar from the next, by Newton's law for all bars up to it.

    For engines without joint forces. Accelerations and forces must be relative to the same falling frame: in inertial
    ones the reactions are lost as small differences of large numbers.

    Parameters
    ----------
    mass_kg : ndarray, shape (N,)
    acceleration_m_s2 : ndarray, shape (..., N, 2)
        Of the bars' centres.
    force_N : ndarray, shape (..., N, 2)
        On each bar, without the reactions.

    Returns
    -------
    ndarray, shape (..., N-1, 2)
    """
    missing: Array = np.cumsum(mass_kg[:, None] * acceleration_m_s2 - force_N, axis=-2)
    return missing[..., :-1, :]
