"""The chain as Exudyn's ObjectKinematicTree: minimal coordinates, no multipliers, reactions from momentum.

Coordinates as in :mod:`adapters.common.joint_coordinates`, in the frame's axes. The reaction is the remainder of each
bar's balance of momentum: R_j = R_{j-1} + m_j a_j - F_j, with Exudyn's own acceleration at the end of a step and the
applied load. No system is solved again.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.joint_coordinates import accelerations, angles, positions, to_joint_coordinates, velocities
from adapters.exudyn.frames.axes import OrbitFrame
from adapters.exudyn.frames.clock import INSIDE_DEGREE, orbit_inputs
from adapters.exudyn.frames.numbers import BarMotion, OrbitNumbers
from adapters.exudyn.library import exu, items
from adapters.exudyn.loads.springs import add_springs
from adapters.exudyn.models.model import Model
from adapters.exudyn.readout import SensorReadings

if TYPE_CHECKING:
    from adapters.trajectory import Array


class TreeModel(Model):
    """Two massless slides and a revolute joint for each bar."""

    inside_degree = INSIDE_DEGREE

    def add_chain(self) -> None:
        """Add the tree, the loads on its links and the sensors."""
        n, chain = self.scene.bars, self.scene.chain
        q, q_t = to_joint_coordinates(np.array(chain.length_m), self.start)
        self.node = self.mbs.AddNode(
            items().NodeGenericODE2(
                referenceCoordinates=[0.0] * (n + 2),
                initialCoordinates=q.tolist(),
                initialCoordinates_t=q_t.tolist(),
                numberOfODE2Coordinates=n + 2,
            )
        )
        joint = exu().JointType
        zero = np.zeros((3, 3))
        offsets = [[0.0, 0.0, 0.0]] * 3 + [[length, 0.0, 0.0] for length in chain.length_m[:-1]]
        tree = self.mbs.AddObject(
            items().ObjectKinematicTree(
                nodeNumber=self.node,
                jointTypes=[joint.PrismaticX, joint.PrismaticY] + [joint.RevoluteZ] * n,
                linkParents=list(range(-1, n + 1)),
                jointTransformations=exu().Matrix3DList([np.eye(3)] * (n + 2)),
                jointOffsets=exu().Vector3DList(offsets),
                linkInertiasCOM=exu().Matrix3DList([zero, zero] + [np.diag([j, j, j]) for j in chain.inertia_kg_m2]),
                linkCOMs=exu().Vector3DList([[0.0] * 3] * 2 + [[0.5 * length, 0.0, 0.0] for length in chain.length_m]),
                linkMasses=[0.0, 0.0, *chain.mass_kg],
            )
        )
        ground = self.add_ground()
        for j, length in enumerate(chain.length_m):
            marker = items().MarkerKinematicTreeRigid(
                objectNumber=tree, linkNumber=j + 2, localPosition=[0.5 * length, 0.0, 0.0]
            )
            self.add_load(j, ground, self.mbs.AddMarker(marker))
        self._add_springs()
        output = exu().OutputVariableType
        kinds = (output.Coordinates, output.Coordinates_t, output.Coordinates_tt)
        self.sensors = [self.sense_node(self.node, what) for what in kinds]

    def _add_springs(self) -> None:
        springs = self.scene.effects.joint_spring_damper
        if springs is None:
            return
        still = self.mbs.AddNode(items().NodePointGround())
        rest = self.mbs.AddMarker(items().MarkerNodeCoordinate(nodeNumber=still, coordinate=0))
        joints = [
            items().MarkerNodeCoordinate(nodeNumber=self.node, coordinate=3 + j) for j in range(self.scene.bars - 1)
        ]
        add_springs(self.mbs, springs, [(rest, self.mbs.AddMarker(joint)) for joint in joints])


class FrozenOrbitTreeModel(TreeModel):
    """Model for a very short run with a constant orbit: a polynomial through equal numbers would fit their rounding."""

    inside_degree = 0


def tree_readings(model: TreeModel, q: Array, q_t: Array, q_tt: Array) -> tuple[SensorReadings, Array]:
    """Readings of a tree's sensors, and the remaining reaction at the free end, (n,) N: round-off."""
    chain = model.scene.chain
    length = np.array(chain.length_m)
    readings = SensorReadings(
        positions(length, q),
        velocities(length, q, q_t),
        angles(q),
        angles(q_t),
        np.empty((len(q), 0, 2)),
        np.empty((len(q), 0)),
    )
    lacking = np.array(chain.mass_kg)[:, None] * accelerations(length, q, q_t, q_tt) - forces(model, readings)
    reaction = np.cumsum(lacking, axis=1)
    return dataclasses.replace(readings, reaction_N=reaction[:, :-1]), np.linalg.norm(reaction[:, -1], axis=-1)


def forces(model: TreeModel, readings: SensorReadings) -> Array:
    """Forces on the bars at the samples, (n, N, 2), by Exudyn's expressions."""
    loading, frame, t = model.loading, model.frame, model.scene.times_s[: len(readings.angle_rad)]
    orbit = OrbitNumbers(*orbit_inputs(frame.orbit)(t, t).T) if isinstance(frame, OrbitFrame) else None
    # at an event, the values just before it
    half_s = 0.5 * model.steps.size_s
    inputs = list(loading.time_inputs(t, np.maximum(t - half_s, half_s)).T) if loading.time_input_count else []
    found = np.zeros_like(readings.position_m)
    for j in filter(loading.acts_on, range(model.scene.bars)):
        fx, fy, _ = loading.on(j, motion_of(readings, j), orbit, inputs, np)
        found[:, j, 0], found[:, j, 1] = fx, fy
    return found


def motion_of(readings: SensorReadings, bar: int) -> BarMotion:
    """Motion of one bar at the samples."""
    (x, y), (vx, vy), angle = readings.position_m[:, bar].T, readings.velocity_m_s[:, bar].T, readings.angle_rad[:, bar]
    return BarMotion(x, y, vx, vy, np.cos(angle), np.sin(angle), readings.rate_rad_s[:, bar])
