"""One run of the compiled reference: the same scene, messages and observables as :mod:`reference_impl.simulate`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reference_impl.fast import layout, walk
from reference_impl.fast.accelerations import evaluate
from reference_impl.fast.dop853 import interpolate
from reference_impl.fast.jit import compiled
from reference_impl.fast.layout import RX, RY
from reference_impl.kinematics import gap_vectors, relative_positions
from reference_impl.simulate import History, Simulation
from reference_impl.stepper import Walk, landing, stretches

if TYPE_CHECKING:
    from reference_impl.chain import Array, ChainModel
    from reference_impl.fast.layout import Chain, Work

LOST = "the joint system is not positive definite in double precision"


class FastSimulation:
    """One run: made, walked, then looked at; arguments and meaning as in :class:`Simulation`."""

    def __init__(
        self,
        model: ChainModel,
        com_m: Array,
        com_velocity_m_s: Array,
        angle_rad: Array,
        rate_rad_s: Array,
        *,
        rtol: float,
    ) -> None:
        """Set up a run, and have its code compiled."""
        self.model = model
        self.twin = Simulation(model, com_m, com_velocity_m_s, angle_rad, rate_rad_s, rtol=rtol)
        self.order = reference_order(model.bars)
        self.y0 = layout.pack(com_m, com_velocity_m_s, angle_rad, rate_rad_s)
        self.atol = np.ones_like(self.y0)
        self.atol[self.order] = self.twin.atol
        self.chain = layout.chain(model)
        self.work = layout.work(model.bars, len(model.prescriptions))
        self.warm_up()

    def warm_up(self) -> None:
        """Have all that a walk may call compiled, or loaded from where it was kept, by calls that change nothing."""
        self.aim(np.zeros(1))
        self.go(np.inf, -np.inf)
        if self.twin.floor_m:
            walk.dense(self.carry, self.chain, self.work)
            interpolate(0.0, self.carry.before, self.carry.powers, self.carry.end)
            walk.take_samples(-np.inf, self.t_s, self.rows, True, self.carry, self.chain, self.work)
            walk.leave_step(self.carry)

    def aim(self, t_s: Array) -> None:
        """Stand at the start, with the sample instants `t_s` ahead."""
        self.t_s, self.rows = t_s, np.empty((len(t_s), len(self.y0)))
        self.rows[0] = self.y0
        self.carry = walk.stepper(self.y0)
        self.carry.clock[walk.NOW] = t_s[0]
        self.carry.clock[walk.SEEN] = 1

    def go(self, start_s: float, end_s: float) -> int:
        """Walk on to `end_s`."""
        code: int = walk.go(
            start_s,
            end_s,
            self.twin.floor_m,
            self.twin.safe_m,
            self.t_s,
            self.rows,
            self.atol,
            self.carry,
            self.chain,
            self.work,
        )
        return code

    def walk(self, t_s: Array) -> Walk:
        """Integrate over the sample instants, from ``t_s[0]``; stop where a bar reaches the surface.

        Raises
        ------
        ArithmeticError
            If the step size collapses, or the state or its rate is not finite.
        numpy.linalg.LinAlgError
            If the joint system is not positive definite in double precision.
        """
        self.aim(t_s)
        stopped_s = None
        breaks_s = tuple(t for p in self.model.prescriptions for t in p.breaks_s)
        for start, end in stretches(t_s, breaks_s):
            code = self.go(start, end)
            while code == walk.LOOK and stopped_s is None:
                stopped_s = self.look()
                code = walk.ARRIVED if stopped_s is not None else self.go(start, end)
            self.complain(code)
            if stopped_s is not None:
                break
        clock = self.carry.clock
        seen = int(clock[walk.SEEN])
        return Walk(self.t_s[:seen], self.rows[:seen], int(clock[walk.STEPS]), int(clock[walk.EVALUATIONS]), stopped_s)

    def look(self) -> float | None:
        """Instant at which a bar reached the surface in the last step, or None; then its samples."""
        carry = self.carry
        walk.dense(carry, self.chain, self.work)
        end, step = carry.clock[walk.NOW], carry.clock[walk.TAKEN]
        found = np.empty_like(carry.y)

        def at(t: float) -> Array:
            interpolate((t - (end - step)) / step, carry.before, carry.powers, found)
            state: Array = found[self.order]
            return state

        before = self.twin.height(carry.before[self.order])
        stopped_s = landing(at, self.twin.height, end - step, end, before)
        until = end if stopped_s is None else stopped_s
        walk.take_samples(until, self.t_s, self.rows, True, carry, self.chain, self.work)
        walk.leave_step(carry)
        return stopped_s

    def complain(self, code: int) -> None:
        """Raise what the reference would."""
        if code == walk.LOST_JOINT:
            raise np.linalg.LinAlgError(LOST)
        now = self.carry.clock[walk.NOW]
        if code == walk.NOT_FINITE and now == self.t_s[0]:
            raise ArithmeticError(f"the initial state or its rate is not finite{self.twin.suspicion}")
        words = {
            walk.COLLAPSED: "Required step size is less than spacing between numbers.",
            walk.NOT_FINITE: "state not finite",
        }
        if code in words:
            raise ArithmeticError(f"DOP853 gave up at t = {now:.6g} s: {words[code]}{self.twin.suspicion}")

    def history(self, seen: Walk, *, condition: bool = False) -> History:
        """Observables at the samples of a walk."""
        n = self.model.bars
        reaction, torque = np.zeros((len(seen.t_s), n - 1, 2)), np.zeros((len(seen.t_s), len(self.chain.laws)))
        observe(seen.t_s, seen.y, self.carry.end, self.chain, self.work, reaction, torque)
        angle, com, rate, velocity = np.split(seen.y[:, : 2 * n + 4], [n, n + 2, 2 * n + 2], axis=1)
        position = np.array([relative_positions(self.model, a) for a in angle])
        gaps = [np.linalg.norm(gap_vectors(self.model, d, a), axis=-1) for d, a in zip(position, angle, strict=True)]
        numbers = [self.twin.condition(self.twin.packing.unpack(y[self.order])) for y in seen.y] if condition else None
        return History(
            seen.t_s,
            com,
            velocity,
            angle,
            rate,
            reaction,
            np.array(gaps),
            np.linalg.norm(np.einsum("j,tjk->tk", self.model.weight, position), axis=1),
            torque,
            None if numbers is None else np.array(numbers),
            seen.steps,
            seen.evaluations,
            seen.stopped_s,
        )


def reference_order(bars: int) -> Array:
    """Where the reference's [Z0, Z0', theta, theta'] are in [theta, Z0, theta', Z0'], shape (2N+4,) of int."""
    n = bars
    order: Array = np.concatenate([[n, n + 1, 2 * n + 2, 2 * n + 3], np.arange(n), np.arange(n + 2, 2 * n + 2)]).astype(
        int
    )
    return order


@compiled
def observe(
    t_s: Array, y: Array, scratch: Array, chain: Chain, work: Work, reaction_N: Array, torque_N_m: Array
) -> None:
    """Reactions (n, N-1, 2) and torques (n, P) at the states (n, size)."""
    joints = chain.bars.shape[1] - 1
    for k in range(len(t_s)):
        evaluate(t_s[k], y[k], scratch, chain, work)
        for j in range(joints):
            reaction_N[k, j, 0], reaction_N[k, j, 1] = work.bars[RX, j], work.bars[RY, j]
        for p in range(len(chain.laws)):
            torque_N_m[k, p] = work.torque_N_m[p]
