"""Mistakes of reading: changes of the arrays of a right motion, in one table."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from adapters.common.initial_state import chain_model, initial_state
from barchain.judge.diagnosis.mistake import Mistake
from barchain.metrics.quantities import arrays
from reference_impl.model.kinematics import cross, directions, relative_positions, relative_velocities
from scenarios.channels import COMPARED
from scenarios.toml.effect_tables import EARTH_ROTATION_RAD_S

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

    Change = Callable[[Array, "Right"], Array]
    """New values of an array, from the right ones"""
    Point = Callable[["Right"], tuple[Array, Array]]
    """Position and velocity of a point, (n, 2) m and m/s"""

REACTION, TORQUE, ANGLE, RATE = "reaction_N", "torque_N_m", "angle_rad", "rate_rad_s"
COM, VELOCITY, IMPULSE = "com_m", "com_velocity_m_s", "impulse_N_s"
ALL = tuple(channel.array for channel in COMPARED)
VECTORS = tuple(channel.array for channel in COMPARED if len(channel.stems) > 1)
"""Arrays of vectors in inertial axes, (..., 2)"""
FORCES = (REACTION, IMPULSE)
WHOLE_TURNS = "angles-with-other-turns"
"""Name of the mistake that is nothing but whole turns"""
HORIZONTAL_RAD = -0.5 * math.pi
"""Direction of the local horizontal relative to the radial direction"""


class Part(NamedTuple):
    """Arrays that are read wrong together."""

    who: str
    """Noun in the plural"""
    fields: tuple[str, ...]
    section: str


PARTS = {
    "reactions": Part("reactions", (REACTION,), "reactions"),
    "joint-forces": Part("reactions", FORCES, "reactions"),
    "impulses": Part("impulses", (IMPULSE,), "impulses"),
    "torques": Part("torques", (TORQUE,), "torques"),
    "angles": Part("angles", (ANGLE,), "angles"),
    "rates": Part("rates", (RATE,), "rates"),
    "angles-and-rates": Part("angles and rates", (ANGLE, RATE), "angles"),
    "centre-of-mass": Part("positions of the centre of mass", (COM,), "centre-of-mass"),
    "velocity": Part("velocities of the centre of mass", (VELOCITY,), "centre-of-mass"),
    "track": Part("centre of mass and its velocity", (COM, VELOCITY), "centre-of-mass"),
    "velocities": Part("rates and velocities", (RATE, VELOCITY), "rates"),
}


class UnreadableError(Exception):
    """An array or a unit that a reading is made of is not there."""


class Right:
    """A right motion of n samples, with what its arrays are turned, shifted or counted by; computed once."""

    def __init__(self, scene: Scene, motion: Trajectory) -> None:
        """Keep the arguments."""
        self.scene, self.motion = scene, motion

    def array(self, field: str) -> Array:
        """Array of the motion."""
        values: Array | None = getattr(self.motion, field)
        if values is None:
            raise UnreadableError(field)
        return values

    def intervals(self, field: str) -> Array:
        """Slope of an array between samples, (n - 1, ...)."""
        values, t_s = self.array(field), self.motion.t_s
        if len(t_s) == 1:
            raise UnreadableError(field)
        slope: Array = np.diff(values, axis=0) / np.diff(t_s).reshape(-1, *[1] * (values.ndim - 1))
        return slope

    @cached_property
    def start(self) -> InitialState:
        """Right initial state."""
        return initial_state(self.scene)

    @cached_property
    def longitude(self) -> Array:
        """Longitude of the centre of mass, (n, 1) rad, unwrapped."""
        return unwrapped(np.arctan2(self.motion.com_m[:, 1], self.motion.com_m[:, 0]))[:, None]

    @cached_property
    def longitude_rate(self) -> Array:
        """Rate of the longitude, (n, 1) rad/s."""
        com = self.motion.com_m
        with np.errstate(divide="ignore", invalid="ignore"):  # no number at the body's centre: it explains nothing
            rate: Array = cross(com, self.motion.com_velocity_m_s) / np.sum(com**2, axis=-1)
        return rate[:, None]

    @cached_property
    def places(self) -> Array:
        """Bars' centres from the centre of the body, (n, N, 2) m."""
        return self.motion.com_m[:, None, :] + relative_positions(chain_model(self.scene), self.array(ANGLE))

    @cached_property
    def speeds(self) -> Array:
        """Velocities of the bars' centres, (n, N, 2) m/s."""
        relative = relative_velocities(chain_model(self.scene), self.array(ANGLE), self.array(RATE))
        return self.motion.com_velocity_m_s[:, None, :] + relative

    @cached_property
    def bar_longitudes(self) -> Array:
        """Longitude of each bar's centre, (n, N) rad, unwrapped."""
        return unwrapped(np.arctan2(self.places[..., 1], self.places[..., 0]))

    @cached_property
    def bar_longitude_rates(self) -> Array:
        """Rate of each bar's longitude, (n, N) rad/s."""
        rate: Array = cross(self.places, self.speeds) / np.sum(self.places**2, axis=-1)
        return rate

    def end(self, bar: int, side: float) -> tuple[Array, Array]:
        """Position and velocity of the left (-1) or right end (+1) of a bar, (n, 2) m and m/s."""
        along, across = directions(self.array(ANGLE)[:, bar])
        half_m = side * chain_model(self.scene).half_m[bar]
        rate = self.array(RATE)[:, bar, None]
        return self.places[:, bar] + half_m * along, self.speeds[:, bar] + half_m * rate * across


