"""Readings of a right motion: its arrays, changed or delayed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from barchain.judge.diagnosis.mistake import Mistake
from barchain.metrics.quantities import arrays
from reference_impl.model.kinematics import cross, directions, relative_positions, relative_velocities
from scenarios.channels import COMPARED

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

    Change = Callable[[Array, "Right"], Array]
    """New values of an array, from the right ones"""


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
        chain, rate = self.scene.chain, self.array(RATE)[:, bar, None]
        lever_m = chain.right_m[bar] if side > 0.0 else -chain.left_m[bar]
        return self.places[:, bar] + lever_m * along, self.speeds[:, bar] + lever_m * rate * across


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
