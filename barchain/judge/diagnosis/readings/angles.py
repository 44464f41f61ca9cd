"""Angles and rates that count from other directions, or relative to other bodies."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from adapters.common.initial_state import chain_model
from barchain.judge.diagnosis.channels import ANGLE, RATE, changed, channel
from barchain.judge.diagnosis.mistake import ReadingMistake
from reference_impl.model.kinematics import cross, relative_positions, relative_velocities

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ReadingChange
    from scenarios import Scene

    Reference = Callable[[Scene, Trajectory], Array]

WHOLE_TURNS = "angles-with-other-turns"
"""Name of the mistake that is nothing but whole turns"""
HORIZONTAL_RAD = -0.5 * math.pi
"""Direction of the local horizontal relative to the radial direction"""


def wrapped(values: Array) -> Array:
    """Angles in (-pi, pi]."""
    found: Array = -np.remainder(math.pi - values, 2.0 * math.pi) + math.pi
    return found


def wrapped_positive(values: Array) -> Array:
    """Angles in [0, 2 pi)."""
    found: Array = np.remainder(values, 2.0 * math.pi)
    return found


def from_previous(values: Array) -> Array:
    """Values (n, N) relative to the previous bar's; the first bar's are absolute."""
    return np.diff(values, axis=1, prepend=0.0)


def from_next(values: Array) -> Array:
    """Values (n, N) relative to the next bar's; the last bar's are absolute."""
    return from_previous(values[:, ::-1])[:, ::-1]


def from_first_bar(values: Array) -> Array:
    """Values (n, N) relative to the first bar's; the first bar's are absolute."""
    return np.concatenate([values[:, :1], values[:, 1:] - values[:, :1]], axis=1)


def from_start(values: Array) -> Array:
    """Change since the first sample."""
    return values - values[:1]


def longitude_rad(_: Scene, right: Trajectory) -> Array:
    """Longitude of the centre of mass, (n, 1) rad, unwrapped."""
    return unwrapped(np.arctan2(right.com_m[:, 1], right.com_m[:, 0]))[:, None]


def unwrapped(angles: Array) -> Array:
    """Angles (n, ...) without jumps of whole turns between samples; unknown samples stay unknown."""
    found: Array = np.array(angles)
    known = ~np.isnan(angles).reshape(len(angles), -1).any(axis=1)
    found[known] = np.unwrap(angles[known], axis=0)
    return found


def horizontal_rad(scene: Scene, right: Trajectory) -> Array:
    """Angle of the local horizontal of the chain's centre of mass, (n, 1) rad."""
    return longitude_rad(scene, right) + HORIZONTAL_RAD


def bar_places(scene: Scene, right: Trajectory) -> tuple[Array, Array]:
    """Positions and velocities of the bars' centres from the centre of the body, (n, N, 2) m and m/s."""
    assert right.angle_rad is not None
    model = chain_model(scene)
    place = right.com_m[:, None, :] + relative_positions(model, right.angle_rad)
    rate = np.zeros_like(right.angle_rad) if right.rate_rad_s is None else right.rate_rad_s
    return place, right.com_velocity_m_s[:, None, :] + relative_velocities(model, right.angle_rad, rate)


def bar_horizontals_rad(scene: Scene, right: Trajectory) -> Array:
    """Angle of each bar's own local horizontal, (n, N) rad."""
    place, _ = bar_places(scene, right)
    return unwrapped(np.arctan2(place[..., 1], place[..., 0])) + HORIZONTAL_RAD


def start_horizontal_rad(scene: Scene, right: Trajectory) -> Array:
    """Angle of the local horizontal at t = 0, (1, 1) rad."""
    del right
    return np.full((1, 1), scene.orbit.longitude_rad + HORIZONTAL_RAD)


def longitude_rate_rad_s(_: Scene, right: Trajectory) -> Array:
    """Rate of the centre of mass' longitude, (n, 1) rad/s."""
    rate: Array = cross(right.com_m, right.com_velocity_m_s) / np.sum(right.com_m**2, axis=-1)
    return rate[:, None]


def bar_longitude_rates_rad_s(scene: Scene, right: Trajectory) -> Array:
    """Rate of each bar's longitude, (n, N) rad/s."""
    place, velocity = bar_places(scene, right)
    rate: Array = cross(place, velocity) / np.sum(place**2, axis=-1)
    return rate


