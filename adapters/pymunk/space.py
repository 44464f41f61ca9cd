"""A chain in a pymunk space, stepped to second order: positions and velocities half a step apart.

Inside a step pymunk moves the positions, then calls the velocity callbacks, then solves the joints. The loads are
therefore evaluated at the new positions. A first half step at fixed positions puts the velocities half a step ahead.
With `error_bias = 0` the joints' velocities close, at the end of the step and to first order, the current gap. The
bars' rotation in one step remains as a gap,

    gap = (dt²/2) (h_j w_j² u_j + h_{j+1} w_{j+1}² u_{j+1}),   h half length, w rate.

This gap is the stationary one of the method. The chain starts with it, and the first half step removes half of it, so
that the reactions are correct from the first instant. The step after the first is an exception: its gap follows the
rates half a step earlier, and the reaction, m gap/dt², is of first order only. A sample coincides with that step only
if there is one step between two samples.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pymunk

from adapters.bar_loads.interface import bars_of
from adapters.pymunk.iteration_count import COLD_START_FACTOR
from reference_impl.model.kinematics import directions

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from adapters.bar_loads.chain_loads import ChainLoads
    from adapters.bar_loads.interface import FrameState, Load
    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array
    from scenarios.scene import Chain

Rows = list[tuple[float, float, float]]
"""For each bar x, y and angle, or their rates; SI units"""
StaggeredSample = tuple[Rows, Rows, Rows]
"""Each bar's position at a sample, its rates half a step before, and half a step after"""
WIDEST_GAP = 0.1  # over the shortest bar; beyond, the joints separate or a bar turns by half a radian in a step


class ChainSpace:
    """pymunk's space, bodies and joints of a chain."""

    def __init__(
        self, chain: Chain, start: InitialState, origin_m: Array, drift_m_s: Array, dt_s: float, sweeps: int
    ) -> None:
        """Set up the chain.

        Parameters
        ----------
        chain : Chain
        start : InitialState
        origin_m, drift_m_s : ndarray, shape (2,)
            Position and velocity of the space's origin at t = 0.
        dt_s : float
        sweeps : int
            Iterations over the joints in each step.
        """
        self.dt_s = dt_s
        self.properties, self.length_m = bars_of(chain), chain.length_m
        self.space = pymunk.Space()
        self.space.damping = 1.0
        self.sweeps = sweeps
        position = start.com_m - origin_m + start.position_m + initial_gaps(chain, start, dt_s)
        velocity = start.com_velocity_m_s - drift_m_s + start.velocity_m_s
        self.bars = [pymunk.Body(m, J) for m, J in zip(chain.mass_kg, chain.inertia_kg_m2, strict=True)]
        for j, bar in enumerate(self.bars):
            bar.position = (float(position[j, 0]), float(position[j, 1]))
            bar.velocity = (float(velocity[j, 0]), float(velocity[j, 1]))
            bar.angle, bar.angular_velocity = float(start.angle_rad[j]), float(start.rate_rad_s[j])
        joints = [
            pymunk.PivotJoint(a, b, (right, 0.0), (-left, 0.0))
            for a, b, right, left in zip(self.bars, self.bars[1:], chain.right_m, chain.left_m[1:], strict=False)
        ]
        for joint in joints:
            joint.error_bias = 0.0
            joint.collide_bodies = False
        self.joints = joints
        self.space.add(*self.bars, *joints)
        self.load_error: Exception | None = None

    def install(self, loads: StepLoads) -> None:
        """Install all loads of a scene; :meth:`step` re-raises an exception of the callback, which pymunk swallows."""
        loads.begin()
        if loads.chain_loads.act:
            for j, bar in enumerate(self.bars):
                bar.velocity_func = self.velocity_function(loads, j)

    def velocity_function(self, loads: StepLoads, j: int) -> Callable[..., None]:
        """Callback that changes velocities of bar `j`: all bars have moved, and earlier bars have new velocities."""
        integrate, pull, properties = pymunk.Body.update_velocity, loads.pull, self.properties[j]

        def change(bar: Any, gravity: Any, damping: float, dt: float) -> None:
            try:
                if pull:
                    x, y = bar.position
                    ax, ay, spin = pull.load(x, y, bar.angle, properties)
                else:
                    ax, ay, spin = loads.load(j, self.positions, self.velocities)
                mass = bar.mass
                bar.force = (mass * ax, mass * ay)
                bar.torque = bar.moment * spin
            except Exception as load_error:
                self.load_error = self.load_error or load_error
            integrate(bar, gravity, damping, dt)

        return change

    def apply_impulses(self, jumps: Sequence[tuple[float, float, float]]) -> None:
        """Apply jumps of each bar's velocities (m/s, m/s, rad/s) under closed joints: a step without motion.

        In a step that closes no gap and has no loads, the joints' impulses do not depend on the step's length.
        """
        for bar, (x, y, turn) in zip(self.bars, jumps, strict=True):
            vx, vy = bar.velocity
            bar.velocity, bar.angular_velocity = (vx + x, vy + y), bar.angular_velocity + turn
            bar.position_func = hold_position
        for joint in self.joints:
            joint.error_bias = 1.0
        self.space.iterations = COLD_START_FACTOR * self.sweeps
        self.step(self.dt_s)

    def half_step(self) -> None:
        """Put the velocities half a step ahead of the positions."""
        for bar in self.bars:
            bar.position_func = hold_position
        for joint in self.joints:
            joint.error_bias = 0.5 ** (2.0 / self.dt_s)  # the fraction left after 1 s: half the gap in half a step
        self.space.iterations = COLD_START_FACTOR * self.sweeps
        self.step(0.5 * self.dt_s)
        for bar in self.bars:
            bar.position_func = pymunk.Body.update_position
        for joint in self.joints:
            joint.error_bias = 0.0

    def settle(self) -> None:
        """Return to the regular number of sweeps, after SETTLED_STEPS."""
        self.space.iterations = self.sweeps

    def step(self, dt_s: float) -> None:
        """One step of pymunk.

        Raises
        ------
        Exception
            Any exception of a load.
        """
        self.space.step(dt_s)
        if self.load_error is not None:
            raise self.load_error

    def take_sample(self, *, first: bool) -> StaggeredSample:
        """Step across a sample: positions there, and velocities half a step before and after.

        The first sample is the chain's initial state; its velocities are the initial ones, and those half a step later.

        Raises
        ------
        ArithmeticError
            If any number is not finite.
        """
        before = self.velocities()
        if first:
            self.half_step()
        else:
            self.step(self.dt_s)
        staggered = (self.positions(), before, self.velocities())
        if not all(math.isfinite(value) for rows in staggered for row in rows for value in row):
            raise ArithmeticError("the state is not finite")
        return staggered

    def check_joints(self) -> None:
        """Check that the joints hold: where the sweeps do not converge, pymunk raises no error.

        Raises
        ------
        ArithmeticError
            If two bar ends at a joint are a tenth of the shortest bar apart.
        """
        widest = 0.0
        for joint in self.joints:
            a, b = joint.a.local_to_world(joint.anchor_a), joint.b.local_to_world(joint.anchor_b)
            widest = max(widest, math.hypot(b[0] - a[0], b[1] - a[1]))
        if widest > WIDEST_GAP * min(self.length_m):
            raise ArithmeticError(f"the two bar ends at a joint are {widest:.3g} m apart")

    def positions(self) -> Rows:
        """Place (m) and angle (rad) of each bar."""
        return [(*bar.position, bar.angle) for bar in self.bars]

    def velocities(self) -> Rows:
        """Rates of x, y (m/s) and angle (rad/s) of each bar."""
        return [(*bar.velocity, bar.angular_velocity) for bar in self.bars]


