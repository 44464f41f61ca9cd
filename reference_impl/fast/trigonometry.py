"""Sine and cosine of many angles at once: branch-free, so that one vector instruction processes several bars.

The angle is reduced by a multiple of pi/2 in three parts (Cody and Waite), then enters the polynomials of fdlibm's
kernels. The error is at most two units in the last place. The mathematical library serves angles beyond that reduction.
"""

from __future__ import annotations

import math

from reference_impl.fast.layout import UX, UY
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.lanes import ROUNDER
from reference_impl.machine_code.structs import Matrix, Vector

LARGEST_RAD = 1e5  # up to here, multiples of PART_1 are exact
PER_QUARTER = 0.6366197723675814
PART_1, PART_2, PART_3 = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21
S1, S2, S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
S4, S5, S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
C1, C2, C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
C4, C5, C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


@inlined
def unit_vectors(n: int, angle: Vector, rows: Matrix) -> None:
    """Rows UX, UY of `rows`: unit vectors along the first `n` angles."""
    beyond = 0
    for i in range(n):
        x = angle[i]
        beyond += 0 if abs(x) < LARGEST_RAD else 1
        quarters = (x * PER_QUARTER + ROUNDER) - ROUNDER
        r = ((x - quarters * PART_1) - quarters * PART_2) - quarters * PART_3
        z = r * r
        sine = r + r * z * (S1 + z * (S2 + z * (S3 + z * (S4 + z * (S5 + z * S6)))))
        cosine = 1.0 - 0.5 * z + z * z * (C1 + z * (C2 + z * (C3 + z * (C4 + z * (C5 + z * C6)))))
        quarter = int(quarters)
        swap = (quarter & 1) != 0
        up, along = (cosine, sine) if swap else (sine, cosine)
        rows[UY, i] = -up if (quarter & 2) != 0 else up
        rows[UX, i] = -along if ((quarter + 1) & 2) != 0 else along
    if beyond > 0:
        library_vectors(n, angle, rows)


@compiled
def library_vectors(n: int, angle: Vector, rows: Matrix) -> None:
    """Rows UX, UY by the library's functions, for any angle."""
    for i in range(n):
        rows[UX, i] = math.cos(angle[i])
        rows[UY, i] = math.sin(angle[i])
