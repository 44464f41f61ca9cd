"""A chain as a library's tree of joints: its loads and its equations of motion in a freely falling frame.

The frame's origin is integrated with the chain and falls as a particle, so that the loads on bars are differences only.
State (4 + 2 (N + 2),): the origin and its velocity, the joint coordinates and their rates. Effects may depend on time
and on the side of an event, see `inside_s`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from adapters.bar_loads.assemble import chain_loads
from adapters.bar_loads.falling_frame import fall_rate
from adapters.bar_loads.gravity import MovingLoads
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.bar_loads.tree import tree_positions, tree_rates
from adapters.common.joint_coordinates import angles, positions
from adapters.common.joint_forces import reaction_from_wrench
from adapters.common.landing import least_height_m
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import BarPosition, BarRate, Load
    from adapters.trajectory import Array
    from scenarios import Impulse, Scene


class JointTree(ABC):
    """Accelerations and reactions of a state, by a library's model of the chain."""

    def __init__(self, scene: Scene, loads: Loads | None = None) -> None:
        """Prepare the loads; `loads` of another frame put the joint coordinates into that frame."""
        self.width = scene.bars + 2
        self.pulls = scene.effects.gravity is not Gravity.NONE
        self.loads = loads or MovingLoads(scene, surface=False)
        self.length_m, self.radius_m = np.array(scene.chain.length_m), scene.central_body.radius_m
        self.effect_loads = chain_loads(scene, self.loads, free_falling=True)
        self.fall_rate = fall_rate(scene)
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
        return np.concatenate([self.fall_rate(t_s, state[:4]), state[4 + self.width :], self.accelerations(t_s, state)])

    def accelerations(self, t_s: float, state: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,)."""
        q, q_t = state[4 : 4 + self.width], state[4 + self.width :]
        if self.effect_loads or self.pulls:
            self.act(t_s, state[:4].tolist(), q.tolist(), q_t.tolist())
        return self.forward(q, q_t)

    def act(self, t_s: float, origin: list[float], q: list[float], q_t: list[float]) -> None:
        """Apply all loads of the scene; `origin` is the frame's position and velocity (4,), m and m/s."""
        if self.effect_loads is None:
            positions, (x, y, *_) = list(tree_positions(q, self.bars)), origin
            self.loads.move_to(x, y)
            load = self.loads.load
            loads = [load(px, py, a, bar.half_length_m) for (px, py, a), bar in zip(positions, self.bars, strict=True)]
        else:
            frame, positions, rates = self.placed(t_s, origin, q, q_t)
            loads = self.effect_loads(frame, positions, rates)
        self.put([angle for *_, angle in positions], loads)

    def placed(
        self, t_s: float, origin: list[float], q: list[float], q_t: list[float]
    ) -> tuple[FrameState, list[BarPosition], list[BarRate]]:
        """Frame, and places and rates of the bars, as loads take them; no rates where no load depends on them."""
        assert self.effect_loads is not None
        x, y, vx, vy = origin
        rates = list(tree_rates(q, q_t, self.bars)) if self.effect_loads.of_rates else []
        return FrameState(x, y, vx, vy, t_s, self.inside_s), list(tree_positions(q, self.bars)), rates

    def incidences(self, t_s: float, state: Array) -> list[list[float]]:
        """Sines of the angles between bars and the wind or the Sun, a list for each effect that depends on faces."""
        if self.effect_loads is None or not self.effect_loads.faced:
            return []
        split = state[:4], state[4 : 4 + self.width], state[4 + self.width :]
        placed = self.placed(t_s, *(part.tolist() for part in split))
        return [effect.incidence(*placed) for effect in self.effect_loads.faced]

    def hold_faces(self, faces: Iterable[list[float] | None]) -> None:
        """Faces, +1 or -1, of each effect that depends on them; None: those of each state."""
        for effect, held in zip(self.effect_loads.faced if self.effect_loads else [], faces, strict=True):
            effect.held = held

    def reactions(self, state: Array, t_s: float = 0.0) -> Array:
        """Force on each bar from the next, (N-1, 2), N, at the state's accelerations."""
        found = self.accelerations(t_s, state)
        return self.joint_forces(state[4 : 4 + self.width], state[4 + self.width :], found)

    def joint_forces(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force on each bar from the next, (N-1, 2), N, just after `forward`."""
        force = self.transmitted(q, q_t, q_tt)
        return reaction_from_wrench(force, on_next_bar=True, axes_rad=angles(q[None])[0, 1:])

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
        q = state[None, 4 : 4 + self.width]
        return least_height_m(self.radius_m, self.length_m, state[:2] + positions(self.length_m, q)[0], angles(q)[0])
