"""All faults and controls by name."""

from __future__ import annotations

from barchain.studies.selftest.faults import equations, events, forces, misprints, output
from barchain.studies.selftest.faults.fault import Fault, FaultGroup
from scenarios import nearest

UNMODIFIED = "unmodified"
CONTROLS = {
    f.name: f for f in (Fault(UNMODIFIED, "the engine as it is", "no fault", FaultGroup.CONTROL), misprints.CONTROL)
}
ORDER = tuple(FaultGroup)
FAULTS = {
    f.name: f
    for f in sorted(
        (*misprints.FAULTS, *equations.FAULTS, *forces.FAULTS, *events.FAULTS, *output.FAULTS),
        key=lambda f: ORDER.index(f.group),
    )
}


class UnknownFaultError(KeyError):
    """There is no fault of that name."""

    def __str__(self) -> str:
        """Give the message without KeyError's quotes."""
        return str(self.args[0])


def find(name: str) -> Fault:
    """Fault or control of a name.

    Raises
    ------
    UnknownFaultError
        With the nearest names.
    """
    known = FAULTS | CONTROLS
    if name not in known:
        raise UnknownFaultError(f"{name}: no such fault{nearest(name, known)}; --list shows all {len(FAULTS)}")
    return known[name]
