"""Engines of SciPy's solvers."""

from __future__ import annotations

from typing import ClassVar, final

from adapters.common.scipy_solver import Method, ScipySolver
from adapters.engine import AccuracyParameter, AccuracySweep
from adapters.ode_solvers.engine import SolverEngine


class ScipyEngine(SolverEngine):
    """Common part of all methods of `solve_ivp`."""

    method: ClassVar[Method]

    def solver(self, rtol: float, atol: float) -> ScipySolver:
        """`solve_ivp` with this method."""
        return ScipySolver(self.method, rtol, atol)


@final
class ScipyDop853(ScipyEngine):
    """The method of highest order in `solve_ivp`."""

    title = "SciPy's DOP853 on the compiled reference's equations"
    method = "DOP853"


@final
class ScipyRadau(ScipyEngine):
    """Implicit, for stiff problems; the free chain is not stiff."""

    title = "SciPy's Radau on the compiled reference's equations"
    method = "Radau"
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10), default=1e-7)
