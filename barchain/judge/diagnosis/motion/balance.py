"""Balance of momenta between the samples of an engine's own motion: gains that the right equations lack."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.quadrature import SAME_INSTANT, quadrature
from barchain.judge.equations import ENDS, Equations, Load, Shape, States, mode_changes, states_of
from reference_impl.model.complex_vectors import as_complex, unit_along
from scenarios import Actuator, Axes, Frame

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.motion.quadrature import Quadrature
    from reference_impl.model.arrays import ComplexArray
    from scenarios import Impulse, Scene

CENTRE, BARS, JOINTS, LAWS = "the centre of mass", "the bars", "the joints", "the prescribed angles"
FEWEST = 8
"""Samples without which a motion has no balance"""


@dataclass(frozen=True)
class Motion:
    """An engine's own motion at n samples; plane vectors are complex."""

    states: States
    reaction: ComplexArray | None
    """(n, N-1) N"""
    torque: Array | None
    """(n, P) N m; None: unknown, where a scene prescribes rotations"""
    impulse: ComplexArray | None
    """(n, N-1) N s"""


def motion_of(t: Trajectory) -> Motion | None:
    """Motion of a trajectory; None without angles and rates, or with few samples."""
    states = states_of(t)
    if states is None or len(t.t_s) < FEWEST:
        return None
    reaction, impulse = (None if v is None or not v.size else as_complex(v) for v in (t.reaction_N, t.impulse_N_s))
    return Motion(states, reaction, t.torque_N_m, impulse)


def real(vectors: ComplexArray) -> Array:
    """Components of complex vectors (n, k), (n, 2k)."""
    return np.stack([vectors.real, vectors.imag], axis=-1).reshape(len(vectors), 2 * vectors.shape[-1])


