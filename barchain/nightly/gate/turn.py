"""Program of one turn of times, in the Python of a build: each scene in turn, in processes that nothing has warmed.

It prints JSON: for each scene the time of `simulate` and the digest of the trajectory, or the reason why it has none.
"""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Any

from barchain.runs.cases import run_tasks
from barchain.runs.choices import choose_setting, named_engine
from barchain.runs.executors import ONE_BY_ONE
from barchain.runs.job import Job, Role
from barchain.studies.timing.bench import TimingBench
from reports.results.outcome import Outcome
from reports.results.rows import frame_digest
from scenarios import load_scene

if TYPE_CHECKING:
    from collections.abc import Sequence

LIMIT_S = 20.0
"""Longest `simulate`: scenes of the times take half a second in one of the builds"""


def turn(given: str, scenes: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Times and digests of one turn, by the scene as it was given."""
    name, registration = named_engine(given)
    setting = choose_setting(name, {}, {name: registration})
    bench = TimingBench()
    jobs = [Job(load_scene(scene), name, registration, setting, Role.MAIN) for scene in scenes]
    found: dict[str, dict[str, Any]] = {}
    results = run_tasks([bench.run(job, LIMIT_S) for job in jobs], ONE_BY_ONE)
    for scene, job, result in zip(scenes, jobs, results, strict=True):
        if result.outcome is Outcome.PASS and result.trajectory is not None:
            bits = frame_digest(result.trajectory.of_run(job.scene).to_frame())
            found[scene] = {"seconds": result.seconds["simulate"], "bits": bits}
        else:
            found[scene] = {"reason": result.reason}
    return found


if __name__ == "__main__":
    print(json.dumps(turn(sys.argv[1], sys.argv[2:])))
