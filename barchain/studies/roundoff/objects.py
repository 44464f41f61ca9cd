"""Objects on the axis of sizes, with the size ratio of each length."""

from __future__ import annotations

from barchain.studies.roundoff.formulations.states import EQUATOR_M

OBJECTS_M = {
    "20 km tether": 20e3,
    "1 km tether": 1e3,
    "100 m truss": 100.0,
    "7 m robot arm link": 7.0,
    "10 cm CubeSat": 0.1,
    "5 mm hinge": 5e-3,
    "10 µm MEMS beam": 1e-5,
}


def objects() -> list[dict[str, float | str]]:
    """Name, length and size ratio of each, from the longest."""
    return [{"name": name, "length_m": m, "ratio": m / EQUATOR_M} for name, m in OBJECTS_M.items()]
