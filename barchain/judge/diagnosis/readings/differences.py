"""Rates and velocities made of neighbouring samples: differences of angles or positions, and means."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.channels import ANGLE, COM, RATE, REACTION, VELOCITY, channel
from barchain.judge.diagnosis.mistake import ReadingMistake

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ReadingChange
    from scenarios import Scene

    Slope = Callable[[Array, Array], Array]


def central(values: Array, t_s: Array) -> Array:
    """Central differences (n, ...), unknown at both ends."""
    slope: Array = np.gradient(values, t_s, axis=0)
    slope[[0, -1]] = np.nan
    return slope


def forward(values: Array, t_s: Array) -> Array:
    """Differences from the next sample, (n, ...); unknown at the last one, where engines differ."""
    slope = intervals(values, t_s)
    return np.concatenate([slope, np.full_like(slope[-1:], np.nan)])


def backward(values: Array, t_s: Array) -> Array:
    """Differences from the sample before, (n, ...); unknown at the first one, where engines differ."""
    slope = intervals(values, t_s)
    return np.concatenate([np.full_like(slope[:1], np.nan), slope])


def intervals(values: Array, t_s: Array) -> Array:
    """Slope in each interval, (n - 1, ...)."""
    slope: Array = np.diff(values, axis=0) / np.diff(t_s).reshape(-1, *[1] * (values.ndim - 1))
    return slope


def by_differences(slope: Slope, source: str, target: str) -> ReadingChange:
    """An array replaced by the slope of another one."""

    def read(_: Scene, right: Trajectory) -> Trajectory:
        values = getattr(right, source)
        if values is None or getattr(right, target) is None or len(right.t_s) <= 1:
            return right
        return right.replace(**{target: slope(values, right.t_s)})

    return read


def with_sample_before(values: Array) -> Array:
    """Mean of each value (n, ...) and the one before; the first one stays."""
    mean: Array = 0.5 * (values + np.concatenate([values[:1], values[:-1]]))
    return mean


DIFFERENCES: tuple[tuple[str, Slope], ...] = (("central", central), ("forward", forward), ("backward", backward))
SLOPES = (
    ("rates", "the rates are", "the angles", ANGLE, RATE, "rates"),
    ("velocities", "the velocities of the centre of mass are", "its positions", COM, VELOCITY, "centre-of-mass"),
)
MEANS = (
    ("rates", "the rates are", RATE, "rates"),
    ("reactions", "the reactions are", REACTION, "reactions"),
)
MISTAKES = (
    *(
        ReadingMistake(
            f"{part}-by-{name}-differences",
            f"{who} {name} differences of {what} at the samples",
            where,
            by_differences(slope, source, target),
        )
        for part, who, what, source, target, where in SLOPES
        for name, slope in DIFFERENCES
    ),
    *(
        ReadingMistake(
            f"{part}-means-of-two-samples",
            f"{who} means of a sample and the one before",
            where,
            channel(with_sample_before, f),
        )
        for part, who, f, where in MEANS
    ),
)
