"""The chain as an Exudyn system with its loads and sensors: rigid bodies and joints, or a kinematic tree.

The tree has minimal coordinates, as in :mod:`adapters.common.joint_coordinates`, in the frame's axes, and no
multipliers. The reaction is the remainder of each bar's balance of momentum: R_j = R_{j-1} + m_j a_j - F_j, with
Exudyn's own acceleration at the end of a step and the applied load. No system is solved again.
"""

from __future__ import annotations

import dataclasses
import itertools
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import InitialState, initial_state
from adapters.common.joint_coordinates import accelerations, from_joint_coordinates, to_joint_coordinates
from adapters.exudyn.frames import BarMotion, frame_of
from adapters.exudyn.library import exu, items, symbolic_function
from adapters.exudyn.loads import Loading
from adapters.exudyn.prescribed import PrescribedAngle, constrain, frame_history
from adapters.exudyn.readout import SensorReadings
from adapters.exudyn.time_inputs import Timetable

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.exudyn.frames import FrameAxes
    from adapters.exudyn.time_inputs import Steps
    from adapters.trajectory import Array
    from scenarios import Scene

INSIDE_DEGREE = 7  # (h n/4)^8/8! of a number's own size: below 1e-13 at 50 steps per orbit, round-off at 400


def initial_coordinates(scene: Scene, axes: FrameAxes, *, absolute: bool) -> InitialState:
    """Initial state of `scene` relative to the origin of `axes`, one instant of a frame, and in these axes."""
    s, zero = initial_state(scene), np.zeros(2)
    position, motion = s.position_m, s.velocity_m_s
    if absolute:
        position, motion = position + s.com_m, motion + s.com_velocity_m_s
    (readings,), (velocity,) = axes.relative(position[None], motion[None])
    angle, rate = s.angle_rad - axes.turn_rad[0], s.rate_rad_s - axes.rate_rad_s[0]
    return InitialState(zero, zero, angle, rate, readings, velocity)


