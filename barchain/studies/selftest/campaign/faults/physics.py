"""Wrong scenes and settings: another field, events met late, a wrong mass, a loosened tolerance, a fast clock."""

from __future__ import annotations

import dataclasses
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.engine import AccuracyParameter
from barchain.studies.selftest.faults import reasons
from barchain.studies.selftest.faults.equations import scaled
from barchain.studies.selftest.faults.events import later, loosened, of_chain, on_time
from barchain.studies.selftest.faults.fault import Fault, FaultGroup, Size
from barchain.studies.selftest.faults.forces import effect
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Engine
    from adapters.trajectory import Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.faults.fault import NotApplicable
    from scenarios import Scene

SIMPLER = {
    Gravity.SLENDER: Gravity.QUADRUPOLE,
    Gravity.QUADRUPOLE: Gravity.GRADIENT,
    Gravity.GRADIENT: Gravity.POINT,
}
"""Another model of gravity, the next simpler one"""
CLAIMED_STEPS = 1e9


def simpler_gravity(scene: Scene, size: float) -> Scene:
    """Scene with the next simpler model of gravity."""
    del size
    return replace(scene, effects=replace(scene.effects, gravity=SIMPLER[scene.effects.gravity]))


def simplest(solution: ReferenceSolution) -> str:
    """Scenes whose gravity has a simpler model."""
    return "" if solution.scene.effects.gravity in SIMPLER else "gravity has no simpler model that is not none at all"


def heavier(scene: Scene, size: float) -> Scene:
    """Scene whose last bar is too heavy, its moment of inertia right."""
    mass = scaled(np.array(scene.chain.mass_kg), -1, 1.0 + size)
    return of_chain(scene, mass_kg=tuple(map(float, mass)))


def stronger_pull(scene: Scene, size: float) -> Scene:
    """Scene whose central body is too heavy, started as it should be."""
    body, orbit = scene.central_body, scene.orbit
    return replace(
        scene,
        central_body=replace(body, mu_m3_s2=body.mu_m3_s2 * (1.0 + size)),
        orbit=replace(orbit, speed_factor=orbit.speed_factor * (1.0 + size) ** -0.5),
    )


def stretched(scene: Scene, size: float) -> Scene:
    """Scene that lasts longer, and all that is timed in it: a fast clock shows its samples at the right instants."""
    k, called = 1.0 + size, scene.effects
    slews = [replace(p, start_s=k * p.start_s, duration_s=k * p.duration_s) for p in called.prescribed_rotation]
    thrusts = [replace(p, times_s=tuple(k * t for t in p.times_s)) for p in called.thrust]
    impulses = [replace(p, at_s=k * p.at_s) for p in called.impulse]
    effects = replace(called, prescribed_rotation=tuple(slews), thrust=tuple(thrusts), impulse=tuple(impulses))
    return replace(scene, effects=effects, run=replace(scene.run, duration_s=k * scene.run.duration_s))


def beyond_end(name: str, first: Callable[[Any], float], late_s: float) -> NotApplicable:
    """Scenes in which an effect begins early enough to begin late, too."""

    def nothing(solution: ReferenceSolution) -> str:
        found = getattr(solution.scene.effects, name)
        if not found:
            return f"no {name}"
        ends = solution.scene.run.duration_s
        return "" if all(first(one) + late_s < ends for one in found) else "it would begin after the end of the run"

    return nothing


def late(name: str, words: str, first: Callable[[Any], float], late_s: float) -> Fault:
    """Effect that begins late by a millisecond or a second."""
    said = {1e-3: "millisecond", 1.0: "second"}[late_s]
    return Fault(
        f"{name}-late-{said}", f"{words} a {said} late", "an event at the end of a step", FaultGroup.EVENTS,
        scene=effect(name, later), nothing=beyond_end(name, first, late_s), size=Size(late_s, "s"),
    )  # fmt: skip


def many_steps(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Run that reports a great many steps."""
    del scene, size
    return dataclasses.replace(trajectory, info=trajectory.info | {"steps": CLAIMED_STEPS})


def equal_steps(engine: type[Engine]) -> str:
    """Engines that choose their steps."""
    return "" if engine.sweep.parameter is AccuracyParameter.RTOL else "it takes equal steps"


FORCES, START, ACCURACY = FaultGroup.FORCES, FaultGroup.START, FaultGroup.ACCURACY
HEAVIER = Fault("mass", "the last bar too heavy, its moment of inertia right", "one entry of a mass matrix",
                FaultGroup.EQUATIONS, scene=heavier, nothing=reasons.joints, size=Size(1e-2))  # fmt: skip
FAULTS = (
    Fault("gravity-model", "the next simpler model of gravity", "a load not switched on", FORCES,
          scene=simpler_gravity, nothing=simplest),
    *(late("impulse", "impulses", lambda one: one.at_s, s) for s in (1e-3, 1.0)),
    *(late("thrust", "thrusts", lambda one: one.times_s[0], s) for s in (1e-3, 1.0)),
    Fault("sloppy", "a tolerance loosened by this factor, and a billion steps claimed", "options not passed on",
          ACCURACY, setting=loosened, output=many_steps, size=Size(1e3, "times", none=1.0), foreign=equal_steps),
    HEAVIER,
    replace(HEAVIER, name="mass-stuck", words="the last bar too heavy, and one setting whatever is asked for",
            stands_for="a cached result", stuck=True),
    Fault("mu", "mu too large in the pull, the start right", "a rounded constant", FORCES, scene=stronger_pull,
          nothing=reasons.gravity, size=Size(1e-6)),
    Fault("clock-fast", "a clock that runs fast, at the right instants by its own account",
          "a rounded step times many", START, scene=stretched, output=on_time, size=Size(1e-7)),
)  # fmt: skip
