"""Wrong signs, and axes that are turned, mirrored or exchanged."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.channels import (
    ANGLE,
    COM,
    JOINT_FORCES,
    RATE,
    REACTION,
    TORQUE,
    VECTORS,
    VELOCITY,
    changed,
    channel,
    plus,
)
from barchain.judge.diagnosis.mistake import ReadingMistake

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.mistake import ReadingChange
    from scenarios import Scene

TURNS = (1, 2, 3)
"""Quarter turns"""
MIRRORS = (
    ("z1", np.diag([-1.0, 1.0])),
    ("z2", np.diag([1.0, -1.0])),
    ("exchanged", np.array([[0.0, 1.0], [1.0, 0.0]])),
)
MIRROR_WORDS = {"z1": "a reversed z1 axis", "z2": "a reversed z2 axis", "exchanged": "exchanged axes"}
MIRRORED_ANGLE = {"z1": math.pi, "z2": 0.0, "exchanged": 0.5 * math.pi}
"""Sum of an angle and its mirror image, rad"""
PARTS = (
    ("reactions", "the reactions", (REACTION,), "reactions"),
    ("track", "the centre of mass and its velocity", (COM, VELOCITY), "centre-of-mass"),
    ("centre-of-mass", "the positions of the centre of mass", (COM,), "centre-of-mass"),
    ("velocity", "the velocities of the centre of mass", (VELOCITY,), "centre-of-mass"),
)
SIGNS = (
    ("reaction-sign", "the reactions have", JOINT_FORCES, "reactions"),
    ("angle-sign", "the angles have", (ANGLE,), "angles"),
    ("rate-sign", "the rates have", (RATE,), "rates"),
    ("angle-and-rate-sign", "the angles and rates have", (ANGLE, RATE), "angles"),
    ("torque-sign", "the torques have", (TORQUE,), "torques"),
    ("centre-of-mass-sign", "the positions of the centre of mass have", (COM,), "centre-of-mass"),
    ("velocity-sign", "the velocities of the centre of mass have", (VELOCITY,), "centre-of-mass"),
)


def quarter_turns(count: int) -> Array:
    """Matrix that turns row vectors counter-clockwise by quarter turns, (2, 2)."""
    matrix: Array = np.linalg.matrix_power(np.array([[0.0, 1.0], [-1.0, 0.0]]), count)
    return matrix


def by_matrix(matrix: Array, *fields: str) -> ReadingChange:
    """Some arrays of vectors times a matrix (2, 2)."""
    return channel(lambda v: v @ matrix, *fields)


def turned(count: int) -> ReadingChange:
    """The whole result turned counter-clockwise by quarter turns."""

    def read(scene: Scene, right: Trajectory) -> Trajectory:
        vectors = by_matrix(quarter_turns(count), *VECTORS)(scene, right)
        return changed(vectors, lambda v: v + 0.5 * math.pi * count, ANGLE)

    return read


def mirrored(name: str, matrix: Array) -> ReadingChange:
    """The whole result mirrored."""

    def read(scene: Scene, right: Trajectory) -> Trajectory:
        vectors = by_matrix(matrix, *VECTORS)(scene, right)
        angles = changed(vectors, lambda v: MIRRORED_ANGLE[name] - v, ANGLE)
        return changed(angles, np.negative, RATE, TORQUE)

    return read


ANGLE_ORIGINS = {1: "the -z2 axis", 2: "the -z1 axis", 3: "the z2 axis"}
MISTAKES = (
    *(
        ReadingMistake(name, f"{who} the opposite sign", where, channel(np.negative, *f))
        for name, who, f, where in SIGNS
    ),
    *(
        ReadingMistake(
            f"axes-turned-{90 * k}", f"the whole result is turned by {90 * k} degrees", "axes", turned(k), True
        )
        for k in TURNS
    ),
    *(
        ReadingMistake(f"axes-mirrored-{n}", f"the whole result has {MIRROR_WORDS[n]}", "axes", mirrored(n, m), True)
        for n, m in MIRRORS
    ),
    *(
        ReadingMistake(
            f"{part}-turned-{90 * k}", f"{who} are turned by {90 * k} degrees", where, by_matrix(quarter_turns(k), *f)
        )
        for part, who, f, where in PARTS
        for k in (1, 3)
    ),
    *(
        ReadingMistake(f"{part}-mirrored-{n}", f"{who} have {MIRROR_WORDS[n]}", where, by_matrix(m, *f))
        for part, who, f, where in PARTS
        for n, m in MIRRORS
    ),
    *(
        ReadingMistake(
            f"angles-turned-{90 * k}",
            f"the angles count from {ANGLE_ORIGINS[k]}",
            "angles",
            plus(0.5 * math.pi * k, ANGLE),
            True,
        )
        for k in TURNS
    ),
)
