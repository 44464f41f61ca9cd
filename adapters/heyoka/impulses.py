"""Impulses in heyoka's equations: the articulated chain with impulses for forces, and jumps for accelerations.

Newton's and Euler's laws integrated over an instant: m (c - t) is the impulse of a bar's joints, with c the jump of its
centre's velocity and t the applied impulse over the mass, I/m; J times the jump of the rate is the moment of all
impulses. Quantities that stay finite drop out: rates, gravity, springs, air. A free bar is treated as in the equations
of motion. A prescribed bar keeps the rate of its law: its jump is 0 relative to inertial axes, and relative to the
local horizontal it is the jump of its longitude's rate, (Z x c)/r². The motor, or an external torque, provides the
impulsive torque for that.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

from adapters.heyoka.applied_forces import end_force
from adapters.heyoka.equations import Symbol, SymbolicBar, chain_motion
from adapters.heyoka.fields import Pair, cross
from adapters.heyoka.structure import BarParameter
from adapters.heyoka.system import as_symbol, parameter, total

if TYPE_CHECKING:
    from adapters.heyoka.structure import Structure
    from adapters.heyoka.system import System


def jumps(structure: Structure, whole: System) -> list[Symbol]:
    """Jumps of Z0' (2) and of theta' (N), and the impulsive reactions on bar j from bar j+1 (2 each)."""
    angle = whole.variables[4 : 4 + structure.bars]
    impulses = [impulse(structure, j, bar, angle[j]) for j, bar in enumerate(whole.bars)]
    bars = [with_impulse(bar, *applied_impulse) for bar, applied_impulse in zip(whole.bars, impulses, strict=True)]
    found = chain_motion(bars, structure, [0.0] * len(structure.laws))
    share = mass_shares(structure)
    track = [total(share, [b.tide[k] for b in bars]) for k in (0, 1)]
    return [as_symbol(x) for x in [*track, *found.turn, *(x for pair in found.reaction for x in pair)]]


def mass_shares(structure: Structure) -> list[Any]:
    """Mass ratios m_j/M."""
    return [parameter(structure, BarParameter.SHARE, j) for j in range(structure.bars)]


def impulse(structure: Structure, j: int, bar: SymbolicBar, angle: Symbol) -> tuple[Pair, Symbol]:
    """Sum of the impulses on a bar, and their moment about its centre."""
    import heyoka as hy

    x: Symbol = 0.0
    y: Symbol = 0.0
    moment: Symbol = 0.0
    for k, shape in enumerate(structure.effects.impulses):
        if shape.bar == j:
            direction, size = (hy.par[structure.slot(f"impulse_{k}_{what}")] for what in ("direction", "size"))
            applied_impulse = end_force(shape, direction, size, angle)
            x, y = x + applied_impulse[0], y + applied_impulse[1]
            moment = moment + shape.side * cross(bar.reach, applied_impulse)
    return (x, y), moment


def with_impulse(bar: SymbolicBar, applied_impulse: Pair, moment: Symbol) -> SymbolicBar:
    """A bar with jumps for accelerations: no rates, and the impulse for gravity."""
    jump = applied_impulse[0] / bar.mass, applied_impulse[1] / bar.mass
    return dataclasses.replace(
        bar, rate=0.0, velocity=(0.0, 0.0), tide=jump, torque=moment, transverse_acceleration=cross(bar.position, jump)
    )
