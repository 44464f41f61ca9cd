"""DART adapter: a skeleton whose accelerations SciPy's DOP853 steps."""

from __future__ import annotations

from math import cos, sin
from typing import TYPE_CHECKING, Any, final

import numpy as np

from adapters.bar_loads.joint_tree import JointTree, JointTreeEngine, reasons

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import BarProperties, Load
    from adapters.trajectory import Array
    from scenarios import Scene


def skeleton_of(bars: Sequence[BarProperties]) -> tuple[Any, list[Any]]:
    """Skeleton and its bodies: a planar joint at bar 1's left end, then a joint about z at each bar's left end."""
    import dartpy as dart

    skeleton, right = dart.dynamics.Skeleton("chain"), dart.math.Isometry3()
    bodies: list[Any] = []
    skeleton.setGravity(np.zeros(3))
    for mass, inertia, half, left in bars:
        if bodies:
            joint, body = skeleton.createRevoluteJointAndBodyNodePair(bodies[-1])
            joint.setAxis([0.0, 0.0, 1.0])
            joint.setTransformFromParentBodyNode(right)
        else:
            _, body = skeleton.createPlanarJointAndBodyNodePair()
        # the same inertia about all axes: DART warns of a thin rod's 0, and plane motion depends on one only
        body.setInertia(dart.dynamics.Inertia(mass, np.array([left, 0.0, 0.0]), inertia * np.eye(3)))
        right.set_translation([2.0 * half, 0.0, 0.0])
        bodies.append(body)
    return skeleton, bodies


class DartChain(JointTree):
    """Accelerations by forward dynamics, and joint forces from the bodies."""

    def __init__(self, scene: Scene, loads: Loads | None = None) -> None:
        """Make the skeleton; `loads` of another frame put the joint coordinates into that frame."""
        super().__init__(scene, loads)
        self.skeleton, self.bodies = skeleton_of(self.bars)
        self.centres = [np.array([bar.left_m, 0.0, 0.0]) for bar in self.bars]
        self.force, self.torque = np.zeros(3), np.zeros(3)

    def put(self, angle: Sequence[float], loads: Sequence[Load]) -> None:
        """Add forces at the bars' centres in the bars' own axes, and torques.

        DART turns a force in world axes into the body's at once, by the pose that the body has before `forward` sets
        the new one. `setExtTorque` would overwrite the moment of the force.
        """
        self.skeleton.clearExternalForces()
        force, torque, columns = self.force, self.torque, (self.bodies, self.centres, angle, self.bars, loads)
        for body, centre, a, bar, (ax, ay, spin) in zip(*columns, strict=True):
            c, s = cos(a), sin(a)
            force[0], force[1] = bar.mass_kg * (c * ax + s * ay), bar.mass_kg * (c * ay - s * ax)
            torque[2] = bar.inertia_kg_m2 * spin
            body.addExtForce(force, centre, True, True)
            body.addExtTorque(torque, True)

    def forward(self, q: Array, q_t: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,), by DART's articulated-body algorithm."""
        self.skeleton.setPositions(q)
        self.skeleton.setVelocities(q_t)
        self.skeleton.computeForwardDynamics()
        found: Array = self.skeleton.getAccelerations()
        return found

    def transmitted(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force of each bar on the next along and across the next, (N-1, 2), N."""
        del q, q_t, q_tt  # the skeleton holds the state
        return np.array([body.getBodyForce()[3:5] for body in self.bodies[1:]]).reshape(-1, 2)


@final
class Dart(JointTreeEngine):
    """Joint coordinates, DART's skeleton."""

    title = "DART, joint coordinates in a freely falling frame, ABA stepped by SciPy's DOP853"
    tree = DartChain
    unsupported_reasons = reasons(
        "prescribed rotation is not supported: the adapter takes accelerations from DART, and does not find the torque "
        "that holds a bar or a joint to its law"
    )
