"""Events met late or missed, inexact initial states, and settings that differ from the request."""

from __future__ import annotations

import dataclasses
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

from adapters.engine import AccuracyParameter
from barchain.studies.selftest.faults import reasons
from barchain.studies.selftest.faults.equations import SINGLE, of_chain
from barchain.studies.selftest.faults.fault import Fault, FaultGroup, Size
from barchain.studies.selftest.faults.forces import effect
from reference_impl.integrate import stepper, surface_contact
from reference_impl.integrate.discrete_modes import DiscreteModes
from scenarios import load_scene
from scenarios.scene import CentralBody

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Trajectory
    from barchain.solutions.reference import ReferenceSolution
    from barchain.studies.selftest.faults.fault import NotApplicable
    from reference_impl.model.arrays import Array
    from scenarios import Scene

STALE = "basics/free_rotation"
CLAIMED_STEPS = 1e9
STUCK = {AccuracyParameter.RTOL: 1e-6, AccuracyParameter.STEPS_PER_ORBIT: 100.0}


def later(one: Any, size: float) -> Any:
    """Effect that starts later."""
    if hasattr(one, "times_s"):
        return replace(one, times_s=tuple(t + size for t in one.times_s))
    if hasattr(one, "at_s"):
        return replace(one, at_s=one.at_s + size)
    return one.with_turns(lambda turn: replace(turn, start_s=turn.start_s + size))


def beyond_end(name: str, first: Callable[[Any], float], late_s: float) -> NotApplicable:
    """Scenes in which an effect that acts begins early enough to begin late, too."""

    def nothing(solution: ReferenceSolution) -> str:
        found = getattr(solution.scene.effects, name)
        if not found:
            return f"no {name}"
        ends = solution.scene.run.duration_s
        begins = [first(one) for one in found if first(one) < ends]
        if not begins:
            return f"no {name} before the end of the run"
        return "" if max(begins) + late_s < ends else "it would begin after the end of the run"

    return nothing


def late(name: str, words: str, stands_for: str, first: Callable[[Any], float]) -> tuple[Fault, Fault]:
    """Effect that begins late by a second, and by a millisecond."""

    def by(late_s: float, ending: str, said: str) -> Fault:
        return Fault(
            f"{name}-late{ending}", f"{words} late{said}", stands_for, FaultGroup.EVENTS, size=Size(late_s, "s"),
            scene=effect(name, later), nothing=beyond_end(name, first, late_s),
        )  # fmt: skip

    return by(1.0, "", ""), by(1e-3, "-millisecond", ", by a millisecond")


def switches_late(size: float) -> AbstractContextManager[object]:
    """Faces and shadows met late."""
    right = DiscreteModes.refine_event

    def meet(self: DiscreteModes, exact: Callable[[float], Array], *given: Any) -> tuple[float, Array]:
        found, _ = right(self, exact, *given)
        return found + size, exact(found + size)

    return patch.object(DiscreteModes, "refine_event", meet)


def landing_late(size: float) -> AbstractContextManager[object]:
    """Surface met late."""
    right = surface_contact.contact_instant

    def landing(*given: Any) -> float | None:
        found = right(*given)
        return None if found is None else found + size

    return patch.object(stepper, "contact_instant", landing)


def no_surface(scene: Scene, size: float) -> Scene:
    """A body that does not stop the chain."""
    del size
    return replace(
        scene,
        central_body=CentralBody(scene.central_body.mu_m3_s2, 1.0),
        orbit=replace(scene.orbit, altitude_m=scene.radius0_m - 1.0),
    )


def faster(scene: Scene, size: float) -> Scene:
    """Initial rate off of the last bar that no law prescribes, in units of the orbit's."""
    led = {law.bar - 1 for law in scene.effects.prescribed_rotation}
    rates = list(scene.chain.rate_factor)
    rates[max(set(range(len(rates))) - led)] += size
    return of_chain(scene, rate_factor=tuple(rates))


def turned(scene: Scene, size: float) -> Scene:
    """First bar's initial angle off."""
    angles = scene.chain.angle_rad
    return of_chain(scene, angle_rad=(angles[0] + size, *angles[1:]))


def injected(scene: Scene, size: float) -> Scene:
    """Speed of injection off; the bars' rates kept."""
    factors = tuple(a / (1.0 + size) for a in scene.chain.rate_factor)
    quick = replace(scene.orbit, speed_factor=scene.orbit.speed_factor * (1.0 + size))
    return of_chain(replace(scene, orbit=quick), rate_factor=factors)


