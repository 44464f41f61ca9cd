"""Order of runs: the longest first, so that no process waits at the end for a long run that began late."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter
from adapters.registry import ENGINES

if TYPE_CHECKING:
    from barchain.runs.job import Job

STEPS_PER_RADIAN = 1.0
"""Of the fastest rate at rtol = 1; methods of high order take rtol^(-1/8) times more"""
ORDER = 8.0
COMPILING = 1e18
"""Work of a run that compiles first"""


def expected_work(job: Job) -> float:
    """Steps times bars that a run takes, as far as scene and setting tell; only the order of jobs depends on it."""
    scene, setting = job.scene, job.setting
    if job.registration.compiles and job.registration in ENGINES.values():
        return COMPILING * scene.bars
    turns = scene.run.duration_s / scene.step_period_s
    steps = setting.value * turns
    if setting.parameter is AccuracyParameter.RTOL:
        steps = STEPS_PER_RADIAN * 2.0 * math.pi * turns * scene.bars * setting.value ** (-1.0 / ORDER)
    return max(steps, scene.run.samples) * scene.bars
