"""Loads on the bars and the chain's geometry, at given states: the right equations of motion, term by term.

Momenta belong to the bars' angles, with the chain's centre of mass apart from them:

    p_j = J_j w_j + sum_i G_ji cos(th_j - th_i) w_i,   p_j' = dT/dth_j + Q_j,
    dT/dth_j = -w_j sum_i G_ji sin(th_j - th_i) w_i,   Q_j = K_j + n_j . sum_k A_kj f_k,

with d_k = sum_j A_kj u_j the bars' centres from the centre of mass, and G = A' m A. Joint forces have no part in Q.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from adapters.common.reference_model import chain_model
from reference_impl.model.complex_vectors import as_complex, as_vectors, unit_along
from reference_impl.model.effect import EffectRows
from reference_impl.model.gravity import complex_field_differences, gradient_angular_accelerations, point_field
from reference_impl.model.state import State

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.arrays import ComplexArray
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import ChainEffect, EffectAccelerations
    from scenarios import Scene


ENDS = (0.5, 0.5)
"""Joints at the bars' ends"""


class Load(NamedTuple):
    """Forces and torques on N bars at k states; plane vectors are complex."""

    common: ComplexArray
    """(k,) m/s², acceleration of all bars alike"""
    force: ComplexArray
    """(k, N) N, besides the common acceleration"""
    torque: Array
    """(k, N) N m"""

    def plus(self, other: Load) -> Load:
        """Both loads together."""
        return Load(self.common + other.common, self.force + other.force, self.torque + other.torque)

    def times(self, factor: float) -> Load:
        """Load times a factor."""
        return Load(factor * self.common, factor * self.force, factor * self.torque)

    def on(self, bar: int) -> Load:
        """Forces and torque on one bar alone, from 0."""
        only = np.zeros(self.torque.shape[1])
        only[bar] = 1.0
        return Load(0.0 * self.common, self.force * only, self.torque * only)

    @property
    def acts(self) -> NDArray[np.bool_]:
        """(N,) bars with a force or a torque."""
        found: NDArray[np.bool_] = np.any(np.abs(self.force) + np.abs(self.torque) > 0.0, axis=0)
        return found


@dataclass(frozen=True)
class States:
    """States of a chain at k instants; plane vectors are complex."""

    t_s: Array
    com: ComplexArray
    """(k,) m"""
    velocity: ComplexArray
    """(k,) m/s"""
    angle: Array
    """(k, N) rad"""
    rate: Array
    """(k, N) rad/s"""

    @cached_property
    def unit(self) -> ComplexArray:
        """Unit vectors along the bars, (k, N)."""
        return unit_along(self.angle)

    @property
    def bars(self) -> int:
        """Number of bars N."""
        return int(self.angle.shape[1])

    def at(self, rows: NDArray[np.intp]) -> States:
        """Some of the states."""
        return States(self.t_s[rows], self.com[rows], self.velocity[rows], self.angle[rows], self.rate[rows])


