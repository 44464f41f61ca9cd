"""All planted mistakes by name, and which of them are tried on the fixed and on the random scenes of the self-test."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.faults import declarations, equations, events, forces, misprints, output, readings
from barchain.faults.fault import Fault, FaultGroup
from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping


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
