"""Runs of an examined engine: several in one process, and one by one where a process fails."""

from __future__ import annotations

import dataclasses
import math
import time
from contextlib import suppress
from typing import TYPE_CHECKING

from barchain.runs import examination
from barchain.runs.asking import OutsideEngine, Reply, ask, failed_reply
from barchain.runs.message import DeclarationError
from barchain.runs.run import one_run, result_of
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array, Trajectory
    from barchain.conform.target import Examined
    from barchain.runs.job import Job, RunResult
    from scenarios import Scene

TIME_LIMITS = "docs/howto/conform.md#time-limits"
START_S = 30.0
"""Time for the import of an engine's library"""
TOGETHER_SHARE = 0.15
"""Time of each of several runs in one process, over the longest time of one; if they take longer, each is made in a
process and with a limit of its own, so that one that hangs costs its own limit"""


def results(
    engine: Examined, jobs: Sequence[Job], t_s: Sequence[Array], limit_s: float, budget_s: float = math.inf
) -> list[RunResult]:
    """Results of runs, in their order.

    Parameters
    ----------
    engine : Examined
    jobs : sequence of Job
    t_s : sequence of ndarray
        Instants, for each run, at which the engine is asked for its noise.
    limit_s : float
        Longest time of one run.
    budget_s : float, optional
        Time after which no further run begins: the last results are then missing. No limit by default. If the runs of
        one process give no result, the time counts anew for runs one by one, after the time of a start.
    """
    if not jobs:
        return []
    if len(jobs) == 1 and budget_s == math.inf:
        return [alone(jobs[0], limit_s)]
    asked = [(job.scene, job.setting, t) for job, t in zip(jobs, t_s, strict=True)]
    together_s = max(limit_s, TOGETHER_SHARE * engine.run_s * len(jobs))
    allowed_s = START_S + min(together_s, budget_s)
    reply = ask(examination.several_runs, engine.registration, asked, budget_s, limit_s=allowed_s)
    if not reply.problem and budget_s < math.inf:
        jobs = jobs[: len(reply.header.get("runs", ()))]
    if reply.problem or len(reply.header.get("runs", ())) != len(jobs):  # to see which run ends the process
        return one_by_one(jobs, limit_s, time.monotonic() + START_S + budget_s)
    if reply.header["noise"]:
        with suppress(DeclarationError):  # a fault of the declaration is told with the first sample
            remember_noise(engine, jobs, t_s, reply)
    return [result_of(job, part(reply, k)) for k, job in enumerate(jobs)]


def one_by_one(jobs: Sequence[Job], limit_s: float, end: float) -> list[RunResult]:
    """Results of runs in a process each; without an end, a scene on which the engine hangs is not run again.

    Parameters
    ----------
    jobs : sequence of Job
    limit_s : float
        Longest time of one run.
    end : float
        Value of `time.monotonic` from which on no run begins.
    """
    made: list[RunResult] = []
    hung: dict[str, RunResult] = {}
    for job in jobs:
        if time.monotonic() >= end:
            break
        result = hung.get(job.scene.name) or alone(job, limit_s)
        if result.outcome is Outcome.TIMED_OUT and end == math.inf:
            hung[job.scene.name] = result
        made.append(result)
    return made


def alone(job: Job, limit_s: float) -> RunResult:
    """Result of a run in a process of its own; of one that was ended, with the option that allows more time."""
    result = one_run(job, START_S + limit_s)
    if result.outcome is not Outcome.TIMED_OUT:
        return result
    hint = f"({START_S:g} s to start and {limit_s:g} s to run; --time-limit allows longer runs)"
    return dataclasses.replace(result, reason=f"{result.reason} {hint}")


def ended_early(scene: Scene, trajectory: Trajectory) -> str:
    """Words on a run that ends before its last sample, as in no scene of the examination; empty on a whole run."""
    n, asked = len(trajectory.t_s), scene.run.samples
    return "" if n == asked else f"ended after {n} of {asked} samples ({trajectory.ended}), though no bar lands"


def part(reply: Reply, k: int) -> Reply:
    """Answer to one of several runs."""
    header, prefix = dict(reply.header["runs"][k]), f"{k}."
    if "failed" in header:
        return failed_reply(header)
    found = {name.removeprefix(prefix): values for name, values in reply.arrays.items() if name.startswith(prefix)}
    return Reply(header, {name: values for name, values in found.items() if not name.startswith("noise.")})


def remember_noise(engine: Examined, jobs: Sequence[Job], t_s: Sequence[Array], reply: Reply) -> None:
    """Keep the noise that came with runs: a question of its own would need another process each time."""
    loaded = engine.load()
    if not issubclass(loaded, OutsideEngine):
        return
    for k, (job, t) in enumerate(zip(jobs, t_s, strict=True)):
        prefix = f"{k}.noise."
        found = {n.removeprefix(prefix): v for n, v in reply.arrays.items() if n.startswith(prefix)}
        if "failed" not in reply.header["runs"][k]:
            loaded.remember_noise(job.scene, job.setting, t, found)
