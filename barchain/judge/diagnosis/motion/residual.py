"""Residual of an engine's own motion: its noise, and the blocks of the balance in which it is no noise."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.ndimage import median_filter

from barchain.judge.diagnosis.motion.balance import BARS, CENTRE, JOINTS, LAWS, Balance, real
from barchain.judge.diagnosis.motion.quadrature import DEGREE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.balance import Motion
    from reference_impl.model.arrays import ComplexArray
    from scenarios import Scene

WRONG = 8.0
"""Ratio of a block's residual to its noise, root mean square, from which on it is no noise"""
DIFFERENCES = 4
"""Order of the differences along the samples that show noise"""
CLIPPED = 100.0
"""Times the median difference of two runs that counts: at an event, one of them may have another step"""
LASTING = 5
"""Rows of which the median difference of two runs is noise there: forces may act in a part of the run alone"""
ROUNDINGS, LAW_ROUNDINGS = 8.0, 1e4
"""Roundings of a momentum, and of an angle of a law, whose place is a difference"""
BEGUN = 1e-3
"""Share of a component's largest residual from which on it has begun: events leave small ones around them"""
LEAST_NOISE = 1e-100  # its square is a number, and that of its reciprocal
PLACES = {
    CENTRE: ("N", "at the centre of mass"),
    BARS: ("N m", "on bar {}"),
    JOINTS: ("N", "in the reactions at joint {}"),
    LAWS: ("rad/s", "in the prescribed angle {}"),
}
"""Unit of a block's rate of change, and words for its components"""
MOST_APART = 1e-3
"""Largest departure of angles from the integrals of rates, relative to these, at which a motion has a balance"""
APART_SHARE = 0.1
"""Share of the relative residual of the centre of mass from which on its positions and velocities are apart"""
ANGLES_APART_SHARE = 0.5
"""The same of the bars' angles and rates: methods of low order have them apart by some of their error"""
FEWEST = 8
"""Intervals that show whether a departure has a pattern"""
COUNTED = 0.1
"""Share of the largest departure of a component from which on the others tell a pattern, too"""
MOST_SPIKE = 30.0
"""Largest departure in an interval over the median one that noise leaves"""
SAME_RATIO = 0.01
"""Least ratio over noise of the bars' residual, relative to that of the reactions, that a wrong clock leaves in both"""
LEAST_APART = 1e-6
"""Departure of places from integrals that is told: interpolants of a low order leave up to 1e-6"""


