"""Bins of estimated quantiles: narrow near a centre, wider farther out, and fixed before values are counted.

A bin is named by the sign of a deviation from the centre, its binary exponent and its first digits, as in a DDSketch
with linear interpolation (Masson, Rim and Lee 2019). No bin but the one at the centre, 2^(1-BELOW) of
the scale wide, and the outermost is wider than 2^-DIGITS of its distance from the centre.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from adapters.trajectory import Array

PILOT_RUNS = 1000
"""First runs, which set centre and scale of each column's bins; whole parts, and a multiple of 8"""
DIGITS = 6
"""Binary digits of a deviation that tell bins apart"""
BELOW, ABOVE = 16, 8
"""Octaves of bins on either side of the scale"""
SHIFT = 52 - DIGITS
"""Of a double's bits, so that those of a bin remain"""
SIDE = (BELOW + ABOVE) << DIGITS
"""Bins on one side of the centre; the outermost has no end"""
BINS = 2 * SIDE + 1
LEAST = int(np.array(2.0**-BELOW).view(np.int64)) >> SHIFT
"""Bits of the least deviation outside the bin at the centre"""


def bin_edges() -> Array:
    """Edges of the bins (BINS + 1,), in deviations over the scale; the outermost are infinite."""
    beyond = ((np.arange(SIDE, dtype=np.int64) + LEAST) << SHIFT).view(np.float64)
    return np.concatenate([[-np.inf], -beyond[::-1], beyond, [np.inf]])


EDGES = bin_edges()
