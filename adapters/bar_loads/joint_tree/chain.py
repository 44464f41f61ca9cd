"""A chain as a library's tree of joints: its loads and its equations of motion in a freely falling frame.

The frame's origin is integrated with the chain and falls as a particle, so that the loads on bars are differences only.
State (4 + 2 (N + 2),): the origin and its velocity, the joint coordinates and their rates. Effects may depend on time
and on the side of an event, see `inside_s`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from adapters.bar_loads.assemble import chain_loads
from adapters.bar_loads.gravity import MovingLoads
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.bar_loads.particle import perturbing_fields
from adapters.bar_loads.tree import tree_positions, tree_rates
from adapters.common.joint_coordinates import angles, positions
from reference_impl.model.kinematics import directions
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import Load
    from adapters.trajectory import Array
    from scenarios import Impulse, Scene


class JointTree(ABC):
    """Accelerations and reactions of a state, by a library's model of the chain."""

    def __init__(self, scene: Scene, loads: Loads | None = None) -> None:
        """Prepare the loads; `loads` of another frame put the joint coordinates into that frame."""
        self.width = scene.bars + 2
        self.mu = 0.0 if scene.effects.gravity is Gravity.NONE else scene.central_body.mu_m3_s2
        self.loads = loads or MovingLoads(scene, surface=False)
        self.length_m, self.radius_m = np.array(scene.chain.length_m), scene.central_body.radius_m
        self.effect_loads = chain_loads(scene, self.loads, free_falling=True)
        self.beside = perturbing_fields(scene)
        self.bars = bars_of(scene.chain)
        self.inside_s = 0.0  # an instant within the current segment between events

    @abstractmethod
    def put(self, angle: Sequence[float], loads: Sequence[Load]) -> None:
        """Set the forces and torques on all bars at `angle` (N,) rad, for the calls that follow."""

    @abstractmethod
    def forward(self, q: Array, q_t: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,), at the forces last set."""

    @abstractmethod
    def transmitted(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force of each bar on the next along and across the next, (N-1, 2), N; called just after `forward`.

        `q` and `q_t` are the arguments of that call and `q_tt` its result.
        """

    def rate(self, t_s: float, state: Array) -> Array:
        """Time derivative of a state."""
        x, y, vx, vy = state[:4].tolist()
        r2 = x * x + y * y
        pull = -self.mu / (r2 * math.sqrt(r2))
        ax, ay = pull * x, pull * y
        for field in self.beside:
            dx, dy = field(t_s, x, y)
            ax, ay = ax + dx, ay + dy
        return np.concatenate([(vx, vy, ax, ay), state[4 + self.width :], self.accelerations(t_s, state)])

    def accelerations(self, t_s: float, state: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,)."""
        q, q_t = state[4 : 4 + self.width], state[4 + self.width :]
        if self.effect_loads or self.mu:
            self.act(t_s, state[:4].tolist(), q.tolist(), q_t.tolist())
        return self.forward(q, q_t)

    def act(self, t_s: float, origin: list[float], q: list[float], q_t: list[float]) -> None:
        """Apply all loads of the scene; `origin` is the frame's position and velocity (4,), m and m/s."""
        positions = list(tree_positions(q, self.bars))
        x, y, vx, vy = origin
        if self.effect_loads is None:
            self.loads.move_to(x, y)
            load = self.loads.load
            loads = [load(px, py, a, bar.half) for (px, py, a), bar in zip(positions, self.bars, strict=True)]
        else:
            rates = list(tree_rates(q, q_t, self.bars)) if self.effect_loads.of_rates else []
            loads = self.effect_loads(FrameState(x, y, vx, vy, t_s, self.inside_s), positions, rates)
        self.put([angle for *_, angle in positions], loads)

    def reactions(self, state: Array, t_s: float = 0.0) -> Array:
        """Force on each bar from the next, (N-1, 2), N, at the state's accelerations."""
        found = self.accelerations(t_s, state)
        return self.joint_forces(state[4 : 4 + self.width], state[4 + self.width :], found)

    def joint_forces(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force on each bar from the next, (N-1, 2), N, just after `forward`."""
        along, across = directions(angles(q[None])[0, 1:])
        force = self.transmitted(q, q_t, q_tt)
        found: Array = -(force[:, :1] * along + force[:, 1:] * across)
        return found

    def apply_impulses(self, state: Array, impulses: Sequence[Impulse]) -> tuple[Array, Array]:
        """State after impulses, and the impulsive reactions on each bar from the next, (N-1, 2), N s.

        With all rates zero, the same joint system gives jumps by impulses as accelerations by forces.
        """
        from adapters.bar_loads.thrusts import impulse_jumps

        q, rest = state[4 : 4 + self.width], np.zeros(self.width)
        angle = list(accumulate(q[2:].tolist()))
        self.put(angle, impulse_jumps(self.bars, impulses, angle))
        jump = self.forward(q, rest)
        after = state.copy()
        after[4 + self.width :] += jump
        found = self.joint_forces(q, rest, jump)
        self.put(angle, [(0.0, 0.0, 0.0)] * len(self.bars))  # without a new load the impulse would act as a force
        return after, found

    def height(self, state: Array) -> float:
        """Least distance of any point of any bar from the surface, m."""
        q, half = state[None, 4 : 4 + self.width], 0.5 * self.length_m
        position, (along, _) = state[:2] + positions(self.length_m, q)[0], directions(angles(q)[0])
        foot = np.clip(-np.sum(position * along, axis=-1), -half, half)  # nearest point of the bar, from its centre
        return float(np.linalg.norm(position + foot[:, None] * along, axis=-1).min() - self.radius_m)


def scales(scene: Scene) -> Array:
    """Unit of each component of a state: radius, bar length and radian, and the rate of each."""
    circular = math.sqrt(scene.central_body.mu_m3_s2 / scene.radius0_m**3)
    rate = max(circular, *(abs(a) * scene.orbital_rate_rad_s for a in scene.chain.rate_factor))
    units = np.repeat([scene.radius0_m, scene.radius0_m * rate], 2)
    joints = np.repeat([max(scene.chain.length_m), 1.0], [2, scene.bars])
    return np.concatenate([units, joints, rate * joints])
