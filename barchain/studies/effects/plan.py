"""Plan of an effect budget."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.runs.declared import engine_class
from barchain.runs.executors import ALL_CORES
from barchain.runs.job import Job, Role
from barchain.studies.effects.default_options import FAST, MATTERS, REPEATS, RTOL, SECONDS, SLOW
from barchain.studies.effects.effect_toggles import Switch, switches
from barchain.studies.effects.sensitivity import LOOSER

if TYPE_CHECKING:
    from collections.abc import Iterable

    from barchain.runs.executors import Executor
    from barchain.studies.effects.altitude_range import Heights
    from scenarios import Scene


@dataclass(frozen=True)
class EffectsPlan:
    """Measurements, and their limits of time."""

    scene: Scene
    switches: tuple[Switch, ...]
    rtol: float = RTOL
    matters: float = MATTERS
    """Share from which a change matters: see :mod:`reports.chapters.effects.advice`"""
    repeats: int = REPEATS
    seconds: float = SECONDS
    executor: Executor = ALL_CORES
    engine: str | None = None
    """Form of the reference that runs all; None: the compiled one where it can"""
    width_m: float | None = None
    """Of every bar, for drag and sunlight that the scene does not have; None: the scene's own, if it has one"""

    @property
    def turns(self) -> int:
        """Number of steps to be reported."""
        return len(self.runs) + self.repeats

    @property
    def runs(self) -> tuple[Job, ...]:
        """All runs, each once: every pair of scenes in the engine that can do both, at both tolerances."""
        return tuple({job.key: job for job in (*self.tight, *map(self.looser, self.tight))}.values())

    @property
    def whole(self) -> tuple[Job, ...]:
        """Runs of the scene as it is, the tighter first."""
        own = self.job(self.scene, self.engine_for(self.scene))
        return own, self.looser(own)

    @property
    def tight(self) -> tuple[Job, ...]:
        """Runs at the tolerance asked for, each once; the scene as it is comes first."""
        pairs = [self.pair(s) for s in self.switches if s.scene]
        return tuple({job.key: job for job in (self.whole[0], *(j for pair in pairs for j in pair))}.values())

    def between(self, heights: Heights) -> EffectsPlan:
        """The plan, with defaults for the range of altitudes of the unmodified scene's run."""
        return dataclasses.replace(self, switches=switches(self.scene, heights, self.width_m))

    def pair(self, switch: Switch) -> tuple[Job, Job]:
        """Runs of the scene and of the switched one, in one engine."""
        assert switch.scene is not None
        engine = self.engine_for(self.scene, switch.scene)
        return self.job(self.scene, engine), self.job(switch.scene, engine)

    def engine_for(self, *scenes: Scene) -> str:
        """Name of the reference that supports all of these scenes."""
        return self.engine or (FAST if compiled_can(scenes) else SLOW)

    def job(self, scene: Scene, engine: str) -> Job:
        """Run at the tolerance asked for."""
        return Job(scene, engine, ENGINES[engine], Setting(AccuracyParameter.RTOL, self.rtol), Role.MAIN)

    def looser(self, job: Job) -> Job:
        """Repeat a run at the looser tolerance, for its numerical error."""
        return Job(
            job.scene, job.engine, job.registration, Setting(AccuracyParameter.RTOL, LOOSER * self.rtol), Role.MAIN
        )


def compiled_can(scenes: Iterable[Scene]) -> bool:
    """Whether the compiled reference is installed and can do these scenes."""
    registration = ENGINES[FAST]
    if registration.missing:
        return False
    engine = engine_class(registration)
    return all(engine.unsupported(s) is None for s in scenes)
