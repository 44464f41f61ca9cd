"""State in the paper's unknowns and units: l within the chain, R_eq beyond, time in sqrt(R_eq³/mu)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.model.kinematics import cross

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.state import State


@dataclass(frozen=True)
class PaperUnits:
    """Units of the paper's nondimensional quantities."""

    length_m: float
    """l: the longest bar"""
    radius_m: float
    """R_eq: the body's radius; the chain's distance from the centre for a model without radius"""
    time_s: float
    """sqrt(R_eq³/mu), eq. (10)"""
    mass_kg: float
    """M of the whole chain"""

    @property
    def ratio(self) -> float:
        """Size ratio epsilon = l/R_eq, eq. (1)."""
        return self.length_m / self.radius_m

    @property
    def force_N(self) -> float:
        """Unit of the reactions, epsilon M g_eq of eq. (14)."""
        return self.mass_kg * self.length_m / self.time_s**2

    @property
    def torque_N_m(self) -> float:
        """Unit of the torques."""
        return self.force_N * self.length_m


def units_of(model: ChainModel, com_m: Array) -> PaperUnits:
    """Units for a model with its centre of mass at `com_m`, shape (2,)."""
    radius = model.body_radius_m or float(np.linalg.norm(com_m))
    time = float(np.sqrt(radius**3 / model.mu_m3_s2))
    return PaperUnits(float(model.length_m.max()), radius, time, float(model.mass_kg.sum()))


@dataclass(frozen=True)
class PaperState:
    """X = [T_11, T_12, phi_1 | ... | Y_01, Y_02] of (B.1) and its rate, nondimensional."""

    ratio: float
    """epsilon"""
    share: Array
    """(N,) mu_j = m_j/M"""
    inertia: Array
    """(N,) lambda_j = J_j/(M l²)"""
    half: Array
    """(N,) l_j/(2 l): 1/2 for equal bars"""
    T: Array
    """(N, 2)"""
    T_rate: Array
    """(N, 2)"""
    phi: Array
    """(N,) angle of each bar from the horizontal through its own centre of mass, rad"""
    phi_rate: Array
    """(N,)"""
    Y0: Array
    """(2,)"""
    Y0_rate: Array
    """(2,)"""

    @property
    def bars(self) -> int:
        """Number of bars N."""
        return len(self.share)

    @cached_property
    def Y(self) -> Array:
        """Positions of the bars' centres Y_j = Y_0 + epsilon T_j, shape (N, 2), eq. (4)."""
        place: Array = self.Y0 + self.ratio * self.T
        return place

    @cached_property
    def Y_rate(self) -> Array:
        """Rate of `Y`, shape (N, 2)."""
        rate: Array = self.Y0_rate + self.ratio * self.T_rate
        return rate

    @cached_property
    def rho(self) -> Array:
        """Radii rho_j, shape (N,)."""
        radius: Array = np.sqrt(np.sum(self.Y**2, axis=-1))
        return radius

    @cached_property
    def theta(self) -> Array:
        """Inertial angles theta_j = phi_j + omega_j - pi/2, shape (N,)."""
        angle: Array = self.phi + longitude(self.Y) - np.pi / 2
        return angle

    @cached_property
    def theta_rate(self) -> Array:
        """Rate of `theta`, shape (N,), with omega_j' from (C.6)."""
        rate: Array = self.phi_rate + longitude_rate(self.Y, self.Y_rate)
        return rate


def longitude(place: Array) -> Array:
    """Longitude omega_j of each position (..., 2), eq. (16)."""
    angle: Array = np.arctan2(place[..., 1], place[..., 0])
    return angle


def longitude_rate(place: Array, motion: Array) -> Array:
    """Rate of the longitude, eq. (C.6)."""
    rate: Array = cross(place, motion) / np.sum(place**2, axis=-1)
    return rate


def paper_state(model: ChainModel, state: State, units: PaperUnits) -> PaperState:
    """State in the paper's unknowns, from SI units and inertial angles."""
    speed = units.length_m / units.time_s
    place = (state.com_m + state.position_m) / units.radius_m
    motion = (state.com_velocity_m_s + state.velocity_m_s) * (units.time_s / units.radius_m)
    return PaperState(
        ratio=units.ratio,
        share=model.weight,
        inertia=model.inertia_kg_m2 / (units.mass_kg * units.length_m**2),
        half=model.half_m / units.length_m,
        T=state.position_m / units.length_m,
        T_rate=state.velocity_m_s / speed,
        phi=state.angle_rad - longitude(place) + np.pi / 2,
        phi_rate=state.rate_rad_s * units.time_s - longitude_rate(place, motion),
        Y0=state.com_m / units.radius_m,
        Y0_rate=state.com_velocity_m_s * (units.time_s / units.radius_m),
    )
