"""Wrong units and factors."""

from __future__ import annotations

import math

from barchain.judge.diagnosis.channels import (
    ANGLE,
    COM,
    IMPULSE,
    JOINT_FORCES,
    RATE,
    REACTION,
    TORQUE,
    VELOCITY,
    times,
)
from barchain.judge.diagnosis.mistake import ReadingMistake

DEGREES = math.degrees(1.0)
STANDARD_GRAVITY_M_S2 = 9.80665
UNITS = (
    ("angles-in-degrees", "the angles are in degrees", DEGREES, (ANGLE,), "angles"),
    ("rates-in-degrees", "the rates are in degrees per second", DEGREES, (RATE,), "rates"),
    ("angles-and-rates-in-degrees", "the angles and rates are in degrees", DEGREES, (ANGLE, RATE), "angles"),
    ("angles-in-turns", "the angles are in turns", 0.5 / math.pi, (ANGLE,), "angles"),
    ("rates-in-turns-per-second", "the rates are in turns per second", 0.5 / math.pi, (RATE,), "rates"),
    ("rates-in-turns-per-minute", "the rates are in turns per minute", 30.0 / math.pi, (RATE,), "rates"),
    ("centre-of-mass-in-km", "the positions of the centre of mass are in kilometres", 1e-3, (COM,), "centre-of-mass"),
    ("velocity-in-km", "the velocities of the centre of mass are in km/s", 1e-3, (VELOCITY,), "centre-of-mass"),
    ("track-in-km", "the centre of mass and its velocity are in km and km/s", 1e-3, (COM, VELOCITY), "centre-of-mass"),
    ("reactions-in-kn", "the reactions are in kilonewtons", 1e-3, JOINT_FORCES, "reactions"),
    ("reactions-in-mn", "the reactions are in millinewtons", 1e3, JOINT_FORCES, "reactions"),
    ("reactions-in-kgf", "the reactions are in kilogram-force", 1.0 / STANDARD_GRAVITY_M_S2, JOINT_FORCES, "reactions"),
    ("torques-in-kn-m", "the torques are in kN m", 1e-3, (TORQUE,), "torques"),
    ("impulses-in-kn-s", "the impulses are in kN s", 1e-3, (IMPULSE,), "impulses"),
)
DOUBLED = (
    ("reactions", (REACTION,), "reactions"),
    ("angles", (ANGLE,), "angles"),
    ("rates", (RATE,), "rates"),
    ("torques", (TORQUE,), "torques"),
)
FACTORS = ((2.0, "twice"), (0.5, "half"))


MISTAKES = (
    *(ReadingMistake(name, words, where, times(factor, *f)) for name, words, factor, f, where in UNITS),
    *(
        ReadingMistake(f"{part}-{word}", f"the {part} are {word} the right values", where, times(factor, *f))
        for part, f, where in DOUBLED
        for factor, word in FACTORS
    ),
)
