"""Plan of a cost study: scenes cut to their first orbit, and every engine's accuracy sweep."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.common.equal_steps import step_s
from adapters.engine import AccuracyParameter
from barchain.runs.declared import engine_class
from barchain.runs.job import Job, Role
from barchain.runs.timing.left_out import LeftOut, cannot
from barchain.studies.cost.limits import MINUTES, REPEATS, TIME_LIMIT_S
from reports.tables.cost import INDEPENDENT, OWN_EQUATIONS

if TYPE_CHECKING:
    from adapters.engine import AccuracySweep, Setting
    from adapters.registry import Registration
    from scenarios import Scene

SAMPLES = 21  # few, so that no engine is timed at interpolating samples; certified solutions have these instants


@dataclass(frozen=True)
class CostPlan:
    """Measurements, and their limits of time."""

    scenes: list[Scene]
    engines: dict[str, Registration]
    repeats: int = REPEATS
    minutes: float = MINUTES
    time_limit_s: float = TIME_LIMIT_S
    named: frozenset[str] = frozenset()
    """Engines that were asked for by name"""

    @property
    def turns(self) -> int:
        """Number of first runs and rounds to be reported, engines left out among them."""
        found = [sweeps(s, self.engines) for s in self.scenes]
        return sum(sum(map(len, runs.values())) + len(out) + self.repeats for runs, out in found)


def kind_of(registration: Registration) -> str:
    """Kind of an engine: one of :data:`reports.tables.cost.KINDS`."""
    return INDEPENDENT if registration.external else OWN_EQUATIONS


def shortened(scene: Scene, orbits: float = 1.0) -> Scene:
    """`scene` over its first orbits, or its whole run if that is shorter, at :data:`SAMPLES` instants."""
    duration_s = min(orbits * scene.period_s, scene.run.duration_s)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration_s, samples=SAMPLES))


def distinct(scene: Scene, sweep: AccuracySweep) -> list[Setting]:
    """Settings of an accuracy sweep, coarse to fine, without those that round to the same steps as a coarser one."""
    if sweep.parameter is AccuracyParameter.RTOL:
        return list(sweep.settings)
    kept: dict[float, Setting] = {}
    for setting in sweep.settings:
        kept.setdefault(step_s(scene, setting.value), setting)
    return list(kept.values())


def sweeps(scene: Scene, engines: dict[str, Registration]) -> tuple[dict[str, list[Job]], list[LeftOut]]:
    """Runs of each engine on a scene, coarse to fine, and the engines left out."""
    runs: dict[str, list[Job]] = {}
    out: list[LeftOut] = []
    for name, registration in engines.items():
        reason = cannot(scene, name, registration)
        if reason is not None:
            out.append(reason)
            continue
        settings = distinct(scene, engine_class(registration).sweep)
        runs[name] = [Job(scene, name, registration, s, Role.MAIN) for s in settings]
    return runs, out
