"""DART adapter: DART's accelerations, stepped by SciPy's DOP853."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

from adapters.bar_loads.joint_tree.engine import JointTreeEngine, reasons

if TYPE_CHECKING:
    from adapters.dart.chain import DartChain
    from scenarios import Scene


@final
class Dart(JointTreeEngine):
    """Joint coordinates, DART's skeleton."""

    title = "DART, joint coordinates in a freely falling frame, ABA stepped by SciPy's DOP853"
    unsupported_reasons = reasons(
        "prescribed rotation is not supported: DART prescribes the angle between two bars, "
        "and a law here prescribes the angle of one bar"
    )

    def tree(self, scene: Scene) -> DartChain:
        """DART's skeleton."""
        from adapters.dart.chain import DartChain

        return DartChain(scene)
