"""Scales of the compared quantities in a scene, which relative errors are relative to."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene


def scales(solution: ReferenceSolution) -> dict[str, float]:
    """Size of each quantity over the whole run, from the judging solution and the scene alone; SI units.

    ``attitude`` counts in radians, ``rate`` in the fastest rate of a bar. ``reaction`` counts in the largest one, but
    in no less than the inertia force of the bars: where forces cancel, their sum says nothing of what they are made of.
    """
    scene, seen = solution.scene, solution.trajectory
    force = inertia_force_N(scene)
    found = {
        "com": largest(seen.com_m),
        "com_velocity": largest(seen.com_velocity_m_s),
        "attitude": 1.0,
        "rate": max(largest_entry(seen.rate_rad_s), scene.fastest_rate_rad_s),
        "reaction": max(largest(seen.reaction_N), force),
        "torque": max(largest_entry(seen.torque_N_m), force * max(scene.chain.length_m)),
        "impulse": max(largest(seen.impulse_N_s), force / scene.fastest_rate_rad_s),
        "gap": min(scene.chain.length_m),
        "com_residual": min(scene.chain.length_m),
    }
    return found | dict.fromkeys(("energy", "angular_momentum", "energy_about_com", "angular_momentum_about_com"), 1.0)


def inertia_force_N(scene: Scene) -> float:
    """Force that turns the heaviest bar about its end at the orbit's rate, or at the bars' own, N: m l w²."""
    chain = scene.chain
    return max(m * size for m, size in zip(chain.mass_kg, chain.length_m, strict=True)) * scene.fastest_rate_rad_s**2


def largest(vectors: Array | None) -> float:
    """Largest length of vectors (..., 2); 0 of none."""
    return 0.0 if vectors is None else float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))


def largest_entry(values: Array | None) -> float:
    """Largest absolute value; 0 of none."""
    return 0.0 if values is None else float(np.abs(values).max(initial=0.0))
