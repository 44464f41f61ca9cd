"""Landing: height of a chain above the surface, and the reason of a run that ended there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.kinematics import directions

if TYPE_CHECKING:
    from adapters.trajectory import Array


def least_height_m(
    radius_m: float, length_m: Array, centre_m: Array, angle_rad: Array, left_m: Array | None = None
) -> float:
    """Least distance of any point of any bar from the surface; negative below it.

    Parameters
    ----------
    radius_m : float
        Radius of the central body.
    length_m : ndarray, shape (N,)
    centre_m : ndarray, shape (N, 2)
        Bars' centres from the centre of the central body.
    angle_rad : ndarray, shape (N,)
    left_m : ndarray, shape (N,), optional
        Distances of the bars' left ends from their centres of mass; half of the lengths by default.

    Returns
    -------
    float
        In metres.
    """
    left, (along, _) = 0.5 * length_m if left_m is None else left_m, directions(angle_rad)
    # nearest point of the bar, from its centre
    foot = np.clip(-np.sum(centre_m * along, axis=-1), -left, length_m - left)
    return float(np.linalg.norm(centre_m + foot[:, None] * along, axis=-1).min() - radius_m)


def landing_text(landed_s: float | None) -> str:
    """Text of `Trajectory.ended`.

    Parameters
    ----------
    landed_s : float or None
        Instant at which a bar reached the surface, s; None if none did.

    Returns
    -------
    str
        Empty for None.
    """
    return "" if landed_s is None else f"a bar reached the surface at t = {landed_s:.6f} s"
