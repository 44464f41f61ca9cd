"""SUNDIALS' solvers by their own C interface, from the libraries that scikit-sundae brings along.

scikit-sundae's own interface calls the equations as Python functions of NumPy arrays, and leaves out some settings.
"""

from __future__ import annotations

import ctypes
from contextlib import ExitStack
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_int64, c_long, c_void_p
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from adapters.engine import EngineError

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array

DISTRIBUTION = "scikit-sundae"
FATAL = -1  # code of an error from which no smaller step recovers
NORMAL = 1  # steps past the requested instant, and interpolates
ROOT_RETURN = 2
EVERY_SOLVER = {
    "SUNContext_Create": (c_int, (c_int, POINTER(c_void_p))),
    "SUNContext_ClearErrHandlers": (c_int, (c_void_p,)),
    "SUNContext_Free": (c_int, (POINTER(c_void_p),)),
    "N_VMake_Serial": (c_void_p, (c_int64, c_void_p, c_void_p)),
    "N_VGetArrayPointer_Serial": (c_void_p, (c_void_p,)),
    "N_VDestroy": (None, (c_void_p,)),
    "SUNDenseMatrix": (c_void_p, (c_int64, c_int64, c_void_p)),
    "SUNMatDestroy": (None, (c_void_p,)),
    "SUNLinSol_Dense": (c_void_p, (c_void_p, c_void_p, c_void_p)),
    "SUNLinSolFree": (c_int, (c_void_p,)),
}
"""Result and arguments of the functions that all solvers' libraries have"""
WITH_PREFIX = {
    "SetUserData": (c_int, (c_void_p, c_void_p)),
    "SetLinearSolver": (c_int, (c_void_p, c_void_p, c_void_p)),
    "SetMaxNumSteps": (c_int, (c_void_p, c_long)),
    "SetStopTime": (c_int, (c_void_p, c_double)),
    "RootInit": (c_int, (c_void_p, c_int, c_void_p)),
    "SetRootDirection": (c_int, (c_void_p, POINTER(c_int))),
    "GetNumSteps": (c_int, (c_void_p, POINTER(c_long))),
    "GetNumJacEvals": (c_int, (c_void_p, POINTER(c_long))),
    "GetReturnFlagName": (c_char_p, (c_long,)),
    "Free": (None, (POINTER(c_void_p),)),
}
"""Those that each solver has under its own prefix"""


@dataclass(frozen=True)
class Interface:
    """Functions of one of SUNDIALS' solvers, for which their arguments are declared."""

    file: str
    """Beginning of the name of the library's file"""
    prefix: str
    """Of the names of the solver's functions"""
    own: tuple[tuple[str, object, tuple[object, ...]], ...]
    """Further functions with their result and arguments"""

    @cache  # noqa: B019  (one for each solver, and as long as the process)
    def library(self) -> ctypes.CDLL:
        """Library with its functions declared.

        Raises
        ------
        EngineError
            If the distribution brings no such library along.
        """
        try:
            found = [f for f in files(DISTRIBUTION) or () if f.name.startswith(self.file)]
        except PackageNotFoundError:
            found = []
        if not found:
            raise EngineError(f"{DISTRIBUTION} has no file {self.file}*; a wheel of {DISTRIBUTION} brings it along")
        loaded = ctypes.CDLL(str(found[0].locate()))
        named = EVERY_SOLVER | {self.prefix + name: types for name, types in WITH_PREFIX.items()}
        for name, (result, arguments) in (named | {name: types for name, *types in self.own}).items():
            function = getattr(loaded, name)
            function.restype, function.argtypes = result, arguments
        return loaded


@dataclass(frozen=True)
class SolverOutput:
    """States at the requested instants, as far as the solver got."""

    y: Array
    """(k, size)"""
    stopped_s: float | None
    """Instant of the event"""
    steps: int
    jacobians: int


class CaughtErrors:
    """Exceptions of functions in Python that C code calls, kept for the caller of the solver: none crosses C code."""

    def __init__(self) -> None:
        self.raised: BaseException | None = None

    def guarded(self, put: Callable[[], None]) -> int:
        """Call a function, and give SUNDIALS its code."""
        try:
            put()
        except BaseException as error:
            self.raised = error
            return FATAL
        return 0

    def last(self) -> BaseException | None:
        """Exception since the last call, or None."""
        found, self.raised = self.raised, None
        return found