@dataclass(frozen=True)
class Shape:
    """Masses, moments of inertia, and the reach from each centre to the bar's left and right joint."""

    mass: Array
    inertia: Array
    left: Array
    right: Array
    weight: Array | None = None
    """Of the bars' centres in the point from which places count; None: their masses, as is right"""

    @cached_property
    def whole(self) -> float:
        """Mass of the chain, kg."""
        return float(self.mass.sum())

    @cached_property
    def reach(self) -> Array:
        """A, (N, N) m."""
        n = len(self.mass)
        from_first = np.tril(np.tile(self.left + self.right, (n, 1)), -1) + np.diag(self.left)
        weight = self.mass if self.weight is None else self.weight
        centred: Array = from_first - (weight / weight.sum()) @ from_first
        return centred

    @cached_property
    def coupling(self) -> Array:
        """G, (N, N) kg m²."""
        product: Array = self.reach.T @ (self.mass[:, None] * self.reach)
        return product

    def centres(self, along: ComplexArray) -> ComplexArray:
        """Vectors from the chain's centre to the bars', of vectors (k, N) along the bars in lengths."""
        return along @ self.reach.T

    def apart(self, force: ComplexArray) -> ComplexArray:
        """Forces (k, N) less each bar's share of their sum, by mass."""
        found: ComplexArray = force - self.mass * (force.sum(axis=1) / self.whole)[:, None]
        return found

    def coupled(self, s: States) -> Array:
        """G_ji cos(th_j - th_i), (k, N, N)."""
        return self.coupling * np.cos(s.angle[:, :, None] - s.angle[:, None, :])

    def turned(self, s: States) -> Array:
        """G_ji sin(th_j - th_i), (k, N, N)."""
        return self.coupling * np.sin(s.angle[:, :, None] - s.angle[:, None, :])

    def momenta(self, s: States) -> Array:
        """p, (k, N) N m s."""
        return self.inertia * s.rate + (self.coupled(s) @ s.rate[:, :, None])[:, :, 0]

    def kinetic_slope(self, s: States) -> Array:
        """dT/dth, (k, N) N m."""
        return -s.rate * (self.turned(s) @ s.rate[:, :, None])[:, :, 0]

    def centrifugal(self, s: States) -> Array:
        """Torques -sum_i G_ji sin(th_j - th_i) w_i² by the rates, (k, N) N m."""
        return -(self.turned(s) @ (s.rate**2)[:, :, None])[:, :, 0]

    def generalised(self, s: States, load: Load) -> Array:
        """Q, (k, N) N m; accelerations common to all bars have no part in it."""
        return load.torque + (s.unit.conj() * (load.force @ self.reach)).imag


@dataclass(frozen=True)
class Equations:
    """Equations of motion of a scene at k states.

    Attributes
    ----------
    scene : Scene
    states : States
    spans : sequence of tuple of float
        Start and end of the smooth piece around each state, s; empty: modes of effects follow from the states.
    reach : tuple of float
        Distance of the left and of the right joint from a bar's centre, in lengths of a bar with equal levers.
    known : tuple of (ChainEffect, Load)
        Loads of effects at the same states that were computed already.
    """

    scene: Scene
    states: States
    spans: tuple[tuple[float, float], ...] = ()
    reach: tuple[float, float] = ENDS
    known: tuple[tuple[ChainEffect, Load], ...] = ()

    @cached_property
    def model(self) -> ChainModel:
        """The reference's model."""
        return chain_model(self.scene)

    @cached_property
    def shape(self) -> Shape:
        """Masses, and reaches to the joints."""
        m, (left, right) = self.model, self.reach
        levers = left * m.length_m * m.left_share, right * m.length_m * m.right_share
        return Shape(m.mass_kg, m.inertia_kg_m2, *levers)

    @cached_property
    def place(self) -> ComplexArray:
        """Bars' centres from the chain's, (k, N) m."""
        return self.shape.centres(self.states.unit)

    @cached_property
    def drift(self) -> ComplexArray:
        """Velocities of the bars' centres relative to the chain's, (k, N) m/s."""
        return self.shape.centres(1j * self.states.unit * self.states.rate)

    @cached_property
    def zero(self) -> Load:
        """No load."""
        k, n = self.states.angle.shape
        return Load(np.zeros(k, complex), np.zeros((k, n), complex), np.zeros((k, n)))

    def force(self, values: ComplexArray) -> Load:
        """Forces (k, N) N on the bars' centres."""
        return self.zero._replace(force=values + 0j)

    def torque(self, values: Array) -> Load:
        """Torques (k, N) N m on the bars."""
        return self.zero._replace(torque=values + 0.0 * self.zero.torque)

    def on_joints(self, torque: Array, before: float = 1.0, after: float = 1.0) -> Load:
        """Torques (k, N - 1) of all joints on the bars before them, the opposite ones on those after, times shares."""
        left, right = np.pad(torque, ((0, 0), (0, 1))), np.pad(torque, ((0, 0), (1, 0)))
        return self.torque(before * left - after * right)

    @cached_property
    def centre(self) -> ComplexArray:
        """Gravity of the central body at the centre of mass, (k,) m/s²."""
        if self.model.gravity == "none":
            return self.zero.common
        return as_complex(point_field(self.model.mu_m3_s2, as_vectors(self.states.com)))

    @cached_property
    def tide(self) -> Load:
        """Gravity of the central body on the bars' masses, less that at the centre of mass."""
        if self.model.gravity == "none":
            return self.zero
        apart = complex_field_differences(self.model.mu_m3_s2, self.states.com[:, None], self.place)
        return self.force(self.model.mass_kg * apart)

    @cached_property
    def gradient(self) -> Load:
        """Torque of the central body's gravity gradient."""
        if self.model.gravity != "gradient":
            return self.zero
        spin = gradient_angular_accelerations(self.model, self.states.com[:, None] + self.place, self.states.unit)
        return self.torque(self.model.inertia_kg_m2 * spin)

    @cached_property
    def rows(self) -> StateRows:
        """All states as one input of effects."""
        return StateRows(self)

    def of_effect(self, effect: ChainEffect) -> Load:
        """Loads of an effect."""
        spans = np.array(self.spans).T[..., None]  # (2, k, 1)
        return self.load_of(effect.accelerations(self.rows, effect.segment_mode(*spans) if self.spans else None))

    def load_of(self, found: EffectAccelerations) -> Load:
        """Load with the accelerations of all states."""
        common = self.zero.common + np.ravel(found.common)
        return Load(common, self.model.mass_kg * found.difference, self.model.inertia_kg_m2 * found.angular)

    @cached_property
    def effects(self) -> list[Load]:
        """Loads of each effect of the model."""
        found = []
        for effect in self.model.effects:
            same = (load for other, load in self.known if is_same(effect, other))
            found.append(next(same, None) or self.of_effect(effect))
        return found

    def alike(self, other: Equations) -> bool:
        """Whether an effect has the same load here as in other equations."""
        places = self.scene.chain == other.scene.chain and self.reach == other.reach
        instants = self.spans == other.spans and np.array_equal(self.states.t_s, other.states.t_s)
        return places and instants and self.scene.central_body == other.scene.central_body

    @cached_property
    def total(self) -> Load:
        """Sum of all loads but the field at the centre of mass."""
        found = self.tide.plus(self.gradient)
        for load in self.effects:
            found = found.plus(load)
        return found


