"""Pairs of a scene and an engine that the default study leaves to a full one: they take minutes, and are known."""

from __future__ import annotations

from typing import TYPE_CHECKING

from adapters.registry import COMPILED, ENGINES
from barchain.studies.stability.expected import SLOW, recorded
from barchain.studies.stability.plan import LONG

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from scenarios import Scene

NUMPY_RATES = frozenset({"reference", "reference-absolute"})
"""Engines that evaluate rates in NumPy: hundreds of orbits take them minutes a run"""
MOST_BARS_COMPILED = 200  # heyoka compiles 1000 bars for minutes, at each setting


def left_to_a_full_study(scenes: Iterable[Scene], names: Iterable[str]) -> frozenset[tuple[str, str]]:
    """Pairs that take long and are known: recorded time-outs, and :func:`takes_minutes`."""
    own, known = frozenset(names), recorded()
    found = {(scene.name, name) for scene in scenes for name in own if takes_minutes(scene, name, own)}
    return frozenset(found | {pair for pair, word in known.items() if word == SLOW and pair[1] in own})


def takes_minutes(scene: Scene, name: str, engines: Collection[str]) -> bool:
    """Whether each run takes minutes: rates in NumPy in a long scene, if the compiled reference is there; compiling."""
    if LONG in scene.tags and COMPILED in engines and name in NUMPY_RATES:
        return True
    solver = name != COMPILED and name in ENGINES and ENGINES[name].needs_kernel
    return scene.bars > MOST_BARS_COMPILED and (solver or (name in ENGINES and ENGINES[name].compiles))
