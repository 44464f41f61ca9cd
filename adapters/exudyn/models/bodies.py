"""The chain in redundant coordinates: rigid bodies, revolute joints, prescribed rotations."""

from __future__ import annotations

import itertools
from typing import Any

from adapters.exudyn.library import exu, items
from adapters.exudyn.loads.prescribed import PrescribedAngle, constrain, frame_history
from adapters.exudyn.loads.springs import add_springs
from adapters.exudyn.models.model import Model


class RedundantModel(Model):
    """Rigid bodies with three coordinates each, and joints with multipliers."""

    inside_degree = 0

    def add_chain(self) -> None:
        """Add bodies, joints, loads, prescribed rotations and sensors."""
        output = exu().OutputVariableType
        ground = self.add_ground()
        self.bodies: list[Any] = []
        self.nodes = [self._add_bar(j, ground) for j in range(self.scene.bars)]
        joints = [self._add_joint(j) for j in range(self.scene.bars - 1)]
        self._add_springs()
        self.coordinates = [self.sense_node(n, output.Coordinates) for n in self.nodes]
        self.rates = [self.sense_node(n, output.Coordinates_t) for n in self.nodes]
        self.reactions = [self._sense_object(j, output.Force) for j in joints]
        self.torques = [self._sense_object(c, output.Force) for c in self._add_prescribed()]

    def _add_bar(self, j: int, ground: Any) -> Any:
        s, chain = self.start, self.scene.chain
        node = self.mbs.AddNode(
            items().NodeRigidBody2D(
                initialCoordinates=[*s.position_m[j], s.angle_rad[j]],
                initialVelocities=[*s.velocity_m_s[j], s.rate_rad_s[j]],
            )
        )
        body = self.mbs.AddObject(
            items().ObjectRigidBody2D(mass=chain.mass_kg[j], inertia=chain.inertia_kg_m2[j], nodeNumber=node)
        )
        self.add_load(j, ground, self.mbs.AddMarker(items().MarkerBodyRigid(bodyNumber=body)))
        self.bodies.append(body)
        return node

    def _add_joint(self, j: int) -> Any:
        half = [0.5 * length for length in self.scene.chain.length_m]
        right = items().MarkerBodyPosition(bodyNumber=self.bodies[j], localPosition=[half[j], 0.0, 0.0])
        left = items().MarkerBodyPosition(bodyNumber=self.bodies[j + 1], localPosition=[-half[j + 1], 0.0, 0.0])
        ends = [self.mbs.AddMarker(right), self.mbs.AddMarker(left)]
        return self.mbs.AddObject(items().ObjectJointRevolute2D(markerNumbers=ends))

    def _add_springs(self) -> None:
        springs = self.scene.effects.joint_spring_damper
        if springs is not None:
            turns = [self.mbs.AddMarker(items().MarkerNodeCoordinate(nodeNumber=n, coordinate=2)) for n in self.nodes]
            add_springs(self.mbs, springs, list(itertools.pairwise(turns)))

    def _add_prescribed(self) -> list[Any]:
        laws = self.scene.effects.prescribed_rotation
        if not laws:
            return []
        track = frame_history(self.frame.at(self.steps.ends_s))
        s = self.start
        positions = [(float(x), float(y), float(a)) for (x, y), a in zip(s.position_m, s.angle_rad, strict=True)]
        angles = [PrescribedAngle(p, self.steps, track, positions, self.nodes) for p in laws]
        self.references.extend(angles)
        return [constrain(self.mbs, a) for a in angles]

    def _sense_object(self, thing: Any, what: Any) -> Any:
        return self.add_sensor(
            items().SensorObject(objectNumber=thing, outputVariableType=what, storeInternal=True, writeToFile=False)
        )
