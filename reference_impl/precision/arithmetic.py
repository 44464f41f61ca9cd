"""Floating-point types: NumPy's three, and one of hundreds of bits that serves as exact.

The formulations beside this module are written once, in operators and the few functions that an
:class:`Arithmetic` brings; arrays of Python objects carry the long numbers through the same lines.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gmpy2
import numpy as np

Values = Any
"""ndarray in some arithmetic's type: float32, float64, long double, or objects"""
Function = Callable[[Values], Values]

EXACT_DIGITS = 120
"""Decimal digits of the long numbers: where reactions vanish, absolute coordinates lose 3 for each one of the size
ratio, 36 at 1e-12, and a system of 500 bars some more; more than 50 are always left."""
EXACT_BITS = int(np.ceil(EXACT_DIGITS * np.log2(10.0)))


@dataclass(frozen=True)
class Arithmetic:
    """A floating-point type and its functions."""

    name: str
    dtype: Any
    unit_roundoff: float
    sqrt: Function
    sin: Function
    cos: Function
    log1p: Function
    expm1: Function

    def cast(self, values: Values) -> Values:
        """Round `values`, of any arithmetic, to this one."""
        array = np.asarray(values)
        if self.dtype is not object:
            return from_exact(array, self.dtype) if array.dtype == object else array.astype(self.dtype)
        return array if array.dtype == object else to_exact(array)

    def zeros(self, shape: tuple[int, ...]) -> Values:
        """Array of zeros."""
        return self.cast(np.zeros(shape))


def numpy_arithmetic(name: str, dtype: Any) -> Arithmetic:
    """One of NumPy's types, rounding to nearest."""
    unit = float(np.finfo(dtype).eps) / 2.0
    return Arithmetic(name, dtype, unit, np.sqrt, np.sin, np.cos, np.log1p, np.expm1)


def each(function: Callable[[Any], Any]) -> Function:
    """Function of one number made one of arrays of them."""
    found: Function = np.frompyfunc(function, 1, 1)
    return found


FLOAT32 = numpy_arithmetic("float32", np.float32)
FLOAT64 = numpy_arithmetic("float64", np.float64)
LONG = numpy_arithmetic("long double", np.longdouble)
EXACT = Arithmetic(
    "exact", object, 2.0**-EXACT_BITS,
    *map(each, (gmpy2.sqrt, gmpy2.sin, gmpy2.cos, gmpy2.log1p, gmpy2.expm1)),
)  # fmt: skip
ARITHMETICS = {a.name: a for a in (FLOAT32, FLOAT64, LONG)}


def long_doubles() -> bool:
    """Whether this machine's long double is longer than double: not so on all systems."""
    return LONG.unit_roundoff < FLOAT64.unit_roundoff


def exact_numbers() -> Any:
    """Context in which :data:`EXACT` computes: its functions take their precision from it."""
    return gmpy2.context(gmpy2.get_context(), precision=EXACT_BITS)


def to_exact(array: Values) -> Values:
    """Long numbers equal to those of a NumPy type: a long double is the sum of two doubles."""
    high = array.astype(np.float64)
    low = (array - high).astype(np.float64)
    lift = np.frompyfunc(lambda h, rest: gmpy2.mpfr(h) + gmpy2.mpfr(rest), 2, 1)
    return np.asarray(lift(high, low), dtype=object)


def from_exact(array: Values, dtype: Any) -> Values:
    """Long numbers rounded to a NumPy type; in two parts, so that a long double gets all its bits."""
    high = array.astype(np.float64)
    low = (array - high).astype(np.float64)
    return high.astype(dtype) + low.astype(dtype)
