"""Engines of SciPy's solvers."""

from __future__ import annotations

from typing import ClassVar, final

from adapters.engine import AccuracyParameter, AccuracySweep
from adapters.ode_solvers.engine import SolverEngine
from adapters.ode_solvers.scipy_solver import Method, ScipySolver


class ScipyEngine(SolverEngine):
    """Common part of all methods of `solve_ivp`."""

    method: ClassVar[Method]

    def solver(self, rtol: float, atol: float) -> ScipySolver:
        """`solve_ivp` with this method."""
        return ScipySolver(self.method, rtol, atol)


@final
class ScipyRK45(ScipyEngine):
    """The default of `solve_ivp`."""

    title = "SciPy's RK45 on the reference's equations"
    method = "RK45"
    sweep = AccuracySweep(
        AccuracyParameter.RTOL,
        (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11),
        default=1e-8,
        finer_rtol=0.01,  # on paper/fig05 the errors at 1e-8 and 1e-9 differ by a factor of 2 only: no error estimate
    )


@final
class ScipyDop853(ScipyEngine):
    """The method of highest order in `solve_ivp`."""

    title = "SciPy's DOP853 on the reference's equations"
    method = "DOP853"


@final
class ScipyRadau(ScipyEngine):
    """Implicit, for stiff problems; the free chain is not stiff."""

    title = "SciPy's Radau on the reference's equations"
    method = "Radau"
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10), default=1e-7)


@final
class ScipyLsoda(ScipyEngine):
    """Adams and BDF, switched automatically."""

    title = "SciPy's LSODA on the reference's equations"
    method = "LSODA"
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), default=1e-10
    )