@dataclass(frozen=True)
class Reading(Mistake):
    """Altered reading of the right motion."""

    changes: Mapping[str, Change]
    """Change of each altered array of `Trajectory`"""
    any_turns: bool = False
    """Whether the angles may differ by whole turns, 2 pi times a constant integer for each bar"""

    def read(self, scene: Scene, motion: Trajectory) -> Trajectory:
        """Trajectory of an engine with this mistake; the right one where arrays are missing."""
        right = Right(scene, motion)
        present = {f: change for f, change in self.changes.items() if getattr(motion, f) is not None}
        try:
            return motion.replace(**{f: change(right.array(f), right) for f, change in present.items()})
        except UnreadableError:
            return motion


@dataclass(frozen=True)
class Timing(Mistake):
    """Samples of some channels taken too late or too early."""

    late_samples: float
    """Delay of the reading: sample k holds the state of sample k minus this number; -1, -1/2, 1/2 or 1"""
    fields: tuple[str, ...]
    """Arrays of `Trajectory` that are delayed"""

    def read(self, motion: Trajectory, halves: Trajectory | None) -> Trajectory | None:
        """Trajectory read with a delay; NaN at the sample that would be outside the run.

        Parameters
        ----------
        motion : Trajectory
            Right motion, n samples.
        halves : Trajectory, optional
            The same motion at the samples and half way between them, 2n - 1 samples.

        Returns
        -------
        Trajectory or None
            None for half a sample without `halves`.
        """
        steps, n = round(2.0 * self.late_samples), len(motion.t_s)
        if steps % 2 == 0:
            dense, rows = motion, np.arange(n) - steps // 2
        elif halves is not None:
            dense, rows = halves, 2 * np.arange(n) - steps
        else:
            return None
        inside = (rows >= 0) & (rows < len(dense.t_s))
        found = {}
        for field, values in arrays(dense).items():
            if field in self.fields:
                found[field] = np.full((n, *values.shape[1:]), np.nan)
                found[field][inside] = values[rows[inside]]
        return motion.replace(**found)


def unwrapped(angles: Array) -> Array:
    """Angles (n, ...) without jumps of whole turns between samples; unknown samples stay unknown."""
    found: Array = np.array(angles)
    known = ~np.isnan(angles).reshape(len(angles), -1).any(axis=1)
    found[known] = np.unwrap(angles[known], axis=0)
    return found


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


