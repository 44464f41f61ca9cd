"""Samples that are taken half a sample or a whole sample too late or too early, or are always the first one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.channels import ANGLE, CHANNELS, COM, RATE, REACTION, VELOCITY, channel, channels_of
from barchain.judge.diagnosis.mistake import ReadingMistake, TimingMistake

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory

DELAYS = (
    (1.0, "a whole sample late"),
    (0.5, "half a sample late"),
    (-0.5, "half a sample early"),
    (-1.0, "a whole sample early"),
)
GROUPS = (
    ("result", "the whole result is", CHANNELS),
    ("reactions", "the reactions are", (REACTION,)),
    ("angles", "the angles are", (ANGLE,)),
    ("angles-and-rates", "the angles and rates are", (ANGLE, RATE)),
    ("centre-of-mass", "the positions of the centre of mass are", (COM,)),
    ("track", "the centre of mass and its velocity are", (COM, VELOCITY)),
    ("velocity", "the velocities of the centre of mass are", (VELOCITY,)),
    ("rates", "the rates are", (RATE,)),
    ("velocities", "the rates and velocities are", (RATE, VELOCITY)),
)
MISTAKES = tuple(
    TimingMistake(f"{name}-{words.replace(' ', '-')}", f"{who} {words}", "samples", late, fields)
    for name, who, fields in GROUPS
    for late, words in DELAYS
)


def held(values: Array) -> Array:
    """First value (n, ...) at all samples."""
    return np.repeat(values[:1], len(values), axis=0)


HELD = (
    ("angles", "the angles stay", (ANGLE,)),
    ("rates", "the rates stay", (RATE,)),
    ("reactions", "the reactions stay", (REACTION,)),
    ("track", "the centre of mass and its velocity stay", (COM, VELOCITY)),
)
HELD_MISTAKES = tuple(
    ReadingMistake(f"{name}-held-at-start", f"{who} as at the first sample", "samples", channel(held, *fields))
    for name, who, fields in HELD
)


def delayed(mistake: TimingMistake, right: Trajectory, halves: Trajectory | None) -> Trajectory | None:
    """Trajectory read with a delay; NaN at the sample that would be outside the run.

    Parameters
    ----------
    mistake : TimingMistake
    right : Trajectory
        n samples.
    halves : Trajectory, optional
        The same motion at the samples and half way between them, 2n - 1 samples.

    Returns
    -------
    Trajectory or None
        None for half a sample without `halves`.
    """
    steps = round(2.0 * mistake.late_samples)
    if steps % 2 and halves is None:
        return None
    dense, stride, shift = (right, 1, steps // 2) if steps % 2 == 0 or halves is None else (halves, 2, steps)
    n, arrays = len(right.t_s), channels_of(dense)
    changes: dict[str, Array | None] = {f: shifted(arrays[f], stride, shift, n) for f in mistake.fields if f in arrays}
    return right.replace(**changes)


def shifted(dense: Array, stride: int, shift: int, n: int) -> Array:
    """Every `stride`-th of dense values (m, ...), `shift` earlier, (n, ...); NaN where there is none."""
    places = np.arange(n) * stride - shift
    inside = (places >= 0) & (places < len(dense))
    found: Array = np.full((n, *dense.shape[1:]), np.nan)
    found[inside] = dense[places[inside]]
    return found
