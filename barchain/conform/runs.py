"""Runs of an examined engine: several in one process, and one by one where a process fails."""

from __future__ import annotations

import dataclasses
import math
import time
from contextlib import suppress
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter
from barchain.conform.target import PHYSICS_RUNS
from barchain.runs import examination
from barchain.runs.asking import AskedAnswers, Reply, ask, failed_reply, with_prefix
from barchain.runs.job import Role, failure
from barchain.runs.message import DeclarationError, plain_number
from barchain.runs.phases import SIMULATE
from barchain.runs.run import one_run, result_of
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Sequence

    from adapters.trajectory import Array, Trajectory
    from barchain.conform.target import Examined
    from barchain.runs.job import Job, RunResult
    from scenarios import Scene

TIME_LIMITS = "docs/howto/conform.md#time-limits"
START_S = 30.0
"""Time for the import of an engine's library"""
FIRST_SLACK = 3.0
"""Time that the first run of a process has for what it imports, over what first runs before it took"""
TOGETHER_SHARE = 0.15
"""Time of each of several runs in one process, over the longest time of one; if they take longer, each is made in a
process and with a limit of its own, so that one that hangs costs its own limit"""
SLOW_RUN_S = 1.0
"""Time of a short run from which on it is compared with one at the coarsest setting"""
MOST_SLOWER = 100.0
"""Largest ratio of the times of two settings that a method's order explains: at order 2 a request 1e6 times finer takes
as many steps more"""


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

    A scene in which a run is late is not run again, and the other runs go on in a new process. Where the time of the
    physics is over, the rest counts as late.
    """
    if not jobs:
        return []
    if len(jobs) == 1 and budget_s == math.inf:
        return [alone(jobs[0], limit_s)]
    made: list[RunResult] = []
    hung: dict[str, RunResult] = {}
    end = time.monotonic() + budget_s
    while len(made) < len(jobs):
        left, times = jobs[len(made) :], t_s[len(made) :]
        if left[0].scene.name in hung:
            made.append(hung[left[0].scene.name])
            continue
        if made and (engine.late or time.monotonic() >= end):
            break
        asked = [(job.scene, job.setting, t) for job, t in zip(left, times, strict=True)]
        together_s = max(limit_s, TOGETHER_SHARE * engine.run_s * len(left)) + limit_s  # one of them may be late
        budget = min(end - time.monotonic(), budget_s)
        allowed_s = START_S + min(together_s, budget)
        first_s = min(FIRST_SLACK * max(engine.first_runs_s, default=START_S), START_S)
        run_s = limit_s if budget_s == math.inf else math.inf  # else the budget counts
        reply = ask(examination.several_runs, engine.registration, asked, budget, run_s, first_s, limit_s=allowed_s)
        headers = [] if reply.problem else list(reply.header.get("runs", ()))
        late = bool(headers) and headers[-1].get("failed") == examination.LATE
        if not late and (reply.problem or (len(headers) < len(left) and budget_s == math.inf)):
            # to see which run ends the process
            made += one_by_one(engine, left, limit_s, START_S + budget)
            break
        with suppress(DeclarationError):  # a fault of the declaration is told with the first sample
            remember_noise(engine, left[: len(headers)], times[: len(headers)], reply)
        made += [result_of(job, part(reply, k)) for k, job in enumerate(left[: len(headers)])]
        engine.first_runs_s.extend(filter(None, [plain_number(reply.header.get("first_s"))]))
        if not late:
            break
        made_name, made[-1] = left[len(headers) - 1].scene.name, with_hint(made[-1], f"{limit_s:g} s to run")
        hung[made_name] = made[-1]
        engine.note(f"{made_name} is late, and was ended after {limit_s:g} s")
    missing = len(jobs) - len(made) if budget_s == math.inf else 0
    return made + [failure(Outcome.TIMED_OUT, no_time_left(engine))] * missing


def no_time_left(engine: Examined) -> str:
    """Words on a scene that is not run, as the time of the physics is over."""
    return f"no time is left: all scenes have {PHYSICS_RUNS * engine.run_s:g} s; --time-limit allows more"


def one_by_one(engine: Examined, jobs: Sequence[Job], limit_s: float, budget_s: float) -> list[RunResult]:
    """Results of runs in a process each; without an end, a scene on which the engine hangs is not run again.

    Parameters
    ----------
    engine : Examined
    jobs : sequence of Job
    limit_s : float
        Longest time of one run.
    budget_s : float
        Time after which no run begins.
    """
    end = time.monotonic() + budget_s
    made: list[RunResult] = []
    hung: dict[str, RunResult] = {}
    for job in jobs:
        if time.monotonic() >= end or (made and engine.late):
            break
        if not made or made[-1] is not hung.get(job.scene.name):
            engine.note(f"{job.scene.name}, in a process of its own")
        result = hung.get(job.scene.name) or alone(job, limit_s)
        if result.outcome is Outcome.TIMED_OUT and budget_s == math.inf:
            hung[job.scene.name] = result
        made.append(result)
    return made


def alone(job: Job, limit_s: float) -> RunResult:
    """Result of a run in a process of its own; of one that was ended, with the option that allows more time."""
    result = one_run(job, START_S + limit_s)
    if result.outcome is not Outcome.TIMED_OUT:
        return result
    return with_hint(result, f"{START_S:g} s to start and {limit_s:g} s to run")


def collapse(engine: Examined, name: str, run: RunResult) -> str:
    """Words on a run whose solver's steps collapse: at the coarsest setting it takes next to no time; empty if not."""
    sweep, late = engine.declarations.sweep, run.outcome is Outcome.TIMED_OUT and run.phase == SIMULATE
    took_s = engine.run_s if late else run.seconds.get("simulate", 0.0)
    if sweep.parameter is not AccuracyParameter.RTOL or took_s < SLOW_RUN_S:
        return ""
    coarsest = sweep.settings[0]
    coarse = alone(engine.job(engine.scene(name), coarsest, Role.COARSE), engine.run_s)
    coarse_s = coarse.seconds.get("simulate", took_s)  # a process that was ended tells no time
    if coarse.outcome is not Outcome.PASS or took_s < MOST_SLOWER * coarse_s:
        return ""
    return (
        f", though one at {coarsest} takes {coarse_s:.2g} s: steps collapse where the right-hand side jumps (a switch, "
        "a sign, dry friction) or is rounded, as by instants in single precision; end the integration at such an "
        "instant, and go on from it"
    )