def of(part: str, name: str, words: str, change: Change, *, turns: bool = False) -> Reading:
    """Reading of a part, whose name comes before the rest of name and words."""
    who, fields, section = PARTS[part]
    prefix = "reactions" if part == "joint-forces" else part
    return Reading(f"{prefix}-{name}", f"the {who} {words}", section, dict.fromkeys(fields, change), turns)


def less(name: str, words: str, angle: Change | None, rate: Change | None) -> Reading:
    """Angles less a direction, rates less its rate, or both."""
    changes = {ANGLE: angle, RATE: rate}
    kept = {field: minus(c) for field, c in changes.items() if c is not None}
    return Reading(name, f"the {words}", "rates" if angle is None else "angles", kept, angle is not None)


SIGNS = (
    ("reaction-sign", "joint-forces"),
    ("angle-sign", "angles"),
    ("rate-sign", "rates"),
    ("angle-and-rate-sign", "angles-and-rates"),
    ("torque-sign", "torques"),
    ("centre-of-mass-sign", "centre-of-mass"),
    ("velocity-sign", "velocity"),
)
MIRRORS: tuple[tuple[str, str, Change, float], ...] = (
    ("z1", "a reversed z1 axis", lambda v, _: v * np.array([-1.0, 1.0]), math.pi),
    ("z2", "a reversed z2 axis", lambda v, _: v * np.array([1.0, -1.0]), 0.0),
    ("exchanged", "exchanged axes", lambda v, _: v[..., ::-1], 0.5 * math.pi),
)
"""Mirrors of vectors, and the sum of an angle and its mirror image, rad"""
DEGREES, TURNS, GRAVITY_M_S2 = math.degrees(1.0), 0.5 / math.pi, 9.80665
UNITS = (
    ("angles", "in-degrees", "in degrees", DEGREES),
    ("rates", "in-degrees", "in degrees per second", DEGREES),
    ("angles-and-rates", "in-degrees", "in degrees", DEGREES),
    ("angles", "in-turns", "in turns", TURNS),
    ("rates", "in-turns-per-second", "in turns per second", TURNS),
    ("rates", "in-turns-per-minute", "in turns per minute", 60.0 * TURNS),
    ("centre-of-mass", "in-km", "in kilometres", 1e-3),
    ("velocity", "in-km", "in km/s", 1e-3),
    ("track", "in-km", "in km and km/s", 1e-3),
    ("joint-forces", "in-kn", "in kilonewtons", 1e-3),
    ("joint-forces", "in-mn", "in millinewtons", 1e3),
    ("joint-forces", "in-kgf", "in kilogram-force", 1.0 / GRAVITY_M_S2),
    ("torques", "in-kn-m", "in kN m", 1e-3),
    ("impulses", "in-kn-s", "in kN s", 1e-3),
)
WRAPPED: tuple[tuple[str, str, Change], ...] = (
    ("wrapped", "half a turn either way", lambda v, _: math.pi - np.remainder(math.pi - v, 2.0 * math.pi)),
    ("wrapped-positive", "one positive turn", lambda v, _: np.remainder(v, 2.0 * math.pi)),
)
UNWRAPPED: tuple[tuple[str, str, Change], ...] = (
    ("unwrapped", "are", lambda v, _: unwrapped(v)),
    ("of-unwrapped-joints", "are sums of joint angles", lambda v, _: np.cumsum(unwrapped(from_previous(v)), axis=1)),
)
RELATIVE: tuple[tuple[str, Change], ...] = (
    ("previous bar", lambda v, _: from_previous(v)),
    ("next bar", lambda v, _: backwards(from_previous(backwards(v)))),
    ("first bar", lambda v, _: np.concatenate([v[:, :1], v[:, 1:] - v[:, :1]], axis=1)),
)
DIRECTIONS: tuple[tuple[str, str, Change, Change | None], ...] = (
    ("radial", "local vertical", lambda _, m: m.longitude, lambda _, m: m.longitude_rate),
    ("horizontal", "chain's local horizontal", lambda _, m: m.longitude + HORIZONTAL_RAD,
     lambda _, m: m.longitude_rate),
    ("bar-horizontal", "each bar's local horizontal", lambda _, m: m.bar_longitudes + HORIZONTAL_RAD,
     lambda _, m: m.bar_longitude_rates),
    ("start-horizontal", "local horizontal at t = 0",
     lambda v, m: np.full_like(v[:1], m.scene.orbit.longitude_rad + HORIZONTAL_RAD), None),
)  # fmt: skip
RATES: tuple[tuple[str, str, Change], ...] = (
    ("orbit", "the rate of the orbit's longitude", lambda _, m: m.longitude_rate),
    ("start", "the orbital rate at t = 0", lambda v, m: np.full_like(v[:1], m.scene.orbital_rate_rad_s)),
    ("mean-motion", "the mean motion", lambda v, m: np.full_like(v[:1], m.scene.mean_motion_rad_s)),
    ("bar-longitude", "the rate of each bar's own longitude", lambda _, m: m.bar_longitude_rates),
)
JOINTS: tuple[tuple[str, str, Change], ...] = (
    ("in-axes-of-bar-before", "in body axes of the bar before the joint",
     lambda v, m: in_axes_at(v, m.array(ANGLE)[:, :-1])),
    ("in-axes-of-bar-after", "in body axes of the bar after the joint",
     lambda v, m: in_axes_at(v, m.array(ANGLE)[:, 1:])),
    ("in-radial-axes", "in radial and transverse axes", lambda v, m: in_axes_at(v, m.longitude)),
    ("in-horizontal-axes", "in horizontal and radial axes",
     lambda v, m: in_axes_at(v, m.longitude + HORIZONTAL_RAD)),
    ("of-next-joint", "those of the next joint",
     lambda v, _: np.concatenate([v[:, 1:], np.zeros_like(v[:, :1])], axis=1)),
    ("of-previous-joint", "those of the previous joint",
     lambda v, _: np.concatenate([np.zeros_like(v[:, :1]), v[:, :-1]], axis=1)),
    ("reversed-order", "in reversed order of the joints", lambda v, _: backwards(v)),
    ("in-reversed-order-and-sign", "in reversed order with the opposite sign", lambda v, _: -backwards(v)),
    ("sorted-as-text", "sorted as text, joint 10 before joint 2", lambda v, _: as_text(v)),
    ("summed", "summed over the joints before", lambda v, _: np.cumsum(v, axis=1)),
    ("resultant", "the resultants on each bar", lambda v, _: from_previous(v)),
    ("zero-at-start", "zero at the first sample", zero_at_start),
    ("not-read", "zero", lambda v, _: np.zeros_like(v)),
)  # fmt: skip
ORDERS: tuple[tuple[str, str, Callable[[Array], Array], tuple[str, ...], str], ...] = (
    ("angles-in-reversed-order", "angles are in reversed order of the bars", backwards, (ANGLE,), "angles"),
    ("rates-in-reversed-order", "rates are in reversed order of the bars", backwards, (RATE,), "rates"),
    ("bars-in-reversed-order", "bars are in reversed order", backwards, (ANGLE, RATE), "angles"),
    ("bars-and-joints-in-reversed-order", "bars and the joints are in reversed order", backwards,
     (ANGLE, RATE, *FORCES), "angles"),
    ("torques-in-reversed-order", "torques are in reversed order", backwards, (TORQUE,), "torques"),
    *(
        (f"{name}-{k}-and-{k + 1}-exchanged", f"{who} of bars {k} and {k + 1} are exchanged", exchanged(k), fields, at)
        for name, who, fields, at in (
            ("angles", "angles", (ANGLE,), "angles"),
            ("rates", "rates", (RATE,), "rates"),
            ("bars", "angles and rates", (ANGLE, RATE), "angles"),
        )
        for k in (1, 2, 3)
    ),
    ("bars-sorted-as-text", "bars are sorted as text, bar 10 before bar 2", as_text, (ANGLE, RATE), "angles"),
    ("bars-and-joints-sorted-as-text", "bars and the joints are sorted as text, 10 before 2", as_text,
     (ANGLE, RATE, *FORCES), "angles"),
)  # fmt: skip
POINTS: tuple[tuple[str, str, Point], ...] = (
    ("first-bar", "the first bar's centre", lambda m: (m.places[:, 0], m.speeds[:, 0])),
    ("last-bar", "the last bar's centre", lambda m: (m.places[:, -1], m.speeds[:, -1])),
    ("left-end", "the chain's left end", lambda m: m.end(0, -1.0)),
    ("right-end", "the chain's right end", lambda m: m.end(-1, 1.0)),
    ("unweighted-centre", "the bars' centres without their masses",
     lambda m: (m.places.mean(axis=1), m.speeds.mean(axis=1))),
)  # fmt: skip
HELD = ("angles", "rates", "reactions", "track")
STRAIGHT = (2, 10)
"""Numbers of samples between which a program may draw straight lines"""
FROM_START: tuple[tuple[str, str, Change], ...] = (
    ("centre-of-mass", "count from", lambda v, m: v - m.start.com_m),
    ("velocity", "are relative to", lambda v, m: v - m.start.com_velocity_m_s),
)


