"""Look for scenes that the reference does not survive, among thousands drawn at random.

    python benchmarks/random_scenes.py [--scenes 10000] [--first 0] [--engine reference-fast] [--out FILE.csv]

Each scene (`barchain.judge.checks.fuzzing.random_scenes.draw`, the same for the same number) is run by one form of the
reference and judged by what it must keep (`barchain.judge.checks.fuzzing.reference_checks`): closed joints, energy,
angular momentum, laws, numbers that are numbers. A run that ends in anything but a readable error, or keeps less than
it must, is a finding: the command lists it and exits with 1. Runs that take too long are counted apart: where bars are
so unequal that double precision is at its end, steps may shrink. What is compiled is compiled first.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
import pandas as pd

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import find_engine
from barchain.cli.common.progress import verdicts_shown
from barchain.judge.checks.fuzzing.random_scenes import draw
from barchain.judge.checks.fuzzing.reference_checks import broken
from barchain.run.job import Job, Role, RunResult
from barchain.run.pool import run_jobs
from barchain.run.time_limits import COMPILE_S
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from scenarios import Scene

RTOL = 1e-9
TIME_LIMIT_S = 30.0
KINDS = 200  # first scenes: among them is one of each set of effects
RAISED = re.compile(r"^\w+(Error|Exception|Warning|Interrupt|Exit): ")
"""How a worker words what is not an engine's own error"""


@click.command()
@click.option("--scenes", default=10_000, show_default=True, help="How many.")
@click.option("--first", default=0, show_default=True, help="Number of the first.")
@click.option("--engine", default="reference-fast", show_default=True, help="Which form of the reference.")
@click.option("--time-limit", default=TIME_LIMIT_S, show_default=True, help="For one run, s.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), help="Table of all scenes, CSV.")
def main(scenes: int, first: int, engine: str, time_limit: float, out: Path | None) -> None:
    """Run the campaign and list what it found."""
    known = compile_first(engine)
    jobs = [job_of(draw(seed), engine) for seed in range(first, first + scenes)]
    rows = []
    with verdicts_shown(len(jobs)) as show:
        for job, result in run_jobs(jobs, time_limit_s=time_limit, compile_s=0.0 if known else COMPILE_S):
            kind, reason = told(job, result)
            rows.append({"scene": job.scene.name, "kind": kind, "reason": reason})
            show(job.scene.name, engine, kind)
    table = pd.DataFrame(rows).sort_values("scene", key=lambda names: names.str.split("/").str[1].astype(int))
    if out:
        table.to_csv(out, index=False)
    click.echo(table["kind"].value_counts().to_string())
    findings = table[table["kind"] == "finding"]
    click.echo(findings.to_string(index=False) if len(findings) else "nothing found")
    raise SystemExit(bool(len(findings)))


def job_of(scene: Scene, engine: str) -> Job:
    """One run."""
    return Job(scene, engine, find_engine(engine), Setting(AccuracyParameter.RTOL, RTOL), Role.MAIN)


def compile_first(engine: str) -> bool:
    """Run the beginning of one scene of each set of effects, so that no run has to be given time to compile."""
    firsts: dict[object, Scene] = {}
    for scene in map(draw, range(KINDS)):
        laws, springs = bool(scene.effects.prescribed_rotation), scene.effects.joint_spring_damper is not None
        firsts.setdefault((scene.effects.gravity, springs, laws), scene)
    short = (replace(s, run=replace(s.run, duration_s=1e-3 * s.run.duration_s)) for s in firsts.values())
    done = [result for _, result in run_jobs([job_of(s, engine) for s in short], time_limit_s=TIME_LIMIT_S)]
    return all(result.outcome is not Outcome.TIMED_OUT for result in done)


def told(job: Job, result: RunResult) -> tuple[str, str]:
    """Kind of a result, and why: kept, ended by a readable error, too long, or a finding."""
    if result.outcome is Outcome.TIMED_OUT:
        return "too long", result.reason
    if result.outcome is Outcome.FAILED and not RAISED.match(result.reason):
        return "error in words", result.reason
    if result.trajectory is None:
        return "finding", result.reason
    lost = broken(job.scene, result.trajectory, RTOL)
    if lost or result.outcome is not Outcome.PASS:
        return "finding", lost or result.reason
    return "kept", result.reason


if __name__ == "__main__":
    main()
