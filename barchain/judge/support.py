"""Whether an engine supports what a scene turns out to do: limits that are known only from the motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from adapters.engine import Engine
    from barchain.solutions.reference import ReferenceSolution


def unsupported(engine: type[Engine], solution: ReferenceSolution) -> str | None:
    """Why an engine can't follow the reference solution of a scene, or None if it can."""
    return engine.unsupported_motion(solution.scene, solution.fine)
