"""State of a chain and its accelerations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array


@dataclass(frozen=True)
class State:
    """Positions and velocities of a chain, split into the centre of mass and the relative part."""

    com_m: Array
    """(2,) Z0"""
    com_velocity_m_s: Array
    """(2,)"""
    angle_rad: Array
    """(N,) theta_j from the z1 axis"""
    rate_rad_s: Array
    """(N,)"""
    position_m: Array
    """(N, 2) d_j = Z_j - Z0"""
    velocity_m_s: Array
    """(N, 2)"""


@dataclass(frozen=True)
class Accelerations:
    """Solution of the equations of motion at one state."""

    com_m_s2: Array
    """(2,) Z0''"""
    angle_rad_s2: Array
    """(N,)"""
    position_m_s2: Array
    """(N, 2) d_j''"""
    reaction_N: Array
    """(N-1, 2) force on bar j from bar j+1"""
    torque_N_m: Array
    """(P,) torque on each prescribed bar"""
