"""Who else than ourselves can carry a scene: what its effects ask, what its instants do, what is committed.

Engines of equal steps refuse instants that no step ends at. That is no lack of an effect: another number of samples,
or a slightly different end of the run, makes every instant a sample or the middle between two.
"""

from __future__ import annotations

import dataclasses
import math
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from adapters.common.step_alignment import inner_events_s, misalignment
from adapters.registry import engines
from barchain.solutions.certified import committed_tables
from barchain.solutions.certified_table import physics_digest, read_head
from scenarios.scene import Run

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.engine import Engine
    from adapters.registry import Registration
    from scenarios import Scene, Thrust

MOST_SAMPLES = 20_001  # of a run that is suggested: beyond it nobody looks at them


def carriers(scene: Scene, asked: Mapping[str, Registration]) -> dict[str, Any]:
    """What run.json says of it: of external engines asked, those that lack an effect and those that instants stop."""
    outside = {name: found for name, r in asked.items() if r.external and (found := loaded(r))}
    return {
        "lack": {name: lacking for name, e in outside.items() if (lacking := sorted(scene.effects.names - e.effects))},
        "instants": in_the_way(scene, outside),
        "not_asked": [name for name, r in engines().items() if name not in asked and carries(r, scene)],
        "solution": committed_precision(scene),
    }


def loaded(registration: Registration) -> type[Engine] | None:
    """Engine's class; None where that can't be had."""
    try:
        return None if registration.missing else registration.load()
    except Exception:
        return None


def carries(registration: Registration, scene: Scene) -> bool:
    """Whether an everyday engine of somebody else's can do a scene, installed or not."""
    if not registration.external or not registration.in_default_set:
        return False
    try:
        return registration.load().unsupported(scene) is None
    except Exception:
        return False


def in_the_way(scene: Scene, outside: Mapping[str, type[Engine]]) -> dict[str, Any]:
    """Engines that refuse a scene for its instants alone, those instants, and a run that they would take.

    Whether it is the instants alone is tried out: on the same scene with every instant at a sample.
    """
    if misalignment(scene) is None:
        return {}
    run = fitting(scene)
    trial = aligned(scene) if run is None else lasting(scene, run)
    stopped = [name for name, e in outside.items() if e.unsupported(scene) and not e.unsupported(trial)]
    if not stopped:
        return {}
    half = 0.5 * scene.run.duration_s / (scene.run.samples - 1)
    off = [t for t in inner_events_s(scene) if abs(t / half - round(t / half)) > 1e-9]
    return {"engines": stopped, "at_s": off, "run": None if run is None else dataclasses.asdict(run)}


def lasting(scene: Scene, run: Run) -> Scene:
    """`scene` over another run; a thrust that lasts to its end still does."""
    end_s = scene.run.duration_s

    def until(thrust: Thrust) -> Thrust:
        times = tuple(run.duration_s if t == end_s else t for t in thrust.times_s)
        return dataclasses.replace(thrust, times_s=times)

    effects = dataclasses.replace(scene.effects, thrust=tuple(map(until, scene.effects.thrust)))
    return dataclasses.replace(scene, run=run, effects=effects)


def fitting(scene: Scene) -> Run | None:
    """Run of as many samples as the scene's, or a few more, every instant of which is a sample or between two.

    The scene's own duration is kept if that can be, else taken to the next multiple of what its instants share. None
    where it would take more than :data:`MOST_SAMPLES`.
    """
    instants = [Fraction(repr(t)) for t in inner_events_s(scene)]
    scale = common_denominator(instants)
    shared = Fraction(math.gcd(*(int(t * scale) for t in instants)), scale)
    own = Fraction(repr(scene.run.duration_s))
    for duration in (own, math.ceil(own / shared) * shared):
        halves = common_denominator([t / duration for t in instants])  # duration/halves goes into every instant
        unit = halves // 2 if halves % 2 == 0 else halves
        run = Run(float(duration), math.ceil(Fraction(scene.run.samples - 1, unit)) * unit + 1)
        if run.samples <= max(MOST_SAMPLES, scene.run.samples):
            return run
    return None


def common_denominator(values: list[Fraction]) -> int:
    """Least number that makes whole numbers of all."""
    return math.lcm(*(v.denominator for v in values))


def aligned(scene: Scene) -> Scene:
    """`scene` with its thrusts, blows and laws at the nearest samples."""
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
    """How the truth was run that is committed for a scene of these physics; empty if there is none."""
    path = committed_tables().get(physics_digest(scene))
    return "" if path is None else read_head(path)["precision"]
