"""Pinocchio adapter: accelerations by `aba`, which SciPy's DOP853 steps, and joint forces by `rnea`."""

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

FIRST = 3  # Pinocchio's number of bar 1's joint, after the universe and two slides


def model_of(bars: Sequence[BarProperties]) -> Any:
    """Pinocchio model: two massless slides, then a joint about z at each bar's left end."""
    import pinocchio as pin

    model, here = pin.Model(), pin.SE3.Identity()
    model.gravity = pin.Motion.Zero()
    joint = model.addJoint(0, pin.JointModelPX(), here, "x")
    joint = model.addJoint(joint, pin.JointModelPY(), here, "y")
    position = here
    for j, (mass, inertia, half, left) in enumerate(bars):
        joint = model.addJoint(joint, pin.JointModelRZ(), position, f"bar{j + 1}")
        centre = np.array([left, 0.0, 0.0])
        model.appendBodyToJoint(joint, pin.Inertia(mass, centre, inertia * np.eye(3)), here)
        position = pin.SE3(np.eye(3), np.array([2.0 * half, 0.0, 0.0]))
    return model


class PinocchioChain(JointTree):
    """Accelerations and reactions of a state."""

    def __init__(self, scene: Scene, loads: Loads | None = None) -> None:
        """Make the model; `loads` of another frame put the joint coordinates into that frame."""
        import pinocchio as pin

        super().__init__(scene, loads)
        self.pin, self.model = pin, model_of(self.bars)
        self.data = self.model.createData()
        self.forces = pin.StdVec_Force()  # one for each joint: Pinocchio reads beyond the end of a shorter list
        for _ in range(self.model.njoints):
            self.forces.append(pin.Force.Zero())
        self.no_torques, self.row = np.zeros(self.width), np.zeros(6)

    def put(self, angle: Sequence[float], loads: Sequence[Load]) -> None:
        """Set forces in the bars' own axes at their left ends, Pinocchio's convention."""
        row, force = self.row, self.pin.Force
        for j, (a, bar, (ax, ay, spin)) in enumerate(zip(angle, self.bars, loads, strict=True)):
            c, s = cos(a), sin(a)
            across = bar.mass_kg * (c * ay - s * ax)
            row[0], row[1], row[5] = (
                bar.mass_kg * (c * ax + s * ay),
                across,
                bar.inertia_kg_m2 * spin + bar.left_m * across,
            )
            self.forces[FIRST + j] = force(row)

    def forward(self, q: Array, q_t: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,), by the articulated-body algorithm."""
        found: Array = self.pin.aba(self.model, self.data, q, q_t, self.no_torques, self.forces)
        return found

    def transmitted(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force of each bar on the next along and across the next, (N-1, 2), N, by inverse dynamics."""
        self.pin.rnea(self.model, self.data, q, q_t, q_tt, self.forces)
        return np.array([self.data.f[FIRST + j].linear[:2] for j in range(1, len(self.bars))]).reshape(-1, 2)


@final
class Pinocchio(JointTreeEngine):
    """Joint coordinates, articulated-body algorithm."""

    title = "Pinocchio, joint coordinates in a freely falling frame, ABA stepped by SciPy's DOP853"
    tree = PinocchioChain
    unsupported_reasons = reasons(
        "prescribed rotation is not supported: Pinocchio's forward dynamics takes torques and does not find the torque "
        "that holds a bar to its law"
    )
