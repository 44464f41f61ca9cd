"""Whether a run ends at the event that ends the reference solution."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from barchain.solutions.reference import Truth


def ended_differently(seen: Trajectory, truth: Truth) -> str | None:
    """Say why, if a run and the reference solution do not end at the same event, to one sample."""
    run, right = truth.scene.run, truth.trajectory
    spacing = run.duration_s / (run.samples - 1)
    apart = abs(len(seen.t_s) - len(right.t_s))
    if apart <= 1 and bool(seen.ended) == bool(right.ended) and (len(seen.t_s) > 1 or len(right.t_s) == 1):
        return None
    return (
        f"ended {apart * spacing:.3g} s apart from the reference: "
        f"{seen.ended or 'at its last sample'}; reference: "
        f"{right.ended or 'at its last sample'}"
    )
