"""Judging solution of a scene at other instants than its own samples.

From the last sample of the solution before an instant the reference goes on to it. Samples are dense where the solution
is certified. A reference solution has its own samples alone: its dense run, made for derivatives, is a thousand times
less accurate. The reference adds its own request in each step, amplified as the scene does from one own sample to the
next. Error, amplification and response are those of the next own sample, as they never fall.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import InitialState
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, Setting
from barchain.metrics.quantities import FIELDS, own_rate, rate_scale
from barchain.solutions.reference import SOLUTION_RTOL
from barchain.solutions.reference_run import reference_run
from scenarios.channels import CHANNELS
from scenarios.scene import RunAt

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

STEPS = 10.0
"""Steps from a sample to an instant, at least: a radian of the fastest motion is one more"""


def solution_at(solution: ReferenceSolution, t_s: Array) -> ReferenceSolution:
    """Judging solution at other instants.

    Parameters
    ----------
    solution : ReferenceSolution
    t_s : ndarray, shape (n,)
        Instants from 0 on, rising, none after the solution's last, s.

    Returns
    -------
    ReferenceSolution
        Its scene has a :class:`scenarios.scene.RunAt`.
    """
    scene, own = solution.scene, solution.trajectory.t_s[: len(solution.amplification)]
    row = np.minimum(np.searchsorted(own, t_s), len(own) - 1)
    base = solution.fine if solution.source.certified else solution.trajectory
    seen = motion_at(scene, base, t_s)
    run = RunAt(float(t_s[-1]), len(t_s), tuple(map(float, t_s)))
    since_s = t_s - base.t_s[np.searchsorted(base.t_s, t_s, side="right") - 1]
    grown = solution.amplification[row] / solution.amplification[np.maximum(row - 1, 0)]
    made_rad = SOLUTION_RTOL * np.maximum(STEPS, rate_scale(scene, solution.trajectory) * since_s) * grown
    made_rad = np.where(since_s > 0.0, made_rad, 0.0)
    added = {name: made_rad * response[row] for name, response in solution.response.items()}
    added["com"] = added["com"] + SOLUTION_RTOL * scene.radius0_m
    added["com_velocity"] = added["com_velocity"] + SOLUTION_RTOL * scene.speed0_m_s
    return dataclasses.replace(
        solution,
        scene=dataclasses.replace(scene, run=run),
        trajectory=dataclasses.replace(seen, ended=solution.trajectory.ended),
        error={name: error[row] + added.get(name, 0.0) for name, error in solution.error.items()},
        amplification=solution.amplification[row],
        response={name: response[row] for name, response in solution.response.items()},
        limit_s=solution.limit_s,
    )


def motion_at(scene: Scene, base: Trajectory, t_s: Array) -> Trajectory:
    """Motion at instants (n,) s, from samples `base` of it; what an engine measures at its own samples is not there."""
    before = np.searchsorted(base.t_s, t_s, side="right") - 1
    names = [name for name in FIELDS.values() if getattr(base, name) is not None]
    arrays = {name: getattr(base, name)[before].copy() for name in names}
    for k in np.unique(before[base.t_s[before] < t_s]):
        rows = np.flatnonzero((before == k) & (t_s > base.t_s[k]))
        later = restarted_run(scene, base, int(k), np.append(base.t_s[k], t_s[rows]), SOLUTION_RTOL)
        for name in names:
            values = getattr(later, name)
            if name == "impulse_N_s":  # counted from the start of the run that went on
                values = values + arrays[name][rows[0]]
            arrays[name][rows] = values[1:]
    measured = {channel.array for channel in CHANNELS.values() if channel.array} - arrays.keys()
    return base.replace(t_s=t_s, **dict.fromkeys(measured), **arrays)


def restarted_run(
    scene: Scene, trajectory: Trajectory, first: int, t_s: Array, rtol: float, moved_rad: Array | None = None
) -> Trajectory:
    """Run of the reference from sample `first` of `trajectory`, at instants (m,) s; its start moved by (2, N) rad.

    The second row moves the rates, in units of the scene's own.

    Raises
    ------
    EngineError
        If the reference can't go on from there.
    """
    assert trajectory.angle_rad is not None
    assert trajectory.rate_rad_s is not None
    moved = np.zeros((2, scene.bars)) if moved_rad is None else moved_rad * [[1.0], [own_rate(scene)]]
    nothing = np.zeros((scene.bars, 2))
    start = InitialState(
        trajectory.com_m[first], trajectory.com_velocity_m_s[first], trajectory.angle_rad[first] + moved[0],
        trajectory.rate_rad_s[first] + moved[1], nothing, nothing,
    )  # fmt: skip
    model = chain_model(scene)
    model = dataclasses.replace(model, impulses=tuple(b for b in model.impulses if b.at_s >= t_s[0]))
    seen = reference_run(scene, Setting(AccuracyParameter.RTOL, rtol), t_s=t_s, start=start, model=model)
    if trajectory.impulse_N_s is not None and seen.impulse_N_s is None:  # no impulse is left: their sum stays zero
        return seen.replace(impulse_N_s=np.zeros((len(t_s), scene.bars - 1, 2)))
    return seen
