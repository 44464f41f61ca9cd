"""Drake adapter: Drake's plant, stepped by Drake's RK5 with error control."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

from adapters.bar_loads.joint_tree.engine import JointTreeEngine, reasons
from adapters.drake.integrator import DrakeIntegrator

if TYPE_CHECKING:
    from adapters.common.solver_driver import Solver
    from adapters.drake.chain import DrakeChain
    from adapters.trajectory import Array
    from scenarios import Scene


@final
class Drake(JointTreeEngine):
    """Joint coordinates, Drake's plant and integrator."""

    title = "Drake, joint coordinates in a freely falling frame, Drake's RK5 with error control"
    unsupported_reasons = reasons(
        "prescribed rotation is not supported: Drake locks a joint at rest only, and has no constraint that holds a "
        "bar to a law of time in a continuous plant"
    )

    def tree(self, scene: Scene) -> DrakeChain:
        """Drake's plant."""
        from adapters.drake.chain import DrakeChain

        return DrakeChain(scene)

    def solver(self, rtol: float, units: Array) -> Solver:
        """Drake's fifth-order Runge-Kutta method."""
        return DrakeIntegrator("runge_kutta5", rtol, units)
