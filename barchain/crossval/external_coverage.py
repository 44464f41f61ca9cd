"""Support of a scene by engines with independent physics: effects they lack, instants they reject, certified solutions.

Engines of equal steps reject instants at which no step ends. Such a rejection is no lack of an effect. Another number
of samples, or a slightly later end of the run, makes every instant a sample or the middle between two.
"""

from __future__ import annotations

import dataclasses
import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from adapters.common.step_alignment import inner_events_s, misalignment
from adapters.registry import engines
from barchain.boundary.declared import engine_class
from barchain.solutions.certified import committed_tables
from barchain.solutions.certified_table import physics_digest, read_head
from scenarios.scene import Run

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.engine import Engine
    from adapters.registry import Registration
    from scenarios import Scene, Thrust

MAX_SUGGESTED_SAMPLES = 20_001
"""Largest number of samples of a suggested run"""


def external_coverage(scene: Scene, requested: Mapping[str, Registration]) -> dict[str, Any]:
    """Entry of run.json: requested engines with independent physics that can't run the scene, and others that can.

    Returns
    -------
    dict
        ``lack``: effects that each engine lacks; ``instants``: see :func:`unaligned_instants`; ``not_requested``:
        engines with independent physics that support the scene; ``solution``: precision of its certified solution, or
        empty.
    """
    outside = {name: found for name, r in requested.items() if r.external and (found := loaded(r))}
    return {
        "lack": {name: lacking for name, e in outside.items() if (lacking := sorted(scene.effects.names - e.effects))},
        "instants": unaligned_instants(scene, outside),
        "not_requested": [name for name, r in engines().items() if name not in requested and supports(r, scene)],
        "solution": committed_precision(scene),
    }


def loaded(registration: Registration) -> type[Engine] | None:
    """Engine's class; None if it is not installed or does not load."""
    try:
        return None if registration.missing else engine_class(registration)
    except Exception:
        return None


def supports(registration: Registration, scene: Scene) -> bool:
    """Whether an engine is external, in everyday use and supports the scene, installed or not."""
    if not registration.external or not registration.in_default_set:
        return False
    try:
        return engine_class(registration).unsupported(scene) is None
    except Exception:
        return False


def unaligned_instants(scene: Scene, outside: Mapping[str, type[Engine]]) -> dict[str, Any]:
    """Engines that reject a scene for its instants alone, those instants (s), and a run that they would support.

    The cause is tested with the same scene and every instant at a sample.
    """
    if misalignment(scene) is None:
        return {}
    run = fitting_run(scene)
    trial = aligned(scene) if run is None else with_run(scene, run)
    stopped = [name for name, e in outside.items() if e.unsupported(scene) and not e.unsupported(trial)]
    if not stopped:
        return {}
    half = 0.5 * scene.run.duration_s / (scene.run.samples - 1)
    off = [t for t in inner_events_s(scene) if abs(t / half - round(t / half)) > 1e-9]
    return {"engines": stopped, "at_s": off, "run": None if run is None else dataclasses.asdict(run)}


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


def common_denominator(values: list[Fraction]) -> int:
    """Smallest positive integer whose product with each value is an integer."""
    return math.lcm(*(v.denominator for v in values))


def aligned(scene: Scene) -> Scene:
    """`scene` with its thrusts, impulses and manoeuvres at the nearest samples."""
    every = scene.run.duration_s / (scene.run.samples - 1)

    def near(t_s: float) -> float:
        return every * round(t_s / every)

    called = scene.effects
    moved = dataclasses.replace(
        called,
        thrust=tuple(dataclasses.replace(p, times_s=tuple(map(near, p.times_s))) for p in called.thrust),
        impulse=tuple(dataclasses.replace(p, at_s=near(p.at_s)) for p in called.impulse),
        prescribed_rotation=tuple(
            dataclasses.replace(p, start_s=near(p.start_s), duration_s=max(near(p.duration_s), every))
            for p in called.prescribed_rotation
        ),
    )
    return dataclasses.replace(scene, effects=moved)


def committed_precision(scene: Scene) -> str:
    """Precision of the certified solution committed for a scene of these physics; empty if there is none."""
    path = committed_tables().get(physics_digest(scene))
    return "" if path is None else read_head(path)["precision"]
