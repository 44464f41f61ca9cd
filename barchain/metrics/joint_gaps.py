"""Joint gaps and the centre-of-mass residual of eq. (6), computed from the places of the bars.

The values that an engine reports may be wrong, or left at zero. An engine whose places follow from the angles gives no
places: its joints are closed by construction, and nothing is computed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.common.departure import departure, drift_bound_m
from adapters.engine import Coordinates

if TYPE_CHECKING:
    from adapters.engine import Declarations
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

ROUNDING = 16.0 * float(np.finfo(float).eps)
"""Relative to the largest term of a place: a handful of sums and a rotation of axes, in the engine and here."""


def gaps(scene: Scene, trajectory: Trajectory) -> Array | None:
    """Distance between the two ends that each joint ties, (n, N-1), m; None without places or angles."""
    if trajectory.position_m is None or trajectory.angle_rad is None:
        return None
    along = np.stack([np.cos(trajectory.angle_rad), np.sin(trajectory.angle_rad)], axis=-1)
    left, right = (np.array(lever_m)[:, None] * along for lever_m in (scene.chain.left_m, scene.chain.right_m))
    between = np.diff(trajectory.position_m, axis=1) - (left[:, 1:] + right[:, :-1])
    distance: Array = np.hypot(between[..., 0], between[..., 1])
    return distance


def centre_of_mass_residual(scene: Scene, trajectory: Trajectory) -> Array | None:
    """Distance of the bars' weighted centre from the centre of mass, |sum mu_j d_j|, (n,), m; None without places."""
    if trajectory.position_m is None:
        return None
    mass = np.array(scene.chain.mass_kg)
    centre = np.einsum("j,njk->nk", mass / mass.sum(), trajectory.position_m)
    distance: Array = np.hypot(centre[:, 0], centre[:, 1])
    return distance


def measured(scene: Scene, trajectory: Trajectory) -> Trajectory:
    """Trajectory whose gaps and residual follow from its places, if it has places.

    A reported number that agrees within round-off stays: an engine may know its angles to more digits than it returns.
    """
    if trajectory.position_m is None:
        return trajectory
    place = ROUNDING * largest_m(scene, trajectory)
    gap = kept_or_computed(trajectory.gap_m, gaps(scene, trajectory), gap_rounding(scene, trajectory, place))
    return trajectory.replace(
        gap_m=gap,
        com_residual_m=kept_or_computed(trajectory.com_residual_m, centre_of_mass_residual(scene, trajectory), place),
    )


def kept_or_computed(reported: Array | None, computed: Array | None, allowed: Array) -> Array | None:
    """Reported numbers where they are within `allowed` of the computed numbers, else the computed numbers."""
    if reported is None or computed is None:
        return reported if computed is None else computed
    return np.where(np.abs(reported - computed) <= allowed, reported, computed)


def disagreement(scene: Scene, engine: Declarations, trajectory: Trajectory) -> str:
    """First reported gap or residual that contradicts the bars' places, in one line; empty if there is none."""
    if trajectory.position_m is None:
        return ""
    place = ROUNDING * (largest_m(scene, trajectory) + origin_m(scene, engine, trajectory))
    return wrong_gap(scene, trajectory, place) or wrong_residual(scene, trajectory, place)


def wrong_gap(scene: Scene, trajectory: Trajectory, place_m: Array) -> str:
    """First reported gap that differs from the computed gap by more than round-off; empty if none does."""
    computed = gaps(scene, trajectory)
    if trajectory.gap_m is None or computed is None:
        return ""
    wrong = np.abs(trajectory.gap_m - computed) > gap_rounding(scene, trajectory, place_m)
    if not wrong.any():
        return ""
    sample, joint = (int(i[0]) for i in np.nonzero(wrong))
    return (
        f"reports a gap of {trajectory.gap_m[sample, joint]:.3g} m at joint {joint + 1} at "
        f"t = {trajectory.t_s[sample]:.6g} s, "
        f"its bars' places leave {computed[sample, joint]:.3g} m"
    )


def wrong_residual(scene: Scene, trajectory: Trajectory, place_m: Array) -> str:
    """First reported residual that differs from the computed residual by more than round-off; empty if none does."""
    computed = centre_of_mass_residual(scene, trajectory)
    if trajectory.com_residual_m is None or computed is None:
        return ""
    wrong = np.abs(trajectory.com_residual_m - computed) > place_m
    if not wrong.any():
        return ""
    sample = int(np.argmax(wrong))
    return (
        f"reports its bars' weighted centre {trajectory.com_residual_m[sample]:.3g} m from the centre of mass at "
        f"t = {trajectory.t_s[sample]:.6g} s, their places leave {computed[sample]:.3g} m"
    )


def largest_m(scene: Scene, trajectory: Trajectory) -> Array:
    """Largest term of places about the centre of mass, (n,), m; loose bars go far."""
    assert trajectory.position_m is not None
    farthest: Array = np.abs(trajectory.position_m).max(axis=(1, 2))
    return scene.size_m + farthest


def origin_m(scene: Scene, engine: Declarations, trajectory: Trajectory) -> Array:
    """Distance of the centre of mass from the origin of the engine's coordinates, (n,), m.

    The engine may have computed gaps from ends of bars at this distance. For a frame on an orbit of its own it
    is a bound of the chain's departure by effects.
    """
    if engine.coordinates.absolute:
        distance: Array = np.linalg.norm(trajectory.com_m, axis=1)
        return distance
    relative = engine.coordinates is Coordinates.RELATIVE
    return np.full(len(trajectory.t_s), 0.0 if relative else departure(scene).distance_m + drift_bound_m(scene))


def gap_rounding(scene: Scene, trajectory: Trajectory, place_m: Array) -> Array:
    """Round-off of a gap, (n, N-1), m: of the places, and of the angles, which may count many turns."""
    if trajectory.angle_rad is None:
        return np.zeros((len(trajectory.t_s), scene.bars - 1))
    moved = ROUNDING * np.abs(trajectory.angle_rad)
    left, right = np.array(scene.chain.left_m), np.array(scene.chain.right_m)
    both: Array = place_m[:, None] + (left[1:] * moved[:, 1:] + right[:-1] * moved[:, :-1])
    return both
