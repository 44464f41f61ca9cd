"""One step of DOP853 (Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, II.5 and II.6), compiled.

Coefficients, error norm, step control and interpolant are SciPy's. The compiled reference therefore takes the same
steps as the NumPy reference. Each stage is one loop over the components, with its few non-zero coefficients as
constants in the code.
"""

from __future__ import annotations

import inspect
import re
from decimal import Decimal

import numpy as np
from scipy.integrate import DOP853
from scipy.integrate._ivp import dop853_coefficients

from reference_impl.fast.accelerations import evaluate
from reference_impl.fast.layout import CompiledChain, Workspace
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.structs import Matrix, Vector

Terms = tuple[tuple[int, ...], tuple[float, ...]]
STAGES, EXTRA, POWER = 12, 3, 7
ROWS = STAGES + 1 + EXTRA  # slopes: twelve stages, one at the end of the step, three for the interpolant
SAFETY, LEAST_FACTOR, LARGEST_FACTOR = 0.9, 0.2, 10.0
EXPONENT = -1.0 / 8.0


def terms(row: Vector) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Columns and values of a row's non-zero coefficients, padded with zeros to 4, 8 or 12."""
    columns = [int(j) for j in np.nonzero(row)[0]]
    idle = -len(columns) % 4 if len(columns) != 5 else 3
    return (*columns, *[0] * idle), (*(float(row[j]) for j in columns), *[0.0] * idle)


TABLE = tuple(terms(row) for row in DOP853.A[1:])
EXTRA_TABLE = tuple(terms(row) for row in DOP853.A_EXTRA)
DENSE_TABLE = tuple(terms(row) for row in DOP853.D)
END, E3, E5 = terms(DOP853.B), terms(DOP853.E3), terms(DOP853.E5)
C = tuple(float(c) for c in DOP853.C)
NODES = np.array(C)
C_EXTRA = tuple(float(c) for c in DOP853.C_EXTRA)


def coefficient_residues() -> Matrix:
    """Rounding errors of the coefficients, (13, 12), from the thirty digits in SciPy's source.

    The errors, up to 2e-15 as some coefficients exceed 40, are equal in every step. An orbit's energy therefore drifts
    by some 6e-16 per revolution in one direction. Rounding alone would cause a random walk.
    """
    found = np.zeros((STAGES + 1, STAGES))
    written = inspect.getsource(dop853_coefficients)
    for row, column, digits in re.findall(r"^A\[(\d+), (\d+)\] = ([-+.\de]+)", written, flags=re.MULTILINE):
        at = int(row), int(column)
        if at[0] <= STAGES:
            found[at] = float(Decimal(digits) - Decimal(float(digits)))
    return found


COEFFICIENTS, COEFFICIENT_RESIDUES = np.vstack([DOP853.A, DOP853.B]), coefficient_residues()


@inlined
def sum4(i: int, k: Matrix, table: Terms) -> float:
    """Sum of four slopes of component `i`, weighted by their coefficients.

    The sum is written out, with the table as a constant of the caller; a loop takes five times longer.
    """
    j, a = table
    return a[0] * k[j[0], i] + a[1] * k[j[1], i] + a[2] * k[j[2], i] + a[3] * k[j[3], i]


@inlined
def sum8(i: int, k: Matrix, table: Terms) -> float:
    """Weighted sum of eight slopes of component `i`."""
    j, a = table
    first = a[0] * k[j[0], i] + a[1] * k[j[1], i] + a[2] * k[j[2], i] + a[3] * k[j[3], i]
    return first + (a[4] * k[j[4], i] + a[5] * k[j[5], i] + a[6] * k[j[6], i] + a[7] * k[j[7], i])


@inlined
def sum12(i: int, k: Matrix, table: Terms) -> float:
    """Weighted sum of twelve slopes of component `i`."""
    j, a = table
    first = a[0] * k[j[0], i] + a[1] * k[j[1], i] + a[2] * k[j[2], i] + a[3] * k[j[3], i]
    second = a[4] * k[j[4], i] + a[5] * k[j[5], i] + a[6] * k[j[6], i] + a[7] * k[j[7], i]
    return first + second + (a[8] * k[j[8], i] + a[9] * k[j[9], i] + a[10] * k[j[10], i] + a[11] * k[j[11], i])


