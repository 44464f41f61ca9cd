"""Reactions in other axes or at other joints, and bars in another order."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.channels import ANGLE, IMPULSE, JOINT_FORCES, RATE, TORQUE, changed, channel
from barchain.judge.diagnosis.mistake import ReadingMistake

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ReadingChange
    from scenarios import Scene


def in_axes_at(vectors: Array, angle_rad: Array) -> Array:
    """Components of vectors (n, J, 2) in axes at angles (n, J) or (n, 1) rad from the inertial axes."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def body_axes(side: slice) -> ReadingChange:
    """Reactions in axes of the bars of a side of the joints."""

    def read(_: Scene, right: Trajectory) -> Trajectory:
        if right.angle_rad is None:
            return right
        angle = right.angle_rad[:, side]
        return changed(right, lambda v: in_axes_at(v, angle), *JOINT_FORCES)

    return read


def local_axes(offset_rad: float) -> ReadingChange:
    """Reactions in axes that follow the orbit, the first axis `offset_rad` from the radial direction."""

    def read(_: Scene, right: Trajectory) -> Trajectory:
        longitude = np.arctan2(right.com_m[:, 1], right.com_m[:, 0])[:, None]
        return changed(right, lambda v: in_axes_at(v, longitude + offset_rad), *JOINT_FORCES)

    return read


def joints(change: Callable[[Array], Array]) -> ReadingChange:
    """Reactions and impulses of all joints changed together."""
    return channel(change, *JOINT_FORCES)


def of_next_joint(values: Array) -> Array:
    """Values (n, J, 2) of joint j+1 at joint j; zero at the last joint."""
    return np.concatenate([values[:, 1:], np.zeros_like(values[:, :1])], axis=1)


def of_previous_joint(values: Array) -> Array:
    """Values (n, J, 2) of joint j-1 at joint j; zero at the first joint."""
    return np.concatenate([np.zeros_like(values[:, :1]), values[:, :-1]], axis=1)


def of_each_interval(_: Scene, right: Trajectory) -> Trajectory:
    """Impulses (n, J, 2) since the sample before, where the convention is their sum since t = 0."""
    return changed(right, lambda v: np.diff(v, axis=0, prepend=v[:1]), IMPULSE)


def reversed_order(values: Array) -> Array:
    """Values (n, k, ...) from the last to the first."""
    return values[:, ::-1]


def sums_before(values: Array) -> Array:
    """Sum of the values (n, J, 2) of all joints up to each."""
    return np.cumsum(values, axis=1)


def differences_along(values: Array) -> Array:
    """Difference of the reactions (n, J, 2) at both ends of each bar: the joints' resultant on the bar."""
    return np.diff(values, axis=1, prepend=0.0)


def zero_at_start(values: Array) -> Array:
    """Values with zeros at the first sample."""
    found = values.copy()
    found[0] = 0.0
    return found


def bars_reversed(*fields: str) -> ReadingChange:
    """Arrays of the bars from the last to the first."""
    return channel(reversed_order, *fields)


def chain_reversed(_: Scene, right: Trajectory) -> Trajectory:
    """Chain described from its other end: other order, bars that point backwards, reactions on the other bar."""
    turned = changed(right, lambda v: v[:, ::-1] + math.pi, ANGLE)
    return changed(changed(turned, reversed_order, RATE), lambda v: -v[:, ::-1], *JOINT_FORCES)


FORCES: tuple[tuple[str, str, ReadingChange], ...] = (
    ("in-axes-of-bar-before", "are in body axes of the bar before the joint", body_axes(slice(None, -1))),
    ("in-axes-of-bar-after", "are in body axes of the bar after the joint", body_axes(slice(1, None))),
    ("in-radial-axes", "are in radial and transverse axes", local_axes(0.0)),
    ("in-horizontal-axes", "are in horizontal and radial axes", local_axes(-0.5 * math.pi)),
    ("of-next-joint", "are those of the next joint", joints(of_next_joint)),
    ("of-previous-joint", "are those of the previous joint", joints(of_previous_joint)),
    ("reversed-order", "are in reversed order of the joints", joints(reversed_order)),
    ("summed", "are summed over the joints before", joints(sums_before)),
    ("resultant", "are the resultants on each bar", joints(differences_along)),
    ("zero-at-start", "are zero at the first sample", joints(zero_at_start)),
    ("not-read", "are zero", joints(np.zeros_like)),
)
MISTAKES = (
    *(ReadingMistake(f"reactions-{name}", f"the reactions {what}", "reactions", read) for name, what, read in FORCES),
    ReadingMistake(
        "angles-in-reversed-order", "the angles are in reversed order of the bars", "angles", bars_reversed(ANGLE)
    ),
    ReadingMistake(
        "rates-in-reversed-order", "the rates are in reversed order of the bars", "rates", bars_reversed(RATE)
    ),
    ReadingMistake("bars-in-reversed-order", "the bars are in reversed order", "angles", bars_reversed(ANGLE, RATE)),
    ReadingMistake(
        "bars-and-joints-in-reversed-order",
        "the bars and the joints are in reversed order",
        "angles",
        bars_reversed(ANGLE, RATE, *JOINT_FORCES),
    ),
    ReadingMistake("chain-from-other-end", "the chain is described from its other end", "angles", chain_reversed, True),
    ReadingMistake(
        "impulses-of-each-interval",
        "the impulses are those since the sample before, not their sum since t = 0",
        "impulses",
        of_each_interval,
    ),
    ReadingMistake("torques-in-reversed-order", "the torques are in reversed order", "torques", bars_reversed(TORQUE)),
    ReadingMistake(
        "reactions-in-reversed-order-and-sign",
        "the reactions are in reversed order with the opposite sign",
        "reactions",
        joints(lambda v: -v[:, ::-1]),
    ),
)