class SundialsRun:
    """One run of a solver; :meth:`close` frees its memory."""

    interface: ClassVar[Interface]

    def __init__(self, y: Array, failure: Callable[[], BaseException | None]) -> None:
        """Make a context and the vector of a state.

        Parameters
        ----------
        y : ndarray, shape (size,)
        failure : callable
            Gives the exception of the equations since its last call, or None.
        """
        self.lib, self.failure, self.y = self.interface.library(), failure, np.array(y)
        self.owned, self.context, self.memory = ExitStack(), c_void_p(), c_void_p()
        self.check("SUNContext_Create", self.lib.SUNContext_Create(0, byref(self.context)))
        self.owned.callback(lambda: self.lib.SUNContext_Free(byref(self.context)))
        self.lib.SUNContext_ClearErrHandlers(self.context)  # a failure is an exception here, and prints nothing
        self.state = self.vector(self.y)

    def vector(self, values: Array) -> int:
        """Vector of the library on an array, which must live as long."""
        return self.made(self.lib.N_VMake_Serial(len(values), values.ctypes.data, self.context), self.lib.N_VDestroy)

    def made(self, thing: int, free: Callable[[int], object]) -> int:
        """Own an object of the library."""
        self.owned.callback(free, thing)
        return thing

    def own_memory(self, memory: int) -> None:
        """Own the solver's memory."""
        self.memory = c_void_p(memory)
        self.owned.callback(lambda: self.function("Free")(byref(self.memory)))

    def function(self, name: str) -> Callable[..., int]:
        """Function of the solver, its name without the prefix."""
        found: Callable[..., int] = getattr(self.lib, self.interface.prefix + name)
        return found

    def call(self, name: str, *arguments: object) -> None:
        """Call a function on the solver's memory, and check its code."""
        self.check(self.interface.prefix + name, self.function(name)(self.memory, *arguments))

    def check(self, name: str, code: int) -> None:
        """Raise the exception of the equations, or that of a failed call."""
        if code >= 0:
            return
        raised = self.failure()
        if raised is not None:
            raise raised
        said = getattr(self.lib, f"{self.interface.prefix}GetReturnFlagName")(code) or b""
        raise EngineError(f"{name} failed: {said.decode()}")

    def solve_by_newton(self) -> None:
        """Solve each implicit step by Newton's method, with a dense Jacobian; by differences unless one is set."""
        size, lib = len(self.y), self.lib
        matrix = self.made(lib.SUNDenseMatrix(size, size, self.context), lib.SUNMatDestroy)
        solver = self.made(lib.SUNLinSol_Dense(self.state, matrix, self.context), lib.SUNLinSolFree)
        self.call("SetLinearSolver", solver, matrix)

    def stop_at_surface(self, height: int) -> None:
        """End the run where the height, by the function at this address, falls through zero."""
        self.call("RootInit", 1, height)
        self.call("SetRootDirection", byref(c_int(-1)))

    def run_by(self, name: str, step: Callable[[float, c_double], int], instants: Array) -> SolverOutput:
        """Integrate through the instants (k,) by a function of that name.

        Raises
        ------
        EngineError
            If the solver fails; an exception of the equations is raised itself.
        """
        rows, reached, stopped = [], c_double(), None
        for instant in instants.tolist():
            code = step(instant, reached)
            self.check(name, code)
            if code == ROOT_RETURN:
                stopped = reached.value
                break
            rows.append(self.y.copy())
        found = np.array(rows).reshape(len(rows), len(self.y))
        return SolverOutput(found, stopped, self.count("GetNumSteps"), self.count("GetNumJacEvals"))

    def count(self, name: str) -> int:
        """One of the solver's counts; 0 where it has none."""
        found = c_long(0)
        self.function(name)(self.memory, byref(found))
        return found.value

    def close(self) -> None:
        """Free the solver."""
        self.owned.close()


def address_of(function: object) -> int:
    """Address of a C function."""
    found = ctypes.cast(function, c_void_p).value  # type: ignore[arg-type]
    assert found is not None
    return found


def view(address: int, size: int) -> Array:
    """Numbers at an address, not copied."""
    found: Array = np.ctypeslib.as_array((ctypes.c_double * size).from_address(address))
    return found
