"""Support of a scene's motion by an engine: limits that only the judging solution shows."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from adapters.engine import Engine
    from barchain.solutions.reference import ReferenceSolution


def unsupported(engine: type[Engine], solution: ReferenceSolution) -> str | None:
    """Reason if an engine does not support the motion of the judging solution; None if it does."""
    return engine.unsupported_motion(solution.scene, solution.fine)
