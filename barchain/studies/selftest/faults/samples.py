"""Mistakes in the samples of random scenes: garbage from an instant on, and small ones.

Garbage is in the main run, in the finer run or in all of them. Small mistakes are rounding, noise, interpolation,
joints reported closed, an invented end.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from adapters.trajectory import Observable
from barchain.runs.job import Role
from barchain.studies.selftest.faults.fault import Fault, FaultGroup, Size

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

    from adapters.engine import Declarations
    from adapters.trajectory import Array, Trajectory
    from barchain.studies.selftest.faults.fault import FreshChange, OutputChange
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
EVERY = ("com", "attitude", "reactions")
"""Channels that may hold garbage, as names of faults write them"""
DECIMALS_DEG = 6
OPENED = 1e-3  # of a bar's length, at the end of the run
ENDS_AT = 0.25  # of the run: an invented end


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


def garbage(share: float, *, growing: bool, channels: tuple[str, ...] = EVERY) -> FreshChange:
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


def in_all_channels(run: str, begins: str, *, growing: bool) -> Fault:
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


def in_millimetres(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Centre of mass as it is written with three decimals."""
    del scene, size
    return trajectory.replace(com_m=np.round(trajectory.com_m, 3))


def in_microdegrees(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Angles as they are written in degrees with six decimals."""
    del scene, size
    if trajectory.angle_rad is None:
        return trajectory
    return trajectory.replace(angle_rad=np.deg2rad(np.round(np.rad2deg(trajectory.angle_rad), DECIMALS_DEG)))


def creeping(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Last bar's angle off by (t/T)² of the size, T the orbit's period."""
    if trajectory.angle_rad is None:
        return trajectory
    angle = trajectory.angle_rad.copy()
    angle[:, -1] += size * (trajectory.t_s / scene.period_s) ** 2
    return trajectory.replace(angle_rad=angle)


def noisy(channel: str, largest_of: Callable[[Array], float]) -> FreshChange:
    """White noise after the first sample, its standard deviation a share of a channel's largest value."""

    def change(trajectory: Trajectory, scene: Scene, size: float, random: Generator) -> Trajectory:
        del scene
        found = getattr(trajectory, channel)
        if found is None:
            return trajectory
        noise = size * largest_of(found) * random.standard_normal(found.shape)
        noise[:1] = 0.0
        return trajectory.replace(**{channel: found + noise})

    return change


def interpolated(steps_per_period: float) -> OutputChange:
    """Angles on straight lines between the ends of steps, which a cubic through the samples gives."""

    def change(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
        del size
        if trajectory.angle_rad is None or trajectory.rate_rad_s is None or len(trajectory.t_s) < 2:
            return trajectory
        step = scene.period_s / steps_per_period
        cubic = CubicHermiteSpline(trajectory.t_s, trajectory.angle_rad, trajectory.rate_rad_s)
        before = np.floor(trajectory.t_s / step) * step
        share = ((trajectory.t_s - before) / step)[:, None]
        line = (1.0 - share) * cubic(before) + share * cubic(before + step)
        return trajectory.replace(angle_rad=trajectory.angle_rad + (line - cubic(trajectory.t_s)))

    return change


def closed(trajectory: Trajectory) -> dict[str, Any]:
    """Gaps and centre-of-mass residual of joints that are closed to the last digit."""
    named = {"gap_m": trajectory.gap_m, "com_residual_m": trajectory.com_residual_m}
    return {name: np.zeros_like(values) for name, values in named.items() if values is not None}


def torn(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Bars that turn freely from half of the run on, without reactions, and joints reported closed."""
    del size
    late = trajectory.t_s > 0.5 * scene.run.duration_s
    if trajectory.angle_rad is None or trajectory.rate_rad_s is None or trajectory.reaction_N is None or not late.any():
        return trajectory
    last = int(np.argmax(late)) - 1
    freely = trajectory.angle_rad[last] + np.outer(trajectory.t_s - trajectory.t_s[last], trajectory.rate_rad_s[last])
    return trajectory.replace(
        angle_rad=np.where(late[:, None], freely, trajectory.angle_rad),
        rate_rad_s=np.where(late[:, None], trajectory.rate_rad_s[last], trajectory.rate_rad_s),
        reaction_N=np.where(late[:, None, None], 0.0, trajectory.reaction_N),
        **closed(trajectory),
    )


def parted(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Bars whose positions separate along the chain during the run, and joints reported closed."""
    places = getattr(trajectory, "position_m", None)
    if places is None:
        return trajectory
    mass = np.array(scene.chain.mass_kg)
    order = np.arange(scene.bars) - mass @ np.arange(scene.bars) / mass.sum()  # about the centre of mass
    off = size * min(scene.chain.length_m) * np.outer(trajectory.t_s / scene.run.duration_s, order)
    return trajectory.replace(position_m=places + off[:, :, None] * np.array([1.0, 0.0]), **closed(trajectory))


def no_gaps(engine: Declarations) -> str:
    """Engines that show gaps."""
    return "" if Observable.GAP in engine.observables else "it shows no gaps"


def landed(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """First part of a run, reported to have ended at the surface."""
    kept = trajectory.t_s <= size * scene.run.duration_s
    if kept.all():
        return trajectory
    said = f"a bar reached the surface at t = {size * scene.run.duration_s:.6f} s"
    return dataclasses.replace(trajectory.samples(slice(0, int(kept.sum()))), ended=said)


NOISY_REACTIONS = noisy("reaction_N", largest)
NOISY_RATES = noisy("rate_rad_s", lambda rates: float(np.abs(rates).max()))
OUTPUT, ACCURACY = FaultGroup.OUTPUT, FaultGroup.ACCURACY
FAULTS = (
    Fault("com-millimetres", "centre of mass written to the millimetre", "a format with three decimals", ACCURACY,
          output=in_millimetres),
    Fault("attitude-decimals", "angles written to six decimals of a degree", "a format with six decimals", ACCURACY,
          output=in_microdegrees),
    Fault("attitude-creeps", "the last bar's angle off by this much times (t/T)²", "a torque too small to be seen",
          ACCURACY, output=creeping, size=Size(1e-7, "rad")),
    Fault("noise-reactions-small", "noise on the reactions, in units of the largest", "multipliers not converged",
          ACCURACY, fresh=NOISY_REACTIONS, size=Size(1e-6)),
    Fault("noise-reactions-large", "noise on the reactions, in units of the largest", "multipliers not converged",
          ACCURACY, fresh=NOISY_REACTIONS, size=Size(1e-4)),
    Fault("noise-rates", "noise on the rates, in units of the largest", "rates from rounded differences", ACCURACY,
          fresh=NOISY_RATES, size=Size(1e-8)),
    *(Fault(f"interpolated-{n}", f"angles interpolated linearly between {n} steps in a period",
            "output between steps of first order", ACCURACY, output=interpolated(float(n))) for n in (20000, 2000)),
    Fault("joints-torn", "bars turn freely from half of the run on, gaps are said to be closed",
          "gaps computed from the angles", OUTPUT, output=torn, foreign=no_gaps),
    Fault("joints-parted", "bars' places part by this share of a length, gaps are said to be closed",
          "gaps never measured", OUTPUT, output=parted, foreign=no_gaps, size=Size(OPENED)),
    Fault("invented-end", "the run is said to end at the surface after this share of it", "an event that is not one",
          OUTPUT, output=landed, size=Size(ENDS_AT)),
)  # fmt: skip
GARBAGE = (
    *(in_all_channels(run, begins, growing=growing) for growing in (False, True) for begins in SHARES for run in RUNS),
    *map(in_one, EVERY),
)
