"""Suggested runs: sample instants, and a duration, with which engines of equal steps support a scene.

Such engines reject instants at which no step ends. Another number of samples, or a slightly later end of the run,
makes every instant a sample or the middle between two.
"""

from __future__ import annotations

import dataclasses
import math
from fractions import Fraction
from typing import TYPE_CHECKING

from adapters.common.step_alignment import half_interval_s, inner_events_s, misalignment
from scenarios.scene import Run

if TYPE_CHECKING:
    from scenarios import Scene, Thrust

MAX_SUGGESTED_SAMPLES = 20_001
"""Largest number of samples of a suggested run"""


def with_run(scene: Scene, run: Run) -> Scene:
    """`scene` over another run; a thrust that lasts to the old end lasts to the new one."""
    end_s = scene.run.duration_s

    def until(thrust: Thrust) -> Thrust:
        times = tuple(run.duration_s if t == end_s else t for t in thrust.times_s)
        return dataclasses.replace(thrust, times_s=times)

    effects = dataclasses.replace(scene.effects, thrust=tuple(map(until, scene.effects.thrust)))
    return dataclasses.replace(scene, run=run, effects=effects)


def fitting_run(scene: Scene) -> Run | None:
    """Run of as many samples as the scene's, or a few more, in which every instant is a sample or midway between two.

    The scene's own duration is kept if possible, else extended to the next multiple of the instants' common divisor.
    None where the run would need more than :data:`MAX_SUGGESTED_SAMPLES`.
    """
    instants = [Fraction(repr(t)) for t in inner_events_s(scene)]
    scale = common_denominator(instants)
    shared = Fraction(math.gcd(*(int(t * scale) for t in instants)), scale)
    own = Fraction(repr(scene.run.duration_s))
    for duration in (own, math.ceil(own / shared) * shared):
        halves = common_denominator([t / duration for t in instants])  # duration/halves goes into every instant
        unit = halves // 2 if halves % 2 == 0 else halves
        run = Run(float(duration), math.ceil(Fraction(scene.run.samples - 1, unit)) * unit + 1)
        if run.samples <= max(MAX_SUGGESTED_SAMPLES, scene.run.samples):
            return run
    return None


def run_advice(scene: Scene) -> str:
    """Advice on instants at which engines of equal steps reject a scene, without a full stop; empty without any."""
    if misalignment(scene) is None:
        return ""
    run, half_s = fitting_run(scene), half_interval_s(scene)
    said = f"engines of equal steps support instants at samples or midway between two, multiples of {half_s:g} s here"
    if run is None:
        return f"{said}; no run of up to {MAX_SUGGESTED_SAMPLES} samples has each instant at one: move the instants"
    return f"{said}; with duration_s = {run.duration_s:.12g} and samples = {run.samples} in [run] each instant is one"


def common_denominator(values: list[Fraction]) -> int:
    """Smallest positive integer whose product with each value is an integer."""
    return math.lcm(*(v.denominator for v in values))


def aligned(scene: Scene) -> Scene:
    """`scene` with its thrusts, impulses and manoeuvres at the nearest samples."""
    every = scene.run.duration_s / (scene.run.samples - 1)

    def near(t_s: float) -> float:
        return every * round(t_s / every)

    effects = scene.effects
    moved = dataclasses.replace(
        effects,
        thrust=tuple(dataclasses.replace(p, times_s=tuple(map(near, p.times_s))) for p in effects.thrust),
        impulse=tuple(dataclasses.replace(p, at_s=near(p.at_s)) for p in effects.impulse),
        prescribed_rotation=tuple(
            dataclasses.replace(p, start_s=near(p.start_s), duration_s=max(near(p.duration_s), every))
            for p in effects.prescribed_rotation
        ),
    )
    return dataclasses.replace(scene, effects=moved)
