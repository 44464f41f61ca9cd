"""Kinematics of a tree of joints in plain floats."""

from __future__ import annotations

from itertools import accumulate
from math import cos, sin
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate


def tree_positions(q: Sequence[float], bars: Sequence[BarProperties]) -> Iterator[BarPosition]:
    """Each bar's position in the frame from joint coordinates (N + 2)."""
    x, y = q[:2]
    for angle, bar in zip(accumulate(q[2:]), bars, strict=True):
        reach_x, reach_y = bar.half_length_m * cos(angle), bar.half_length_m * sin(angle)
        yield x + reach_x, y + reach_y, angle
        x, y = x + 2.0 * reach_x, y + 2.0 * reach_y


def tree_rates(q: Sequence[float], q_t: Sequence[float], bars: Sequence[BarProperties]) -> Iterator[BarRate]:
    """Each bar's rates in the frame from joint coordinates and their rates, each (N + 2)."""
    vx, vy = q_t[:2]
    for angle, rate, bar in zip(accumulate(q[2:]), accumulate(q_t[2:]), bars, strict=True):
        reach_x, reach_y = -bar.half_length_m * rate * sin(angle), bar.half_length_m * rate * cos(angle)
        yield vx + reach_x, vy + reach_y, rate
        vx, vy = vx + 2.0 * reach_x, vy + 2.0 * reach_y
