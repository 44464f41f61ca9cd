"""Changes of the arrays of a right motion, of which the catalogue's readings are made."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.reading import ANGLE, UnreadableError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.reading import Change, Right

    Point = Callable[[Right], tuple[Array, Array]]
    """Position and velocity of a point, (n, 2) m and m/s"""


def in_axes_at(vectors: Array, angle_rad: Array) -> Array:
    """Components of vectors (n, ..., 2) in axes at angles (n, ...) rad from the inertial axes."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def backwards(values: Array) -> Array:
    """Values (n, k, ...) from the last bar or joint to the first."""
    return values[:, ::-1]


def as_text(values: Array) -> Array:
    """Values (n, k, ...) in the order of the numbers of bars or joints as text: 1, 10, 2."""
    return values[:, sorted(range(values.shape[1]), key=lambda k: str(k + 1))]


def exchanged(bar: int) -> Callable[[Array], Array]:
    """Values (n, k, ...) with a bar, from 1, and the next one in each other's place; as they are without these."""

    def order(values: Array) -> Array:
        places = np.arange(values.shape[1])
        if bar < len(places):
            places[[bar - 1, bar]] = bar, bar - 1
        return values[:, places]

    return order


def ordered(order: Callable[[Array], Array]) -> Change:
    """Values in another order of bars or joints."""
    return lambda v, _: order(v)


def from_previous(values: Array) -> Array:
    """Values (n, k, ...) less those of the bar or joint before; the first ones are absolute."""
    return np.diff(values, axis=1, prepend=0.0)


def zero_at_start(values: Array, _: Right) -> Array:
    """Values with zeros at the first sample."""
    found = values.copy()
    found[0] = 0.0
    return found


def unknown_at(rows: list[int], values: Array) -> Array:
    """Values that are unknown at some samples, where engines differ."""
    found = values.copy()
    found[rows] = np.nan
    return found


def last_alone(values: Array, _: Right) -> Array:
    """Last step of values (n, ...) that stay between steps."""
    steps = np.diff(values, axis=0, prepend=values[:1])
    stepped = steps.reshape(len(values), -1).any(axis=1)
    found: Array = steps[np.maximum.accumulate(np.where(stepped, np.arange(len(values)), 0))]
    return found


def differences(source: str) -> Iterator[tuple[str, Change]]:
    """Slopes of an array by its samples, with their names."""
    yield "central", lambda _, m: unknown_at([0, -1], np.gradient(m.array(source), m.motion.t_s, axis=0))
    yield "forward", lambda _, m: unknown_at([-1], np.concatenate([s := m.intervals(source), s[-1:]]))
    yield "backward", lambda _, m: unknown_at([0], np.concatenate([(s := m.intervals(source))[:1], s]))


def times(factor: float) -> Change:
    """Values times a factor."""
    return lambda v, _: factor * v


def plus(constant: float | Array) -> Change:
    """Values and a constant."""
    return lambda v, _: v + constant


def minus(reference: Change) -> Change:
    """Values less others."""
    return lambda v, m: v - reference(v, m)


def subtracted_from(total: float) -> Change:
    """A constant less values."""
    return lambda v, _: total - v


def begun_at(point: Point) -> Change:
    """Positions of a track whose start is taken as that of another point."""
    return lambda v, m: v - (point(m)[0][0] - m.start.com_m)


def at_point(point: Point, which: int) -> Change:
    """Position (0) or velocity (1) of a point."""
    return lambda _, m: point(m)[which]


def turned(quarters: int) -> Change:
    """Vectors turned counter-clockwise by quarter turns."""
    matrix = np.linalg.matrix_power(np.array([[0.0, 1.0], [-1.0, 0.0]]), quarters)
    return lambda v, _: v @ matrix


def in_orbital_rates(values: Array, right: Right) -> Array:
    """Values over the orbital rate at t = 0; there is no such unit where the chain starts at rest."""
    rate = right.scene.orbital_rate_rad_s
    if rate == 0.0:
        raise UnreadableError("orbital rate")
    found: Array = values / rate
    return found


def longitude_of_chain(right: Right) -> Array:
    """Longitude of the centre of mass, (n, 1) rad."""
    return right.longitude


def longitude_of_bars(right: Right) -> Array:
    """Longitude of each bar's centre, (n, N) rad."""
    return right.bar_longitudes


def jumping(wrap: Change, whose: Callable[[Right], Array], offset: float, _: Array, right: Right) -> Array:
    """Direction by a wrapped longitude, (n, ...) rad.

    Raises
    ------
    UnreadableError
        If the longitude does not jump in the run.
    """
    smooth = whose(right)
    found = wrap(smooth, right)
    if not np.any(np.abs(np.diff(found - smooth, axis=0)) > math.pi):
        raise UnreadableError(ANGLE)
    return found + offset


def jumped(wrap: Change, whose: Callable[[Right], Array], values: Array, right: Right) -> Array:
    """Angles that were made with a wrapped longitude, (n, N) rad."""
    found: Array = values + jumping(wrap, whose, 0.0, values, right) - whose(right)
    return found


def straight(every: int) -> Change:
    """Samples of a longer interval, with straight lines between; the last one stays beyond it."""

    def change(values: Array, _: Right) -> Array:
        rows = np.arange(len(values))
        begin = rows // every * every
        end = np.minimum(begin + every, begin[-1])
        share = ((rows - begin) / every).reshape(-1, *(1,) * (values.ndim - 1))
        found: Array = values[begin] + share * (values[end] - values[begin])
        return found

    return change
