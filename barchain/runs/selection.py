"""Selection of engines and scenes by name."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

from adapters.registry import Registration, engines, find_engine

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenarios import Scene


def chosen_engines(names: Iterable[str] | None) -> dict[str, Registration]:
    """Registrations by name, in the order given; without names all default engines."""
    if names is None:
        return {name: r for name, r in engines().items() if r.by_default}
    return {name: find_engine(name) for name in dict.fromkeys(names)}


def one_of_each(registered: dict[str, Registration]) -> dict[str, Registration]:
    """First engine of each library, and the first of those built on barchain's own equations, in their order."""
    first: dict[str, str] = {}
    for name, r in registered.items():
        first.setdefault("" if r.ours else r.requires or r.distribution or name, name)
    return {name: registered[name] for name in first.values()}


def unique_names(scenes: list[Scene]) -> list[Scene]:
    """Scenes with different names, so that no scene overwrites files of another; duplicates are dropped."""
    kept: dict[str, Scene] = {}
    for scene in scenes:
        name, count = scene.name, 1
        while name in kept and kept[name].digest != scene.digest:
            count += 1
            name = f"{scene.name}-{count}"
        kept[name] = dataclasses.replace(scene, name=name)
    return list(kept.values())
