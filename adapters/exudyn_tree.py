"""The chain as Exudyn's ObjectKinematicTree: minimal coordinates, no multipliers, reactions recovered.

Coordinates as in :mod:`adapters.joint_coordinates`, in the frame's axes.
The reaction is what each bar's momentum lacks: R_j = R_{j-1} + m_j a_j - F_j, with the acceleration that
Exudyn itself gives at the end of a step and the load that it was given. Nothing is solved again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.exudyn_clock import INSIDE_DEGREE
from adapters.exudyn_library import exu, items
from adapters.exudyn_loads import Bar, Motion, OrbitNumbers, orbit_load
from adapters.exudyn_model import Model
from adapters.exudyn_readout import Seen
from adapters.joint_coordinates import accelerations, angles, folded, places, velocities

if TYPE_CHECKING:
    from adapters.engine import Array
    from adapters.exudyn_orbit import KeplerOrbit
    from scenarios import Scene


class TreeModel(Model):
    """Two massless slides and a revolute joint for each bar."""

    inside_degree = INSIDE_DEGREE

    def add_chain(self) -> None:
        """Add the tree, the loads on its links and the sensors."""
        n, chain = self.scene.bars, self.scene.chain
        q, q_t = folded(np.array(chain.length_m), self.start)
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
        output = exu().OutputVariableType
        kinds = (output.Coordinates, output.Coordinates_t, output.Coordinates_tt)
        self.sensors = [self.sense_node(self.node, what) for what in kinds]


class StandingTreeModel(TreeModel):
    """For a run so brief that the orbit stands still: a polynomial through equal numbers would fit their rounding."""

    inside_degree = 0


def seen_tree(scene: Scene, orbit: KeplerOrbit | None, q: Array, q_t: Array, q_tt: Array) -> tuple[Seen, Array]:
    """Return what a tree's sensors saw, and the reaction left at the free end, (n,) N: round-off."""
    length = np.array(scene.chain.length_m)
    place, motion = places(length, q), velocities(length, q, q_t)
    mass = np.array(scene.chain.mass_kg)[:, None]
    lacking = mass * accelerations(length, q, q_t, q_tt)
    if orbit is not None:
        lacking = lacking - loads(scene, orbit, place, motion)
    reaction = np.cumsum(lacking, axis=1)
    seen = Seen(place, motion, angles(q), angles(q_t), reaction[:, :-1], np.empty((len(q), 0)))
    return seen, np.linalg.norm(reaction[:, -1], axis=-1)


def loads(scene: Scene, orbit: KeplerOrbit, place_m: Array, velocity_m_s: Array) -> Array:
    """Return the forces on the bars at the samples, (n, N, 2), by the expressions that Exudyn evaluates."""
    track = orbit.at(scene.times_s)
    numbers = OrbitNumbers(track.radius_m, track.rate_rad_s, track.spin_up_rad_s2, track.pull_s2, track.shape)
    forces = np.empty_like(place_m)
    for j in range(scene.bars):
        (x, y), (vx, vy) = place_m[:, j].T, velocity_m_s[:, j].T
        m = Motion(x, y, vx, vy, 1.0, 0.0)
        forces[:, j, 0], forces[:, j, 1], _ = orbit_load(Bar(scene.chain.mass_kg[j]), numbers, m, np.sqrt)
    return forces
