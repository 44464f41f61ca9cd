"""IDA by its own C interface, which can leave algebraic components out of the error test; scikit-sundae's can't."""

from __future__ import annotations

import ctypes
from ctypes import POINTER, byref, c_double, c_int, c_void_p
from typing import TYPE_CHECKING

from adapters.common.sundials import NORMAL, CaughtErrors, Interface, SolverOutput, SundialsRun, address_of, view

if TYPE_CHECKING:
    from adapters.ida.chain import RedundantChain
    from adapters.trajectory import Array

POINTERS = {n: (c_void_p,) * n for n in (2, 4, 5)}
RESIDUAL = ctypes.CFUNCTYPE(c_int, c_double, *POINTERS[4])
JACOBIAN = ctypes.CFUNCTYPE(c_int, c_double, c_double, *POINTERS[5], c_void_p, c_void_p, c_void_p)
HEIGHT = ctypes.CFUNCTYPE(c_int, c_double, *POINTERS[4])


class Ida(SundialsRun):
    """One run of IDA on a chain, in the chain's units."""

    interface = Interface(
        "libsundials_ida",
        "IDA",
        (
            ("SUNDenseMatrix_Data", c_void_p, (c_void_p,)),
            ("IDACreate", c_void_p, (c_void_p,)),
            ("IDAInit", c_int, (c_void_p, c_void_p, c_double, c_void_p, c_void_p)),
            ("IDASVtolerances", c_int, (c_void_p, c_double, c_void_p)),
            ("IDASetInitStep", c_int, (c_void_p, c_double)),
            ("IDASetId", c_int, (c_void_p, c_void_p)),
            ("IDASetSuppressAlg", c_int, (c_void_p, c_int)),
            ("IDASetJacFn", c_int, (c_void_p, c_void_p)),
            ("IDASolve", c_int, (c_void_p, c_double, POINTER(c_double), c_void_p, c_void_p, c_int)),
        ),
    )

    def __init__(self, chain: RedundantChain, t: float, y: Array, slopes: Array, rtol: float, most_steps: int) -> None:
        """Prepare a run from a consistent state; each component is requested to `rtol` of its unit."""
        self.caught = CaughtErrors()
        super().__init__(y, self.caught.last)
        self.chain, self.slopes = chain, slopes.copy()
        self.evaluations = self.event_calls = 0
        self.differential = chain.differential.copy()
        self.kept = RESIDUAL(self.put_residual), JACOBIAN(self.put_jacobian), HEIGHT(self.put_height)
        residual, jacobian, height = map(address_of, self.kept)
        self.slopes_vector = self.vector(self.slopes)
        self.own_memory(self.lib.IDACreate(self.context))
        self.call("Init", residual, t, self.state, self.slopes_vector)
        self.tolerances = rtol * chain.shares
        self.call("SVtolerances", 0.0, self.vector(self.tolerances))
        self.call("SetInitStep", float(self.tolerances.min()) ** chain.start_power)
        self.call("SetId", self.vector(self.differential))
        self.call("SetSuppressAlg", 1)
        self.call("SetMaxNumSteps", most_steps)
        self.solve_by_newton()
        self.call("SetJacFn", jacobian)
        self.stop_at_surface(height)

    def run(self, instants: Array) -> SolverOutput:
        """Integrate through the instants (k,) in units of time.

        The last step goes past the end, with the loads of the segment: a step cut short would divide the errors of
        places by its own square, and the last multipliers would be wrong by a tenth.
        """

        def step(instant: float, reached: c_double) -> int:
            solve = self.lib.IDASolve
            code: int = solve(self.memory, instant, byref(reached), self.state, self.slopes_vector, NORMAL)
            return code

        return self.run_by("IDASolve", step, instants)

    def numbers(self, vector: int) -> Array:
        """Numbers of a vector, (size,), not copied."""
        return view(self.lib.N_VGetArrayPointer_Serial(vector), len(self.y))

    def put_residual(self, t: float, y: int, slopes: int, out: int, _user_data: int) -> int:
        """Evaluate the residual into a vector."""

        def put() -> None:
            self.evaluations += 1
            self.numbers(out)[:] = self.chain.residual(t, self.numbers(y), self.numbers(slopes))

        return self.caught.guarded(put)

    def put_jacobian(self, t: float, c: float, y: int, slopes: int, _residual: int, matrix: int, *_others: int) -> int:
        """Evaluate the Jacobian into a matrix, which SUNDIALS stores by columns."""

        def put() -> None:
            found = self.chain.jacobian(t, self.numbers(y), self.numbers(slopes), c)
            view(self.lib.SUNDenseMatrix_Data(matrix), found.size)[:] = found.T.ravel()

        return self.caught.guarded(put)

    def put_height(self, _t: float, y: int, _slopes: int, out: int, _user_data: int) -> int:
        """Evaluate the height."""

        def put() -> None:
            self.event_calls += 1
            view(out, 1)[0] = self.chain.height(self.numbers(y) * self.chain.units)

        return self.caught.guarded(put)