class Model(ABC):
    """An assembled system with its sensors; it holds references to all objects that Exudyn uses."""

    inside_degree: int
    """Degree of the time inputs within a step: 0 where loads are evaluated at its end only"""

    def __init__(self, scene: Scene, steps: Steps, *, absolute: bool, load_copies: int = 1) -> None:
        """Assemble the system; `load_copies` connectors share each bar's load."""
        self.scene, self.steps, self.absolute, self.load_copies = scene, steps, absolute, load_copies
        self.frame = frame_of(scene, absolute=absolute)
        self.start = initial_coordinates(scene, self.frame.at(np.zeros(1)), absolute=absolute)
        self.loading = Loading(scene, self.frame)
        self.symbolic = exu().symbolic
        self.system = exu().SystemContainer()
        self.mbs: Any = self.system.AddSystem()
        self.references: list[Any] = []
        self.sensors_added: list[Any] = []
        self.stored: dict[int, list[Array]] = {}
        self.timetable: Timetable | None = None
        if count := self.loading.time_input_count:
            self.timetable = Timetable(self.loading.time_inputs, count, steps, degree=self.inside_degree)
            self.timetable.start(self.symbolic)
            self.mbs.SetPreStepUserFunction(self._tick)
        self.add_chain()
        self.mbs.Assemble()

    @abstractmethod
    def add_chain(self) -> None:
        """Add bars, joints, loads and sensors."""

    def history(self, sensor: Any) -> Array:
        """Stored samples of a sensor, (n, 1 + width), time first."""
        segments = self.stored.get(sensor.GetIndex())
        return np.concatenate(segments) if segments else self._stored_now(sensor)

    def store_segment(self, samples: Callable[[int], Array]) -> None:
        """Store the sensors' readings, which the next run of the solver clears.

        Parameters
        ----------
        samples : callable
            From the number of stored rows to a mask of those that are samples, (rows,).
        """
        for sensor in self.sensors_added:
            rows = self._stored_now(sensor)
            self.stored.setdefault(sensor.GetIndex(), []).append(rows[samples(len(rows))])

    def add_sensor(self, sensor: Any) -> Any:
        """Add a sensor that stores its samples in memory."""
        index = self.mbs.AddSensor(sensor)
        self.sensors_added.append(index)
        return index

    def _stored_now(self, sensor: Any) -> Array:
        rows: Array = np.atleast_2d(np.array(self.mbs.GetSensorStoredData(sensor)))
        return rows

    def close(self) -> None:
        """Free the system; its symbolic functions would leak otherwise."""
        self.mbs.Reset()

    def add_load(self, bar: int, ground: Any, marker: Any) -> None:
        """Apply all loads of a bar to the body of `marker`, between the body and the ground."""
        for _ in range(self.load_copies if self.loading.acts_on(bar) else 0):
            connector = "ObjectConnectorRigidBodySpringDamper"
            function = symbolic_function(self.mbs, self.load_function(bar), "springForceTorqueUserFunction", connector)
            self.references.append(function)
            self.mbs.AddObject(
                items().ObjectConnectorRigidBodySpringDamper(
                    markerNumbers=[ground, marker],
                    stiffness=np.zeros((6, 6)),
                    damping=np.zeros((6, 6)),
                    springForceTorqueUserFunction=function,
                )
            )

    def load_function(self, bar: int) -> Callable[..., list[Any]]:
        """User function of a bar's load; a connector's force acts in the opposite direction, hence the signs."""

        def pull(
            _mbs: Any,
            t: Any,
            _item: Any,
            displacement: Any,
            rotation: Any,
            velocity: Any,
            spin: Any,
            _stiffness: Any,
            _damping: Any,
            _axes0: Any,
            _axes1: Any,
            _offset: Any,
        ) -> list[Any]:
            c, s = self.symbolic.cos(rotation[2]), self.symbolic.sin(rotation[2])
            m = BarMotion(displacement[0], displacement[1], velocity[0], velocity[1], c, s, spin[2])
            inputs = self.timetable.symbols(t) if self.timetable else []
            fx, fy, torque = self.loading.on(bar, m, inputs, self.symbolic)
            zero, sign = 0.0 * displacement[0], -1.0 / self.load_copies
            return [sign * fx, sign * fy, zero, zero, zero, zero if torque is None else sign * torque]

        return pull

    def add_ground(self) -> Any:
        """Marker at the frame's origin."""
        ground = self.mbs.AddObject(items().ObjectGround())
        return self.mbs.AddMarker(items().MarkerBodyRigid(bodyNumber=ground))

    def sense_node(self, node: Any, what: Any) -> Any:
        """Add a sensor on a node; it stores its samples in memory."""
        return self.add_sensor(
            items().SensorNode(nodeNumber=node, outputVariableType=what, storeInternal=True, writeToFile=False)
        )

    def add_springs(self, markers: list[tuple[Any, Any]]) -> None:
        """Connect pairs of coordinates, one pair for each joint: torque -k (difference - rest) - c rate on the second.

        The coordinates are not reduced to one revolution, so that springs wind up.

        Parameters
        ----------
        markers : list of (MarkerIndex, MarkerIndex)
            Angle before each joint and the angle behind it.
        """
        springs = self.scene.effects.joint_spring_damper
        assert springs is not None
        columns = zip(springs.stiffness_N_m_rad, springs.damping_N_m_s_rad, springs.rest_rad, markers, strict=True)
        for stiffness, damping, rest, pair in columns:
            self.mbs.AddObject(
                items().ObjectConnectorCoordinateSpringDamper(
                    markerNumbers=list(pair), stiffness=stiffness, damping=damping, offset=rest
                )
            )

    def _tick(self, _mbs: object, t_s: float) -> bool:
        """Exudyn's preStepUserFunction, called before each step with the step's end."""
        assert self.timetable is not None
        for _ in range(self.load_copies):
            self.timetable.tick(t_s)
        return True


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
        right_m, left_m = self.scene.chain.right_m[j], self.scene.chain.left_m[j + 1]
        right = items().MarkerBodyPosition(bodyNumber=self.bodies[j], localPosition=[right_m, 0.0, 0.0])
        left = items().MarkerBodyPosition(bodyNumber=self.bodies[j + 1], localPosition=[-left_m, 0.0, 0.0])
        ends = [self.mbs.AddMarker(right), self.mbs.AddMarker(left)]
        return self.mbs.AddObject(items().ObjectJointRevolute2D(markerNumbers=ends))

    def _add_springs(self) -> None:
        if self.scene.effects.joint_spring_damper:
            turns = [self.mbs.AddMarker(items().MarkerNodeCoordinate(nodeNumber=n, coordinate=2)) for n in self.nodes]
            self.add_springs(list(itertools.pairwise(turns)))

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


