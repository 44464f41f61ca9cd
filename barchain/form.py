"""The form of an engine's values: numbers that lie on a lattice were written with too few digits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.engine import Array, Trajectory

FEWEST = 12
"""Different values that a channel must have: by chance they all lie on a lattice a hundred times coarser than their
own digits with a probability of 1e-24"""
COARSE = 100.0  # units in the last place: a lattice closer than that is what rounding makes of any number
LEFT_OVER = 1e-6  # of a channel's largest value: what is smaller may be left over by sums that cancel, with few bits
EXPONENTS = range(-12, 4)
DEGREE = np.pi / 180.0
UNITS = {
    "com_m": (1.0,),
    "com_velocity_m_s": (1.0,),
    "angle_rad": (1.0, DEGREE),
    "rate_rad_s": (1.0, DEGREE),
    "reaction_N": (1.0,),
    "torque_N_m": (1.0,),
    "impulse_N_s": (1.0,),
}


def rounded_values(seen: Trajectory) -> str | None:
    """Say which channel was rounded to decimals, or to single precision; None if none was."""
    for name, units in UNITS.items():
        values = getattr(seen, name)
        if values is None or not values.size:
            continue
        least = LEFT_OVER * np.abs(values).max()
        for column in values.reshape(len(values), -1).T:
            said = rounded_column(column[np.abs(column) > least], units)
            if said:
                return f"{name} is {said}"
    return None


def rounded_column(column: Array, units: tuple[float, ...]) -> str:
    """How the values of one component were rounded; empty if they were not."""
    different = np.unique(column)
    if len(different) < FEWEST:
        return ""
    if np.array_equal(different, different.astype(np.float32)):
        return "in single precision"
    grain = np.spacing(np.abs(different))
    for unit in units:
        for exponent in reversed(EXPONENTS):
            lattice = unit * 10.0**exponent
            if lattice < COARSE * grain.max():
                break
            count = np.round(different / lattice)
            if np.all(np.abs(different - count * lattice) <= 4.0 * grain) and len(np.unique(count)) >= FEWEST:
                named = "degrees" if unit == DEGREE else "its unit"
                return f"rounded to multiples of 1e{exponent:d} of {named}"
    return ""
