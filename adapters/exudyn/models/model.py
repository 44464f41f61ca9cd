"""The chain as an Exudyn system: loads, clock and sensors of all models."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.exudyn.frames.axes import FrameAxes, OrbitFrame, ReferenceFrame, frame_of
from adapters.exudyn.frames.clock import Clock
from adapters.exudyn.frames.numbers import BarMotion
from adapters.exudyn.library import exu, items, symbolic_function
from adapters.exudyn.loads.total_load import Loading
from adapters.exudyn.timetable import Timetable

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.exudyn.loads.interface import BarForce
    from adapters.exudyn.timetable import Steps
    from adapters.trajectory import Array
    from scenarios import Scene


@dataclass(frozen=True)
class InitialCoordinates:
    """Initial coordinates in the frame's axes."""

    position_m: Array
    """(N, 2)"""
    velocity_m_s: Array
    """(N, 2)"""
    angle_rad: Array
    """(N,)"""
    rate_rad_s: Array
    """(N,)"""


def initial_coordinates(scene: Scene, axes: FrameAxes, *, absolute: bool) -> InitialCoordinates:
    """Initial state of `scene` in `axes`, one instant of a frame."""
    s = initial_state(scene)
    position, motion = s.position_m, s.velocity_m_s
    if absolute:
        position, motion = position + s.com_m, motion + s.com_velocity_m_s
    readings, velocity = axes.relative(position[None], motion[None])
    return InitialCoordinates(
        readings[0], velocity[0], s.angle_rad - axes.turn_rad[0], s.rate_rad_s - axes.rate_rad_s[0]
    )


class Model(ABC):
    """An assembled system with its sensors; it holds references to all objects that Exudyn uses."""

    inside_degree: int
    """Degree of the orbital quantities within a step: 0 where loads are evaluated at its end only."""

    def __init__(self, scene: Scene, steps: Steps, *, absolute: bool, load_copies: int = 1) -> None:
        """Assemble the system; `load_copies` connectors share each bar's load."""
        self.scene, self.steps, self.absolute, self.load_copies = scene, steps, absolute, load_copies
        self.frame: ReferenceFrame = frame_of(scene, absolute=absolute)
        self.start = initial_coordinates(scene, self.frame.at(np.zeros(1)), absolute=absolute)
        self.loading = Loading(scene, self.frame)
        self.symbolic = exu().symbolic
        self.system = exu().SystemContainer()
        self.mbs: Any = self.system.AddSystem()
        self.references: list[Any] = []
        self.sensors_added: list[Any] = []
        self.stored: dict[int, list[Array]] = {}
        self.clock: Clock | None = None
        self.tables: list[Timetable] = []
        self.timetable: Timetable | None = None
        self._add_clock()
        self._add_timetable()
        self._start_tables()
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

    def load(self, bar: int, m: BarMotion, t_s: Any) -> BarForce:
        """Symbolic load on a bar."""
        orbit = None if self.clock is None else self.clock.numbers(t_s)
        inputs = [] if self.timetable is None else self.timetable.symbols(t_s)
        return self.loading.on(bar, m, orbit, inputs, self.symbolic)

    def add_load(self, bar: int, ground: Any, marker: Any) -> None:
        """Apply all loads of a bar to the body of `marker`, between the body and the ground."""
        for _ in range(self.load_copies if self.loading.acts_on(bar) else 0):
            self._add_connector(bar, ground, marker)

    def _add_connector(self, bar: int, ground: Any, marker: Any) -> None:
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
            fx, fy, torque = self.load(bar, m, t)
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

    def _add_clock(self) -> None:
        if not isinstance(self.frame, OrbitFrame):
            return
        self.clock = Clock(self.frame.orbit, self.steps, degree=self.inside_degree)
        if self.clock.table is not None:
            self.tables.append(self.clock.table)

    def _add_timetable(self) -> None:
        count = self.loading.time_input_count
        if count:
            self.timetable = Timetable(self.loading.time_inputs, count, self.steps, degree=self.inside_degree)
            self.tables.append(self.timetable)

    def _start_tables(self) -> None:
        for table in self.tables:
            table.start(self.symbolic)
        if self.tables:
            self.mbs.SetPreStepUserFunction(self._tick)

    def _tick(self, _mbs: object, t_s: float) -> bool:
        """Exudyn's preStepUserFunction, called before each step with the step's end."""
        for _ in range(self.load_copies):
            for table in self.tables:
                table.tick(t_s)
        return True