def track_readings() -> Iterator[Reading]:
    """Positions and velocities of other points, from other origins, in other axes."""
    for part, verb, change in FROM_START:
        yield of(part, "from-start", f"{verb} the first sample", change)
    both = {COM: FROM_START[0][2], VELOCITY: FROM_START[1][2]}
    said = "the centre of mass and its velocity are relative to the first sample"
    yield Reading("track-from-start", said, "centre-of-mass", both)
    for name, words, change in (
        ("rotating", "velocities are relative to axes that turn with the orbit",
         lambda v, m: v - m.longitude_rate * turned(1)(m.motion.com_m, m)),
        ("earth", "velocities are relative to axes that turn with the Earth",
         lambda v, m: v - EARTH_ROTATION_RAD_S * turned(1)(m.motion.com_m, m)),
        ("radial", "velocity is given by its radial and transverse components",
         lambda v, m: in_axes_at(v, m.longitude[:, 0])),
    ):  # fmt: skip
        yield Reading(f"velocity-in-{name}-axes", f"the {words}", "centre-of-mass", {VELOCITY: change})
    for name, what, point in POINTS:
        at = {COM: at_point(point, 0), VELOCITY: at_point(point, 1)}
        for part, words, fields in (
            ("track", "track is that", (COM, VELOCITY)),
            ("position", "positions alone are those", (COM,)),
            ("velocity", "velocities alone are those", (VELOCITY,)),
        ):
            yield Reading(f"{part}-of-{name}", f"the {words} of {what}", "centre-of-mass", {f: at[f] for f in fields})
        said = f"the orbit's first position is taken as that of {what}, not of the centre of mass"
        yield Reading(f"position-from-{name}", said, "centre-of-mass", {COM: begun_at(point)})


