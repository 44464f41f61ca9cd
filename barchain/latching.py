"""Latches: joints that catch at once, in a state from which another run goes on."""

from __future__ import annotations

from collections.abc import Collection
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.reference_model import chain_model
from reference_impl.model.invariants import relative_motion
from scenarios import Actuator, Frame, SceneError
from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array
    from scenarios import Scene


def latched(scene: Scene, state: Mapping[str, Any], joints: Collection[int]) -> dict[str, Any]:
    """State just after joints have caught: their bars then turn at one rate.

    An impact without rebound. Each joint that catches passes a pair of opposite torque impulses p, and the rates become
    w + M^-1 D^T p, with M the chain's matrix of inertia about its centre of mass and D the bars that each pair turns;
    p follows from C (w + M^-1 D^T p) = r. Laws of the scene go on during the impact by impulses of their own. Forces of
    finite size do nothing in no time. Positions, angles, the momentum and, unless a law acts from outside, the angular
    momentum stay.

    Parameters
    ----------
    scene : Scene
        Scene of the run, with the joints free.
    state : mapping
        Of `Trajectory.state`.
    joints : collection of int
        Joints that catch, from 1.

    Returns
    -------
    dict
        For :func:`barchain.go_on`, with laws that hold the joints: ``amplitude_deg = 0``, ``frame = "previous_bar"``.

    Raises
    ------
    SceneError
        If no list of joints is given, a joint is none of the scene, a law turns it or one of the other joints past what
        the bars can do, or a law follows the local horizontal.
    """
    if not isinstance(joints, Collection) or not all(isinstance(joint, Integral) for joint in joints):
        raise SceneError(f"{shorten(joints)} given, allowed: a list of joints, e.g. [1, 2]")
    wrong = sorted(joint for joint in joints if not 1 <= joint < scene.bars)
    if wrong:
        raise SceneError(f"joint {wrong[0]} given, allowed: 1 to {scene.bars - 1}")
    laws = scene.effects.prescribed_rotation
    if any(law.frame is Frame.LOCAL_HORIZONTAL for law in laws):
        raise SceneError("a law follows the local horizontal, allowed: frames inertial and previous_bar in an impact")
    angle_rad, rate_rad_s = (np.array(state["chain"][name]) for name in ("angle_rad", "rate_rad_s"))
    bar = np.eye(scene.bars)
    held = [bar[joint] - bar[joint - 1] for joint in joints]
    kept, turned = [], []
    for law in laws:
        k = law.bar - 1
        neighbour = k - 1 if k else 1
        kept.append(bar[k] - bar[k - 1] if law.frame is Frame.PREVIOUS_BAR else bar[k])
        turned.append(bar[k] if law.actuator is Actuator.EXTERNAL else bar[k] - bar[neighbour])
    conditions, pairs = np.array([*held, *kept]), np.array([*held, *turned])
    wanted = np.concatenate([np.zeros(len(held)), np.array(kept).reshape(-1, scene.bars) @ rate_rad_s])
    by_torque = np.linalg.solve(inertia_matrix(scene, angle_rad), pairs.T)
    answer = conditions @ by_torque
    if np.linalg.matrix_rank(answer) < len(answer):
        raise SceneError(
            f"joints {sorted(joints)} given, allowed: joints and laws that do not hold the same bars twice"
        )
    after = rate_rad_s + by_torque @ np.linalg.solve(answer, wanted - conditions @ rate_rad_s)
    return {**state, "chain": {**state["chain"], "rate_rad_s": after.tolist()}}


def inertia_matrix(scene: Scene, angle_rad: Array) -> Array:
    """Matrix of the kinetic energy about the centre of mass at angles (N,), shape (N, N), kg m²."""
    model = chain_model(scene)
    _, velocity = relative_motion(model, np.tile(angle_rad, (scene.bars, 1)), np.eye(scene.bars))
    weighted = velocity * model.mass_kg[:, None]
    moving: Array = np.einsum("ikd,jkd->ij", velocity, weighted)
    return np.diag(model.inertia_kg_m2) + moving
