"""Scenes with some of several thrusts, impulses, motors or prescribed rotations changed: candidates of wrong loads."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenarios.toml.changing import clock_at_start

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.trajectory import Array
    from scenarios import Scene

    Made = Iterator[tuple[str, str, Scene]]
    """Name, words and scene"""
    Fields = Callable[[Any], dict[str, Any]]
    """New fields of a part of a scene"""


def with_effects(scene: Scene, **values: Any) -> Scene:
    """Scene with other effects."""
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **values))


def other(choice: Any) -> Any:
    """The other of two choices."""
    return next(c for c in type(choice) if c is not choice)


def moved_joints(scene: Scene) -> dict[int, tuple[Array, Array]]:
    """Instants of the run, s, and rest angles, rad, by joints (from 1) that have a set point in the scene's file."""
    springs = (scene.given or {}).get("effects", {}).get("joint_spring_damper") or {}
    start_s = clock_at_start(scene) if springs.get("set_point") else 0.0
    return {
        point["joint"]: (np.array(point["times_s"], float) - start_s, np.radians(point["angle_deg"]))
        for point in springs.get("set_point", ())
    }


class ChosenLoads(NamedTuple):
    """Some of several thrusts, impulses, motors or prescribed rotations of a scene."""

    scene: Scene
    kind: str
    places: tuple[int, ...]
    who: str
    name: str
    s: str
    """Ending of a verb"""

    @property
    def every(self) -> tuple[Any, ...]:
        """All of the kind."""
        found: tuple[Any, ...] = getattr(self.scene.effects, self.kind)
        return found

    def changed(self, change: Callable[[Any], tuple[Any, ...]]) -> Scene:
        """Scene with others in place of each of these, which come last."""
        kept = [p for k, p in enumerate(self.every) if k not in self.places]
        new = [p for k in self.places for p in change(self.every[k])]
        return with_effects(self.scene, **{self.kind: (*kept, *new)})

    def each(self, change: Fields) -> Scene:
        """Scene with fields of these changed."""
        new = (dataclasses.replace(p, **change(p)) if k in self.places else p for k, p in enumerate(self.every))
        return with_effects(self.scene, **{self.kind: tuple(new)})


def choices(scene: Scene, kind: str) -> Iterator[ChosenLoads]:
    """All thrusts, impulses, motors or prescribed rotations together, and each alone."""
    every, noun = getattr(scene.effects, kind), kind.replace("_", " ")
    if kind == "joint_torque" and {motor.joint for motor in every} <= moved_joints(scene).keys():
        noun = "moving set point"
    count = len(every)
    s = "s" if count > 1 else ""
    for places in [tuple(range(count)), *((k,) for k in range(count) if count > 1)] if count else ():
        alone = len(places) == 1
        who = f"{noun}{s}" if len(places) == count else f"{noun} {places[0] + 1}"
        yield ChosenLoads(scene, kind, places, f"the {who}", who.replace(" ", "-"), "s" if alone else "")
