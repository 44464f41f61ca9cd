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


class SetPoint(NamedTuple):
    """Set point of a joint's spring and damper."""

    times_s: Array
    """Instants of the run, s"""
    angle_rad: Array
    motor: int | None
    """Place of the torque that moves the rest angle among the scene's motors; None where it does not move"""


def moved_joints(scene: Scene) -> dict[int, SetPoint]:
    """Set points in the scene's file by joint, from 1. Their motors come before those of the file."""
    given = (scene.given or {}).get("effects", {}).get("joint_spring_damper") or {}
    springs, start_s = scene.effects.joint_spring_damper, clock_at_start(scene) if given.get("set_point") else 0.0
    found, motors = dict[int, SetPoint](), 0
    if springs is None:
        return found
    for point in given.get("set_point", ()):
        joint, times_s = point["joint"], np.array(point["times_s"], float) - start_s
        angle_rad = np.radians(point["angle_deg"])
        gains = (springs.stiffness_N_m_rad[joint - 1], springs.damping_N_m_s_rad[joint - 1])
        inside = np.clip([0.0, *times_s, scene.run.duration_s], 0.0, scene.run.duration_s)
        moves = any(gains) and float(np.ptp(np.interp(inside, times_s, angle_rad))) > 0.0
        found[joint] = SetPoint(times_s, angle_rad, motors if moves else None)
        motors += moves
    return found


def set_point_of_motor(scene: Scene, k: int) -> bool:
    """Whether a motor of a scene, by its place, moves a set point."""
    return any(point.motor == k for point in moved_joints(scene).values())


def motors_words(scene: Scene) -> str:
    """Noun for all motors of a scene, some of which may move set points."""
    by_points = [set_point_of_motor(scene, k) for k in range(len(scene.effects.joint_torque))]
    if not any(by_points):
        return "joints' motors"
    return "moving set points" if all(by_points) else "motors and moving set points"


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
    count = len(every)
    by_points = [kind == "joint_torque" and set_point_of_motor(scene, k) for k in range(count)]
    noun = "moving set point" if count and all(by_points) else noun
    s = "s" if count > 1 else ""
    for places in [tuple(range(count)), *((k,) for k in range(count) if count > 1)] if count else ():
        alone = len(places) == 1
        who = f"{noun}{s}" if len(places) == count else f"{noun} {places[0] + 1}"
        if any(by_points) and count > 1:  # a file numbers what it has
            who = f"{'moving set point' if by_points[places[0]] else 'motor'} in joint {every[places[0]].joint}"
            who = who if alone else "motors and moving set points"
        yield ChosenLoads(scene, kind, places, f"the {who}", who.replace(" ", "-"), "s" if alone else "")
