"""A chain as a Pinocchio model, its loads and its equations of motion in a freely falling frame.

The frame's origin is integrated with the chain and falls as a particle, so that the loads on bars are differences only.
State (4 + 2 (N + 2),): the origin and its velocity, the joint coordinates and their rates. Effects may depend on time
and on the side of an event, see `inside_s`.
"""

from __future__ import annotations

from itertools import accumulate
from math import cos, sin
from typing import TYPE_CHECKING, Any

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
    from collections.abc import Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import BarProperties, Load
    from adapters.trajectory import Array
    from scenarios import Impulse, Scene
    from scenarios.scene import Chain

FIRST = 3  # Pinocchio's number of bar 1's joint, after the universe and two slides


def model_of(chain: Chain) -> Any:
    """Pinocchio model: two massless slides, then a joint about z at each bar's left end."""
    import pinocchio as pin

    model, here = pin.Model(), pin.SE3.Identity()
    model.gravity = pin.Motion.Zero()
    joint = model.addJoint(0, pin.JointModelPX(), here, "x")
    joint = model.addJoint(joint, pin.JointModelPY(), here, "y")
    position = here
    for j, (mass, length, inertia) in enumerate(zip(chain.mass_kg, chain.length_m, chain.inertia_kg_m2, strict=True)):
        joint = model.addJoint(joint, pin.JointModelRZ(), position, f"bar{j + 1}")
        centre = np.array([0.5 * length, 0.0, 0.0])
        model.appendBodyToJoint(joint, pin.Inertia(mass, centre, inertia * np.eye(3)), here)
        position = pin.SE3(np.eye(3), np.array([length, 0.0, 0.0]))
    return model


class PinocchioChain:
    """Accelerations and reactions of a state."""

    def __init__(self, scene: Scene, loads: Loads | None = None) -> None:
        """Make the model; `loads` of another frame put the joint coordinates into that frame."""
        import pinocchio as pin

        self.pin, chain = pin, scene.chain
        self.model = model_of(chain)
        self.data = self.model.createData()
        self.width = scene.bars + 2
        self.pulls = scene.effects.gravity is not Gravity.NONE
        self.loads = loads or MovingLoads(scene, surface=False)
        self.length_m, self.radius_m = np.array(chain.length_m), scene.central_body.radius_m
        self.effect_loads = chain_loads(scene, self.loads, free_falling=True)
        self.fall_rate = fall_rate(scene)
        self.bars = bars_of(chain)
        self.inside_s = 0.0  # an instant within the current segment between events
        self.forces = pin.StdVec_Force()  # one for each joint: Pinocchio reads beyond the end of a shorter list
        for _ in range(self.model.njoints):
            self.forces.append(pin.Force.Zero())
        self.no_torques, self.row = np.zeros(self.width), np.zeros(6)

    def rate(self, t_s: float, state: Array) -> Array:
        """Time derivative of a state."""
        return np.concatenate([self.fall_rate(t_s, state[:4]), state[4 + self.width :], self.accelerations(t_s, state)])

    def accelerations(self, t_s: float, state: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,)."""
        q, q_t = state[4 : 4 + self.width], state[4 + self.width :]
        if self.effect_loads:
            self.act(t_s, state[:4].tolist(), q.tolist(), q_t.tolist())
        elif self.pulls:
            self.apply(float(state[0]), float(state[1]), q.tolist())
        found: Array = self.pin.aba(self.model, self.data, q, q_t, self.no_torques, self.forces)
        return found

    def act(self, t_s: float, origin: list[float], q: list[float], q_t: list[float]) -> None:
        """Apply all loads of the scene; `origin` is the frame's position and velocity (4,), m and m/s."""
        assert self.effect_loads is not None
        positions = list(tree_positions(q, self.bars))
        rates = list(tree_rates(q, q_t, self.bars)) if self.effect_loads.of_rates else []
        x, y, vx, vy = origin
        loads = self.effect_loads(FrameState(x, y, vx, vy, t_s, self.inside_s), positions, rates)
        for j, ((*_, angle), bar, load) in enumerate(zip(positions, self.bars, loads, strict=True)):
            self.put(j, cos(angle), sin(angle), bar, load)

    def apply(self, x: float, y: float, q: list[float]) -> None:
        """Apply gravity at `q` (N + 2,) in the bars' own axes at their left ends, Pinocchio's convention."""
        self.loads.move_to(x, y)
        left_x, left_y = q[:2]
        for j, (angle, bar) in enumerate(zip(accumulate(q[2:]), self.bars, strict=True)):
            c, s, half = cos(angle), sin(angle), bar.half
            self.put(j, c, s, bar, self.loads.load(left_x + half * c, left_y + half * s, angle, half))
            left_x, left_y = left_x + 2.0 * half * c, left_y + 2.0 * half * s

    def put(self, j: int, c: float, s: float, bar: BarProperties, load: Load) -> None:
        """Set the load of bar `j`, along (c, s), in Pinocchio's convention."""
        ax, ay, spin = load
        mass, inertia, half = bar
        across = mass * (c * ay - s * ax)
        row = self.row
        row[0], row[1], row[5] = mass * (c * ax + s * ay), across, inertia * spin + half * across
        self.forces[FIRST + j] = self.pin.Force(row)

    def reactions(self, state: Array, t_s: float = 0.0) -> Array:
        """Force on each bar from the next, (N-1, 2), N, by inverse dynamics at the state's accelerations."""
        return self.joint_forces(state[4 : 4 + self.width], state[4 + self.width :], self.accelerations(t_s, state))

    def apply_impulses(self, state: Array, impulses: Sequence[Impulse]) -> tuple[Array, Array]:
        """State after impulses, and the impulsive reactions on each bar from the next, (N-1, 2), N s.

        With all rates zero, the same joint system gives jumps by impulses as accelerations by forces.
        """
        from adapters.bar_loads.thrusts import impulse_jumps

        q, rest = state[4 : 4 + self.width], np.zeros(self.width)
        angle = list(accumulate(q[2:].tolist()))
        for j, (a, bar, load) in enumerate(
            zip(angle, self.bars, impulse_jumps(self.bars, impulses, angle), strict=True)
        ):
            self.put(j, cos(a), sin(a), bar, load)
        jump = self.pin.aba(self.model, self.data, q, rest, self.no_torques, self.forces)
        after = state.copy()
        after[4 + self.width :] += jump
        found = self.joint_forces(q, rest, jump)
        for j in range(len(self.bars)):  # without a new load the impulse would act as a force
            self.forces[FIRST + j] = self.pin.Force.Zero()
        return after, found

    def joint_forces(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force on each bar from the next, (N-1, 2), N, at the loads last applied."""
        self.pin.rnea(self.model, self.data, q, q_t, q_tt, self.forces)
        # force of bar j on bar j + 1, in the axes of bar j + 1
        joint_forces = np.array([self.data.f[FIRST + j].linear[:2] for j in range(1, len(self.bars))]).reshape(-1, 2)
        return reaction_from_wrench(joint_forces, on_next_bar=True, axes_rad=angles(q[None])[0, 1:])

    def height(self, state: Array) -> float:
        """Least distance of any point of any bar from the surface, m."""
        q = state[None, 4 : 4 + self.width]
        return least_height_m(self.radius_m, self.length_m, state[:2] + positions(self.length_m, q)[0], angles(q)[0])
