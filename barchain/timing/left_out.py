"""Engines and points that a study of times skips, with reasons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from barchain.boundary.declared import engine_class
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from adapters.registry import Registration
    from scenarios import Scene


@dataclass(frozen=True)
class LeftOut:
    """An engine that is skipped on a scene, with the reason."""

    scene: str
    engine: str
    outcome: Outcome
    reason: str


def cannot(scene: Scene, engine: str, registration: Registration) -> LeftOut | None:
    """Reason why an engine is skipped on a scene, or None if it runs."""
    if registration.missing:
        return LeftOut(scene.name, engine, Outcome.MISSING, registration.missing)
    try:
        unsupported = engine_class(registration).unsupported(scene)
    except Exception as error:
        reason = f"its adapter does not load: {type(error).__name__}: {error}"
        return LeftOut(scene.name, engine, Outcome.FAILED, reason)
    return None if unsupported is None else LeftOut(scene.name, engine, Outcome.UNSUPPORTED, unsupported)