class Residual:
    """Residual of a motion under a scene's right equations."""

    def __init__(self, motion: Motion, scene: Scene, other: Motion | None = None) -> None:
        """Compute the residual.

        Parameters
        ----------
        motion : Motion
        scene : Scene
            Scene at the samples of the motion.
        other : Motion, optional
            The same run at another accuracy: what differs is an error of integration.
        """
        self.motion, self.scene = motion, scene
        self.balance = Balance(motion, scene)
        self.value = self.balance.value
        self.other = None if other is None else self.balance.of_another(other).value

    @cached_property
    def known(self) -> NDArray[np.bool_]:
        """(n - 1,) rows with values."""
        found: NDArray[np.bool_] = np.all(np.isfinite(self.value), axis=1)
        return found

    @cached_property
    def consistent(self) -> bool:
        """Whether angles are integrals of rates and positions those of velocities: without that there is no balance."""
        return not (self.angles_apart > MOST_APART or self.track_apart > MOST_APART)

    @cached_property
    def track_apart(self) -> float:
        """Departure of the centre of mass from the integral of its velocity, relative to that."""
        s = self.motion.states
        return self.apart(real(s.com[:, None]), real(s.velocity[:, None]))

    @cached_property
    def angles_apart(self) -> float:
        """Departure of the angles from the integrals of the rates, relative to these."""
        return self.apart(self.motion.states.angle, self.motion.states.rate)

    def apart(self, place: Array, speed: Array) -> float:
        """Departure of places from the integrals of speeds between samples beyond their error, relative to these."""
        rule = self.balance.rule
        step, error = (of(speed[rule.rows])[self.known] for of in (rule.integral, rule.error))
        departed = np.maximum(np.abs(np.diff(place, axis=0)[self.known] - step) - error, 0.0)
        return float(np.linalg.norm(departed)) / max(float(np.linalg.norm(step)), LEAST_NOISE)

    def scatter(self, place: Array, speed: Array) -> float:
        """Noise of places about the integrals of speeds, root mean square; 0 where they part with a pattern.

        The departure of noise has another sign in the next interval, that of a method or a clock the same.
        """
        rule = self.balance.rule
        step, error = (of(speed[rule.rows])[self.known] for of in (rule.integral, rule.error))
        apart = np.diff(place, axis=0)[self.known] - step
        apart = apart[np.all(error <= np.median(np.abs(apart), axis=0), axis=1)]  # at events no integral tells
        if len(apart) < FEWEST:
            return 0.0
        whole = np.linalg.norm(apart, axis=0)
        apart = apart[:, whole >= COUNTED * whole.max(initial=0.0)]
        size, jumps = (np.median(np.abs(each), axis=0) for each in (apart, np.diff(apart, axis=0)))
        if np.any(jumps < size) or np.any(np.abs(apart).max(axis=0) > MOST_SPIKE * size):
            return 0.0
        return float(np.sqrt(0.5 * np.mean(apart**2)))  # of two places, at both ends of an interval

    @cached_property
    def clock_wrong(self) -> bool:
        """Whether places and velocities, or angles and rates, are apart by as much as the residual: no force does that.

        A clock, a length in other units or a wrong integration does; its accelerations look like those of other loads.
        Where another block is further from noise, the residual of one is a small one of the method.
        """
        s, shape = self.motion.states, self.balance.shape
        most = max(self.ratios, key=lambda name: self.ratios[name])
        if most == CENTRE and CENTRE in self.wrong:
            return self.track_apart > APART_SHARE * self.share(CENTRE, shape.whole * np.diff(s.velocity))
        # reactions show the same, by the accelerations, unless they are wrong by much more than the bars' motion
        if most in {BARS, JOINTS} and BARS in self.wrong and self.ratios[BARS] > SAME_RATIO * self.ratios[most]:
            return self.angles_apart > ANGLES_APART_SHARE * self.share(BARS, np.diff(shape.momenta(s), axis=0))
        return False

    def share(self, block: str, change: Array | ComplexArray) -> float:
        """Residual of a block relative to the change of its momenta between samples."""
        residual = self.value[self.known][:, self.balance.columns[block]]
        return float(np.linalg.norm(residual)) / max(float(np.linalg.norm(change[self.known])), LEAST_NOISE)

    @property
    def apart_words(self) -> str:
        """Sentence on places and angles that are no integrals of velocities and rates; empty where they are."""
        s = self.motion.states
        found, scattered = [], True
        for places, speeds, apart, unit, place, speed in (
            ("positions", "velocities", self.track_apart, "m", real(s.com[:, None]), real(s.velocity[:, None])),
            ("angles", "rates", self.angles_apart, "rad", s.angle, s.rate),
        ):
            if apart > LEAST_APART:
                noise = self.scatter(place, speed)
                by = f"scatter by {noise:.2g} {unit} about" if noise else "differ from"
                of = "" if noise else f" by {apart:.2g} of these"
                found.append(f"{places} {by} the integrals of the {speeds}{of}")
                scattered = scattered and noise > 0.0
        if not found or not (self.clock_wrong or (not self.wrong and bool(self.known.all()))):
            return ""
        also = ", or a load acts at other instants" if self.scene.effects.breaks_s else ""
        why = "the output has noise" if scattered else f"the integration or its clock is wrong{also}"
        return f" Between samples {' and '.join(found)}: {why}."

    @cached_property
    def noise(self) -> Array:
        """Noise of the residual, (n - 1, c)."""
        column, local = differenced_noise(self.value), np.zeros_like(self.value)
        if self.other is not None and self.other.shape == self.value.shape:
            apart = np.abs(self.value - self.other)
            most = CLIPPED * np.nanmedian(apart, axis=0)
            column = np.maximum(column, np.sqrt(np.nanmean(np.minimum(apart, most) ** 2, axis=0)))
            local = median_filter(np.nan_to_num(apart), (LASTING, 1))
        found: Array = np.sqrt(self.balance.error**2 + column**2 + local**2 + self.rounding**2)
        return found

    @property
    def rounding(self) -> Array:
        """Rounding of the momenta, (c,)."""
        b, s = self.balance, self.motion.states
        size = np.zeros(b.width)
        size[:2] = b.shape.whole * np.abs(s.velocity).max()
        size[b.columns[BARS]] = np.abs(b.shape.momenta(s)).max()
        if JOINTS in b.columns:
            size[b.columns[JOINTS]] = np.abs(b.shape.mass * b.shape.centres(1j * s.unit * s.rate)).sum(axis=1).max()
        if LAWS in b.columns:
            size[b.columns[LAWS]] = LAW_ROUNDINGS
        return ROUNDINGS * np.finfo(float).eps * size + LEAST_NOISE

    @cached_property
    def ratios(self) -> dict[str, float]:
        """Residual over noise of each block, root mean square."""
        if not self.known.any():
            return dict.fromkeys(self.balance.columns, 0.0)
        share = (self.value[self.known] / self.noise[self.known]) ** 2
        return {name: float(np.sqrt(share[:, c].mean())) for name, c in self.balance.columns.items()}

    @cached_property
    def wrong(self) -> tuple[str, ...]:
        """Blocks whose residual is no noise."""
        return tuple(name for name, ratio in self.ratios.items() if ratio > WRONG)

    @property
    def begin_s(self) -> float:
        """First instant from which on the residual of an interval is no noise, and no trifle, s; 0 without one."""
        columns = self.balance.of_blocks(self.wrong)
        size = np.abs(self.value[:, columns])
        least = BEGUN * np.nanmax(size, axis=0, initial=0.0)
        over = size > np.maximum(WRONG * self.noise[:, columns], least)  # unknown ones compare as false
        rows = np.flatnonzero(over.any(axis=1))
        return float(self.motion.states.t_s[rows[0]]) if len(rows) else 0.0

    @cached_property
    def moves_right(self) -> bool:
        """Whether centre of mass, bars and prescribed angles move by the right equations."""
        return self.consistent and not set(self.wrong) & {CENTRE, BARS, LAWS}

    @property
    def place(self) -> str:
        """Where the residual is largest, with its size, in words."""
        found = []
        for name in self.wrong:
            c = self.balance.columns[name]
            over = np.sqrt((self.value[self.known][:, c] ** 2).mean(axis=0))
            each = over.reshape(-1, 2).max(axis=1) if name in (CENTRE, JOINTS) else over
            worst = int(np.argmax(each))
            size = each[worst] / float(np.diff(self.motion.states.t_s[:2])[0])
            unit, where = PLACES[name]
            if name == JOINTS and self.motion.impulse is not None:
                where = where.replace("reactions", "reactions or impulses")
            if name == BARS and self.balance.torques_unknown:
                bars = np.flatnonzero(self.balance.free_of_motors[worst]) + 1
                to = "and" if len(bars) == 2 else "to"
                where = f"on bars {bars[0]} {to} {bars[-1]} together" if len(bars) > 1 else where
            found.append(f"{size:.2g} {unit} {where.format(worst + 1)}")
        return ", ".join(found)


def differenced_noise(values: Array) -> Array:
    """Noise of each column (n, c) of values that are smooth along the samples, (c,)."""
    if len(values) <= DEGREE:
        return np.zeros(values.shape[1])
    size = np.abs(np.diff(values, n=DIFFERENCES, axis=0))
    size = size[np.isfinite(size).all(axis=1)]
    if not len(size):
        return np.zeros(values.shape[1])
    found: Array = np.median(size, axis=0) / (0.6745 * math.sqrt(math.comb(2 * DIFFERENCES, DIFFERENCES)))
    return found