def axes_readings() -> Iterator[Reading]:
    """The whole result turned or mirrored, or vectors alone, or angles alone."""
    for k in (1, 2, 3):
        angle: dict[str, Change] = {ANGLE: plus(0.5 * math.pi * k)}
        yield Reading(f"axes-turned-{90 * k}", f"the whole result is turned by {90 * k} degrees", "axes",
                      dict.fromkeys(VECTORS, turned(k)) | angle, True)  # fmt: skip
        origin = {1: "-z2", 2: "-z1", 3: "z2"}[k]
        yield of("angles", f"turned-{90 * k}", f"count from the {origin} axis", angle[ANGLE], turns=True)
    for name, words, mirror, total in MIRRORS:
        others: dict[str, Change] = dict.fromkeys((RATE, TORQUE), times(-1.0))
        others[ANGLE] = subtracted_from(total)
        yield Reading(f"axes-mirrored-{name}", f"the whole result has {words}", "axes",
                      dict.fromkeys(VECTORS, mirror) | others, True)  # fmt: skip
    for part in ("reactions", "track", "centre-of-mass", "velocity"):
        for k in (1, 3):
            yield of(part, f"turned-{90 * k}", f"are turned by {90 * k} degrees", turned(k))
        for name, words, mirror, _ in MIRRORS:
            yield of(part, f"mirrored-{name}", f"have {words}", mirror)


