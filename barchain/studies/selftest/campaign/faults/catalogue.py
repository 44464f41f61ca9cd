"""All faults of the random campaign by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from barchain.studies.selftest.campaign.faults import declarations, garbage, physics, readings
from barchain.studies.selftest.faults.catalogue import UnknownFaultError
from scenarios import nearest

if TYPE_CHECKING:
    from barchain.studies.selftest.faults.fault import Fault

FAULTS = {f.name: f for f in (*garbage.FAULTS, *readings.FAULTS, *physics.FAULTS, *declarations.FAULTS)}


def find(name: str) -> Fault:
    """Fault of a name.

    Raises
    ------
    UnknownFaultError
        With the nearest names.
    """
    if name not in FAULTS:
        raise UnknownFaultError(f"{name}: no such fault{nearest(name, FAULTS)}; --list shows all {len(FAULTS)}")
    return FAULTS[name]
