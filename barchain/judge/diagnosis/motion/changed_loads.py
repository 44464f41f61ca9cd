"""Scenes with some of several thrusts, impulses, motors or prescribed rotations changed: candidates of wrong loads."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, NamedTuple

from barchain.judge.diagnosis.motion.set_points import SET_POINT, motor_nouns, motor_words, motors_words

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

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
    count, noun = len(getattr(scene.effects, kind)), kind.replace("_", " ")
    nouns = motor_nouns(scene) if kind == "joint_torque" else []
    noun = SET_POINT if nouns and {*nouns} == {SET_POINT} else noun
    s = "s" if count > 1 else ""
    for places in [tuple(range(count)), *((k,) for k in range(count) if count > 1)] if count else ():
        alone = len(places) == 1
        who = f"{noun}{s}" if len(places) == count else f"{noun} {places[0] + 1}"
        if SET_POINT in nouns and count > 1:  # the file has no numbers of these
            who = motor_words(scene)[places[0]] if alone else motors_words(scene)
        yield ChosenLoads(scene, kind, places, f"the {who}", who.replace(" ", "-"), "s" if alone else "")