def in_orbital_rates(values: Array, right: Right) -> Array:
    """Values over the orbital rate at t = 0; there is no such unit where the chain starts at rest."""
    rate = right.scene.orbital_rate_rad_s
    if rate == 0.0:
        raise UnreadableError("orbital rate")
    found: Array = values / rate
    return found


def angle_readings() -> Iterator[Reading]:
    """Angles and rates that count from other directions, or relative to other bodies."""
    yield of("rates", "in-orbital-rates", "are in units of the orbital rate at t = 0",
             in_orbital_rates)  # fmt: skip
    for name, words, change in WRAPPED:
        yield of("angles", name, f"are wrapped to {words}", change)
    for name, words, change in UNWRAPPED:
        said = f"{words} unwrapped from sample to sample, and lose whole turns between these"
        yield of("angles", name, said, change, turns=True)
    yield Reading(WHOLE_TURNS, "the angles differ by whole turns", "angles", {ANGLE: times(1.0)}, True)
    for part in ("angles", "rates"):
        yield of(part, "from-start", "count from their first sample", lambda v, _: v - v[:1])
    for whose, change in RELATIVE:
        for part in ("angles", "rates", "angles-and-rates"):
            name = whose if whose == "first bar" else whose.partition(" ")[0]
            yield of(part, f"relative-to-{name.replace(' ', '-')}", f"are relative to the {whose}", change, turns=True)
    for name, where, angle, rate in DIRECTIONS:
        article = "" if where.startswith("each") else "the "
        yield less(f"angles-from-{name}", f"angles count from {article}{where}", angle, None)
        if rate is not None:
            yield less(f"angles-and-rates-from-{name}", f"angles and rates count from {article}{where}", angle, rate)
    for name, what, rate in RATES:
        yield less(f"rates-less-{name}", f"rates lack {what}", None, rate)


def jumping_readings() -> Iterator[Reading]:
    """Angles from, or made with, a longitude by atan2 that jumps by a whole turn."""
    for wrapped, range_words, wrap in WRAPPED:
        for name, where, whose, offset, rate in (
            ("radial", "the local vertical", longitude_of_chain, 0.0, DIRECTIONS[0][3]),
            ("horizontal", "the chain's local horizontal", longitude_of_chain, HORIZONTAL_RAD, DIRECTIONS[1][3]),
            ("bar-horizontal", "each bar's local horizontal", longitude_of_bars, HORIZONTAL_RAD, DIRECTIONS[2][3]),
        ):
            said = f"count from {where} by a longitude that jumps, wrapped to {range_words}"
            direction = partial(jumping, wrap, whose, offset)
            yield less(f"angles-from-{wrapped}-{name}", f"angles {said}", direction, None)
            yield less(f"angles-and-rates-from-{wrapped}-{name}", f"angles and rates {said}", direction, rate)
        for name, whose in (("chain", longitude_of_chain), ("bar", longitude_of_bars)):
            said = f"jump by a whole turn with the {name}'s longitude, wrapped to {range_words}"
            yield of("angles", f"jump-with-{name}-longitude-{wrapped}", said, partial(jumped, wrap, whose), turns=True)


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