def start_rate_rad_s(scene: Scene, right: Trajectory) -> Array:
    """Orbital rate at t = 0, (1, 1) rad/s."""
    del right
    return np.full((1, 1), scene.orbital_rate_rad_s)


def mean_motion_rad_s(scene: Scene, right: Trajectory) -> Array:
    """Mean motion of the orbit, (1, 1) rad/s."""
    del right
    return np.full((1, 1), scene.mean_motion_rad_s)


def less(angle: Reference | None, rate: Reference | None) -> ReadingChange:
    """Angles and rates less a reference direction and its rate; None leaves them."""

    def read(scene: Scene, right: Trajectory) -> Trajectory:
        if right.angle_rad is None:
            return right
        new = right
        if angle is not None:
            new = changed(new, lambda v: v - angle(scene, right), ANGLE)
        return new if rate is None else changed(new, lambda v: v - rate(scene, right), RATE)

    return read


def in_orbital_rates(scene: Scene, right: Trajectory) -> Trajectory:
    """Rates over the orbital rate at t = 0."""
    return changed(right, lambda v: v / scene.orbital_rate_rad_s, RATE)


RELATIVE = (
    ("previous", "relative to the previous bar", from_previous),
    ("next", "relative to the next bar", from_next),
    ("first-bar", "relative to the first bar", from_first_bar),
)
DIRECTIONS: tuple[tuple[str, str, Reference, Reference | None], ...] = (
    ("radial", "count from the local vertical", longitude_rad, longitude_rate_rad_s),
    ("horizontal", "count from the chain's local horizontal", horizontal_rad, longitude_rate_rad_s),
    ("bar-horizontal", "count from each bar's local horizontal", bar_horizontals_rad, bar_longitude_rates_rad_s),
    ("start-horizontal", "count from the local horizontal at t = 0", start_horizontal_rad, None),
)
RATE_REFERENCES: tuple[tuple[str, str, Reference], ...] = (
    ("orbit", "the rate of the orbit's longitude", longitude_rate_rad_s),
    ("start", "the orbital rate at t = 0", start_rate_rad_s),
    ("mean-motion", "the mean motion", mean_motion_rad_s),
    ("bar-longitude", "the rate of each bar's own longitude", bar_longitude_rates_rad_s),
)
MISTAKES = (
    ReadingMistake(
        "rates-in-orbital-rates", "the rates are in units of the orbital rate at t = 0", "rates", in_orbital_rates
    ),
    ReadingMistake(
        "angles-wrapped", "the angles are wrapped to half a turn either way", "angles", channel(wrapped, ANGLE)
    ),
    ReadingMistake(
        "angles-wrapped-positive",
        "the angles are wrapped to one positive turn",
        "angles",
        channel(wrapped_positive, ANGLE),
    ),
    ReadingMistake(WHOLE_TURNS, "the angles differ by whole turns", "angles", channel(np.positive, ANGLE), True),
    ReadingMistake(
        "angles-from-start", "the angles count from their first sample", "angles", channel(from_start, ANGLE)
    ),
    ReadingMistake("rates-from-start", "the rates count from their first sample", "rates", channel(from_start, RATE)),
    *(
        ReadingMistake(f"{part}-relative-to-{name}", f"the {words} are {how}", where, channel(change, *fields), True)
        for name, how, change in RELATIVE
        for part, words, fields, where in (
            ("angles", "angles", (ANGLE,), "angles"),
            ("rates", "rates", (RATE,), "rates"),
            ("angles-and-rates", "angles and rates", (ANGLE, RATE), "angles"),
        )
    ),
    *(
        ReadingMistake(f"angles-from-{name}", f"the angles {how}", "angles", less(angle, None), True)
        for name, how, angle, _ in DIRECTIONS
    ),
    *(
        ReadingMistake(
            f"angles-and-rates-from-{name}", f"the angles and rates {how}", "angles", less(angle, rate), True
        )
        for name, how, angle, rate in DIRECTIONS
        if rate is not None
    ),
    *(
        ReadingMistake(f"rates-less-{name}", f"the rates lack {what}", "rates", less(None, rate))
        for name, what, rate in RATE_REFERENCES
    ),
)
