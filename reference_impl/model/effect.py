"""Effects in the reference: loads on every bar, as a common acceleration and differences from that acceleration.

An effect is a frozen dataclass in a module of its own in :mod:`reference_impl.effects`, imported only for a model with
that effect. A model without effects evaluates no code of this module.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from reference_impl.model.complex_vectors import as_complex

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array, ComplexArray
    from reference_impl.model.state import State

Indices = NDArray[np.intp]
Modes = tuple["Array | None", ...]
"""Discrete mode of each effect of a model, constant while the effect is smooth (faces, light or shadow, segment of a
table). None: the mode follows from the state.
"""


class ChainProperties(Protocol):
    """Properties of a chain that effects read; see :class:`reference_impl.model.chain.ChainModel`."""

    @property
    def mu_m3_s2(self) -> float:
        """Gravitational parameter of the central body, m³/s²."""

    @property
    def mass_kg(self) -> Array:
        """Masses, (N,) kg."""

    @property
    def length_m(self) -> Array:
        """Lengths, (N,) m."""

    @property
    def inertia_kg_m2(self) -> Array:
        """Moments of inertia about the bars' centres, (N,) kg m²."""

    @property
    def effects(self) -> tuple[ChainEffect, ...]:
        """All effects of the model."""

    @property
    def bars(self) -> int:
        """Number of bars N."""

    @property
    def weight(self) -> Array:
        """Mass fractions, (N,)."""

    @property
    def inverse_mass(self) -> Array:
        """Inverse masses, (N,) 1/kg."""

    @property
    def com_share(self) -> Array | None:
        """Shares of the lengths from the left ends to the centres of mass, (N,); None: midway in all bars."""

    @property
    def left_share(self) -> Array:
        """Distances of the left ends from the centres of mass over the half lengths, (N,)."""

    @property
    def right_share(self) -> Array:
        """Those of the right ends, (N,)."""

    @property
    def half_m(self) -> Array:
        """Half lengths, (N,) m."""

    @property
    def gyration2(self) -> Array:
        """Moments of inertia over masses, (N,) m²."""

    @property
    def lever(self) -> Array:
        """Half lengths over moments of inertia, (N,) 1/(kg m)."""


class EffectAccelerations(NamedTuple):
    """Accelerations of N bars by an effect; plane vectors are complex."""

    common: complex
    """m/s², part of the acceleration common to all bars"""
    difference: ComplexArray
    """(N,) m/s², acceleration of each bar minus the common part"""
    angular: Array
    """(N,) rad/s², torque over moment of inertia"""


class EffectState:
    """State of a chain as input of effects; each derived quantity is computed on first use."""

    def __init__(
        self, model: ChainProperties, t_s: float, state: State, unit: ComplexArray, *, absolute: bool = False
    ) -> None:
        """Store a state.

        Parameters
        ----------
        model : ChainProperties
        t_s : float
        state : State
        unit : ndarray of complex, shape (N,)
            Unit vectors u_j.
        absolute : bool
            Whether `state` counts from the centre of the body (`com_m` is zero). Effects then return no common part.
        """
        self.model, self.t_s, self.state, self.unit, self.absolute = model, t_s, state, unit, absolute

    @cached_property
    def position(self) -> ComplexArray:
        """Bars' centres from the origin of the state (centre of mass, or centre of the body), (N,) m."""
        return as_complex(self.state.position_m)

    @cached_property
    def com(self) -> complex:
        """Centre of mass from the centre of the body, m."""
        if self.absolute:
            return complex(self.model.weight @ self.position)
        return complex(self.state.com_m[0], self.state.com_m[1])

    @cached_property
    def position_from_body(self) -> ComplexArray:
        """Bars' centres from the centre of the body, (N,) m."""
        return self.position if self.absolute else self.com + self.position

    @cached_property
    def velocity(self) -> ComplexArray:
        """Inertial velocities of the bars' centres, (N,) m/s."""
        relative = as_complex(self.state.velocity_m_s)
        drift = self.state.com_velocity_m_s
        return relative if self.absolute else complex(drift[0], drift[1]) + relative

    @property
    def rate(self) -> Array:
        """Angular velocities, (N,) rad/s."""
        return self.state.rate_rad_s

    @cached_property
    def zero_acceleration(self) -> ComplexArray:
        """Zero linear accelerations, (N,)."""
        return np.zeros(self.model.bars, complex)

    @cached_property
    def zero_angular(self) -> Array:
        """Zero angular accelerations, (N,)."""
        return np.zeros(self.model.bars)