def joint_readings() -> Iterator[Reading]:
    """Reactions in other axes or at other joints, and bars in another order."""
    for name, what, change in JOINTS:
        yield of("joint-forces", name, f"are {what}", change)
    for name, words, order, fields, section in ORDERS:
        yield Reading(name, f"the {words}", section, dict.fromkeys(fields, ordered(order)))
    other_end: dict[str, Change] = {ANGLE: lambda v, _: backwards(v) + math.pi, RATE: lambda v, _: backwards(v)}
    yield Reading("chain-from-other-end", "the chain is described from its other end", "angles",
                  other_end | dict.fromkeys(FORCES, lambda v, _: -backwards(v)), True)  # fmt: skip
    yield of("impulses", "of-each-interval", "are those since the sample before, not their sum since t = 0",
             lambda v, _: np.diff(v, axis=0, prepend=v[:1]))  # fmt: skip
    yield of("impulses", "of-last-instant", "are those of the last instant, not their sum since t = 0", last_alone)


def sampled_readings() -> Iterator[Reading]:
    """Rates and velocities made of neighbouring samples, and values that stay as at the first one."""
    for name, who, what, source, target, section in (
        ("rates", "rates", "the angles", ANGLE, RATE, "rates"),
        ("velocities", "velocities of the centre of mass", "its positions", COM, VELOCITY, "centre-of-mass"),
    ):
        for way, slope in differences(source):
            said = f"the {who} are {way} differences of {what} at the samples"
            yield Reading(f"{name}-by-{way}-differences", said, section, {target: slope})
    for part in ("rates", "reactions", "velocity"):
        yield of(part, "means-of-two-samples", "are means of a sample and the one before",
                 lambda v, _: 0.5 * (v + np.concatenate([v[:1], v[:-1]])))  # fmt: skip
    for part in ("angles", "rates", "reactions", "torques", "centre-of-mass", "velocity"):
        yield of(part, "repeated-at-end", "repeat at the last sample those of the one before",
                 lambda v, _: np.concatenate([v[:-1], v[-2:-1]]))  # fmt: skip
    for every in STRAIGHT:
        which = "every second sample" if every == 2 else f"every {every}th sample"
        words = f"straight lines between {which}"
        yield Reading(f"result-straight-between-{every}", f"the samples are {words}", "samples",
                      dict.fromkeys(ALL, straight(every)))  # fmt: skip
        for part in ("angles-and-rates", "angles", "rates", "reactions", "track"):
            yield of(part, f"straight-between-{every}", f"are {words}", straight(every))
    for part in HELD:
        who, fields, _ = PARTS[part]
        yield Reading(f"{part}-held-at-start", f"the {who} stay as at the first sample", "samples",
                      dict.fromkeys(fields, lambda v, _: np.repeat(v[:1], len(v), axis=0)))  # fmt: skip


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


READINGS: tuple[Reading, ...] = (
    *(Reading(name, f"the {PARTS[p].who} have the opposite sign", PARTS[p].section,
              dict.fromkeys(PARTS[p].fields, times(-1.0))) for name, p in SIGNS),
    *(of(part, name, f"are {unit}", times(factor)) for part, name, unit, factor in UNITS),
    *(of(part, word, f"are {word} the right values", times(factor))
      for part in ("reactions", "angles", "rates", "torques") for word, factor in (("twice", 2.0), ("half", 0.5))),
    *axes_readings(),
    *angle_readings(),
    *jumping_readings(),
    *joint_readings(),
    *track_readings(),
    *sampled_readings(),
)  # fmt: skip
LATE = (
    (1.0, "a whole sample late"), (0.5, "half a sample late"),
    (-0.5, "half a sample early"), (-1.0, "a whole sample early"),
)  # fmt: skip
DELAYED = (
    "reactions", "torques", "angles", "angles-and-rates", "centre-of-mass", "track", "velocity", "rates", "velocities",
)  # fmt: skip
TIMINGS = tuple(
    Timing(f"{name}-{words.replace(' ', '-')}", f"the {who} {words}", "samples", late, fields)
    for name, who, fields in (
        ("result", "whole result is", ALL),
        *((part, f"{PARTS[part].who} are", PARTS[part].fields) for part in DELAYED),
    )
    for late, words in LATE
)
