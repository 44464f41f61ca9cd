"""Floating-point types: NumPy's three, quadruple precision, and one of hundreds of bits that serves as exact.

The formulations of this package are written once, in operators and the few functions of an :class:`Arithmetic`. Arrays
of Python objects take the multiple-precision numbers through the same code.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import gmpy2
import numpy as np

Values = Any
"""ndarray of an arithmetic's type: float32, float64, long double, or objects"""
Function = Callable[[Values], Values]

EXACT_DIGITS = 120
"""Decimal digits of the multiple-precision type.

Where reactions vanish, absolute coordinates lose 3 digits for each digit of the size ratio, 36 at 1e-12. A system of
500 bars loses some more; more than 50 always remain.
"""
EXACT_BITS = int(np.ceil(EXACT_DIGITS * np.log2(10.0)))
QUADRUPLE_BITS = 113  # of IEEE 754's binary128


@dataclass(frozen=True)
class Arithmetic:
    """Floating-point type and its functions."""

    name: str
    dtype: Any
    unit_roundoff: float
    sqrt: Function
    sin: Function
    cos: Function
    log1p: Function
    expm1: Function
    bits: int = field(default=EXACT_BITS, kw_only=True)
    """Of a multiple-precision type, in whose :meth:`numbers` it computes"""

    def cast(self, values: Values) -> Values:
        """Round `values` of any arithmetic to this type."""
        array = np.asarray(values)
        if self.dtype is not object:
            return from_exact(array, self.dtype) if array.dtype == object else array.astype(self.dtype)
        numbers = array if array.dtype == object else to_exact(array)
        return numbers if self.bits == EXACT_BITS else each(lambda x: gmpy2.mpfr(x, self.bits))(numbers)

    def numbers(self) -> Any:
        """Context in which operations of a multiple-precision type round to its bits; others need none."""
        return gmpy2.context(gmpy2.get_context(), precision=self.bits)

    def zeros(self, shape: tuple[int, ...]) -> Values:
        """Array of zeros."""
        return self.cast(np.zeros(shape))


def numpy_arithmetic(name: str, dtype: Any) -> Arithmetic:
    """Arithmetic of one of NumPy's types, rounding to nearest."""
    unit = float(np.finfo(dtype).eps) / 2.0
    return Arithmetic(name, dtype, unit, np.sqrt, np.sin, np.cos, np.log1p, np.expm1)


def each(function: Callable[[Any], Any]) -> Function:
    """Elementwise version of a function of one number."""
    found: Function = np.frompyfunc(function, 1, 1)
    return found


FLOAT32 = numpy_arithmetic("float32", np.float32)
FLOAT64 = numpy_arithmetic("float64", np.float64)
LONG = numpy_arithmetic("long double", np.longdouble)
OF_MANY_BITS = tuple(map(each, (gmpy2.sqrt, gmpy2.sin, gmpy2.cos, gmpy2.log1p, gmpy2.expm1)))
EXACT = Arithmetic("exact", object, 2.0**-EXACT_BITS, *OF_MANY_BITS)
QUADRUPLE = Arithmetic("quadruple", object, 2.0**-QUADRUPLE_BITS, *OF_MANY_BITS, bits=QUADRUPLE_BITS)
ARITHMETICS = {a.name: a for a in (FLOAT32, FLOAT64, LONG)}


def long_doubles() -> bool:
    """Whether this machine's long double is more precise than double; not so on all systems."""
    return LONG.unit_roundoff < FLOAT64.unit_roundoff


def exact_numbers() -> Any:
    """Context of :data:`EXACT`, which sets the precision of its functions."""
    return EXACT.numbers()


def to_exact(array: Values) -> Values:
    """Multiple-precision numbers equal to those of a NumPy type: a long double is the sum of two doubles."""
    high = array.astype(np.float64)
    low = (array - high).astype(np.float64)
    lift = np.frompyfunc(lambda h, rest: gmpy2.mpfr(h) + gmpy2.mpfr(rest), 2, 1)
    return np.asarray(lift(high, low), dtype=object)


def from_exact(array: Values, dtype: Any) -> Values:
    """Multiple-precision numbers rounded to a NumPy type, in two parts, so that a long double gets all its bits."""
    high = array.astype(np.float64)
    low = (array - high).astype(np.float64)
    return high.astype(dtype) + low.astype(dtype)
