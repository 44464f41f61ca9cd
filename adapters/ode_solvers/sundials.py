"""CVODE by its own C interface: the library that scikit-sundae brings along, called with addresses of C functions.

scikit-sundae's own interface calls the right-hand side as a Python function of NumPy arrays. That call takes as long as
ten evaluations of five bars.
"""

from __future__ import annotations

import ctypes
from contextlib import ExitStack
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_int64, c_long, c_void_p
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, files
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.solver_driver import CFunctions
from adapters.engine import EngineError

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.common.solver_driver import Problem
    from adapters.trajectory import Array

DISTRIBUTION, LIBRARY = "scikit-sundae", "libsundials_cvode"
ADAMS, BDF = 1, 2
NORMAL = 1  # steps past the requested instant, and interpolates
ROOT_RETURN, TIME_STOP = 2, 1
FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
FATAL = -1  # CVODE's code of an error from which no smaller step recovers
SIGNATURES: dict[str, tuple[object, tuple[object, ...]]] = {
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
    "SUNNonlinSol_FixedPoint": (c_void_p, (c_void_p, c_int, c_void_p)),
    "SUNNonlinSolFree": (c_int, (c_void_p,)),
    "CVodeCreate": (c_void_p, (c_int, c_void_p)),
    "CVodeInit": (c_int, (c_void_p, c_void_p, c_double, c_void_p)),
    "CVodeSStolerances": (c_int, (c_void_p, c_double, c_double)),
    "CVodeSetUserData": (c_int, (c_void_p, c_void_p)),
    "CVodeSetLinearSolver": (c_int, (c_void_p, c_void_p, c_void_p)),
    "CVodeSetNonlinearSolver": (c_int, (c_void_p, c_void_p)),
    "CVodeSetMaxNumSteps": (c_int, (c_void_p, c_long)),
    "CVodeSetStopTime": (c_int, (c_void_p, c_double)),
    "CVodeRootInit": (c_int, (c_void_p, c_int, c_void_p)),
    "CVodeSetRootDirection": (c_int, (c_void_p, POINTER(c_int))),
    "CVode": (c_int, (c_void_p, c_double, c_void_p, POINTER(c_double), c_int)),
    "CVodeGetNumSteps": (c_int, (c_void_p, POINTER(c_long))),
    "CVodeGetNumJacEvals": (c_int, (c_void_p, POINTER(c_long))),
    "CVodeGetReturnFlagName": (c_char_p, (c_long,)),
    "CVodeFree": (None, (POINTER(c_void_p),)),
}


@cache
def library() -> ctypes.CDLL:
    """SUNDIALS' library with its functions declared.

    Raises
    ------
    EngineError
        If the distribution brings no such library along.
    """
    try:
        found = [f for f in files(DISTRIBUTION) or () if f.name.startswith(LIBRARY)]
    except PackageNotFoundError:
        found = []
    if not found:
        raise EngineError(f"{DISTRIBUTION} has no file {LIBRARY}*; a wheel of {DISTRIBUTION} brings it along")
    loaded = ctypes.CDLL(str(found[0].locate()))
    for name, (result, arguments) in SIGNATURES.items():
        function = getattr(loaded, name)
        function.restype, function.argtypes = result, arguments
    return loaded


@dataclass(frozen=True)
class CvodeOutput:
    """States at the requested instants, as far as CVODE got."""

    y: Array
    """(k, size)"""
    stopped_s: float | None
    """Instant of the event"""
    steps: int
    jacobians: int