class StepLoads:
    """Loads on each bar in the current step.

    Velocities are half a step ahead of the positions. Loads that depend on velocities use the linear extrapolation of
    the last two, (3 v(n-1/2) - v(n-3/2))/2, at the positions' instant: second order. Just after a start the two are the
    initial rates and the rates half a step later.
    """

    def __init__(self, chain_loads: ChainLoads) -> None:
        """Prepare for the first step."""
        self.chain_loads, self.pull = chain_loads, chain_loads.pull_alone
        self.steps = 0
        self.before: Rows = []
        self.found: list[Load] = []

    def begin(self) -> None:
        """Discard the velocities: the chain restarts."""
        self.steps, self.before = 0, []

    def move_to(self, frame_state: FrameState) -> None:
        """Prepare a step to `frame_state`."""
        self.frame_state, self.found = frame_state, []
        if self.pull:
            self.pull.move_to(frame_state.x, frame_state.y)

    def load(self, j: int, positions: Callable[[], Rows], velocities: Callable[[], Rows]) -> Load:
        """Load of bar `j`; the first call of a step computes the loads of all bars."""
        if not self.found:
            rates = self.rates(velocities()) if self.chain_loads.of_rates else []
            self.found = self.chain_loads(self.frame_state, positions(), rates)
        return self.found[j]

    def rates(self, now: Rows) -> Rows:
        """Velocities at the instant of the positions, from velocities half a step earlier."""
        step, before, self.before = self.steps, self.before, now
        self.steps += 1
        if step == 0:
            return now
        ahead = 1.0 if step == 1 else 0.5  # share of the last change: half a step, later a whole one
        return [
            (vx + ahead * (vx - ux), vy + ahead * (vy - uy), w + ahead * (w - u))
            for (vx, vy, w), (ux, uy, u) in zip(now, before, strict=True)
        ]


def hold_position(bar: Any, dt: float) -> None:
    """Leave a bar in place."""


def initial_gaps(chain: Chain, start: InitialState, dt_s: float) -> Array:
    """Displacements of the bars, (N, 2) m, that open each joint by the method's stationary gap."""
    along, _ = directions(start.angle_rad)
    left, right = (
        0.5 * dt_s**2 * (np.array(lever_m) * start.rate_rad_s**2)[:, None] * along
        for lever_m in (chain.left_m, chain.right_m)
    )
    apart = np.zeros_like(left)
    apart[1:] = np.cumsum(right[:-1] + left[1:], axis=0)
    mass = np.array(chain.mass_kg)
    displaced: Array = apart - mass @ apart / mass.sum()
    return displaced
