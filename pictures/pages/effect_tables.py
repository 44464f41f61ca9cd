"""Tables of the pages of effects: the keys of each effect, and the engines that support it."""

from __future__ import annotations

import re
from functools import partial
from typing import TYPE_CHECKING

from adapters.registry import built_in
from pictures.pages.words import table
from scenarios.toml.key_tables import HEAD, key_tables

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

EFFECTS = {
    "gravity": "gravity", "oblateness": "oblateness", "third body": "third_body", "drag": "drag",
    "light": r"solar_pressure$", "shadow": r"solar_pressure\.shadow", "springs": "joint_spring_damper",
    "motors": "joint_torque", "rotation": "prescribed_rotation", "thrust": "thrust", "impulse": "impulse",
}  # fmt: skip
"""Kinds of effects, and patterns of the names that engines declare"""
WITH_KEYS = (
    "oblateness",
    "third_body",
    "drag",
    "solar_pressure",
    "joint_spring_damper",
    "joint_spring_damper.set_point",
    "joint_torque",
    "prescribed_rotation",
    "thrust",
    "impulse",
)
"""Tables of a scene that belong to one effect"""


def effect_keys(effect: str) -> str:
    """Keys of an effect's table.

    Raises
    ------
    StopIteration
        If a scene has no such table.
    """
    return next(table(HEAD, rows) for title, _, rows in key_tables() if title.strip("`[]") == f"effects.{effect}")


def effects_of_engines() -> str:
    """Effects that each engine declares; engines that declare the same share a row."""
    engines = built_in()
    declared = {name: frozenset(r.declarations().effects) for name, r in engines.items()}
    every = frozenset().union(*declared.values())
    rows: dict[tuple[bool, tuple[str, ...]], list[str]] = {}
    for name, registration in engines.items():
        rows.setdefault((registration.ours, tuple(cells(declared[name], every))), []).append(name)
    return table(("engine", *EFFECTS), ([", ".join(names), *found] for (_, found), names in rows.items()))


def cells(supported: frozenset[str], every: frozenset[str]) -> Iterator[str]:
    """Support by an engine of each kind of effect: all of a kind, none, or the names."""
    for pattern in EFFECTS.values():
        kind = {name for name in every if re.match(pattern, name)}
        have = sorted(name.rpartition(".")[2] for name in kind & supported)
        yield "✓" if kind <= supported else ", ".join(have) or "–"


TABLES: dict[str, Callable[[], str]] = {
    "effects-of-engines": effects_of_engines,
    **{f"keys-{effect.replace('.', '-')}": partial(effect_keys, effect) for effect in WITH_KEYS},
}
"""Tables by their names"""
