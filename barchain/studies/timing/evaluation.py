"""Time of one evaluation of the right-hand side without a solver, for the forms of the reference; a chain to be cut."""

from __future__ import annotations

import dataclasses
import gc
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from barchain.runs.phases import Stopwatch
from reference_impl.integrate.simulate import Simulation
from reference_impl.kernel import layout
from reference_impl.kernel.library import Evaluation
from reference_impl.kernel.simulate import modes_at, set_modes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from adapters.trajectory import Array
    from reference_impl.integrate.coordinate_sets import CoordinateSet
    from scenarios import Scene

LEAST_S = 0.002  # of one batch: thousands of clock ticks
BATCHES = 7  # in a turn, whose time is the least of them: disturbances only add
DIRECT: dict[str, CoordinateSet | None] = {  # None: compiled
    "reference": "minimal",
    "reference-fast": None,
    "reference-absolute": "absolute",
}


def loop_of(engine: str, scene: Scene) -> Callable[[int], None]:
    """Function that evaluates an engine's right-hand side at the scene's start a number of times."""
    coordinates = DIRECT[engine]
    return compiled_loop(scene) if coordinates is None else numpy_loop(scene, coordinates)


def numpy_loop(scene: Scene, coordinates: CoordinateSet) -> Callable[[int], None]:
    """Loop over the right-hand side in NumPy."""
    start = initial_state(scene)
    state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
    simulation = Simulation(chain_model(scene), *state, rtol=1.0, coordinates=coordinates)
    rhs, y = simulation.coordinates.rhs, simulation.y0

    def loop(times: int) -> None:
        for _ in range(times):
            rhs(0.0, y)

    return loop


def compiled_loop(scene: Scene) -> Callable[[int], None]:
    """Loop over the compiled right-hand side, itself compiled: a call from Python takes as long as ten bars."""
    start, model = initial_state(scene), chain_model(scene)
    state = (start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s)
    y, chain = layout.pack(*state), layout.compiled_chain(model)
    at_start = Simulation(model, *state, rtol=1.0)
    set_modes(chain, modes_at(at_start.coordinates, 0.0, at_start.y0))
    return Evaluation(y, np.zeros_like(y), chain, layout.workspace_of(chain)).repeat


def evaluation_times(
    loops: Sequence[Callable[[int], None]], turns: int, least_s: float = LEAST_S, batches: int = BATCHES
) -> Array:
    """Time of one evaluation of each loop, in turn, again and again, (turns, loops) s: the least of its batches."""
    counts = [calibrated(loop, least_s) for loop in loops]
    gc.collect()
    gc.disable()
    try:
        found = [
            [min(batch_s(loop, n) for _ in range(batches)) for loop, n in zip(loops, counts, strict=True)]
            for _ in range(turns)
        ]
    finally:
        gc.enable()
    return np.array(found) / counts


def calibrated(loop: Callable[[int], None], least_s: float) -> int:
    """Number of evaluations that fill a batch; the very first evaluation may compile and is not timed."""
    loop(1)
    times = 1
    while batch_s(loop, times) < least_s:
        times *= 2
    return times


def batch_s(loop: Callable[[int], None], times: int) -> float:
    """Time of a batch without the wait for a processor, s."""
    clock = Stopwatch()
    loop(times)
    return clock.seconds()


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
        com_share=(),
    )
    run = dataclasses.replace(scene.run, duration_s=share * scene.period_s, samples=SAMPLES)
    return dataclasses.replace(scene, name=f"{scene.name}, {bars} bars", chain=chain, run=run)
