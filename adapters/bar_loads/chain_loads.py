"""All loads on a chain, assembled from the effects of its scene: in plain floats, or as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from adapters.bar_loads.fields import FieldLoad, InversePowerField, SecondMomentLoad, SlenderLoad, oblateness_field
from adapters.bar_loads.forces import DragLoad, MotorLoad, SpringLoad, SunlightLoad, ThrustLoad
from adapters.bar_loads.gravity import AbsoluteLoads, MovingLoads
from adapters.bar_loads.interface import FaceDependentLoad, bars_of
from adapters.engine import GRAVITY_MODELS
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import BarLoad, BarPosition, BarProperties, BarRate, FrameState, Load
    from adapters.trajectory import Array
    from scenarios import Scene

SUPPORTED = frozenset({
    *GRAVITY_MODELS, "oblateness", "third_body", "drag", "solar_pressure", "joint_spring_damper", "joint_torque",
    "thrust.body", "thrust.inertial", "impulse",
})  # fmt: skip
"""Names of the effects that these loads support"""


class ChainLoads:
    """Gravity of the central body, and every other effect of a scene."""

    def __init__(self, scene: Scene, gravity: Loads, *, falling: bool) -> None:
        """Prepare the loads of `scene`.

        Parameters
        ----------
        scene : Scene
        gravity : Loads
            In the frame of the coordinates.
        falling : bool
            Whether the frame falls with all fields; otherwise it is at rest at the centre of the body.
        """
        self.gravity = None if scene.effects.gravity is Gravity.NONE else gravity
        self.bars = bars_of(scene.chain)
        self.effects = tuple(effects_of(scene, self.bars, falling=falling))
        self.of_rates = any(effect.of_rates for effect in self.effects)
        self.faced = [effect for effect in self.effects if isinstance(effect, FaceDependentLoad)]

    @property
    def pull_alone(self) -> Loads | None:
        """Gravity where it is the only load: to call it bar by bar saves a third of a short chain's time."""
        return None if self.effects else self.gravity

    @property
    def act(self) -> bool:
        """Whether there is any load."""
        return self.gravity is not None or bool(self.effects)

    def __call__(
        self, frame: FrameState, positions: Sequence[BarPosition], rates: Sequence[BarRate] = ()
    ) -> list[Load]:
        """Load of each bar; `rates` may be omitted unless `of_rates`.

        Raises
        ------
        LandedError
            If a bar touches the surface.
        """
        parts = [effect(frame, positions, rates) for effect in self.effects]
        if self.gravity:
            self.gravity.move_to(frame.x, frame.y)
            load = self.gravity.load
            parts.append([load(x, y, a, bar) for (x, y, a), bar in zip(positions, self.bars, strict=True)])
        if not parts:
            return [(0.0, 0.0, 0.0)] * len(self.bars)
        if len(parts) == 1:
            return parts[0]
        return [
            (sum(ax for ax, _, _ in loads), sum(ay for _, ay, _ in loads), sum(spin for _, _, spin in loads))
            for loads in zip(*parts, strict=True)
        ]


def effects_of(scene: Scene, bars: list[BarProperties], *, falling: bool) -> Iterator[BarLoad]:
    """Effects besides the central body's pull on points and its gradient."""
    called, mu = scene.effects, scene.central_body.mu_m3_s2
    turns, spread = called.gravity.turns, called.gravity in (Gravity.QUADRUPOLE, Gravity.SLENDER)
    if called.gravity is Gravity.SLENDER:
        yield SlenderLoad(bars, mu)
    if called.gravity is Gravity.QUADRUPOLE:
        yield SecondMomentLoad(bars, InversePowerField(mu, 3))
    if called.oblateness:
        yield FieldLoad(bars, oblateness_field(mu, called.oblateness), turns, spread, whole=not falling)
    for body in called.third_body:
        yield FieldLoad(bars, InversePowerField(body.mu_m3_s2, 3), turns, spread, body)
    if called.drag:
        yield DragLoad(bars, called.drag, scene.central_body.radius_m)
    if called.solar_pressure:
        yield SunlightLoad(bars, called.solar_pressure)
    if called.joint_spring_damper:
        yield SpringLoad(bars, called.joint_spring_damper)
    if called.joint_torque:
        yield MotorLoad(bars, called.joint_torque)
    if called.thrust:
        yield ThrustLoad(bars, called.thrust)


class ChainForces:
    """Force and torque of gravity and all other effects on each bar.

    In a frame that falls with the chain, gravity is the field at a bar less the field at the frame's origin. It is
    computed as a difference from the beginning (Encke's form), so that no digits cancel. Prescribed rotations and
    impulses are no forces, and solar pressure is without shadow.
    """

    def __init__(self, scene: Scene, *, falling: bool = True, surface: bool = True) -> None:
        """Prepare the effects of a scene, for a frame that falls freely or one at rest.

        Parameters
        ----------
        scene : Scene
        falling : bool
            Whether the frame falls freely; False for a frame at rest at the centre of the body.
        surface : bool
            Whether bars at the surface raise. False for trial states of a solver, which may lie below it.
        """
        gravity = MovingLoads(scene, surface=surface) if falling else AbsoluteLoads(scene, surface=surface)
        self.loads = ChainLoads(scene, gravity, falling=falling)
        self.mass_kg, self.inertia_kg_m2 = np.array(scene.chain.mass_kg), np.array(scene.chain.inertia_kg_m2)

    def __call__(
        self, frame: FrameState, position_m: Array, angle_rad: Array, velocity_m_s: Array, rate_rad_s: Array
    ) -> tuple[Array, Array]:
        """Force (N, 2), N, and torque (N,), N m, on each bar, from its place and velocity in the frame.

        Parameters
        ----------
        frame : FrameState
            Origin, velocity and instant of the frame; zeros but for the instant in a frame at rest.
        position_m, velocity_m_s : ndarray, shape (N, 2)
            Bars' centres in the frame, in axes of fixed direction.
        angle_rad, rate_rad_s : ndarray, shape (N,)
            Absolute angles, and their rates.

        Returns
        -------
        force_N : ndarray, shape (N, 2)
            At the bars' centres.
        torque_N_m : ndarray, shape (N,)
            About the bars' centres.

        Raises
        ------
        LandedError
            If a bar touches the surface.
        """
        bars = np.column_stack([position_m, angle_rad]).tolist()
        rates = np.column_stack([velocity_m_s, rate_rad_s]).tolist() if self.loads.of_rates else []
        load = np.array(self.loads(frame, bars, rates))
        return self.mass_kg[:, None] * load[:, :2], self.inertia_kg_m2 * load[:, 2]
