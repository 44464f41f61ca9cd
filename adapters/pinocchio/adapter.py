"""Pinocchio adapter: Pinocchio's accelerations, stepped by SciPy's DOP853."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

from adapters.bar_loads.joint_tree.engine import JointTreeEngine, reasons

if TYPE_CHECKING:
    from adapters.pinocchio.chain import PinocchioChain
    from scenarios import Scene


@final
class Pinocchio(JointTreeEngine):
    """Joint coordinates, articulated-body algorithm."""

    title = "Pinocchio, joint coordinates in a freely falling frame, ABA stepped by SciPy's DOP853"
    unsupported_reasons = reasons(
        "prescribed rotation is not supported: Pinocchio's forward dynamics takes torques and does not find the torque "
        "that holds a bar to its law"
    )

    def tree(self, scene: Scene) -> PinocchioChain:
        """Pinocchio's model."""
        from adapters.pinocchio.chain import PinocchioChain

        return PinocchioChain(scene)
