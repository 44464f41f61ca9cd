"""Scenes with a few changes: of their run, their orbit, their chain, their effects."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenarios import Scene


def lasting(scene: Scene, duration_s: float, samples: int | None = None) -> Scene:
    """`scene` for some seconds, with as many samples as it has or with others."""
    run = dataclasses.replace(scene.run, duration_s=duration_s, samples=samples or scene.run.samples)
    return dataclasses.replace(scene, run=run)


def under(scene: Scene, **effects: Any) -> Scene:
    """`scene` with other effects."""
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **effects))


def on_orbit(scene: Scene, **elements: Any) -> Scene:
    """`scene` on another orbit."""
    return dataclasses.replace(scene, orbit=dataclasses.replace(scene.orbit, **elements))


def with_chain(scene: Scene, **columns: Any) -> Scene:
    """`scene` with other bars."""
    return dataclasses.replace(scene, chain=dataclasses.replace(scene.chain, **columns))
