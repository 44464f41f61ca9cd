"""Engines and points that a study of times leaves out, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from adapters.engine import Engine
    from adapters.registry import Registration
    from scenarios import Scene

NOT_RUN = "not run"  # how the reason of a point that was not tried begins


@dataclass(frozen=True)
class LeftOut:
    """An engine that is not run on a scene, and why."""

    scene: str
    engine: str
    outcome: Outcome
    reason: str


def cannot(scene: Scene, engine: str, registration: Registration) -> LeftOut | None:
    """Why an engine is not run on a scene, or None if it is."""
    if registration.missing:
        return LeftOut(scene.name, engine, Outcome.MISSING, registration.missing)
    try:
        loaded: type[Engine] = registration.load()
    except Exception as error:
        reason = f"its adapter does not load: {type(error).__name__}: {error}"
        return LeftOut(scene.name, engine, Outcome.FAILED, reason)
    unsupported = loaded.unsupported(scene)
    return None if unsupported is None else LeftOut(scene.name, engine, Outcome.UNSUPPORTED, unsupported)
