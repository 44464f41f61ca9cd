"""Garbage in a part of a run: from an instant on, in the main run, in the finer run or in all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.faults.fault import Fault, FaultGroup
from barchain.runs.job import Role

if TYPE_CHECKING:
    from numpy.random import Generator

    from adapters.trajectory import Array, Trajectory
    from barchain.faults.fault import FreshChange
    from scenarios import Scene

OFF_M = 1.4e6
ANGLE_RAD = (1.0, 3.0)
FORCE_N = 5.0  # or FORCES times the largest reaction, whichever is more
FORCES = 5.0
LEAST = 1e-9  # of it: where growing garbage begins
AMOUNT = (0.5, 1.5)  # of it in one run: two runs are off by different amounts
SHARES = {"25": 0.25, "50": 0.5, "90": 0.9}
RUNS = {
    "main": (frozenset({Role.MAIN}), "in the main run alone"),
    "finer": (frozenset({Role.FINER}), "in the finer run alone"),
    "all": (None, "in all runs, by different amounts"),
}
CHANNELS = {"com": "com_m", "attitude": "angle_rad", "reactions": "reaction_N"}
ALL = tuple(CHANNELS)


def since(t_s: Array, duration_s: float, share: float, *, growing: bool) -> Array:
    """Weight of the garbage, (n,): 0 before a share of the run, then 1, or growing exponentially to 1."""
    begins = share * duration_s
    reached = np.clip((t_s - begins) / (duration_s - begins), 0.0, 1.0)
    weight = LEAST ** (1.0 - reached) if growing else np.ones(len(t_s))
    return np.where(t_s >= begins, weight, 0.0)


def direction(random: Generator, shape: tuple[int, ...]) -> Array:
    """Unit vectors (..., 2) of any direction."""
    angle = random.uniform(-np.pi, np.pi, shape)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def largest(values: Array) -> float:
    """Largest length of vectors (..., 2); 0 of none."""
    return float(np.linalg.norm(values, axis=-1).max(initial=0.0))


def garbage(share: float, *, growing: bool, channels: tuple[str, ...] = ALL) -> FreshChange:
    """Garbage in some channels from a share of the run on."""

    def change(trajectory: Trajectory, scene: Scene, size: float, random: Generator) -> Trajectory:
        weight = size * random.uniform(*AMOUNT) * since(trajectory.t_s, scene.run.duration_s, share, growing=growing)
        found: dict[str, Any] = {}
        if "com" in channels:
            found["com_m"] = trajectory.com_m + OFF_M * weight[:, None] * direction(random, ())
        if "attitude" in channels and trajectory.angle_rad is not None:
            bars = trajectory.angle_rad.shape[1]
            off = random.uniform(*ANGLE_RAD, bars) * random.choice([-1.0, 1.0], bars)
            found["angle_rad"] = trajectory.angle_rad + weight[:, None] * off
        if "reactions" in channels and trajectory.reaction_N is not None:
            force = max(FORCE_N, FORCES * largest(trajectory.reaction_N))
            off = force * direction(random, trajectory.reaction_N.shape[1:2])
            found["reaction_N"] = trajectory.reaction_N + weight[:, None, None] * off
        return trajectory.replace(**found)

    return change


def everywhere(run: str, begins: str, *, growing: bool) -> Fault:
    """Garbage in all channels."""
    how = "growing" if growing else "sudden"
    roles, where = RUNS[run]
    words = f"centre of mass, angles and reactions: {how} garbage after {begins} % of the run, {where}"
    stands = "an unstable method" if growing else "a buffer overwritten"
    change = garbage(SHARES[begins], growing=growing)
    return Fault(f"garbage-{how}-{begins}-{run}", words, stands, FaultGroup.GARBAGE, fresh=change, roles=roles)


def in_one(channel: str) -> Fault:
    """Garbage in one channel from half of the run on."""
    change = garbage(0.5, growing=False, channels=(channel,))
    words = f"{channel}: garbage after half of the run, in all runs"
    return Fault(f"garbage-{channel}", words, "one array overwritten", FaultGroup.GARBAGE, fresh=change)


FAULTS = (
    *(everywhere(run, begins, growing=growing) for growing in (False, True) for begins in SHARES for run in RUNS),
    *map(in_one, CHANNELS),
)
