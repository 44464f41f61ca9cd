"""One chain divided into any number of equal bars."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Scene

SCENE = "paper/fig13"  # the 80° chain stays regular; a horizontal chain of many bars buckles at once
SAMPLES = 11  # few, so that no engine is timed at its output


def divided(scene: Scene, bars: int, share: float = 1.0) -> Scene:
    """`scene` with its chain divided into equal slender bars, over a share of its first orbit.

    The length, the mass, and the angle and rate of the first bar are kept.
    """
    mass, length = scene.mass_kg / bars, scene.size_m / bars
    chain = dataclasses.replace(
        scene.chain,
        mass_kg=(mass,) * bars,
        length_m=(length,) * bars,
        inertia_kg_m2=(mass * length**2 / 12.0,) * bars,
        angle_rad=scene.chain.angle_rad[:1] * bars,
        rate_factor=scene.chain.rate_factor[:1] * bars,
    )
    run = dataclasses.replace(scene.run, duration_s=share * scene.period_s, samples=SAMPLES)
    return dataclasses.replace(scene, name=f"{scene.name}, {bars} bars", chain=chain, run=run)