class Balance:
    """Balance of one motion under the equations of one scene.

    Rows belong to the intervals between samples. Columns are the components of the blocks: momentum of the centre of
    mass (2), of each bar's angle (N), of the bars before each joint (2N - 2; with reactions), and the gain of each
    prescribed angle (P).
    """

    def __init__(
        self,
        motion: Motion,
        scene: Scene,
        hidden: Sequence[int] | None = None,
        reach: tuple[float, float] = ENDS,
        beside: Balance | None = None,
    ) -> None:
        """Keep the arguments.

        `hidden` are the intervals in which an effect changes its mode, found by default. Loads that are the same in the
        balance of another scene, `beside` this one, are taken from there.
        """
        self.motion, self.scene = motion, scene
        if hidden is None:
            changed = (np.nonzero(each)[0].tolist() for _, each in mode_changes(Equations(scene, motion.states)))
            hidden = sorted(set().union(*changed))
        self.hidden = hidden
        rule = quadrature(motion.states.t_s, scene.effects.breaks_s, self.hidden, often=beside is None)
        shared = beside if beside is not None and rule.alike(beside.rule) else None
        self.rule: Quadrature = rule if shared is None else shared.rule
        self.angles: dict[float, Array] = {} if shared is None else shared.angles
        """Angles of the bars at impulses, by the instant, rad"""
        spans = tuple(self.rule.pieces[p] for p in self.rule.piece)
        self.equations = Equations(scene, motion.states.at(self.rule.rows), spans, reach)
        if beside is not None and self.equations.alike(other := beside.equations):
            known = tuple(zip(other.model.effects, other.effects, strict=True))
            self.equations = dataclasses.replace(self.equations, known=known)

    def of_another(self, motion: Motion) -> Balance:
        """Balance of another motion under the same equations; at the same samples, the weights are found once."""
        found = Balance(motion, self.scene, self.hidden)
        if found.rule.alike(self.rule) and np.array_equal(found.rule.t_s, self.rule.t_s):
            found.rule = self.rule
        return found

    @property
    def shape(self) -> Shape:
        """Masses and lengths of the scene."""
        return self.equations.shape

    @cached_property
    def columns(self) -> dict[str, slice]:
        """Columns of each block that the motion has."""
        n, laws = self.motion.states.bars, len(self.scene.effects.prescribed_rotation)
        joints = 2 * (n - 1) if self.motion.reaction is not None else 0
        ends = np.cumsum([0, 2, n, joints, laws]).tolist()
        names = (CENTRE, BARS, JOINTS, LAWS)
        return {name: slice(a, b) for name, a, b in zip(names, ends[:-1], ends[1:], strict=True) if b > a}

    def of_blocks(self, names: Iterable[str]) -> NDArray[np.intp]:
        """Columns of some blocks."""
        own = (np.arange(self.columns[name].start, self.columns[name].stop) for name in names)
        return np.concatenate([np.arange(0), *own])

    @property
    def width(self) -> int:
        """Number of columns."""
        return max(int(c.stop) for c in self.columns.values())

    def blocks(self, states: States, load: Load, centre: ComplexArray | float = 0.0) -> Array:
        """Rates of change (k, c) by a load, with a field at the centre of mass (k,)."""
        mean = load.force.sum(axis=1) / self.shape.whole
        found = np.zeros((len(states.t_s), self.width))
        found[:, :2] = real((self.shape.whole * (centre + load.common + mean))[:, None])
        found[:, self.columns[BARS]] = self.shape.generalised(states, load)
        if JOINTS in self.columns:
            found[:, self.columns[JOINTS]] = real(np.cumsum(self.shape.apart(load.force), axis=1)[:, :-1])
        return found

    def rows(self, load: Load) -> Array:
        """Gains of momentum by a load, (n - 1, c)."""
        return self.without_motors(self.rule.integral(self.blocks(self.equations.states, load)))

    def block(self, name: str, values: Array) -> Array:
        """Rows (n - 1, c) with values in the columns of one block alone."""
        found = np.zeros((len(values), self.width))
        found[:, self.columns[name]] = values
        return self.without_motors(found)

    @cached_property
    def _integrand(self) -> Array:
        """Right rates of change at the evaluations, with the engine's own reactions and torques, (k, c)."""
        e, at = self.equations, self.rule.rows
        found = self.blocks(e.states, e.total.plus(self.own_torques), e.centre)
        found[:, self.columns[BARS]] += self.shape.kinetic_slope(e.states)
        if self.motion.reaction is not None and JOINTS in self.columns:
            found[:, self.columns[JOINTS]] += real(self.motion.reaction[at])
        if self.torques_unknown:
            found[:, self.columns[BARS]] @= self.free_of_motors.T
        return found

    @property
    def torques_unknown(self) -> bool:
        """Whether the scene has motors whose torques the motion lacks: only what they can't give is balanced."""
        return self.motion.torque is None and bool(self.scene.effects.prescribed_rotation)

    @property
    def own_torques(self) -> Load:
        """The engine's own torques of the prescribed rotations."""
        e, own = self.equations, self.motion.torque
        if own is None:
            return e.zero
        known = min(own.shape[1], self.motors.shape[1])
        return e.torque(own[self.rule.rows, :known] @ self.motors[:, :known].T)

    @cached_property
    def value(self) -> Array:
        """Momenta gained less the right integrals, (n - 1, c) N s and N m s; NaN in unknown intervals."""
        s, shape = self.motion.states, self.shape
        found = np.zeros((len(s.t_s) - 1, self.width))
        found[:, :2] = real((shape.whole * np.diff(s.velocity))[:, None])
        found[:, self.columns[BARS]] = np.diff(shape.momenta(s), axis=0)
        if JOINTS in self.columns:
            drift = shape.centres(1j * s.unit * s.rate)
            found[:, self.columns[JOINTS]] = real(np.cumsum(shape.mass * np.diff(drift, axis=0), axis=1)[:, :-1])
            if self.motion.impulse is not None:
                found[:, self.columns[JOINTS]] -= np.diff(real(self.motion.impulse), axis=0)
        found -= self.rule.integral(self._integrand)
        for k, push in self.impulses:
            self.subtract_impulse(found[k], push, k)
        if LAWS in self.columns:
            found[:, self.columns[LAWS]] = np.diff(self.law_errors(), axis=0)
        found[~self.rule.known] = np.nan
        return self.without_motors(found)

    def without_motors(self, rows: Array) -> Array:
        """Rows (n - 1, c) less what motors may give: everywhere where their torques are unknown, else at an impulse.

        No result has the impulse of a motor that holds its bar.
        """
        columns, struck = self.columns[BARS], [k for k, _ in self.impulses]
        within = slice(None) if self.torques_unknown else struck
        rows[within, columns] = rows[within, columns] @ self.free_of_motors.T
        return rows

    @cached_property
    def free_of_motors(self) -> Array:
        """Sums of torques on the bars in which no motor has a part, (N, N).

        Bars that motors in joints hold together have their sum in the first one's row; a motor that acts from outside
        leaves nothing.
        """
        found = np.eye(self.motion.states.bars)
        for motor in self.motors.T:
            given = found @ motor
            if given.any():
                last = np.flatnonzero(given)[-1]
                found = found - np.outer(given / given[last], found[last])
        return found

    @cached_property
    def motors(self) -> Array:
        """Torques on the bars by a unit torque of each motor, (N, P)."""
        laws = self.scene.effects.prescribed_rotation
        found = np.zeros((self.motion.states.bars, len(laws)))
        for column, law in enumerate(laws):
            bar = law.bar - 1
            found[bar, column] = 1.0
            if law.actuator is Actuator.JOINT:
                found[bar - 1 if bar else 1, column] = -1.0
        return found

    @cached_property
    def impulses(self) -> list[tuple[int, Impulse]]:
        """Impulses with the interval of each; a sample at one holds the state before."""
        t_s = self.motion.states.t_s
        pushes = ((int(np.searchsorted(t_s, p.at_s + self.near_s)) - 1, p) for p in self.scene.effects.impulse)
        return [(k, p) for k, p in pushes if 0 <= k < len(t_s) - 1]

    @property
    def near_s(self) -> float:
        """Difference of instants that are the same, s."""
        return SAME_INSTANT * float(np.diff(self.motion.states.t_s[:2])[0])

    @cached_property
    def error(self) -> Array:
        """Error of the integrals in :attr:`value`, (n - 1, c)."""
        return self.rule.error(self._integrand)

    def subtract_impulse(self, found: Array, push: Impulse, k: int) -> None:
        """Subtract the momentum of an impulse from the row of its interval."""
        s, bar = self.motion.states, push.bar - 1
        if push.at_s not in self.angles:
            before = [p for p, (_, end) in enumerate(self.rule.pieces) if abs(end - push.at_s) <= self.near_s]
            rates = self.rule.curve(s.rate[self.rule.rows], before[0]) if before else None
            more = 0.0 if rates is None else rates.integrate(s.t_s[k], push.at_s)
            self.angles[push.at_s] = s.angle[k] + more
        angle = self.angles[push.at_s]
        unit = unit_along(angle)
        way = push.impulse_N_s * np.exp(1j * push.direction_rad) * (unit[bar] if push.axes is Axes.BODY else 1.0)
        arm = self.shape.right[bar] if push.end.sign > 0.0 else -self.shape.left[bar]
        force, torque = np.zeros((1, s.bars), complex), np.zeros((1, s.bars))
        force[0, bar], torque[0, bar] = way, arm * (unit[bar].conj() * way).imag
        state = States(np.array([push.at_s]), s.com[k : k + 1], s.velocity[k : k + 1], angle[None], s.rate[k : k + 1])
        found -= self.blocks(state, Load(np.zeros(1, complex), force, torque))[0]

    def law_errors(self) -> Array:
        """Prescribed angles less their laws, (n, P) rad, up to a constant."""
        s, shape = self.motion.states, self.shape
        place = s.com[:, None] + shape.centres(s.unit)
        found = []
        for law in self.scene.effects.prescribed_rotation:
            bar = law.bar - 1
            own = s.angle[:, bar]
            if law.frame is Frame.LOCAL_HORIZONTAL:
                own = own - np.unwrap(np.angle(place[:, bar]))
            if law.frame is Frame.PREVIOUS_BAR:
                own = own - s.angle[:, bar - 1]
            found.append(own - np.array([law.law(t)[0] for t in s.t_s.tolist()]))
        return np.stack(found, axis=1)
