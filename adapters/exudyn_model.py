"""The chain as an Exudyn system: the loads, the clock and the sensors that all models share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.exudyn_clock import Clock, Steps
from adapters.exudyn_frames import Axes, Frame, OrbitFrame, frame_of
from adapters.exudyn_library import exu, items, symbolic_function
from adapters.exudyn_loads import Bar, Load, Motion, absolute_load, orbit_load
from adapters.initial_state import initial_state
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Array
    from scenarios import Scene


@dataclass(frozen=True)
class Start:
    """Initial coordinates in the frame's axes."""

    position_m: Array
    """(N, 2)"""
    velocity_m_s: Array
    """(N, 2)"""
    angle_rad: Array
    """(N,)"""
    rate_rad_s: Array
    """(N,)"""


def start_of(scene: Scene, axes: Axes, *, absolute: bool) -> Start:
    """See the initial state of `scene` from `axes`, one instant of a frame."""
    s = initial_state(scene)
    place, motion = s.position_m, s.velocity_m_s
    if absolute:
        place, motion = place + s.com_m, motion + s.com_velocity_m_s
    seen, velocity = axes.relative(place[None], motion[None])
    return Start(seen[0], velocity[0], s.angle_rad - axes.turn_rad[0], s.rate_rad_s - axes.rate_rad_s[0])


class Model(ABC):
    """An assembled system with its sensors; keeps alive what Exudyn only refers to."""

    inside_degree: int
    """Degree of the orbit's numbers within a step: 0 where loads are evaluated at its end only."""

    def __init__(self, scene: Scene, steps: Steps, *, absolute: bool) -> None:
        self.scene, self.steps, self.absolute = scene, steps, absolute
        self.frame: Frame = frame_of(scene, absolute=absolute)
        self.start = start_of(scene, self.frame.at(np.zeros(1)), absolute=absolute)
        gradient = scene.effects.gravity is Gravity.GRADIENT
        chain = scene.chain
        self.bars = [Bar(m, j, gradient) for m, j in zip(chain.mass_kg, chain.inertia_kg_m2, strict=True)]
        self.symbolic = exu().symbolic
        self.system = exu().SystemContainer()
        self.mbs: Any = self.system.AddSystem()
        self.kept: list[Any] = []
        self.clock: Clock | None = None
        self._add_clock()
        self.add_chain()
        self.mbs.Assemble()

    @abstractmethod
    def add_chain(self) -> None:
        """Add bars, joints, loads and sensors."""

    def history(self, sensor: Any) -> Array:
        """Read what a sensor stored, (n, 1 + width), time first."""
        rows: Array = np.atleast_2d(np.array(self.mbs.GetSensorStoredData(sensor)))
        return rows

    def close(self) -> None:
        """Free the system: symbolic functions leak without it."""
        self.mbs.Reset()

    def load(self, bar: int, m: Motion, t_s: Any) -> Load:
        """Load on a bar, of symbolic numbers."""
        if self.absolute:
            return absolute_load(self.bars[bar], self.scene.central_body.mu_m3_s2, m, self.symbolic.sqrt)
        assert self.clock is not None
        return orbit_load(self.bars[bar], self.clock.numbers(t_s), m, self.symbolic.sqrt)

    def add_load(self, bar: int, ground: Any, marker: Any) -> None:
        """Let gravity and the frame's forces act on the body of `marker`, between it and the ground."""
        if self.scene.effects.gravity is Gravity.NONE:
            return
        connector = "ObjectConnectorRigidBodySpringDamper"
        function = symbolic_function(self.mbs, self.pull_on(bar), "springForceTorqueUserFunction", connector)
        self.kept.append(function)
        self.mbs.AddObject(
            items().ObjectConnectorRigidBodySpringDamper(
                markerNumbers=[ground, marker],
                stiffness=np.zeros((6, 6)),
                damping=np.zeros((6, 6)),
                springForceTorqueUserFunction=function,
            )
        )

    def pull_on(self, bar: int) -> Callable[..., list[Any]]:
        """Return the user function of a bar's load; a connector pulls back, hence the signs."""

        def pull(
            _mbs: Any,
            t: Any,
            _item: Any,
            displacement: Any,
            rotation: Any,
            velocity: Any,
            _spin: Any,
            _stiffness: Any,
            _damping: Any,
            _axes0: Any,
            _axes1: Any,
            _offset: Any,
        ) -> list[Any]:
            c, s = self.symbolic.cos(rotation[2]), self.symbolic.sin(rotation[2])
            m = Motion(displacement[0], displacement[1], velocity[0], velocity[1], c, s)
            fx, fy, torque = self.load(bar, m, t)
            zero = 0.0 * displacement[0]
            return [-fx, -fy, zero, zero, zero, -torque]

        return pull

    def add_ground(self) -> Any:
        """Marker at the frame's origin."""
        ground = self.mbs.AddObject(items().ObjectGround())
        return self.mbs.AddMarker(items().MarkerBodyRigid(bodyNumber=ground))

    def sense_node(self, node: Any, what: Any) -> Any:
        """Add a sensor on a node; it keeps its samples in memory."""
        return self.mbs.AddSensor(
            items().SensorNode(nodeNumber=node, outputVariableType=what, storeInternal=True, writeToFile=False)
        )

    def _add_clock(self) -> None:
        if not isinstance(self.frame, OrbitFrame):
            return
        self.clock = Clock(self.frame.orbit, self.steps, degree=self.inside_degree)
        self.clock.start(self.symbolic)
        if not self.clock.constant:
            self.mbs.SetPreStepUserFunction(self.clock.tick)
