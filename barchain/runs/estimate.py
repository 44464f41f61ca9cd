"""Estimate of the time that a run of a scene takes, and the rejection of scenes that nobody can run.

The time is that of the compiled reference at its default tolerance, the fastest form of the equations here. It is the
number of evaluations of the equations times the time of one.

The method is explicit, of order 8 (DOP853), with 12 evaluations a step, and three more where samples lie. Its steps are
bounded by accuracy and by stability.

- Accuracy: one revolution of the centre of mass takes 42 steps and 630 evaluations at 1e-10 (measured, 100 and 1000
  revolutions of one bar): 100 evaluations a radian. The slow modes of a chain in a gravity gradient turn at up to 3 n,
  in planes of the orbit: three bars take 320 evaluations a radian of the orbit (measured).
- Stability: a mode of rate w allows steps of at most about 6/w: two evaluations a radian of the fastest mode. A taut
  chain in a gravity gradient, and one that turns, has the tension 3/2 rho n^2 (L^2/4 - s^2) and less. The equation of
  its transversal modes is Legendre's: w_k = n sqrt(3 k (k + 1) / 2), with k up to the number of bars. Undamped springs
  have their own rate. Damped ones lose their motion, and the implicit method of stiff scenes takes no notice of it.
  Modes that nothing excites allow longer steps for a while: a thousand bars took a ninth of the limit's evaluations in
  0.3 orbits, so that a tenth of them counts.

An open orbit turns less than once. A free flight at rest has no rate at all, and takes a step from sample to sample.

An evaluation takes 3e-8 s and 2e-8 s a bar (measured between 1 and 100 000 bars: 5e-8, 9e-8, 2.1e-7, 1.7e-6, 1.8e-5,
2.5e-4 and 3.9e-3 s for 1, 3, 10, 100, 1000, 10 000 and 100 000 bars, on one core of 2 GHz or more).

The estimate was 1.9 times too long for two bars at rest. Modes that a motion excites take up to a hundred times as many
steps, and the reference in NumPy up to a thousand times as long.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from barchain.runs.job import MOST_SECONDS
from scenarios import Gravity, SceneError
from scenarios.size_limits import LimitError, SizeLimit

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenarios import Scene

ACCURATE = 100.0
"""Evaluations of the equations a radian of a resolved motion"""
STABLE = 0.2
"""Evaluations a radian of the fastest mode: a tenth of those of an explicit method at its limit of stability"""
SLOW_MODES = 3.0
"""Rate of a chain's slow modes, relative to the mean motion"""
CALL_S, BAR_S = 3e-8, 2e-8
"""Time of an evaluation, and of each bar in it, s"""
LONGEST_S = SizeLimit("BARCHAIN_MOST_RUN_SECONDS", 120, "s for one run")
"""The usual time limit of a run"""
UNITS = ((3.156e7, "years"), (86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))
TOLD_S = 1.0  # a shorter time is not worth a line


class TooLongError(SceneError):
    """Raised for a scene whose run would take longer than is allowed; nothing was run."""


def estimated_run_s(scene: Scene) -> float:
    """Estimate of the wall time of one run of a scene by the compiled reference, s."""
    pulled = scene.effects.gravity is not Gravity.NONE
    revolutions = scene.run.duration_s / scene.period_s
    orbit_rad = 2.0 * math.pi * (revolutions if scene.bound else min(revolutions, 1.0)) if pulled else 0.0
    chain = math.sqrt(1.5 * scene.bars * (scene.bars + 1)) if scene.bars > 1 else 0.0
    turned_rad = scene.run.duration_s * scene.orbital_rate_rad_s * max(map(abs, scene.chain.rate_factor))
    springs = scene.effects.joint_spring_damper
    undamped = springs is not None and not any(springs.damping_N_m_s_rad)
    springs_rad = scene.run.duration_s * scene.spring_rate_rad_s if undamped else 0.0
    accurate = ACCURATE * orbit_rad * (SLOW_MODES if scene.bars > 1 else 1.0)
    stable = STABLE * max(chain * max(orbit_rad, turned_rad), springs_rad)
    return max(accurate, stable, float(scene.run.samples)) * (CALL_S + BAR_S * scene.bars)


def work_words(scene: Scene) -> str:
    """Time of a run in words: ``one run takes about 2.1 h``."""
    return f"one run takes about {duration_words(estimated_run_s(scene))}"


def duration_words(seconds: float) -> str:
    """Duration to two digits, in the largest unit of which it holds two."""
    size, unit = next((each for each in UNITS if seconds >= 2.0 * each[0]), UNITS[-1])
    return f"{seconds / size:.2g} {unit}"


def need_runnable(scenes: Iterable[Scene], time_limit_s: float = 0.0) -> None:
    """Check that a run of each scene may end in the time that is allowed.

    Parameters
    ----------
    scenes : iterable of Scene
    time_limit_s : float
        Wall time of one run that the user may choose, s; one below the usual limit rejects no further scene.

    Raises
    ------
    TooLongError
        If not even the fastest form of the reference would end; the message says how long it takes, and what allows
        more.
    """
    for scene in scenes:
        try:
            allowed_s = max(LONGEST_S.most, time_limit_s)
        except LimitError as error:
            raise TooLongError(str(error)) from None
        if estimated_run_s(scene) > allowed_s:
            size = f"{scene.bars} bars, {scene.run.duration_s:.3g} s of motion"
            option = "--time-limit or " if 0.0 < time_limit_s < estimated_run_s(scene) <= MOST_SECONDS else ""
            raise TooLongError(
                f"{scene.name}: {work_words(scene)} ({size}), allowed: at most {duration_words(allowed_s)}; "
                f"{option}the environment variable {LONGEST_S.variable} allows more"
            )
