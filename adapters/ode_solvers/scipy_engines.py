"""Engines of SciPy's solvers, on compiled rates and on rates in NumPy."""

from __future__ import annotations

from typing import ClassVar, final

from adapters.common.scipy_solver import Method, ScipySolver
from adapters.engine import AccuracyParameter, AccuracySweep
from adapters.ode_solvers.engine import CompiledSolverEngine, SolverEngine


class ScipyEngine(SolverEngine):
    """Common part of all methods of `solve_ivp`."""

    method: ClassVar[Method]

    def solver(self, rtol: float, atol: float) -> ScipySolver:
        """`solve_ivp` with this method."""
        return ScipySolver(self.method, rtol, atol)


class ScipyRK45Method(ScipyEngine):
    """The default of `solve_ivp`."""

    method = "RK45"
    sweep = AccuracySweep(
        AccuracyParameter.RTOL,
        (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11),
        default=1e-8,
        finer_rtol=0.01,  # on paper/fig05 the errors at 1e-8 and 1e-9 differ by a factor of 2 only: no error estimate
    )


class ScipyDop853Method(ScipyEngine):
    """The method of highest order in `solve_ivp`."""

    method = "DOP853"


class ScipyRadauMethod(ScipyEngine):
    """Implicit, for stiff problems; the free chain is not stiff."""

    method = "Radau"
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10), default=1e-7)


class ScipyLsodaMethod(ScipyEngine):
    """Adams and BDF, switched automatically."""

    method = "LSODA"
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), default=1e-10
    )


@final
class ScipyRK45(CompiledSolverEngine, ScipyRK45Method):
    """RK45 on compiled rates."""

    title = "SciPy's RK45 on the compiled reference's equations"


@final
class ScipyDop853(CompiledSolverEngine, ScipyDop853Method):
    """DOP853 on compiled rates."""

    title = "SciPy's DOP853 on the compiled reference's equations"


@final
class ScipyRadau(CompiledSolverEngine, ScipyRadauMethod):
    """Radau on compiled rates."""

    title = "SciPy's Radau on the compiled reference's equations"


@final
class ScipyLsoda(CompiledSolverEngine, ScipyLsodaMethod):
    """LSODA on compiled rates."""

    title = "SciPy's LSODA on the compiled reference's equations"


@final
class ScipyRK45NumPy(ScipyRK45Method):
    """RK45 on rates in NumPy."""

    title = "SciPy's RK45 on the NumPy reference's equations"


@final
class ScipyDop853NumPy(ScipyDop853Method):
    """DOP853 on rates in NumPy."""

    title = "SciPy's DOP853 on the NumPy reference's equations"


@final
class ScipyRadauNumPy(ScipyRadauMethod):
    """Radau on rates in NumPy."""

    title = "SciPy's Radau on the NumPy reference's equations"


@final
class ScipyLsodaNumPy(ScipyLsodaMethod):
    """LSODA on rates in NumPy."""

    title = "SciPy's LSODA on the NumPy reference's equations"
