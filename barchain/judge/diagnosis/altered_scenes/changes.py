"""Copies of a scene with one part changed."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from scenarios import Scene

    SceneChange = Callable[[Scene], Scene]
    PartChange = Callable[[Scene], Any]


def part(name: str, **changes: PartChange) -> SceneChange:
    """Change of some fields of one part of a scene; each function gives the new value.

    Parameters
    ----------
    name : str
        Field of `Scene`: ``central_body``, ``orbit``, ``chain``, ``effects`` or ``run``.
    **changes : callable
        New value of a field of that part, from the scene.
    """

    def change(scene: Scene) -> Scene:
        values = {field: value(scene) for field, value in changes.items()}
        return dataclasses.replace(scene, **{name: dataclasses.replace(getattr(scene, name), **values)})

    return change


def reversed_tuple(field: str) -> PartChange:
    """Values of the bars from the last to the first."""

    def value(scene: Scene) -> tuple[float, ...]:
        return tuple(reversed(getattr(scene.chain, field)))

    return value


def per_bar(value: Callable[[Scene, int], float]) -> PartChange:
    """One value for each bar, from the scene and the bar's index from 0."""

    def values(scene: Scene) -> tuple[float, ...]:
        return tuple(value(scene, j) for j in range(scene.bars))

    return values


def times(field: str, factor: float) -> PartChange:
    """Values of the bars times a factor."""
    return per_bar(lambda scene, j: factor * float(getattr(scene.chain, field)[j]))


def constant(value: object) -> PartChange:
    """A value that does not depend on the scene."""
    return lambda _: value
