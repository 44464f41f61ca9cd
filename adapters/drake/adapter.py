"""Drake adapter: a plant's accelerations and joint forces, stepped by Drake's RK5 with error control.

The loads are applied spatial forces: generalized forces would leave the loads out of the joint forces.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, final

import numpy as np

from adapters.bar_loads.joint_tree import JointTree, JointTreeEngine, reasons
from adapters.drake.integrator import DrakeIntegrator

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import BarProperties, Load
    from adapters.common.solver_driver import Solver
    from adapters.trajectory import Array
    from scenarios import Scene


def plant_of(bars: Sequence[BarProperties]) -> Any:
    """Continuous plant: a planar joint at bar 1's left end, then a joint about z at each bar's left end."""
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import FixedOffsetFrame, PlanarJoint, RevoluteJoint, RotationalInertia, SpatialInertia

    plant, before = MultibodyPlant(time_step=0.0), None
    for j, (mass, J, half, left) in enumerate(bars):
        # the same inertia about all three axes: plane motion depends on the one about z alone
        inertia = SpatialInertia.MakeFromCentralInertia(mass, [left, 0.0, 0.0], RotationalInertia(J, J, J))
        frame = plant.AddRigidBody(f"bar{j + 1}", inertia).body_frame()
        if before is None:
            joint: Any = PlanarJoint("end", plant.world_frame(), frame, [0.0, 0.0, 0.0])
        else:
            joint = RevoluteJoint(f"joint{j}", plant.AddFrame(before), frame, [0.0, 0.0, 1.0])
        plant.AddJoint(joint)
        before = FixedOffsetFrame(f"right{j + 1}", frame, RigidTransform([2.0 * half, 0.0, 0.0]))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    return plant


class DrakeChain(JointTree):
    """Accelerations and reactions of a state."""

    def __init__(self, scene: Scene, loads: Loads | None = None) -> None:
        """Make the plant; `loads` of another frame put the joint coordinates into that frame."""
        from pydrake.multibody.math import SpatialForce
        from pydrake.multibody.plant import ExternallyAppliedSpatialForce

        super().__init__(scene, loads)
        self.plant, self.spatial_force = plant_of(self.bars), SpatialForce
        self.context = self.plant.CreateDefaultContext()
        self.applied = [ExternallyAppliedSpatialForce() for _ in self.bars]
        for j, (force, bar) in enumerate(zip(self.applied, self.bars, strict=True)):
            force.body_index = self.plant.GetBodyByName(f"bar{j + 1}").index()
            force.p_BoBq_B = [bar.left_m, 0.0, 0.0]
        self.forces_port = self.plant.get_applied_spatial_force_input_port()
        self.accelerations_port = self.plant.get_generalized_acceleration_output_port()
        self.joint_forces_port = self.plant.get_reaction_forces_output_port()
        self.row = np.zeros(6)
        self.put([0.0] * scene.bars, [(0.0, 0.0, 0.0)] * scene.bars)

    def put(self, angle: Sequence[float], loads: Sequence[Load]) -> None:
        """Set torques and forces along the frame's axes at the bars' centres."""
        del angle
        row, spatial_force = self.row, self.spatial_force
        for force, bar, (ax, ay, spin) in zip(self.applied, self.bars, loads, strict=True):
            row[2], row[3], row[4] = bar.inertia_kg_m2 * spin, bar.mass_kg * ax, bar.mass_kg * ay
            force.F_Bq_W = spatial_force(row)
        self.forces_port.FixValue(self.context, self.applied)

    def forward(self, q: Array, q_t: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,), by Drake's articulated-body algorithm."""
        state = np.concatenate([q, q_t])
        if not np.isfinite(state).all():  # Drake would raise SystemExit, and end the process
            return np.full(self.width, np.nan)
        self.plant.SetPositionsAndVelocities(self.context, state)
        found: Array = self.accelerations_port.Eval(self.context)
        return found

    def transmitted(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force of each bar on the next along and across the next, (N-1, 2), N."""
        del q, q_t, q_tt  # the context holds the state
        found = self.joint_forces_port.Eval(self.context)[1:]
        return np.array([force.translational()[:2] for force in found]).reshape(-1, 2)


@final
class Drake(JointTreeEngine):
    """Joint coordinates, Drake's plant and integrator."""

    title = "Drake, joint coordinates in a freely falling frame, Drake's RK5 with error control"
    tree = DrakeChain
    unsupported_reasons = reasons(
        "prescribed rotation is not supported: Drake locks a joint at rest only, and has no constraint that holds a "
        "bar to a law of time in a continuous plant"
    )

    def solver(self, rtol: float, units: Array) -> Solver:
        """Drake's fifth-order Runge-Kutta method."""
        return DrakeIntegrator("runge_kutta5", rtol, units)
