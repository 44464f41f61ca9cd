"""All planted mistakes by name, and which of them are tried on the fixed and on the random scenes of the self-test."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.engine import Engine
from adapters.registry import Registration, find_own_engine
from barchain.faults import declarations, equations, events, forces, misprints, output, readings
from barchain.faults.fault import Fault, FaultGroup
from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.engine import Setting
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene


def by_name(faults: Iterable[Fault]) -> dict[str, Fault]:
    """Faults by their names, in the order of their groups."""
    order = tuple(FaultGroup)
    return {f.name: f for f in sorted(faults, key=lambda f: order.index(f.group))}


UNMODIFIED = "unmodified"
CONTROLS = by_name((Fault(UNMODIFIED, "the engine as it is", "no fault", FaultGroup.CONTROL), misprints.CONTROL))
CATALOGUE = by_name((
    *misprints.FAULTS, *equations.FAULTS, *forces.FAULTS, *events.FAULTS, *output.FAULTS, *readings.FAULTS,
    *readings.GARBAGE, *declarations.FAULTS,
))  # fmt: skip
SHARED = ("sign-reaction", "damped-rate", "mass", "mu", "impulse-late", "thrust-late")
"""Faults that are tried on fixed and on random scenes"""
REACHING_RANDOM_SCENES = (
    "gravity-model", "impulse-late-millisecond", "impulse-late", "thrust-late-millisecond", "thrust-late", "sloppy",
    "mass", "mass-stuck", "mu", "clock-fast",
)  # fmt: skip
"""Faults in the scene or the setting that any engine can be given"""
RANDOM_SCENES = {
    name: CATALOGUE[name]
    for name in (
        *(f.name for f in (*readings.GARBAGE, *readings.FAULTS)), "sign-reaction", "damped-rate",
        *REACHING_RANDOM_SCENES, *(f.name for f in declarations.FAULTS),
    )
}  # fmt: skip
"""Those that a verdict on any scene detects, or that are smaller than its own detection limit"""
FIXED_SCENES = {name: f for name, f in CATALOGUE.items() if name not in RANDOM_SCENES or name in SHARED}
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


DECLARED = (
    "title", "coordinates", "order", "sweep", "effects", "observables", "options", "joints_in_place",
    "track_by_length", "unsupported_reasons",
)  # fmt: skip


class FaultyEngine(Engine):
    """A host engine with a fault inserted; :func:`engine_with_fault` makes the final class."""

    host: ClassVar[type[Engine]]
    fault: ClassVar[Fault]
    size: ClassVar[float]
    recorded: ClassVar[Mapping[Setting, Trajectory]]
    """Runs of the unmodified engine, which serve a fault in the read-out alone"""

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """As its host."""
        return cls.host.unsupported(scene)

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        """As its host."""
        return cls.host.unsupported_motion(scene, motion)

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """As its host."""
        return cls.host.noise(scene, setting, t_s)

    def build(self, scene: Scene, setting: Setting) -> None:
        """Give the host the faulty scene and setting."""
        self.scene, self.setting = scene, setting
        self.unmodified = self.recorded.get(setting) if self.fault.replays else None
        if self.unmodified is None:
            self.inner = self.host()
            used = self.host.sweep.setting() if self.fault.stuck else self.fault.asked(setting, self.size)
            with self.fault.within(self.size):
                self.inner.build(self.fault.staged(scene, self.size), used)

    def simulate(self) -> None:
        """Let it run."""
        if self.unmodified is None:
            with self.fault.within(self.size):
                self.inner.simulate()

    def read(self) -> Trajectory:
        """Insert the fault into its samples."""
        if self.unmodified is not None:
            return self.fault.output_of(self.unmodified, self.scene, self.setting, self.size)
        with self.fault.within(self.size):
            seen = self.inner.read()
        return self.fault.output_of(seen, self.scene, self.setting, self.size)


def engine_with_fault(
    fault: Fault,
    size: float,
    host: type[Engine],
    recorded: Mapping[Setting, Trajectory] | None = None,
    main: Trajectory | None = None,
) -> type[Engine]:
    """Class of a host engine with a fault; without a `main` run of the host it has the host's declarations."""
    kept: dict[str, Any] = {name: getattr(host, name) for name in DECLARED}
    own = {"host": host, "fault": fault, "size": size, "recorded": recorded or {}}
    wrong = fault.declares(host, main) if fault.declares and main is not None else {}
    return type(f"Faulty{host.__name__}", (FaultyEngine,), kept | own | wrong)


@dataclass(frozen=True)
class FaultRegistration(Registration):
    """Names and a number from which a worker makes the class."""

    host: str = "reference"
    fault: str = ""
    size: float = 0.0

    def load(self) -> type[Engine]:
        """Make the class."""
        return engine_with_fault(find(self.fault), self.size, find_own_engine(self.host).load())


def fault_registration(host: str, fault: str, size: float | None = None) -> FaultRegistration:
    """Registration of a host with a fault, by their names; at its natural size by default."""
    used = find(fault).natural if size is None else size
    name, compiles = f"fault:{fault}={used!r}:{host}", find_own_engine(host).compiles
    return FaultRegistration(name, compiles=compiles, host=host, fault=fault, size=used)
