"""CVODE by its own C interface, called with addresses of C functions.

A call of a Python function of NumPy arrays takes as long as ten evaluations of five bars.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, byref, c_double, c_int, c_void_p
from typing import TYPE_CHECKING

from adapters.common.solver_driver import CFunctions
from adapters.common.sundials import NORMAL, CaughtErrors, Interface, SolverOutput, SundialsRun, address_of, view

if TYPE_CHECKING:
    from adapters.common.solver_driver import Problem
    from adapters.trajectory import Array

ADAMS, BDF = 1, 2
FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class Cvode(SundialsRun):
    """One run of CVODE."""

    interface = Interface(
        "libsundials_cvode",
        "CVode",
        (
            ("SUNNonlinSol_FixedPoint", c_void_p, (c_void_p, c_int, c_void_p)),
            ("SUNNonlinSolFree", c_int, (c_void_p,)),
            ("CVodeCreate", c_void_p, (c_int, c_void_p)),
            ("CVodeInit", c_int, (c_void_p, c_void_p, c_double, c_void_p)),
            ("CVodeSStolerances", c_int, (c_void_p, c_double, c_double)),
            ("CVodeSetNonlinearSolver", c_int, (c_void_p, c_void_p)),
            ("CVode", c_int, (c_void_p, c_double, c_void_p, POINTER(c_double), c_int)),
        ),
    )

    def __init__(self, method: int, functions: CFunctions, y: Array, start_s: float) -> None:
        """Prepare a run from the state `y` (size,) at `start_s`."""
        super().__init__(y, functions.failure)
        self.functions = functions
        functions.read_vectors(address_of(self.lib.N_VGetArrayPointer_Serial))
        self.own_memory(self.lib.CVodeCreate(method, self.context))
        self.call("Init", functions.rates, start_s, self.state)
        self.call("SetUserData", functions.user_data)

    def set_tolerances(self, rtol: float, atol: float, most_steps: int) -> None:
        """Set the tolerances of all components, and the number of steps allowed between two instants."""
        self.call("SStolerances", rtol, atol)
        self.call("SetMaxNumSteps", most_steps)

    def solve_by_iteration(self) -> None:
        """Solve each implicit step by fixed-point iteration, as SUNDIALS advises for problems that are not stiff."""
        solver = self.lib.SUNNonlinSol_FixedPoint(self.state, 0, self.context)
        self.call("SetNonlinearSolver", self.made(solver, self.lib.SUNNonlinSolFree))

    def run(self, instants_s: Array) -> SolverOutput:
        """Integrate through the instants (k,); no step goes past the last.

        Raises
        ------
        EngineError
            If CVODE fails; an exception of the equations is raised itself.
        """
        self.call("SetStopTime", float(instants_s[-1]))

        def step(instant: float, reached: c_double) -> int:
            code: int = self.lib.CVode(self.memory, instant, self.state, byref(reached), NORMAL)
            return code

        return self.run_by("CVode", step, instants_s)


class PythonFunctions(CFunctions):
    """Functions of a problem; the problem counts the calls itself."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.size = problem, len(problem.y0)
        self.caught = CaughtErrors()
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

        return self.caught.guarded(put)

    def put_height(self, t_s: float, state: int, out: int, _user_data: int) -> int:
        """Evaluate the height."""

        def put() -> None:
            view(out, 1)[0] = self.problem.height_at_event(t_s, self.numbers(state))

        return self.caught.guarded(put)

    def counts(self) -> tuple[int, int]:
        """Nothing: the problem counts."""
        return 0, 0

    def failure(self) -> BaseException | None:
        """Exception in the equations since the last call."""
        return self.caught.last()