class TreeModel(Model):
    """Two massless slides and a revolute joint for each bar."""

    inside_degree = INSIDE_DEGREE

    def add_chain(self) -> None:
        """Add the tree, the loads on its links and the sensors."""
        n, chain = self.scene.bars, self.scene.chain
        q, q_t = to_joint_coordinates(np.array(chain.length_m), self.start, np.array(chain.left_m))
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
                linkCOMs=exu().Vector3DList([[0.0] * 3] * 2 + [[left, 0.0, 0.0] for left in chain.left_m]),
                linkMasses=[0.0, 0.0, *chain.mass_kg],
            )
        )
        ground = self.add_ground()
        for j, left in enumerate(chain.left_m):
            marker = items().MarkerKinematicTreeRigid(
                objectNumber=tree, linkNumber=j + 2, localPosition=[left, 0.0, 0.0]
            )
            self.add_load(j, ground, self.mbs.AddMarker(marker))
        self._add_springs()
        output = exu().OutputVariableType
        kinds = (output.Coordinates, output.Coordinates_t, output.Coordinates_tt)
        self.sensors = [self.sense_node(self.node, what) for what in kinds]

    def _add_springs(self) -> None:
        if not self.scene.effects.joint_spring_damper:
            return
        still = self.mbs.AddNode(items().NodePointGround())
        rest = self.mbs.AddMarker(items().MarkerNodeCoordinate(nodeNumber=still, coordinate=0))
        joints = [
            items().MarkerNodeCoordinate(nodeNumber=self.node, coordinate=3 + j) for j in range(self.scene.bars - 1)
        ]
        self.add_springs([(rest, self.mbs.AddMarker(joint)) for joint in joints])


class FrozenOrbitTreeModel(TreeModel):
    """Model for a very short run with a constant orbit: a polynomial through equal numbers would fit their rounding."""

    inside_degree = 0


def tree_readings(model: TreeModel, q: Array, q_t: Array, q_tt: Array) -> tuple[SensorReadings, Array]:
    """Readings of a tree's sensors, and the remaining reaction at the free end, (n,) N: round-off."""
    chain = model.scene.chain
    length, left, none = np.array(chain.length_m), np.array(chain.left_m), np.empty((len(q), 0))
    bars = from_joint_coordinates(length, q, q_t, left)
    parts = bars.position_m, bars.velocity_m_s, bars.angle_rad, bars.rate_rad_s
    readings = SensorReadings(*parts, none[..., None], none)
    lacking = np.array(chain.mass_kg)[:, None] * accelerations(length, q, q_t, q_tt, left) - forces(model, readings)
    reaction = np.cumsum(lacking, axis=1)
    return dataclasses.replace(readings, reaction_N=reaction[:, :-1]), np.linalg.norm(reaction[:, -1], axis=-1)


def forces(model: TreeModel, readings: SensorReadings) -> Array:
    """Forces on the bars at the samples, (n, N, 2), by Exudyn's expressions."""
    loading, t = model.loading, model.scene.times_s[: len(readings.angle_rad)]
    # at an event, the values just before it
    half_s = 0.5 * model.steps.size_s
    inputs = list(loading.time_inputs(t, np.maximum(t - half_s, half_s)).T) if loading.time_input_count else []
    found = np.zeros_like(readings.position_m)
    for j in filter(loading.acts_on, range(model.scene.bars)):
        fx, fy, _ = loading.on(j, motion_of(readings, j), inputs, np)
        found[:, j, 0], found[:, j, 1] = fx, fy
    return found


def motion_of(readings: SensorReadings, bar: int) -> BarMotion:
    """Motion of one bar at the samples."""
    (x, y), (vx, vy), angle = readings.position_m[:, bar].T, readings.velocity_m_s[:, bar].T, readings.angle_rad[:, bar]
    return BarMotion(x, y, vx, vy, np.cos(angle), np.sin(angle), readings.rate_rad_s[:, bar])