@compiled
def advance(t: float, h: float, y: Vector, slopes: Matrix, end: Vector, chain: CompiledChain, work: Workspace) -> bool:
    """Take one step from `y` with slope ``slopes[0]``: the state at ``t + h`` into `end`, its slope into row 12.

    Returns
    -------
    bool
        False if the joint system was not positive definite in an evaluation.
    """
    for i in range(len(y)):
        end[i] = y[i] + h * sum4(i, slopes, TABLE[0])
    well = evaluate(t + C[1] * h, end, slopes[1], chain, work)
    for i in range(len(y)):
        end[i] = y[i] + h * sum4(i, slopes, TABLE[1])
    well = evaluate(t + C[2] * h, end, slopes[2], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum4(i, slopes, TABLE[2])
    well = evaluate(t + C[3] * h, end, slopes[3], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum4(i, slopes, TABLE[3])
    well = evaluate(t + C[4] * h, end, slopes[4], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum4(i, slopes, TABLE[4])
    well = evaluate(t + C[5] * h, end, slopes[5], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum4(i, slopes, TABLE[5])
    well = evaluate(t + C[6] * h, end, slopes[6], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum8(i, slopes, TABLE[6])
    well = evaluate(t + C[7] * h, end, slopes[7], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum8(i, slopes, TABLE[7])
    well = evaluate(t + C[8] * h, end, slopes[8], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum8(i, slopes, TABLE[8])
    well = evaluate(t + C[9] * h, end, slopes[9], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum8(i, slopes, TABLE[9])
    well = evaluate(t + C[10] * h, end, slopes[10], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum12(i, slopes, TABLE[10])
    well = evaluate(t + C[11] * h, end, slopes[11], chain, work) and well
    for i in range(len(y)):
        end[i] = y[i] + h * sum8(i, slopes, END)
    return evaluate(t + h, end, slopes[12], chain, work) and well


@compiled
def advance_exactly(
    t: float,
    h: float,
    y: Vector,
    residue: Vector,
    slopes: Matrix,
    end: Vector,
    left: Vector,
    chain: CompiledChain,
    work: Workspace,
) -> bool:
    """Take one step as :func:`advance`, with coefficients of thirty digits and compensated summation of the state.

    Parameters
    ----------
    residue, left : ndarray, shape (size,)
        Rounding residue of the state at the start and at the end of the step (Kahan's compensated summation).
    """
    well = True
    for stage in range(1, STAGES + 1):
        for i in range(len(y)):
            head = tail = 0.0
            for j in range(stage):
                head += COEFFICIENTS[stage, j] * slopes[j, i]
                tail += COEFFICIENT_RESIDUES[stage, j] * slopes[j, i]
            change = h * (head + tail) + residue[i]
            end[i] = y[i] + change
            left[i] = change - (end[i] - y[i])
        share = 1.0 if stage == STAGES else NODES[stage]
        well = evaluate(t + share * h, end, slopes[stage], chain, work) and well
    return well


@compiled
def error_norm(size: int, h: float, y: Vector, end: Vector, slopes: Matrix, atol: Vector, rtol: float) -> float:
    """Error of a step relative to the allowed error, over `size` components: from the estimates of orders 5 and 3."""
    fifth = third = 0.0
    for i in range(len(y)):
        e5, e3 = sum8(i, slopes, E5), sum8(i, slopes, E3)
        inverse = 1.0 / (atol[i] + max(abs(y[i]), abs(end[i])) * rtol)
        fifth += (e5 * inverse) * (e5 * inverse)
        third += (e3 * inverse) * (e3 * inverse)
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return abs(h) * fifth / np.sqrt((fifth + 0.01 * third) * size)


@compiled
def first_step(size: int, t: float, span_s: float, y: Vector, slopes: Matrix, end: Vector, atol: Vector, rtol: float,
               chain: CompiledChain, work: Workspace) -> float:  # fmt: skip
    """Size of the first step, s (Hairer et al., II.4), from the slope in ``slopes[0]``; one evaluation."""
    d0 = d1 = d2 = 0.0
    for i in range(len(y)):
        scale = atol[i] + abs(y[i]) * rtol
        d0 += (y[i] / scale) ** 2
        d1 += (slopes[0, i] / scale) ** 2
    d0, d1 = np.sqrt(d0 / size), np.sqrt(d1 / size)
    h0 = min(1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1, span_s)
    for i in range(len(y)):
        end[i] = y[i] + h0 * slopes[0, i]
    evaluate(t + h0, end, slopes[1], chain, work)
    for i in range(len(y)):
        d2 += ((slopes[1, i] - slopes[0, i]) / (atol[i] + abs(y[i]) * rtol)) ** 2
    d2 = np.sqrt(d2 / size) / h0
    h1 = max(1e-6, h0 * 1e-3) if d1 <= 1e-15 and d2 <= 1e-15 else (0.01 / max(d1, d2)) ** (1.0 / 8.0)
    return min(100.0 * h0, h1, span_s)


@compiled
def interpolant(t: float, h: float, y: Vector, end: Vector, slopes: Matrix, scratch: Vector, powers: Matrix,
                chain: CompiledChain, work: Workspace) -> None:  # fmt: skip
    """Seventh-order interpolant of a step into `powers`, shape (7, size); three evaluations."""
    for i in range(len(y)):
        scratch[i] = y[i] + h * sum8(i, slopes, EXTRA_TABLE[0])
    evaluate(t + C_EXTRA[0] * h, scratch, slopes[13], chain, work)
    for i in range(len(y)):
        scratch[i] = y[i] + h * sum8(i, slopes, EXTRA_TABLE[1])
    evaluate(t + C_EXTRA[1] * h, scratch, slopes[14], chain, work)
    for i in range(len(y)):
        scratch[i] = y[i] + h * sum8(i, slopes, EXTRA_TABLE[2])
    evaluate(t + C_EXTRA[2] * h, scratch, slopes[15], chain, work)
    for i in range(len(y)):
        change = end[i] - y[i]
        powers[0, i] = change
        powers[1, i] = h * slopes[0, i] - change
        powers[2, i] = 2.0 * change - h * (slopes[12, i] + slopes[0, i])
        powers[3, i] = h * sum12(i, slopes, DENSE_TABLE[0])
        powers[4, i] = h * sum12(i, slopes, DENSE_TABLE[1])
        powers[5, i] = h * sum12(i, slopes, DENSE_TABLE[2])
        powers[6, i] = h * sum12(i, slopes, DENSE_TABLE[3])


@compiled
def interpolate(x: float, y: Vector, powers: Matrix, found: Vector) -> None:
    """State at the fraction `x` of the step."""
    rest = 1.0 - x
    for i in range(len(y)):
        total = powers[6, i] * x
        total = (total + powers[5, i]) * rest
        total = (total + powers[4, i]) * x
        total = (total + powers[3, i]) * rest
        total = (total + powers[2, i]) * x
        total = (total + powers[1, i]) * rest
        found[i] = y[i] + (total + powers[0, i]) * x
