"""Wrong thrusts, impulses and prescribed rotations: one of several is missing, or a table is held."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from barchain.judge.diagnosis.altered_scenes.loads import SECTION, with_effects
from barchain.judge.diagnosis.mistake import SceneMistake

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.judge.diagnosis.mistake import SceneChange
    from scenarios import Scene, Thrust

    LaterEntry = Callable[[Any, float], dict[str, Any]]

JUMP_S = 1e-4
"""Duration of a jump in a table; its effect on the motion is of second order"""
LATER: dict[str, LaterEntry] = {
    "thrust": lambda entry, late_s: {"times_s": tuple(t + late_s for t in entry.times_s)},
    "impulse": lambda entry, late_s: {"at_s": entry.at_s + late_s},
    "prescribed_rotation": lambda entry, late_s: {"start_s": entry.start_s + late_s},
}
"""Instants of an effect that comes late by a number of seconds"""
BEFORE = 1e-11
"""Share of the run by which an effect comes early if a sample at its instant is to show the state after it: ten times
the difference of two instants that count as one"""
SEVERAL = (("thrust", "thrust"), ("impulse", "impulse"), ("prescribed_rotation", "prescribed rotation"))
PROLONGED = (
    ("from-the-start", "acts from the start of the run on", True, False),
    ("without-end", "does not end", False, True),
    ("all-along", "acts from the start to the end of the run", True, True),
)
MISSING = (
    ("first", "that the scene names first is missing", True),
    ("later", "that the scene names first is the only one", False),
)


def interval_s(scene: Scene) -> float:
    """Time from one sample to the next, s."""
    return scene.run.duration_s / (scene.run.samples - 1)


def delayed(name: str, late_s: float) -> SceneChange:
    """Scene in which all effects of a kind come late, s."""

    def change(scene: Scene) -> Scene:
        later = LATER[name]
        late = tuple(dataclasses.replace(entry, **later(entry, late_s)) for entry in getattr(scene.effects, name))
        return with_effects(scene, **{name: late})

    return change


def a_sample_late(name: str) -> SceneChange:
    """Scene in which all effects of a kind come one sample late."""
    return lambda scene: delayed(name, interval_s(scene))(scene)


def seen_after(name: str) -> SceneChange:
    """Scene in which samples at the instants of a kind of effect hold the state after them."""
    return lambda scene: delayed(name, -BEFORE * scene.run.duration_s)(scene)


def one_missing(name: str, *, first: bool) -> SceneChange:
    """Scene without the first, or with only the first, of several effects of a kind."""

    def change(scene: Scene) -> Scene:
        entries = getattr(scene.effects, name)
        return with_effects(scene, **{name: entries[1:] if first else entries[:1]}) if len(entries) > 1 else scene

    return change


def prolonged(*, before: bool, after: bool) -> SceneChange:
    """Scene whose thrusts have their first size from the start on, their last size to the end, or both."""

    def change(scene: Scene) -> Scene:
        return with_effects(
            scene, thrust=tuple(longer(t, scene.run.duration_s, before, after) for t in scene.effects.thrust)
        )

    return change


def longer(thrust: Thrust, end_s: float, before: bool, after: bool) -> Thrust:
    """A thrust that begins at the start, goes on to the end, or both."""
    times, sizes = list(thrust.times_s), list(thrust.force_N)
    if before and times[0] > 0.0:
        times, sizes = [0.0, *times], [sizes[0], *sizes]
    if after and times[-1] < end_s:
        times, sizes = [*times, end_s], [*sizes, sizes[-1]]
    return dataclasses.replace(thrust, times_s=tuple(times), force_N=tuple(sizes))


def held_table(scene: Scene) -> Scene:
    """Thrusts whose sizes stay from one instant of the table to the next."""
    return with_effects(scene, thrust=tuple(held(entry) for entry in scene.effects.thrust))


def held(entry: Thrust) -> Thrust:
    """A thrust whose size jumps at each instant of its table; a jump takes :data:`JUMP_S`."""
    if len(set(entry.force_N)) == 1:
        return entry
    times, sizes = [entry.times_s[0]], [entry.force_N[0]]
    for at_s, before, after in zip(entry.times_s[1:-1], entry.force_N, entry.force_N[1:], strict=False):
        times += [at_s - 0.5 * JUMP_S, at_s + 0.5 * JUMP_S]
        sizes += [before, after]
    return dataclasses.replace(entry, times_s=(*times, entry.times_s[-1]), force_N=(*sizes, entry.force_N[-2]))


MISTAKES = (
    *(
        SceneMistake(
            f"{name}-{which}-missing".replace("_", "-"), f"the {said} {words}", SECTION, one_missing(name, first=first)
        )
        for name, said in SEVERAL
        for which, words, first in MISSING
    ),
    *(
        SceneMistake(f"{name}-a-sample-late", f"the {name} comes a whole sample late", SECTION, a_sample_late(name))
        for name in ("impulse", "thrust")
    ),
    SceneMistake(
        "impulse-sample-after", "the sample at an impulse holds the state after it", "samples", seen_after("impulse")
    ),
    SceneMistake(
        "thrust-sample-after",
        "the sample at a start or an end of a thrust holds the forces after it",
        "samples",
        seen_after("thrust"),
    ),
    *(
        SceneMistake(f"thrust-{name}", f"the thrust {words}", SECTION, prolonged(before=before, after=after))
        for name, words, before, after in PROLONGED
    ),
    SceneMistake(
        "thrust-table-held", "the thrust keeps its size from one instant of its table to the next", SECTION, held_table
    ),
)