class EffectRows(EffectState):
    """Many states of a chain as one input of effects: (k, N) arrays, and (k, 1) of the chain."""

    def __init__(self, model: ChainProperties, t_s: Array, state: State, unit: ComplexArray) -> None:
        """Store states at `t_s`, (k,) s: vectors of the chain are (k, 2), of the bars (k, N, 2), `unit` is (k, N)."""
        super().__init__(model, t_s[:, None], state, unit)  # type: ignore[arg-type]  # of each state
        self.com = as_complex(state.com_m)[:, None]  # type: ignore[assignment]  # of each state
        self.velocity = as_complex(state.com_velocity_m_s)[:, None] + as_complex(state.velocity_m_s)
        self.zero_acceleration, self.zero_angular = np.zeros(unit.shape, complex), np.zeros(unit.shape)


EDGE_ON = 1e-12
"""Sine of the angle by which a face may be turned away before its mode changes.

Without this margin, rounding would change the face of an edge-on bar at every evaluation. At this angle, the wrong
face's force differs from the right face's force by less than the force's own rounding error.
"""


class ChainEffect(ABC):
    """Base class of the effects of a model."""

    name: ClassVar[str]
    central: ClassVar[bool] = False
    """Whether all accelerations point to the centre of the body, and so change no longitude"""
    potential: ClassVar[bool] = False
    """Whether forces and torques derive from a time-independent potential"""
    internal: ClassVar[bool] = False
    """Whether the effect acts between bars only; the centre of mass is then unaffected"""
    isotropic: ClassVar[bool] = False
    """Whether the effect has no preferred direction; angular momentum is then conserved"""

    has_state_events: ClassVar[bool] = False
    """Whether the motion may end a mode (state events)"""
    has_short_modes: ClassVar[bool] = False
    """Whether a mode may begin and end between two samples; :meth:`short_mode_indicator` then locates it"""

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants at which the effect is not smooth in time."""
        return ()

    def largest_acceleration_m_s2(self, model: ChainProperties) -> float:
        """Contribution to the upper bound of the centre of mass' acceleration, m/s².

        Effects small relative to gravity contribute 0.
        """
        del model
        return 0.0

    @abstractmethod
    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Linear and angular accelerations in the given mode; None: the mode follows from the state."""

    def mode(self, at: EffectState) -> Array | None:
        """Mode at a state; None for an effect that is smooth everywhere."""
        del at
        return None

    def segment_mode(self, start_s: float, end_s: float) -> Array | None:
        """Mode between two neighbouring breaks, where the mode depends on time alone; otherwise None."""
        del start_s, end_s
        return None

    def event_functions(self, at: EffectState, mode: Array) -> Array:
        """Event functions of the state, positive while the k entries of `mode` are valid, (k,)."""
        raise NotImplementedError(f"{self.name} has no modes")

    def short_mode_indicator(self, at: EffectState) -> float:
        """Function that changes sign inside a mode that may be shorter than a step; 0 far from such a mode.

        Example: the distance from the axis of the shadow. A fast chain may enter and leave the shadow within one step,
        so that the event function of its edge is positive at both ends; the distance from the axis changes sign.
        """
        del at
        return 0.0

    def mode_after(self, mode: Array, crossed: Indices) -> Array:
        """Mode after the event functions at the indices `crossed` have fallen through zero."""
        raise NotImplementedError(f"{self.name} has no modes")

    def energy(self, model: ChainProperties, com_m: Array, angle_rad: Array) -> Array:
        """Potential energy over time, (n,), J, of a chain with closed joints; `com_m` (n, 2), `angle_rad` (n, N)."""
        raise NotImplementedError(f"{self.name} has no potential")


def total_accelerations(at: EffectState, modes: Modes) -> tuple[EffectAccelerations, ComplexArray]:
    """Sum of all effects of a model, and the noncentral part of their accelerations, which changes longitudes, (N,)."""
    common, difference, angular, noncentral_acceleration = (
        0j,
        at.zero_acceleration,
        at.zero_angular,
        at.zero_acceleration,
    )
    for effect, mode in zip(at.model.effects, modes, strict=True):
        added = effect.accelerations(at, mode)
        common, difference, angular = common + added.common, difference + added.difference, angular + added.angular
        if not effect.central:
            noncentral_acceleration = noncentral_acceleration + (added.common + added.difference)
    return EffectAccelerations(common, difference, angular), noncentral_acceleration
