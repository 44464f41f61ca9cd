"""All planted mistakes by name, and which of them the self-test tries on its scenes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.engine import Engine
from adapters.registry import Registration, find_own_engine
from barchain.studies.selftest.faults import (
    declarations,
    equations,
    events,
    forces,
    output,
    paper_misprints,
    samples,
)
from barchain.studies.selftest.faults.fault import Fault, FaultGroup
from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Trajectory
    from scenarios import Scene


def by_name(faults: Iterable[Fault]) -> dict[str, Fault]:
    """Faults by their names, in the order of their groups."""
    order = tuple(FaultGroup)
    return {f.name: f for f in sorted(faults, key=lambda f: order.index(f.group))}


UNMODIFIED = "unmodified"
CONTROLS = by_name((Fault(UNMODIFIED, "the engine as it is", "no fault", FaultGroup.CONTROL), paper_misprints.CONTROL))
CATALOGUE = by_name((
    *paper_misprints.FAULTS, *equations.FAULTS, *forces.FAULTS, *events.FAULTS, *output.FAULTS, *samples.FAULTS,
    *samples.GARBAGE, *declarations.FAULTS,
))  # fmt: skip
FOR_OTHER_SCENES = {
    "gravity-model", "impulse-late-millisecond", "thrust-late-millisecond", "sloppy", "mass-stuck", "clock-fast",
    *(f.name for f in (*samples.GARBAGE, *samples.FAULTS, *declarations.FAULTS)),
}  # fmt: skip
"""Names of those that the short scenes need not detect: random scenes (`benchmarks/random_scenes.py`) and tests have
them"""
FIXED_SCENES = {name: f for name, f in CATALOGUE.items() if name not in FOR_OTHER_SCENES}
"""Those that have to be detected, at their natural size, in at least one of the short scenes of the kill matrix"""


class UnknownFaultError(KeyError):
    """There is no fault of that name."""

    def __str__(self) -> str:
        """Give the message without KeyError's quotes."""
        return str(self.args[0])


def find(name: str, among: Mapping[str, Fault] | None = None) -> Fault:
    """Fault of a name, among some or among all faults and controls.

    Raises
    ------
    UnknownFaultError
        With the nearest names.
    """
    known = CATALOGUE | CONTROLS if among is None else among
    if name not in known:
        raise UnknownFaultError(f"{name}: no such fault{nearest(name, known)}; --list shows all {len(known)}")
    return known[name]


class FaultyEngine(Engine):
    """A host engine with a fault inserted into its scene, its setting, its code or its samples."""

    def __init__(self, host: Registration, fault: Fault, size: float) -> None:
        """Make the host; a fault that is stuck runs at the host's default setting."""
        self.host, self.fault, self.size = host.engine(), fault, size
        self.stuck_at = host.declarations().sweep.setting() if fault.stuck else None

    def build(self, scene: Scene, setting: Setting) -> None:
        """Give the host the faulty scene and setting."""
        self.scene, self.setting = scene, setting
        with self.fault.within(self.size):
            used = self.stuck_at or self.fault.asked(setting, self.size)
            self.host.build(self.fault.staged(scene, self.size), used)

    def simulate(self) -> None:
        """Let it run."""
        with self.fault.within(self.size):
            self.host.simulate()

    def read(self) -> Trajectory:
        """Insert the fault into its samples."""
        with self.fault.within(self.size):
            seen = self.host.read()
        return self.fault.output_of(seen, self.scene, self.setting, self.size)


@dataclass(frozen=True)
class FaultRegistration(Registration):
    """Names and a number from which a worker makes the engine."""

    host: str = "reference"
    fault: str = ""
    size: float = 0.0

    def engine(self, options: Iterable[str] = ()) -> Engine:
        """The host with the fault; it takes no options."""
        del options
        return FaultyEngine(find_own_engine(self.host), find(self.fault), self.size)

    def declarations(self) -> Declarations:
        """Declarations of the host."""
        return find_own_engine(self.host).declarations()


def fault_registration(host: str, fault: str, size: float | None = None) -> FaultRegistration:
    """Registration of a host with a fault, by their names; at its natural size by default."""
    used = find(fault).natural if size is None else size
    name, compiles = f"fault:{fault}={used!r}:{host}", find_own_engine(host).compiles
    return FaultRegistration(name, compiles=compiles, host=host, fault=fault, size=used)
