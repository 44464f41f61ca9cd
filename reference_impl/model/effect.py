"""What an effect is to the reference: a push on every bar, as a part common to all and differences from it.

An effect is a frozen dataclass in a module of its own in :mod:`reference_impl.effects`, imported only for a model that
calls for it. A model without effects evaluates nothing of this.
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
"""For each effect of a model, what is held while its push is smooth (a face, light or shadow, a piece of a table);
None: to be told from the state."""


class ChainProperties(Protocol):
    """What effects know of a chain; see :class:`reference_impl.model.chain.ChainModel`."""

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
    def half_m(self) -> Array:
        """Half lengths, (N,) m."""

    @property
    def gyration2(self) -> Array:
        """Moments of inertia over masses, (N,) m²."""

    @property
    def lever(self) -> Array:
        """Half lengths over moments of inertia, (N,) 1/(kg m)."""


class EffectAccelerations(NamedTuple):
    """What an effect does to N bars; plane vectors are complex."""

    common: complex
    """m/s², a part of the acceleration that all bars share"""
    difference: ComplexArray
    """(N,) m/s², each bar's less that part"""
    angular: Array
    """(N,) rad/s², torque over moment of inertia"""


class EffectState:
    """One state as effects see it: each quantity is made when it is first asked for."""

    def __init__(
        self, model: ChainProperties, t_s: float, state: State, unit: ComplexArray, *, absolute: bool = False
    ) -> None:
        """See a state.

        Parameters
        ----------
        model : ChainProperties
        t_s : float
        state : State
        unit : ndarray of complex, shape (N,)
            Unit vectors u_j.
        absolute : bool
            Whether `state` counts from the centre of the body (`com_m` is zero): then nothing is split.
        """
        self.model, self.t_s, self.state, self.unit, self.absolute = model, t_s, state, unit, absolute

    @cached_property
    def position(self) -> ComplexArray:
        """(N,) centres from the origin of the state, m: the centre of mass, or that of the body."""
        return as_complex(self.state.position_m)

    @cached_property
    def com(self) -> complex:
        """Centre of mass, m."""
        if self.absolute:
            return complex(self.model.weight @ self.position)
        return complex(self.state.com_m[0], self.state.com_m[1])

    @cached_property
    def position_from_body(self) -> ComplexArray:
        """(N,) centres from the centre of the body, m."""
        return self.position if self.absolute else self.com + self.position

    @cached_property
    def velocity(self) -> ComplexArray:
        """(N,) velocities of the centres, m/s."""
        relative = as_complex(self.state.velocity_m_s)
        drift = self.state.com_velocity_m_s
        return relative if self.absolute else complex(drift[0], drift[1]) + relative

    @property
    def rate(self) -> Array:
        """(N,) rad/s."""
        return self.state.rate_rad_s

    @cached_property
    def zero_acceleration(self) -> ComplexArray:
        """(N,) zeros."""
        return np.zeros(self.model.bars, complex)

    @cached_property
    def zero_angular(self) -> Array:
        """(N,) zeros."""
        return np.zeros(self.model.bars)


EDGE_ON = 1e-12
"""Sine of an angle by which a face may be turned away before it counts as turned.

A bar held edge-on would change its face with every rounding. At this angle the wrong face's force differs from the
right one's by less than the force's own rounding.
"""


class ChainEffect(ABC):
    """One effect of a model."""

    name: ClassVar[str]
    central: ClassVar[bool] = False
    """Whether its accelerations point to the centre of the body: then they turn no longitude"""
    potential: ClassVar[bool] = False
    """Whether forces and torques come from a potential that does not depend on time"""
    internal: ClassVar[bool] = False
    """Whether it acts between bars only, and so moves no centre of mass"""
    isotropic: ClassVar[bool] = False
    """Whether nothing in it has a direction of its own: then angular momentum stays"""

    has_state_events: ClassVar[bool] = False
    """Whether the motion may carry it to where its mode no longer holds"""
    has_brief_events: ClassVar[bool] = False
    """Whether a margin may fall and rise again between two looks: then :meth:`brief_event` tells"""

    @property
    def breaks_s(self) -> tuple[float, ...]:
        """Instants at which it is not smooth in time."""
        return ()

    def largest_acceleration_m_s2(self, model: ChainProperties) -> float:
        """Bound of what it does to the centre of mass, m/s², where that may be more than a little beside gravity."""
        del model
        return 0.0

    @abstractmethod
    def accelerations(self, at: EffectState, mode: Array | None) -> EffectAccelerations:
        """Accelerations and torques, while `mode` holds; None: by what the state says."""

    def mode(self, at: EffectState) -> Array | None:
        """What holds at a state; None where the push is smooth everywhere."""
        del at
        return None

    def segment_mode(self, start_s: float, end_s: float) -> Array | None:
        """What holds between two neighbouring breaks, where that is a matter of time alone; else None."""
        del start_s, end_s
        return None

    def event_functions(self, at: EffectState, mode: Array) -> Array:
        """(k,) functions of the state that are positive while the k entries of `mode` hold."""
        raise NotImplementedError(f"{self.name} has no modes")

    def brief_event(self, at: EffectState) -> float:
        """Function of the state that changes sign within a spell that may be short beside a step; 0: none is near."""
        del at
        return 0.0

    def mode_after(self, mode: Array, crossed: Indices) -> Array:
        """Mode after the margins at the indices `crossed` have fallen through zero."""
        raise NotImplementedError(f"{self.name} has no modes")

    def energy(self, model: ChainProperties, com_m: Array, angle_rad: Array) -> Array:
        """Potential energy over time, (n,), J, of a joined chain; `com_m` (n, 2), `angle_rad` (n, N)."""
        raise NotImplementedError(f"{self.name} has no potential")


def total_accelerations(at: EffectState, modes: Modes) -> tuple[EffectAccelerations, ComplexArray]:
    """Sum of all effects of a model, and (N,) what of their accelerations may turn a longitude."""
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