def stale(scene: Scene, size: float) -> Scene:
    """Another scene, run for as long."""
    del size
    return replace(load_scene(STALE), run=scene.run)


def stretched(scene: Scene, size: float) -> Scene:
    """Scene that lasts a little longer."""
    return replace(scene, run=replace(scene.run, duration_s=scene.run.duration_s * (1.0 + size)))


def all_stretched(scene: Scene, size: float) -> Scene:
    """Scene that lasts longer, and all that is timed in it: a fast clock shows its samples at the right instants."""
    k, called = 1.0 + size, scene.effects
    effects = called.at_instants(lambda t: k * t)
    return replace(stretched(scene, size), effects=effects)


def on_time(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Samples labelled with the requested instants."""
    del size
    return trajectory.replace(t_s=scene.times_s[: len(trajectory.t_s)])


def loosened(setting: Setting, size: float) -> Setting:
    """Setting less exact by a factor."""
    value = setting.value * size if setting.parameter is AccuracyParameter.RTOL else setting.value / size
    return dataclasses.replace(setting, value=value)


def many_steps(trajectory: Trajectory, scene: Scene, size: float) -> Trajectory:
    """Run that reports a great many steps."""
    del scene, size
    return dataclasses.replace(trajectory, info=trajectory.info | {"steps": CLAIMED_STEPS})


def equal_steps(engine: Declarations) -> str:
    """Engines that choose their steps."""
    return "" if engine.sweep.parameter is AccuracyParameter.RTOL else "it takes equal steps"


def stuck(setting: Setting, size: float) -> Setting:
    """One constant setting for every request."""
    del size
    return dataclasses.replace(setting, value=STUCK[setting.parameter])


SECOND = Size(1.0, "s")
START, ACCURACY, EVENTS = FaultGroup.START, FaultGroup.ACCURACY, FaultGroup.EVENTS
FAULTS = (
    Fault("slew-late", "slews that start late", "a step that straddles a break", EVENTS, size=SECOND,
          nothing=reasons.SLEW, scene=effect("prescribed_rotation", later)),
    *late("thrust", "thrusts that start and end", "a step that straddles a break", lambda one: one.times_s[0]),
    *late("joint_torque", "torques of joints' motors", "a step that straddles a break", lambda one: one.times_s[0]),
    *late("impulse", "impulses that act", "an impulse at the end of a step", lambda one: one.at_s),
    Fault("switch-late", "shadow's edges and turned faces met late", "an event located at the end of a step", EVENTS,
          code=switches_late, size=SECOND, nothing=reasons.flips),
    Fault("landing-late", "the surface met late", "an event located at the end of a step", EVENTS,
          code=landing_late, size=Size(1.0, "s", most=1e3), nothing=reasons.lands),
    Fault("surface-missed", "the surface not met at all", "an event not looked for", EVENTS, scene=no_surface,
          nothing=reasons.lands),
    Fault("start-rate", "the initial rate of the last free bar off", "a rounded input", START, scene=faster,
          size=Size(1e-6, "v0/r0")),
    Fault("start-angle", "the first bar's initial angle off", "a rounded input", START, scene=turned,
          size=Size(1e-6, "rad")),
    Fault("start-speed", "the centre of mass' initial speed off", "a rounded input", START, scene=injected,
          size=Size(1e-6)),
    Fault("stale", f"the motion of another scene ({STALE}), run for as long", "a result file not overwritten", START,
          scene=stale),
    Fault("motion-stretched", "the motion of a clock that runs fast, at the right instants by its own account",
          "a rounded step times many", START, scene=stretched, output=on_time, size=Size(1e-6)),
    Fault("clock-fast", "a clock that runs fast, and effects at the right instants by its own account too",
          "a rounded step times many", START, scene=all_stretched, output=on_time, size=Size(1e-7)),
    Fault("loosened", "a tolerance silently loosened, at both settings", "a factor in the solver's own options",
          ACCURACY, setting=loosened, size=Size(100.0, "times", none=1.0, most=1e8)),
    Fault("sloppy", "a tolerance loosened by this factor, and a billion steps claimed", "options not passed on",
          ACCURACY, setting=loosened, output=many_steps, size=Size(1e3, "times", none=1.0), foreign=equal_steps),
    Fault("stuck-setting", "one loose setting, whatever is asked for", "an option not passed on", ACCURACY,
          setting=stuck),
    SINGLE,
)  # fmt: skip
