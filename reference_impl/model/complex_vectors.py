"""Plane vectors as complex numbers: half the array operations, and a quarter turn is a product with i.

Outside, vectors are arrays of shape (..., 2); inside the hot path the same memory is seen as complex.
With conj(a) b = a·b + i (a × b), dot and cross product come from one multiplication.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray


def as_complex(vectors: Array) -> ComplexArray:
    """Vectors (..., 2) seen as complex numbers (...)."""
    seen: ComplexArray = np.ascontiguousarray(vectors).view(np.complex128)[..., 0]
    return seen


def as_vectors(numbers: ComplexArray) -> Array:
    """Complex numbers (...), at least one-dimensional, seen as vectors (..., 2)."""
    seen: Array = np.ascontiguousarray(numbers)[..., None].view(np.float64)
    return seen


def unit_along(angle_rad: Array) -> ComplexArray:
    """Unit vectors at the given angles; i times them are those across."""
    unit: ComplexArray = np.exp(1j * angle_rad)
    return unit


def squared_norm(numbers: ComplexArray) -> Array:
    """Squared lengths."""
    length: Array = numbers.real**2 + numbers.imag**2
    return length
