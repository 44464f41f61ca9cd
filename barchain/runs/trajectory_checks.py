"""Checks that a trajectory is as its engine declares: complete, finite, with closed joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.metrics.joint_gaps import disagreement, gaps
from reports.results.outcome import Outcome
from scenarios.channels import STORED, TIME, Of

if TYPE_CHECKING:
    from adapters.engine import Declarations
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

OF_EFFECTS = [channel for channel in STORED if channel.effects]
TIME_SLACK = 1e-9  # of the run: round-off of an engine's clock in the sample instants
LOOSE_JOINT = 0.1  # of the shorter bar: ends farther apart are not joined by any standard


Fault = tuple[Outcome, str]
"""Outcome and reason"""


def fault(scene: Scene, engine: Declarations, trajectory: Trajectory) -> Fault | None:
    """Outcome and reason of the first fault of a trajectory, or None if it can be compared."""
    return (
        missing_channel(scene, engine, trajectory)
        or shape_fault(scene, trajectory)
        or no_samples(trajectory)
        or not_finite(trajectory)
        or cut_short(scene, trajectory)
        or off_the_clock(scene, trajectory)
        or places_contradict(scene, engine, trajectory)
        or joints_ignored(scene, trajectory)
        or undeclared_channel(engine, trajectory)
    )


def arrays(trajectory: Trajectory) -> dict[str, Array]:
    """Arrays that a trajectory holds, by name."""
    return {name: value for name, value in vars(trajectory).items() if isinstance(value, np.ndarray)}


def missing_channel(scene: Scene, engine: Declarations, trajectory: Trajectory) -> Fault | None:
    """Find quantities that the engine declares and does not return."""
    wanted = set(engine.observables) - {c.observable for c in OF_EFFECTS if c.absent_from(scene)}
    lacking = sorted(wanted - trajectory.observables)
    return (Outcome.INCOMPLETE, f"declares but does not return: {', '.join(lacking)}") if lacking else None


def undeclared_channel(engine: Declarations, trajectory: Trajectory) -> Fault | None:
    """Find quantities that the engine returns without declaring them: a verdict covers declared quantities only."""
    more = sorted(trajectory.observables.difference(engine.observables, {c.observable for c in OF_EFFECTS}))
    return (Outcome.MALFORMED, f"returns but does not declare: {', '.join(more)}") if more else None


def shape_fault(scene: Scene, trajectory: Trajectory) -> Fault | None:
    """Find values that can't be stored: no arrays of float64, without one row per sample, or with wrong columns."""
    if not isinstance(trajectory.t_s, np.ndarray) or trajectory.t_s.ndim != 1:
        return Outcome.INCOMPLETE, f"t_s is a {type(trajectory.t_s).__name__}, expected an array of shape (n,)"
    n = len(trajectory.t_s)
    shapes = {TIME: (n,)} | {channel.array: channel.shape(n, scene) for channel in STORED}
    for name in (TIME, *(channel.array for channel in STORED if channel.of is Of.TRACK)):
        if not isinstance(getattr(trajectory, name), np.ndarray):
            return Outcome.INCOMPLETE, f"{name} is a {type(getattr(trajectory, name)).__name__}, expected an array"
    for name, value in arrays(trajectory).items():
        if value.dtype != np.float64:
            return Outcome.INCOMPLETE, f"{name} holds {value.dtype}, expected float64"
    for name, value in arrays(trajectory).items():
        if name in shapes and value.shape != shapes[name]:
            return Outcome.INCOMPLETE, f"{name} has shape {value.shape}, expected {shapes[name]}"
    return None


def no_samples(trajectory: Trajectory) -> Fault | None:
    """Find results without the first sample."""
    if len(trajectory.t_s):
        return None
    return Outcome.INCOMPLETE, "returned no samples; the first, at t = 0, is always there"


def not_finite(trajectory: Trajectory) -> Fault | None:
    """Find NaN and infinity."""
    for name, value in arrays(trajectory).items():
        bad = ~np.isfinite(value.reshape(len(value), -1)).all(axis=1)
        if bad.any():
            first = int(np.argmax(bad))
            return (
                Outcome.NOT_FINITE,
                f"{name} is not finite from sample {first} (t = {trajectory.t_s[first]:.6g} s) on",
            )
    return None


def cut_short(scene: Scene, trajectory: Trajectory) -> Fault | None:
    """Find runs that stop before the last sample without a reason."""
    if len(trajectory.t_s) == scene.run.samples or trajectory.ended:
        return None
    last = trajectory.t_s[-1]
    return (
        Outcome.INCOMPLETE,
        f"returned {len(trajectory.t_s)} of {scene.run.samples} samples, up to t = {last:.6g} of "
        f"{scene.run.duration_s:.6g} s, and gave no reason: a chain at the surface gives `ended`, a program `ended_s`",
    )


def off_the_clock(scene: Scene, trajectory: Trajectory) -> Fault | None:
    """Find samples at other instants than the scene's."""
    late = np.abs(trajectory.t_s - scene.times_s[: len(trajectory.t_s)]).max(initial=0.0)
    if late <= TIME_SLACK * scene.run.duration_s:
        return None
    return Outcome.INCOMPLETE, f"samples are up to {late:.3g} s away from the instants asked for"


def places_contradict(scene: Scene, engine: Declarations, trajectory: Trajectory) -> Fault | None:
    """Find reported gaps and residuals that contradict the places of the bars."""
    found = disagreement(scene, engine, trajectory)
    return (Outcome.INCOMPLETE, found) if found else None


def joints_ignored(scene: Scene, trajectory: Trajectory) -> Fault | None:
    """Find open joints: by the places of the bars if the engine returns them, else by reported gaps."""
    computed = gaps(scene, trajectory)
    gap = trajectory.gap_m if computed is None else computed
    if gap is None or scene.bars == 1:
        return None
    length = np.array(scene.chain.length_m)
    loose = gap > LOOSE_JOINT * np.minimum(length[:-1], length[1:])
    if not loose.any():
        return None
    sample, joint = (int(i[0]) for i in np.nonzero(loose))
    return (
        Outcome.JOINTS_IGNORED,
        f"joint {joint + 1} is open by {gap[sample, joint]:.3g} m at t = {trajectory.t_s[sample]:.6g} s",
    )