class StateRows(EffectRows):
    """States of equations as one input of effects."""

    def __init__(self, equations: Equations, rate: Array | None = None) -> None:
        """Lay out the states, maybe with other rates of the bars beside the same velocities."""
        s, place, drift = equations.states, equations.place, equations.drift
        com, velocity = (as_vectors(z) for z in (s.com, s.velocity))
        turning = s.rate if rate is None else rate
        state = State(com, velocity, s.angle, turning, as_vectors(place), as_vectors(drift))
        super().__init__(equations.model, s.t_s, state, s.unit)


def is_same(a: ChainEffect, b: ChainEffect) -> bool:
    """Whether two effects are equal."""
    names = [f.name for f in dataclasses.fields(a)]  # type: ignore[arg-type]  # every effect is a dataclass
    return type(a) is type(b) and all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)


def states_of(t: Trajectory) -> States | None:
    """States of a trajectory; None without angles, rates, and the track, of which a file may lack a part."""
    no_track = any(part is None for part in (t.com_m, t.com_velocity_m_s))
    if t.angle_rad is None or t.rate_rad_s is None or no_track:
        return None
    return States(t.t_s, as_complex(t.com_m), as_complex(t.com_velocity_m_s), t.angle_rad, t.rate_rad_s)


def mode_changes(equations: Equations) -> Iterator[tuple[ChainEffect, NDArray[np.bool_]]]:
    """Effects with modes (faces, shadow), and whether each changes its mode between two samples, (k - 1,)."""
    for effect in equations.model.effects:
        if effect.has_state_events:
            modes = effect.mode(equations.rows)
            assert modes is not None
            yield effect, (modes[1:] != modes[:-1]).any(axis=1)
