"""Readings with a number that is fitted to the result: a factor or a constant, of all bars and joints or of one."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.array_changes import plus, times
from barchain.judge.diagnosis.reading import PARTS, VECTORS, Reading
from barchain.judge.diagnosis.readings import READINGS, of
from barchain.metrics.quantities import QUANTITY_OF, arrays
from scenarios import Gravity
from scenarios.channels import UNITS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.reading import Change, Right
    from scenarios import Scene

SCALED = ("reactions", "angles", "rates", "torques", "centre-of-mass", "velocity")
"""Parts with an unknown factor"""
SHIFTED = ("reactions", "torques", "rates", "centre-of-mass", "velocity")
"""Parts with an unknown constant"""
PLACES = ("reactions", "angles", "rates")
"""Parts with an unknown factor at one place"""
NEAR_ONE = 1e-3
"""Departure from 1 below which a factor is told by the departure"""
DIGITS = 3
"""Digits of a fitted constant"""


def fitted(scene: Scene, given: Trajectory, right: Trajectory) -> Iterator[Reading]:
    """Readings whose number fits a result best, at n common samples.

    Parameters
    ----------
    scene : Scene
    given : Trajectory
        The result.
    right : Trajectory
        The right motion.
    """
    own, known = arrays(given), arrays(right)
    both = {p: (own[f], known[f]) for p in SCALED if (f := PARTS[p].fields[0]) in own and f in known}
    for part, (mine, true) in both.items():
        if np.any(true):
            factor = fitted_factor(mine, true)
            also = same_factor(scene) if part == "reactions" else ""
            said = f"are {factor_words(factor)} times the right values{also}"
            yield of(part, "times-a-factor", said, times(factor))
        constant: Array = np.median(mine - true, axis=0)
        if part == "angles":
            for k in (None, *(range(true.shape[1]) if true.shape[1] > 1 else ())):
                apart = mine - true if k is None else (mine - true)[:, k]
                turn = math.remainder(float(np.median(apart)), 2.0 * math.pi)
                said = f"are off by a constant {math.degrees(turn):.6g} degrees"
                found = of(part, "off-by-a-constant", said, plus(turn), turns=True)
                yield found if k is None else at_place(found, part, k)
        elif part in SHIFTED and np.any(constant):
            rows = constant.reshape(-1, 2 if PARTS[part].fields[0] in VECTORS else 1)
            said = f"are off by a constant {constant_words(rows)} {UNITS[QUANTITY_OF[PARTS[part].fields[0]]]}"
            yield of(part, "off-by-a-constant", said, plus(constant))
    for part in (p for p in PLACES if p in both):
        mine, true = both[part]
        for k in range(true.shape[1]) if true.shape[1] > 1 else ():
            if np.any(true[:, k]) and not np.array_equal(mine[:, k], true[:, k]):
                factor = fitted_factor(mine[:, k], true[:, k])
                said = f"are {factor_words(factor)} times the right values"
                yield at_place(of(part, "times-a-factor", said, times(factor)), part, k)


def at_places(scene: Scene) -> Iterator[Reading]:
    """Known mistakes of reading at one bar or joint only."""
    for part, count in (("angles", scene.bars), ("rates", scene.bars), ("angles-and-rates", scene.bars),
                        ("reactions", scene.bars - 1), ("joint-forces", scene.bars - 1)):  # fmt: skip
        who, fields, _ = PARTS[part]
        for reading in READINGS if count > 1 else ():
            if set(reading.changes) == set(fields) and reading.sentence.startswith(f"the {who} "):
                yield from (at_place(reading, part, k) for k in range(count))


def at_place(reading: Reading, part: str, place: int) -> Reading:
    """A reading of a part, at one bar or joint alone."""
    who, words = PARTS[part].who, f"{'at joint' if part in ('reactions', 'joint-forces') else 'of bar'} {place + 1}"

    def alone(change: Change) -> Change:
        def changed(values: Array, right: Right) -> Array:
            found = values.copy()
            found[:, place] = change(values, right)[:, place]
            return found

        return changed

    name, said = f"{reading.name}-{words.replace(' ', '-')}", reading.sentence.replace(who, f"{who} {words}", 1)
    changes = {field: alone(change) for field, change in reading.changes.items()}
    return Reading(name, said, reading.section, changes, reading.any_turns)


def same_factor(scene: Scene) -> str:
    """Properties of all bars whose common factor has reactions as its only trace in a scene, in words."""
    effects = scene.effects
    if effects.beyond_basic or effects.prescribed_rotation:
        return ""
    lengths = " or the lengths" if effects.gravity is Gravity.NONE else ""
    return f", or the masses{lengths} of all bars are, in the moments of inertia too"


def constant_words(places: Array) -> str:
    """Values or vectors of all bars or joints as text, (k, 1) or (k, 2); one where all are the same.

    The largest value has three digits, and the others have no further ones.
    """
    decimals = DIGITS - 1 - math.floor(math.log10(np.abs(places).max()))
    rows = [", ".join(f"{round(v, decimals) + 0.0:.{DIGITS}g}" for v in place) for place in places.tolist()]
    each = [f"({row})" if places.shape[1] > 1 else row for row in rows]
    return each[0] if len(set(each)) == 1 else f"({', '.join(each)})"


def fitted_factor(given: Array, right: Array) -> float:
    """Factor of the right values that comes nearest to the given ones, by least squares."""
    return 1.0 + float(np.vdot(right, given - right)) / float(np.vdot(right, right))


def factor_words(factor: float) -> str:
    """Factor as text; one near 1 as its departure from 1."""
    departure = factor - 1.0
    near = abs(departure) < NEAR_ONE
    return f"(1 {'-' if departure < 0.0 else '+'} {abs(departure):.3g})" if near else f"{factor:.6g}"
