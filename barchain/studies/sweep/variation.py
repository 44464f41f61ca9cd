"""Numbers of a scene that vary: ``orbit.speed_factor=1:1.3:7``, parsed, drawn, and put into the scene."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.studies.distributions import FAMILIES, VariationError, is_bounded, parameters, stream
from scenarios import SceneError, nearest
from scenarios.load import scene_of
from scenarios.toml.changing import current_tables, merged
from scenarios.toml.paths import EVERY, KEY, PATH, PathError, changes_at, each_path
from scenarios.toml.writing import scene_data

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from scenarios import Scene

FORM = re.compile(rf"\s*({PATH})\s*=\s*(.+?)\s*")
DRAWN = re.compile(r"(\w+)\s*\(([^()]*)\)")
FOLLOWS = re.compile(rf"(?:([^*\[\]]+)\*\s*)?({KEY}(?:\.{KEY})+)")
"""A factor, and a key with its table"""
WITH = re.compile(r"\s+with\s+")
"""Between keys whose values go together"""
FORMS = (
    "KEY=LOW:HIGH:COUNT, KEY=NUMBER,NUMBER,..., KEY=DISTRIBUTION(NUMBERS), 'KEY=... with KEY=...' or KEY=FACTOR*KEY, "
    "e.g. orbit.speed_factor=1:1.3:7, chain.angle_deg[2]=normal(80, 1)"
)
MOST_VALUES = 100_000
"""Of one grid, and runs of one engine: each is checked before the first run, in some milliseconds"""
DIGITS = 12
"""Of the values of a grid: 1.15 is not 1.1500000000000001"""


@dataclass(frozen=True)
class Variation:
    """One number of a scene's file that varies."""

    path: str
    """E.g. ``orbit.speed_factor``"""
    text: str
    """As it was given"""
    values: tuple[float, ...] = ()
    """Of a grid or a list; empty of a number that is drawn"""
    family: str = ""
    """Of the distribution of a number that is drawn"""
    parameters: tuple[float, ...] = ()
    """Of the distribution"""
    beside: bool = False
    """Whether its values go with those of the grid or list before it"""
    source: str = ""
    """Path of the number that it is a multiple of"""
    factor: float = 1

    @property
    def kind(self) -> str:
        """``grid``, ``drawn``, or ``tied`` to another number."""
        return "tied" if self.beside or self.source else "drawn" if self.family else "grid"

    def draws(self, runs: int, seed: int) -> list[float]:
        """Values of all runs, which depend neither on their number nor on what else varies."""
        made = FAMILIES[self.family].make(*self.parameters)
        with np.errstate(over="ignore"):  # the scene rejects infinity
            found: list[float] = made.rvs(size=runs, random_state=stream(seed, self.path)).tolist()
        return found


def variations_of(scene: Scene, texts: Iterable[str]) -> tuple[Variation, ...]:
    """Variations from their texts: those of grids and lists, those that are drawn, multiples of others.

    Raises
    ------
    VariationError
        If a text has another form, a number varies twice, or is a multiple of one that does not vary.
    """
    found = [each for text in texts for each in parse(text, scene)]
    paths = [each.path for each in found]
    free = [each.path for each in found if not each.source]
    for each in found:
        if paths.count(each.path) > 1:
            raise VariationError(f"--vary {each.text}: {each.path} is given twice, allowed: once")
        if each.source and each.source not in free:
            raise VariationError(
                f"--vary {each.text}: {each.source} has no values of its own{nearest(each.source, free)}, allowed: "
                "a key to which another --vary gives some"
            )
    return tuple(sorted(found, key=lambda each: (bool(each.source), bool(each.family))))


def parse(text: str, scene: Scene) -> list[Variation]:
    """Variations from one text; of several keys with ``with`` those of each, whose values go together."""
    parts = WITH.split(text.strip())
    if len(parts) == 1:
        return variations_at(text, scene)
    found = [each for part in parts for each in variations_at(part, scene)]
    counts = [len(each.values) for each in found]
    if len(set(counts)) > 1 or not counts[0] or len(set(found[0].values)) < counts[0]:
        raise VariationError(
            f"--vary: {text!r} given, allowed: grids and lists of equally many values beside `with`, different ones "
            "of the first key"
        )
    return [replace(each, text=text, beside=k > 0) for k, each in enumerate(found)]


def variations_at(text: str, scene: Scene) -> list[Variation]:
    """Variations of one key; several of a list whose values are drawn, or follow, each by itself."""
    match = FORM.fullmatch(text)
    if not match:
        raise VariationError(f"--vary: {text!r} given, allowed: {FORMS}")
    path, right = match.groups()
    drawn, follows = DRAWN.fullmatch(right), FOLLOWS.fullmatch(right)
    try:
        if drawn:
            given = parameters(text, *drawn.groups())
            return [Variation(each, text, (), drawn[1], given) for each in each_path(scene, path)]
        if follows:
            return multiples(text, each_path(scene, path), each_path(scene, follows[2]), follows[1])
    except PathError as error:
        raise VariationError(f"--vary {text}: {error}") from None
    if EVERY in path:
        raise VariationError(f"--vary: {text!r} given, allowed: {EVERY} with a distribution, or the index of one")
    return [Variation(path, text, numbers_of(text, right))]


