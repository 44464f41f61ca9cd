"""Mistakes of reading: changes of the arrays of a right motion, in one table."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.array_changes import (
    as_text,
    at_point,
    backwards,
    begun_at,
    differences,
    exchanged,
    from_previous,
    in_axes_at,
    in_orbital_rates,
    jumped,
    jumping,
    last_alone,
    longitude_of_bars,
    longitude_of_chain,
    minus,
    ordered,
    plus,
    straight,
    subtracted_from,
    times,
    turned,
    zero_at_start,
)
from barchain.judge.diagnosis.reading import (
    ALL,
    ANGLE,
    COM,
    FORCES,
    HORIZONTAL_RAD,
    PARTS,
    RATE,
    TORQUE,
    VECTORS,
    VELOCITY,
    WHOLE_TURNS,
    Reading,
    Timing,
    unwrapped,
)
from scenarios.toml.effect_tables import EARTH_ROTATION_RAD_S

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.array_changes import Point
    from barchain.judge.diagnosis.reading import Change


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
