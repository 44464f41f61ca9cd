"""Runs of the effects' scenes with a whole number of steps from sample to sample, against the reference."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, Engine, Setting
from scenarios import Scene, load_scene
from tests.support.generic_scenes import solution

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory

SMOOTH = ("quadrupole", "slender", "oblateness", "third_body", "drag", "joint_springs", "thrust")
JUMPING = ("thrust_table", "impulse")


def effect_scene(name: str, share: float = 1.0) -> Scene:
    """Scene `effects/name`, its first `share`, with as many samples less."""
    scene = load_scene(f"effects/{name}")
    samples = round(share * (scene.run.samples - 1)) + 1
    run = dataclasses.replace(scene.run, duration_s=share * scene.run.duration_s, samples=samples)
    return dataclasses.replace(scene, run=run)


def by_steps(engine: type[Engine], scene: Scene, steps_in_a_sample: int) -> Trajectory:
    """Run with a whole number of steps from sample to sample."""
    steps = steps_in_a_sample * (scene.run.samples - 1) * scene.step_period_s / scene.run.duration_s
    return engine().run(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, steps))


def errors(found: Trajectory, scene: Scene) -> dict[str, float]:
    """Largest error of each channel against the reference at its tightest."""
    true = solution(scene)
    names = ("angle_rad", "rate_rad_s", "reaction_N", "impulse_N_s")
    pairs = {name: (getattr(found, name), getattr(true, name)) for name in names}
    return {name: largest(a, b) for name, (a, b) in pairs.items() if b is not None}


def largest(a: Array, b: Array) -> float:
    """Largest difference."""
    return float(np.abs(a - b).max())
