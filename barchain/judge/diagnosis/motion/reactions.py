"""Reactions that follow from other equations than the motion: without a load, or with other masses."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.balance import JOINTS, real
from barchain.judge.diagnosis.motion.candidate import BODIES, Candidate, fixed
from barchain.judge.diagnosis.motion.terms import named, pieces

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.balance import Balance
    from barchain.judge.diagnosis.motion.equations import Load
    from reference_impl.model.arrays import ComplexArray


def of_reactions(b: Balance) -> Iterator[Candidate]:
    """Candidates that act in the reactions alone."""
    for label, section, load in pieces(b):
        if load.acts.any():
            yield fixed(
                f"reactions-without-{named(label)}",
                section,
                partial(response, b, load),
                f"the reactions lack {label}: their equations are solved without this load",
            )
        if load.force.any():
            for side, words in ((1.0, "first"), (-1.0, "last")):
                yield fixed(
                    f"reactions-from-{words}-without-{named(label)}",
                    section,
                    partial(summed, b, load, side),
                    f"the reactions, summed from the {words} bar, lack {label}",
                )
    c = b.scene.chain
    masses = (
        ("reversed", "in reversed order", c.mass_kg[::-1]),
        ("mean", "all the mean mass", (b.scene.mass_kg / b.scene.bars,) * b.scene.bars),
        ("first", "all the first bar's", c.mass_kg[:1] * b.scene.bars),
    )
    for name, words, other in masses:
        ratio = np.array(other) / np.array(c.mass_kg)
        for side, end in ((1.0, "first"), (-1.0, "last")):
            yield fixed(
                f"reactions-with-masses-{name}-from-{end}",
                BODIES,
                partial(with_masses, b, ratio, side),
                f"the masses are {words} in the reactions alone",
            )


def in_joints(b: Balance, joints: ComplexArray) -> Array:
    """Rows (n - 1, c) of vectors at the joints (n - 1, N - 1)."""
    found = np.zeros((len(joints), b.width))
    found[:, b.columns[JOINTS]] = real(joints)
    return found


def response(b: Balance, load: Load) -> Array:
    """Reactions to a load, integrated: of the accelerations that it gives, less the load itself."""
    s, shape = b.equations.states, b.shape
    matrix = shape.coupled(s) + np.diag(shape.inertia)
    turning = np.linalg.solve(matrix, shape.generalised(s, load)[..., None])[..., 0]
    moved: ComplexArray = shape.mass * shape.centres(1j * s.unit * turning)
    apart = load.force - shape.mass * (load.force.sum(axis=1) / shape.whole)[:, None]
    summed_up: ComplexArray = np.cumsum(moved - apart, axis=1)[:, :-1]
    return in_joints(b, b.rule.integral(summed_up))


def summed(b: Balance, load: Load, side: float) -> Array:
    """Load summed over the bars before each joint (side 1) or after it (-1), integrated, with the opposite sign."""
    before: ComplexArray = np.cumsum(load.force, axis=1)
    found: ComplexArray = -before[:, :-1] if side > 0.0 else before[:, -1:] - before[:, :-1]
    return in_joints(b, b.rule.integral(found))


def with_masses(b: Balance, ratio: Array, side: float) -> Array:
    """Momentum gained by joint forces before (side 1) or after (-1) each joint, less that with other masses."""
    s, shape, e = b.motion.states, b.shape, b.equations
    gained = shape.mass * np.diff(shape.centres(1j * s.unit * s.rate), axis=0)
    force = e.total.force
    apart = force - shape.mass * (force.sum(axis=1) / shape.whole)[:, None]
    each = (1.0 - ratio) * (gained - b.rule.integral(apart))
    before = np.cumsum(each, axis=1)
    return in_joints(b, before[:, :-1] if side > 0.0 else before[:, :-1] - before[:, -1:])
