"""Numbers of a scene that vary: ``orbit.speed_factor=1:1.3:7``, parsed, drawn, and put into the scene."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.studies.distributions import FAMILIES, VariationError, is_bounded, parameters, stream
from scenarios import SceneError
from scenarios.load import scene_of
from scenarios.toml.changing import current_tables, merged
from scenarios.toml.paths import EVERY, PATH, PathError, changes_at, each_path
from scenarios.toml.writing import scene_data

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from scenarios import Scene

FORM = re.compile(rf"\s*({PATH})\s*=\s*(.+?)\s*")
DRAWN = re.compile(r"(\w+)\s*\(([^()]*)\)")
FORMS = (
    "KEY=LOW:HIGH:COUNT, KEY=NUMBER,NUMBER,... or KEY=DISTRIBUTION(NUMBERS), e.g. orbit.speed_factor=1:1.3:7, "
    "chain.angle_deg[2]=normal(80, 1)"
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

    def draws(self, runs: int, seed: int) -> list[float]:
        """Values of all runs, which depend neither on their number nor on what else varies."""
        made = FAMILIES[self.family].make(*self.parameters)
        with np.errstate(over="ignore"):  # the scene rejects infinity
            found: list[float] = made.rvs(size=runs, random_state=stream(seed, self.path)).tolist()
        return found


def variations_of(scene: Scene, texts: Iterable[str]) -> tuple[Variation, ...]:
    """Variations from their texts, those of grids and lists first.

    Raises
    ------
    VariationError
        If a text has another form, or a number varies twice.
    """
    found = [each for text in texts for each in parse(text, scene)]
    paths = [each.path for each in found]
    for each in found:
        if paths.count(each.path) > 1:
            raise VariationError(f"--vary {each.text}: {each.path} is given twice, allowed: once")
    return tuple(sorted(found, key=lambda each: bool(each.family)))


def parse(text: str, scene: Scene) -> list[Variation]:
    """Variations from one text; several of a list whose values are drawn each by itself."""
    match = FORM.fullmatch(text)
    if not match:
        raise VariationError(f"--vary: {text!r} given, allowed: {FORMS}")
    path, right = match.groups()
    drawn = DRAWN.fullmatch(right)
    if not drawn:
        if EVERY in path:
            raise VariationError(f"--vary: {text!r} given, allowed: {EVERY} with a distribution, or the index of one")
        return [Variation(path, text, numbers_of(text, right))]
    family, inside = drawn.groups()
    given = parameters(text, family, inside)
    try:
        return [Variation(each, text, (), family, given) for each in each_path(scene, path)]
    except PathError as error:
        raise VariationError(f"--vary {text}: {error}") from None


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
        return tuple(dict.fromkeys(found))
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
    grids = [each.values for each in variations if not each.family]
    drawn = [each for each in variations if each.family]
    count = math.prod(map(len, grids)) * (runs if drawn else 1)
    if count > MOST_VALUES:
        raise VariationError(f"--vary: {count} runs of each engine, allowed: at most {MOST_VALUES}")
    draws = list(zip(*(each.draws(runs, seed) for each in drawn), strict=True)) if drawn else [()]
    return [(*point, *draw) for point in itertools.product(*grids) for draw in draws]


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
