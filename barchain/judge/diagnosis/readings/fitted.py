"""Readings with a number that is fitted to the result: an unknown factor, or an unknown constant angle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.channels import (
    ANGLE,
    COM,
    RATE,
    REACTION,
    TORQUE,
    VECTORS,
    VELOCITY,
    channel,
    channels_of,
    plus,
    times,
)
from barchain.judge.diagnosis.mistake import ReadingMistake
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ReadingChange
    from scenarios import Scene

SCALED = (
    ("reactions", "the reactions are", REACTION, "reactions"),
    ("angles", "the angles are", ANGLE, "angles"),
    ("rates", "the rates are", RATE, "rates"),
    ("torques", "the torques are", TORQUE, "torques"),
    ("centre-of-mass", "the positions of the centre of mass are", COM, "centre-of-mass"),
    ("velocity", "the velocities of the centre of mass are", VELOCITY, "centre-of-mass"),
)
PLACES = (
    ("reactions", "the reactions", REACTION, "reactions", "at joint"),
    ("angles", "the angles", ANGLE, "angles", "of bar"),
    ("rates", "the rates", RATE, "rates", "of bar"),
)
OFFSETS = (
    ("reactions", "the reactions are", REACTION, "reactions", "N"),
    ("rates", "the rates are", RATE, "rates", "rad/s"),
    ("centre-of-mass", "the positions of the centre of mass are", COM, "centre-of-mass", "m"),
    ("velocity", "the velocities of the centre of mass are", VELOCITY, "centre-of-mass", "m/s"),
)
SAME = 1e-6
"""Departure of a fitted factor from -1 that is not worth a number"""
DIGITS = 3
"""Digits of a fitted constant"""


def fitted(scene: Scene, given: Trajectory, right: Trajectory) -> Iterator[ReadingMistake]:
    """Readings whose number fits a result best, at n common samples.

    Parameters
    ----------
    scene : Scene
    given : Trajectory
        The result.
    right : Trajectory
        The right motion.
    """
    values = channels_of(given)
    for part, words, field, section in SCALED:
        right_values = getattr(right, field)
        if field not in values or right_values is None or not np.any(right_values):
            continue
        factor = fitted_factor(values[field], right_values)
        said = f"{words} {factor_words(factor)} times the right values{same_factor(scene) if field == REACTION else ''}"
        yield ReadingMistake(f"{part}-times-a-factor", said, section, times(factor, field))
    if given.angle_rad is not None and right.angle_rad is not None:
        offset = math.remainder(float(np.median(given.angle_rad - right.angle_rad)), 2.0 * math.pi)
        said = f"the angles are off by a constant {math.degrees(offset):.6g} degrees"
        yield ReadingMistake("angles-off-by-a-constant", said, "angles", plus(offset, ANGLE), True)
    yield from off_by_constants(given, right)
    yield from at_one_place(given, right)


def same_factor(scene: Scene) -> str:
    """Properties of all bars whose common factor has reactions as its only trace in a scene, in words."""
    effects = scene.effects
    if effects.beyond_basic or effects.prescribed_rotation:
        return ""
    lengths = " or the lengths" if effects.gravity is Gravity.NONE else ""
    return f", or the masses{lengths} of all bars are, in the moments of inertia too"


def off_by_constants(given: Trajectory, right: Trajectory) -> Iterator[ReadingMistake]:
    """Readings with a constant added, of each component its median."""
    values = channels_of(given)
    for part, words, field, section, unit in OFFSETS:
        right_values = getattr(right, field)
        if field not in values or right_values is None:
            continue
        constant = np.median(values[field] - right_values, axis=0)
        if np.any(constant):
            places = constant.reshape(-1, 2 if field in VECTORS else 1)
            said = f"{words} off by a constant {constant_words(places)} {unit}"
            yield ReadingMistake(f"{part}-off-by-a-constant", said, section, plus(constant, field))


def constant_words(places: Array) -> str:
    """Values or vectors of all bars or joints as text, (k, 1) or (k, 2); one where all are the same.

    The largest value has three digits, and the others have no further ones.
    """
    decimals = DIGITS - 1 - math.floor(math.log10(np.abs(places).max()))
    rows = [", ".join(f"{round(v, decimals) + 0.0:.{DIGITS}g}" for v in place) for place in places.tolist()]
    each = [f"({row})" if places.shape[1] > 1 else row for row in rows]
    return each[0] if len(set(each)) == 1 else f"({', '.join(each)})"


def at_one_place(given: Trajectory, right: Trajectory) -> Iterator[ReadingMistake]:
    """Readings that are wrong by a factor at one bar or joint only."""
    values = channels_of(given)
    for part, words, field, section, place in PLACES:
        right_values = getattr(right, field)
        if field not in values or right_values is None or right_values.shape[1] == 1:
            continue
        for k in range(right_values.shape[1]):
            there = right_values[:, k]
            if not np.any(there) or np.array_equal(values[field][:, k], there):
                continue
            factor = fitted_factor(values[field][:, k], there)
            how = (
                "have the opposite sign"
                if abs(factor + 1.0) < SAME
                else f"are {factor_words(factor)} times the right values"
            )
            said = f"{words} {place} {k + 1} {how}"
            yield ReadingMistake(f"{part}-{place.split()[-1]}-{k + 1}", said, section, times_at(k, factor, field))


def fitted_factor(given: Array, right: Array) -> float:
    """Factor of the right values that comes nearest to the given ones, by least squares."""
    return 1.0 + float(np.vdot(right, given - right)) / float(np.vdot(right, right))


def factor_words(factor: float) -> str:
    """Factor as text; one near 1 as its departure from 1."""
    departure = factor - 1.0
    return f"(1 {'-' if departure < 0.0 else '+'} {abs(departure):.3g})" if abs(departure) < 1e-3 else f"{factor:.6g}"


def times_at(place: int, factor: float, field: str) -> ReadingChange:
    """Values (n, k, ...) of one bar or joint times a factor."""

    def scaled(values: Array) -> Array:
        found = values.copy()
        found[:, place] *= factor
        return found

    return channel(scaled, field)