def with_hint(result: RunResult, limits: str) -> RunResult:
    """Result of a run that was ended at its limits, with the option that allows more time."""
    return dataclasses.replace(result, reason=f"{result.reason} ({limits}; --time-limit allows longer runs)")


def ended_early(scene: Scene, trajectory: Trajectory) -> str:
    """Words on a run that ends before its last sample, as in no scene of the examination; empty on a whole run."""
    n, asked = len(trajectory.t_s), scene.run.samples
    return "" if n == asked else f"ended after {n} of {asked} samples ({trajectory.ended}), though no bar lands"


def part(reply: Reply, k: int) -> Reply:
    """Answer to one of several runs."""
    header = dict(reply.header["runs"][k])
    if "failed" in header:
        return failed_reply(header)
    found = with_prefix(reply.arrays, f"{k}.")
    return Reply(header, {name: values for name, values in found.items() if not name.startswith("noise.")})


def remember_noise(engine: Examined, jobs: Sequence[Job], t_s: Sequence[Array], reply: Reply) -> None:
    """Keep the noise that came with runs: a question of its own would need another process each time."""
    answers = engine.declarations.answers
    if not isinstance(answers, AskedAnswers):
        return
    for k, (job, t) in enumerate(zip(jobs, t_s, strict=True)):
        if "failed" not in reply.header["runs"][k]:
            answers.remember_noise(job.scene, job.setting, t, with_prefix(reply.arrays, f"{k}.noise."))
