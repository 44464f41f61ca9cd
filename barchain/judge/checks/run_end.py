"""Whether a run ends at the event that ends the judging solution."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from barchain.solutions.reference import ReferenceSolution


def end_event_fault(trajectory: Trajectory, solution: ReferenceSolution) -> str | None:
    """Reason if a run and the judging solution do not end at the same event, to one sample; None if they do."""
    run, right = solution.scene.run, solution.trajectory
    spacing = run.duration_s / (run.samples - 1)
    apart = abs(len(trajectory.t_s) - len(right.t_s))
    if apart <= 1 and bool(trajectory.ended) == bool(right.ended) and (len(trajectory.t_s) > 1 or len(right.t_s) == 1):
        return None
    return (
        f"ended {apart * spacing:.3g} s apart from the reference: "
        f"{trajectory.ended or 'at its last sample'}; reference: "
        f"{right.ended or 'at its last sample'}"
    )
