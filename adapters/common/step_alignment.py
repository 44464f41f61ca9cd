"""Instants at which something jumps, for engines of equal steps: each has to fall on a step's end."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Impulse, Scene

SLACK = 1e-9  # of half a sample interval: an instant this near to a step's end is on it


def misalignment(scene: Scene) -> str | None:
    """Why equal steps would straddle a jump of `scene`, or None if they do not.

    Steps are even in number from sample to sample, so that a sample and the middle between two are steps' ends whatever
    their number is.
    """
    half = 0.5 * scene.run.duration_s / (scene.run.samples - 1)
    for t in inner_events_s(scene):
        if abs(t / half - round(t / half)) > SLACK:
            return (
                f"a jump at t = {t:g} s: equal steps would straddle it; "
                f"allowed: at a sample or midway between two, multiples of {half:g} s"
            )
    return None


def inner_events_s(scene: Scene) -> list[float]:
    """Jumps within the run; what jumps at its very ends is before it or after it."""
    slack = SLACK * scene.run.duration_s / scene.run.samples
    return [t for t in scene.effects.breaks_s if slack < t < scene.run.duration_s - slack]


def events_by_step(scene: Scene, dt_s: float) -> dict[int, tuple[Impulse, ...]]:
    """Steps at whose end something jumps, with the blows that fall there; 0 only where there are some."""
    found: dict[int, tuple[Impulse, ...]] = {round(t / dt_s): () for t in inner_events_s(scene)}
    steps = round(scene.run.duration_s / dt_s)
    for blow in scene.effects.impulse:
        step = round(blow.at_s / dt_s)
        if 0 <= step < steps:
            found[step] = (*found.get(step, ()), blow)
    return found
