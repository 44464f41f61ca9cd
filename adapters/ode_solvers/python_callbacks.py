"""C functions around Python functions of NumPy arrays, for a solver with a C interface."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.solver_driver import CFunctions

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.common.solver_driver import Problem
    from adapters.trajectory import Array

FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
FATAL = -1  # CVODE's code of an error from which no smaller step recovers


class PythonFunctions(CFunctions):
    """Functions of a problem; the problem counts the calls itself."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.size = problem, len(problem.y0)
        self.raised: BaseException | None = None
        self.kept = FUNCTION(self.put_rates), FUNCTION(self.put_height)
        self.rates, self.height = (address(f) for f in self.kept)
        self.user_data = 0

    def read_vectors(self, data_of: int) -> None:
        """Take the address of SUNDIALS' function from a vector to its numbers."""
        self.data_of = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p)(data_of)

    def numbers(self, vector: int) -> Array:
        """Numbers of a vector, (size,), not copied."""
        return view(self.data_of(vector), self.size)

    def put_rates(self, t_s: float, state: int, slopes: int, _user_data: int) -> int:
        """Evaluate the rates into a vector."""

        def put() -> None:
            self.numbers(slopes)[:] = self.problem.rate(t_s, self.numbers(state))

        return self.guarded(put)

    def put_height(self, t_s: float, state: int, out: int, _user_data: int) -> int:
        """Evaluate the height."""

        def put() -> None:
            view(out, 1)[0] = self.problem.height_at_event(t_s, self.numbers(state))

        return self.guarded(put)

    def guarded(self, put: Callable[[], None]) -> int:
        """Keep an exception for the caller of the solver: none crosses C code."""
        try:
            put()
        except BaseException as error:
            self.raised = error
            return FATAL
        return 0

    def counts(self) -> tuple[int, int]:
        """Nothing: the problem counts."""
        return 0, 0

    def failure(self) -> BaseException | None:
        """Exception in the equations since the last call."""
        found, self.raised = self.raised, None
        return found


def view(address: int, size: int) -> Array:
    """Numbers at an address, not copied."""
    found: Array = np.ctypeslib.as_array((ctypes.c_double * size).from_address(address))
    return found


def address(function: object) -> int:
    """Address of a C function."""
    found = ctypes.cast(function, ctypes.c_void_p).value  # type: ignore[arg-type]
    assert found is not None
    return found
