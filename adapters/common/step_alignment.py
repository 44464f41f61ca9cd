"""Alignment of events with equal steps: each event must coincide with the end of a step."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenarios import Impulse, Scene

NO_SHADOW = "solar_pressure.shadow is not supported: equal steps straddle the shadow's edge, where the light jumps"
SLACK = 1e-9  # relative to half a sample interval: distance up to which an event coincides with a step's end


def misalignment(scene: Scene) -> str | None:
    """Reason why equal steps do not support the events of `scene`; None if they do.

    The number of steps between two samples is even. A sample and the midpoint between two samples are therefore ends of
    steps at every setting.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    str or None
    """
    off = off_step_events_s(scene)
    return straddled_words(scene, off[0]) if off else None


def off_step_events_s(scene: Scene) -> list[float]:
    """Instants of events within the run at which no step ends."""
    half = half_interval_s(scene)
    return [t for t in inner_events_s(scene) if abs(t / half - round(t / half)) > SLACK]


def straddled_words(scene: Scene, t_s: float) -> str:
    """Reason why an event inside a step is not supported, and the allowed instants."""
    return (
        f"an event at t = {t_s:g} s is not supported: equal steps would straddle it; "
        f"allowed: at a sample or midway between two, multiples of {half_interval_s(scene):g} s"
    )


def half_interval_s(scene: Scene) -> float:
    """Half of the time from one sample to the next, s: its multiples are ends of steps at every setting."""
    return 0.5 * scene.run.duration_s / (scene.run.samples - 1)


def inner_events_s(scene: Scene) -> list[float]:
    """Instants of events within the run; an event at either end lies before or after the run."""
    slack = SLACK * scene.run.duration_s / scene.run.samples
    return [t for t in scene.effects.breaks_s if slack < t < scene.run.duration_s - slack]


def events_by_step(scene: Scene, dt_s: float) -> dict[int, tuple[Impulse, ...]]:
    """Steps that end at an event, with the impulses applied there; step 0 appears only with impulses.

    Parameters
    ----------
    scene : Scene
    dt_s : float
        Size of the equal steps.

    Returns
    -------
    dict
        From the number of a step to the impulses at its end, of an event without impulses to none.
    """
    found: dict[int, tuple[Impulse, ...]] = {round(t / dt_s): () for t in inner_events_s(scene)}
    steps = round(scene.run.duration_s / dt_s)
    for impulse in scene.effects.impulse:
        step = round(impulse.at_s / dt_s)
        if 0 <= step < steps:
            found[step] = (*found.get(step, ()), impulse)
    return found
