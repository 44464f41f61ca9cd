"""One bar of the chain in heyoka expressions: constants, position, motion and load.

Symbols are heyoka's, and constants are parameters of the integrator. Constants therefore have its precision, and
chains of one structure share one compiled code. Literals are 0.5, 2, 3 ...: exact in any precision.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

Symbol = Any
"""A heyoka expression, or a number"""
Pair = tuple[Symbol, Symbol]


def cross(a: Pair, b: Pair) -> Symbol:
    """Component of the cross product normal to the plane."""
    return a[0] * b[1] - a[1] * b[0]


def dot(a: Pair, b: Pair) -> Symbol:
    """Dot product."""
    return a[0] * b[0] + a[1] * b[1]


@dataclass(frozen=True)
class Load:
    """Load on a bar besides its joints."""

    push: Pair = (0.0, 0.0)
    """Acceleration of its centre, relative to the falling frame"""
    torque: Symbol = 0.0
    """Sum of all torques but those of its joints' forces and motors"""
    transverse_acceleration: Symbol | None = None
    """Z x the part of its whole acceleration that is not along Z; None where there is none"""

    def __add__(self, other: Load) -> Load:
        """Sum of two loads."""
        swerves = [s for s in (self.transverse_acceleration, other.transverse_acceleration) if s is not None]
        return Load(
            (self.push[0] + other.push[0], self.push[1] + other.push[1]),
            self.torque + other.torque,
            sum(swerves[1:], swerves[0]) if swerves else None,
        )


@dataclass(frozen=True)
class SymbolicBar:
    """A bar with its load."""

    index: int
    """Counted from 0"""
    mass: Symbol
    inertia: Symbol
    """About its centre"""
    end_inertia: Symbol
    """About its left end"""
    half: Symbol
    slender: Symbol
    """3 J/(l/2)²"""
    along: Pair
    """u"""
    reach: Pair
    """p = (l/2) u"""
    left: Pair
    """a u, from its left end to its centre of mass; p itself where levers are equal"""
    right: Pair
    """b u, from there to its right end"""
    lean: Symbol
    """m a over l/2"""
    rate: Symbol
    offset: Pair
    """d, of its centre from the chain's"""
    position: Pair
    velocity: Pair
    load: Load = field(default_factory=Load)

    @property
    def normal(self) -> Pair:
        """Unit vector n."""
        return -self.along[1], self.along[0]

    @property
    def across(self) -> Pair:
        """(l/2) n: p turned by +90 degrees."""
        return -self.reach[1], self.reach[0]

    @property
    def excess(self) -> Pair | None:
        """(b - a) n; None where levers are equal."""
        if self.left is self.reach:
            return None
        return self.left[1] - self.right[1], self.right[0] - self.left[0]

    def arm(self, side: float) -> Pair:
        """Vector from its centre of mass to its right end (side 1) or to its left one (-1)."""
        return self.right if side > 0.0 else (-self.left[0], -self.left[1])

    def pushed(self, force: Pair, torque: Symbol = 0.0) -> Load:
        """Load of a force at its centre."""
        push = force[0] / self.mass, force[1] / self.mass
        return Load(push, torque, cross(self.position, push))
