"""An engine with a fault in it, behind the contract and in the registry's own form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from adapters.engine import Engine
from adapters.registry import Registration, find_own_engine
from barchain.faults.catalogue import find

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.engine import Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.faults.fault import Fault
    from scenarios import Scene

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