class Cvode:
    """One run of CVODE; :meth:`close` frees its memory."""

    def __init__(self, method: int, functions: CFunctions, y: Array, start_s: float) -> None:
        """Prepare a run from the state `y` (size,) at `start_s`."""
        self.lib, self.functions, self.y = library(), functions, np.array(y)
        functions.read_vectors(address_of(self.lib.N_VGetArrayPointer_Serial))
        self.owned, self.context, self.memory = ExitStack(), c_void_p(), c_void_p()
        self.check("SUNContext_Create", self.lib.SUNContext_Create(0, byref(self.context)))
        self.owned.callback(lambda: self.lib.SUNContext_Free(byref(self.context)))
        self.lib.SUNContext_ClearErrHandlers(self.context)  # a failure is an exception here, and prints nothing
        self.state = self.made(self.lib.N_VMake_Serial(len(y), self.y.ctypes.data, self.context), self.lib.N_VDestroy)
        self.memory = c_void_p(self.lib.CVodeCreate(method, self.context))
        self.owned.callback(lambda: self.lib.CVodeFree(byref(self.memory)))
        self.call("CVodeInit", functions.rates, start_s, self.state)
        self.call("CVodeSetUserData", functions.user_data)

    def made(self, thing: int, free: Callable[[int], object]) -> int:
        """Own an object of the library."""
        self.owned.callback(free, thing)
        return thing

    def call(self, name: str, *arguments: object) -> None:
        """Call a function on the solver's memory, and check its code."""
        self.check(name, getattr(self.lib, name)(self.memory, *arguments))

    def check(self, name: str, code: int) -> None:
        """Raise the exception of the equations, or that of a failed call."""
        if code >= 0:
            return
        raised = self.functions.failure()
        if raised is not None:
            raise raised
        said = self.lib.CVodeGetReturnFlagName(code) or b""
        raise EngineError(f"{name} failed: {said.decode()}")

    def set_tolerances(self, rtol: float, atol: float, most_steps: int) -> None:
        """Set the tolerances of all components, and the number of steps allowed between two instants."""
        self.call("CVodeSStolerances", rtol, atol)
        self.call("CVodeSetMaxNumSteps", most_steps)

    def solve_by_newton(self) -> None:
        """Solve each implicit step by Newton's method, with a dense Jacobian by differences."""
        size, lib = len(self.y), self.lib
        matrix = self.made(lib.SUNDenseMatrix(size, size, self.context), lib.SUNMatDestroy)
        solver = self.made(lib.SUNLinSol_Dense(self.state, matrix, self.context), lib.SUNLinSolFree)
        self.call("CVodeSetLinearSolver", solver, matrix)

    def solve_by_iteration(self) -> None:
        """Solve each implicit step by fixed-point iteration, as SUNDIALS advises for problems that are not stiff."""
        solver = self.lib.SUNNonlinSol_FixedPoint(self.state, 0, self.context)
        self.call("CVodeSetNonlinearSolver", self.made(solver, self.lib.SUNNonlinSolFree))

    def stop_at_surface(self) -> None:
        """End the run where the height falls through zero."""
        self.call("CVodeRootInit", 1, self.functions.height)
        self.call("CVodeSetRootDirection", byref(c_int(-1)))

    def run(self, instants_s: Array) -> CvodeOutput:
        """Integrate through the instants (k,); no step goes past the last.

        Raises
        ------
        EngineError
            If CVODE fails; an exception of the equations is raised itself.
        """
        self.call("CVodeSetStopTime", float(instants_s[-1]))
        rows, reached, stopped = [], c_double(), None
        for instant in instants_s.tolist():
            code = self.lib.CVode(self.memory, instant, self.state, byref(reached), NORMAL)
            self.check("CVode", code)
            if code == ROOT_RETURN:
                stopped = reached.value
                break
            rows.append(self.y.copy())
        found = np.array(rows).reshape(len(rows), len(self.y))
        return CvodeOutput(found, stopped, self.count("CVodeGetNumSteps"), self.count("CVodeGetNumJacEvals"))

    def count(self, name: str) -> int:
        """One of the solver's counts; 0 where it has none."""
        found = c_long(0)
        getattr(self.lib, name)(self.memory, byref(found))
        return found.value

    def close(self) -> None:
        """Free the solver."""
        self.owned.close()


def address_of(function: object) -> int:
    """Address of a C function."""
    found = ctypes.cast(function, c_void_p).value  # type: ignore[arg-type]
    assert found is not None
    return found


class PythonFunctions(CFunctions):
    """Functions of a problem; the problem counts the calls itself."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.size = problem, len(problem.y0)
        self.raised: BaseException | None = None
        self.kept = FUNCTION(self.put_rates), FUNCTION(self.put_height)
        self.rates, self.height = (address_of(f) for f in self.kept)
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