def multiples(text: str, paths: Sequence[str], sources: Sequence[str], factor: str | None) -> list[Variation]:
    """Variations that are a factor times another number: each of one, or of the one with its own index."""
    try:
        times = number(factor) if factor else 1
    except ValueError:
        raise VariationError(f"--vary: {text!r} given, allowed: {FORMS}") from None
    if not is_bounded(times):
        raise VariationError(f"--vary: {text!r} given, allowed: a factor that a scene file may hold")
    sources = sources if len(sources) > 1 else [*sources] * len(paths)
    if len(sources) != len(paths):
        raise VariationError(f"--vary: {text!r} given, allowed: lists of one length with {EVERY}")
    return [Variation(path, text, source=source, factor=times) for path, source in zip(paths, sources, strict=True)]


def numbers_of(text: str, right: str) -> tuple[float, ...]:
    """Numbers of a grid ``low:high:count`` or a list ``a,b,c``; whole ones stay whole, as numbers of bars are."""
    is_grid = ":" in right
    try:
        found = [number(part) for part in right.split(":" if is_grid else ",")]
    except ValueError:
        raise VariationError(f"--vary: {text!r} given, allowed: {FORMS}") from None
    if not all(map(is_bounded, found)):
        raise VariationError(f"--vary: {text!r} given, allowed: numbers that a scene file may hold")
    if not is_grid:
        return tuple(found)
    low, high, count = found if len(found) == 3 else (0, 0, 0)
    if not isinstance(count, int) or not 2 <= count <= MOST_VALUES:
        raise VariationError(f"--vary: {text!r} given, allowed: LOW:HIGH:COUNT with a COUNT of 2 to {MOST_VALUES}")
    grid = [float(f"{value:.{DIGITS}g}") for value in np.linspace(low, high, count)]
    if isinstance(low, int) and isinstance(high, int) and all(value.is_integer() for value in grid):
        return tuple(map(int, grid))
    return tuple(grid)


def number(text: str) -> float:
    """Number of a text, a whole one where it is written so."""
    try:
        return int(text)
    except ValueError:
        return float(text)


def points_of(variations: Sequence[Variation], runs: int, seed: int) -> list[tuple[float, ...]]:
    """Values of the variations in each run: the product of all grids, with all draws at each of its points.

    Raises
    ------
    VariationError
        If there are too many of them.
    """
    texts = itertools.groupby((each for each in variations if each.values), key=lambda each: each.text)
    grids = [list(dict.fromkeys(zip(*(each.values for each in group), strict=True))) for _, group in texts]
    drawn = [each for each in variations if each.family]
    count = math.prod(map(len, grids)) * (runs if drawn else 1)
    if count > MOST_VALUES:
        raise VariationError(f"--vary: {count} runs of each engine, allowed: at most {MOST_VALUES}")
    draws = list(zip(*(each.draws(runs, seed) for each in drawn), strict=True)) if drawn else [()]
    free = [(*itertools.chain(*point), *draw) for point in itertools.product(*grids) for draw in draws]
    paths = [each.path for each in variations]
    follow = [(each.factor, paths.index(each.source)) for each in variations if each.source]
    return [(*point, *(factor * point[k] for factor, k in follow)) for point in free]


class VariedScene:
    """A scene that is made again and again, with other numbers."""

    def __init__(self, scene: Scene) -> None:
        """Take the tables of its file."""
        self.name, self.tables = scene.name, current_tables(scene)

    def at(self, values: Mapping[str, float]) -> Scene:
        """Scene with numbers at some paths.

        What follows from a whole key, as the inertia of slender bars from their masses, is there before a list is
        changed.

        Raises
        ------
        VariationError
            If the scene refuses one of them; one line.
        """
        single = {path: value for path, value in values.items() if "[" in path}
        tables = self.tables
        try:
            for part in ({path: value for path, value in values.items() if path not in single}, single):
                tables = merged(tables, changes_at(tables, part, partial(self.whole, tables)))
            return scene_of(tables, self.name, self.name)
        except (SceneError, PathError) as error:
            said = ", ".join(f"{path}={value:.6g}" for path, value in values.items())
            raise VariationError(f"--vary {said}: {str(error).splitlines()[0]}") from None

    def whole(self, tables: dict[str, Any]) -> dict[str, Any]:
        """Tables with all values given."""
        return scene_data(scene_of(tables, self.name, self.name))
