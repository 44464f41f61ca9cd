"""Scenes for testing an engine: chains of unequal bars in no particular state, falls, other durations."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from reference_impl.model.relative import accelerations
from reference_impl.model.state import Accelerations, State
from scenarios import Gravity, Scene, load_scene
from tests.support import solutions

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory


def generic(seed: int, bars: int = 5, size: float = 1.0, gravity: Gravity = Gravity.GRADIENT) -> Scene:
    """Unequal bars at any angles, turning at up to three times the orbit's rate, lengths of some `size` x 100 m."""
    rng, base = np.random.default_rng(seed), load_scene("paper/fig05")
    mass, length = rng.uniform(10.0, 100.0, bars), 100.0 * size * rng.uniform(0.3, 1.0, bars)
    chain = dataclasses.replace(
        base.chain,
        mass_kg=tuple(mass.tolist()),
        length_m=tuple(length.tolist()),
        inertia_kg_m2=tuple((mass * length**2 / 12.0).tolist()),
        angle_rad=tuple(rng.uniform(-3.0, 3.0, bars).tolist()),
        rate_factor=tuple(rng.uniform(-3.0, 3.0, bars).tolist()),
    )
    orbit = dataclasses.replace(base.orbit, speed_factor=1.1, longitude_rad=float(rng.uniform(-3.0, 3.0)))
    effects = dataclasses.replace(base.effects, gravity=gravity)
    return dataclasses.replace(base, chain=chain, orbit=orbit, effects=effects)


def solution_at_start(scene: Scene) -> Accelerations:
    """Accelerations and reactions of the initial state, by the relative formulation."""
    s = initial_state(scene)
    state = State(s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s, s.position_m, s.velocity_m_s)
    return accelerations(chain_model(scene), 0.0, state)


def steep(orbits: float = 1.0, samples: int = 21, name: str = "paper/fig13", **orbit: float) -> Scene:
    """The 80 degree chain, for a while, on another orbit if wanted."""
    scene = load_scene(name)
    scene = dataclasses.replace(scene, orbit=dataclasses.replace(scene.orbit, **orbit))
    run = dataclasses.replace(scene.run, duration_s=orbits * scene.step_period_s, samples=samples)
    return dataclasses.replace(scene, run=run)


def of_bars(scene: Scene, bars: int) -> Scene:
    """`scene` with as many bars, all like its first."""
    chain = scene.chain
    names = ("mass_kg", "length_m", "inertia_kg_m2", "angle_rad", "rate_factor")
    changes = {name: getattr(chain, name)[:1] * bars for name in names}
    return dataclasses.replace(scene, chain=dataclasses.replace(chain, **changes))


def solution(scene: Scene) -> Trajectory:
    """The reference at its tightest."""
    return solutions.run(scene, 1e-13)


def worst(a: Array | None, b: Array | None) -> float:
    """Largest difference."""
    assert a is not None
    assert b is not None
    return float(np.abs(a - b).max(initial=0.0))
