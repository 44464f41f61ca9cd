"""One chain cut into more and more bars."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Scene

SCENE = "paper/fig13"  # the 80° chain, which stays regular; a horizontal one of many bars buckles at once
SAMPLES = 11  # few, so that no engine is timed at bringing samples out


def divided(scene: Scene, bars: int, share: float = 1.0) -> Scene:
    """`scene` with its chain cut into equal slender bars, over a share of its first orbit.

    Length, mass, and the first bar's angle and rate are kept.
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
