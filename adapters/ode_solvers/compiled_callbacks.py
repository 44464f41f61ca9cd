"""C functions that CVODE calls: a chain's rates and its height above the surface, with no Python in between.

CVODE passes vectors as `N_Vector` and a struct, :class:`CvodeData`, as `user_data`. A SUNDIALS function gives the
address of a vector's numbers, which the compiled rates then read and write in place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.solver_driver import CFunctions
from reference_impl.machine_code.functions import compiled, through_address
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Struct, Vector
from reference_impl.model.joints import NOT_POSITIVE_DEFINITE

if TYPE_CHECKING:
    from adapters.ode_solvers.compiled_rates import RatesFunction
    from adapters.trajectory import Array

EVALUATIONS, EVENT_CALLS, LOST = range(3)  # of CvodeData.counts
GOOD, FATAL = 0, -1  # CVODE's codes; after the second no smaller step is tried
FAR = 1e300  # m


@dataclass(frozen=True)
class ChainShape(Struct):
    """Numbers of a chain in its height above the surface."""

    half_m: Vector
    """(N,)"""
    weight: Vector
    """(N,)"""
    body_radius_m: float


@dataclass(frozen=True)
class CvodeData(Struct):
    """CVODE's `user_data`."""

    data_of: int
    """Address of SUNDIALS' function from a vector to its numbers"""
    evaluate: int
    """Address of the compiled rates"""
    put_height: int
    """Address of :func:`put_height`"""
    size: int
    """Number of components of a state"""
    chain: int
    """Address of the compiled chain"""
    work: int
    """Address of its workspace"""
    shape: int
    """Address of the chain's :class:`ChainShape`"""
    counts: Vector
    """(3,) EVALUATIONS, EVENT_CALLS, and LOST: 1 after a joint was lost in round-off"""


@through_address
def data_of(address: int, vector: int) -> int:
    """Address of a vector's numbers."""
    raise NotImplementedError


@through_address
def evaluate(address: int, t_s: float, y: int, y_size: int, rates: int, rates_size: int, chain: int, work: int) -> bool:
    """Compiled rates, with addresses instead of arrays and structs."""
    raise NotImplementedError


@through_address
def put_height_at(address: int, y: int, y_size: int, out: int, out_size: int, shape: int) -> None:
    """:func:`put_height`, with addresses instead of arrays and structs."""


@compiled
def lowest_height(y: Vector, shape: ChainShape) -> float:
    """Least distance of any point of a chain from the surface, m.

    Parameters
    ----------
    y : ndarray, shape (2N+4,)
        State in the compiled order: angles, then the centre of mass.
    shape : ChainShape
    """
    n, x, z, mean_x, mean_z = len(shape.half_m), 0.0, 0.0, 0.0, 0.0
    for i in range(1, n):
        x += shape.half_m[i - 1] * math.cos(y[i - 1]) + shape.half_m[i] * math.cos(y[i])
        z += shape.half_m[i - 1] * math.sin(y[i - 1]) + shape.half_m[i] * math.sin(y[i])
        mean_x += shape.weight[i] * x
        mean_z += shape.weight[i] * z
    x, z, least = y[n] - mean_x, y[n + 1] - mean_z, FAR
    for i in range(n):
        ux, uz, half = math.cos(y[i]), math.sin(y[i]), shape.half_m[i]
        if i > 0:
            x += half * ux + shape.half_m[i - 1] * math.cos(y[i - 1])
            z += half * uz + shape.half_m[i - 1] * math.sin(y[i - 1])
        foot = min(max(-(ux * x + uz * z), -half), half)  # nearest point of the bar, from its centre
        least = min(least, math.hypot(x + foot * ux, z + foot * uz))
    return least - shape.body_radius_m


@compiled
def put_height(y: Vector, out: Vector, shape: ChainShape) -> None:
    """Height of a chain into an array of one number."""
    out[0] = lowest_height(y, shape)


@compiled
def cvode_rates(t_s: float, state: int, slopes: int, own: CvodeData) -> int:
    """CVODE's right-hand side."""
    own.counts[EVALUATIONS] += 1.0
    y, out = data_of(own.data_of, state), data_of(own.data_of, slopes)
    if evaluate(own.evaluate, t_s, y, own.size, out, own.size, own.chain, own.work):
        return GOOD
    own.counts[LOST] = 1.0
    return FATAL


@compiled
def cvode_height(t_s: float, state: int, out: int, own: CvodeData) -> int:
    """CVODE's event function."""
    own.counts[EVENT_CALLS] += 1.0
    put_height_at(own.put_height, data_of(own.data_of, state), own.size, out, 1, own.shape)
    return GOOD


Library("cvode", (lowest_height, put_height, cvode_rates, cvode_height))


class CompiledFunctions(CFunctions):
    """Compiled functions of one chain."""

    def __init__(self, function: RatesFunction) -> None:
        """Compile the functions, or load them from the cache."""
        self.function, model = function, function.model
        self.shape = ChainShape(model.half_m, model.weight, float(model.body_radius_m))
        self.counted = np.zeros(3)
        self.rates: int = cvode_rates.address  # type: ignore[attr-defined]
        self.height: int = cvode_height.address  # type: ignore[attr-defined]

    def height_m(self, y: Array) -> float:
        """Least distance of the chain from the surface, m; `y` (size,) in the compiled order."""
        return lowest_height(np.ascontiguousarray(y), self.shape)

    def read_vectors(self, data_of: int) -> None:
        """Take the address of SUNDIALS' function from a vector to its numbers."""
        own = self.function
        place: int = put_height.address  # type: ignore[attr-defined]
        chain, work, shape = own.chain.address, own.work.address, self.shape.address
        self.data = CvodeData(data_of, own.address, place, own.size, chain, work, shape, self.counted)
        self.user_data = self.data.address

    def counts(self) -> tuple[int, int]:
        """Evaluations of the rates and of the height since the last call."""
        found = int(self.counted[EVALUATIONS]), int(self.counted[EVENT_CALLS])
        self.counted[[EVALUATIONS, EVENT_CALLS]] = 0.0
        return found

    def failure(self) -> Exception | None:
        """Exception of the last run's equations."""
        if self.counted[LOST] == 0.0:
            return None
        self.counted[LOST] = 0.0
        return np.linalg.LinAlgError(NOT_POSITIVE_DEFINITE)
