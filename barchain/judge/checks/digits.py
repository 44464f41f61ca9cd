"""Digits of an engine's values: numbers that lie on a lattice were written with too few digits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.reference import ReferenceSolution

FEWEST = 12
"""Different values that a channel must have: by chance they all lie on a lattice a hundred times coarser than their
own digits with a probability of 1e-24"""
COARSE = 100.0  # units in the last place: a lattice closer than that is what rounding makes of any number
LEFT_OVER = 1e-6  # of a channel's largest value: what is smaller may be left over by sums that cancel, with few bits
EXPONENTS = range(-12, 4)
DEGREE = np.pi / 180.0
UNITS: dict[str, tuple[str, tuple[float, ...]]] = {
    "com_m": ("com", (1.0,)),
    "com_velocity_m_s": ("com_velocity", (1.0,)),
    "angle_rad": ("attitude", (1.0, DEGREE)),
    "rate_rad_s": ("rate", (1.0, DEGREE)),
    "reaction_N": ("reaction", (1.0,)),
    "torque_N_m": ("torque", (1.0,)),
    "impulse_N_s": ("impulse", (1.0,)),
}
"""Quantity of each channel, and units that it may have been rounded in"""
ROUNDED = 4.0  # units in the last place, of a number that was multiplied by its unit
ERRORS = 10.0  # of the judging solution: where a value is exact, its error is no more than this off the decimal
MOSTLY = 0.5  # of the reference's values: chance puts next to none on a lattice so coarse


def rounded_values(trajectory: Trajectory, solution: ReferenceSolution | None = None) -> str | None:
    """Say which channel was rounded to decimals, or to single precision; None if none was.

    Parameters
    ----------
    trajectory : Trajectory
    solution : ReferenceSolution, optional
        Values that are exact decimals in the judging solution, too, were not rounded.
    """
    for name, (quantity, units) in UNITS.items():
        values = getattr(trajectory, name)
        if values is None or not values.size:
            continue
        least = LEFT_OVER * np.abs(values).max()
        columns = values.reshape(len(values), -1)
        for k, column in enumerate(columns.T):
            lattice = lattice_of(column[np.abs(column) > least], units)
            if lattice is not None and not (solution and exact(solution, name, quantity, k, lattice)):
                return f"{name} is {lattice.words}"
    return None


@dataclass(frozen=True)
class Lattice:
    """Lattice that values were rounded to."""

    words: str
    spacing: float | None
    """Of decimals; None of single precision"""

    def off(self, values: Array) -> Array:
        """Distance of values from it."""
        if self.spacing is None:
            found: Array = np.abs(values - values.astype(np.float32))
            return found
        return np.abs(values - np.round(values / self.spacing) * self.spacing)


def exact(solution: ReferenceSolution, name: str, quantity: str, column: int, lattice: Lattice) -> bool:
    """Whether the judging solution's own values are on the lattice, to its error."""
    values = getattr(solution.trajectory, name)
    if values is None or quantity not in solution.error:
        return False
    own = values.reshape(len(values), -1)[:, column]
    n = min(len(own), len(solution.error[quantity]))
    allowed = ERRORS * solution.error[quantity][:n] + ROUNDED * np.spacing(np.abs(own[:n]))
    return bool(np.mean(lattice.off(own[:n]) <= allowed) > MOSTLY)


def lattice_of(column: Array, units: tuple[float, ...]) -> Lattice | None:
    """Find the lattice that the values of one component were rounded to; None if they were not."""
    different = np.unique(column)
    if len(different) < FEWEST:
        return None
    if np.array_equal(different, different.astype(np.float32)):
        return Lattice("in single precision", None)
    grain = np.spacing(np.abs(different))
    for unit in units:
        for exponent in reversed(EXPONENTS):
            spacing = unit * 10.0**exponent
            if spacing < COARSE * grain.max():
                break
            count = np.round(different / spacing)
            if np.all(np.abs(different - count * spacing) <= ROUNDED * grain) and len(np.unique(count)) >= FEWEST:
                named = "degrees" if unit == DEGREE else "its unit"
                return Lattice(f"rounded to multiples of 1e{exponent:d} of {named}", spacing)
    return None
