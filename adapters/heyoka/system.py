"""Equations of a whole scene as a heyoka system: state, parameters, observables, events."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

from adapters.heyoka.applied_forces import BarKinematics
from adapters.heyoka.equations import Symbol, SymbolicBar, chain_motion
from adapters.heyoka.fields import Rod
from adapters.heyoka.structure import LAW_PARAMETERS, BarParameter, Structure
from adapters.heyoka.symbolic_loads import SymbolicLoads, SymbolicState


@dataclass(frozen=True)
class System:
    """Expressions that heyoka compiles."""

    variables: list[Symbol]
    """Z0, Z0', theta, theta'"""
    rates: list[Symbol]
    """Their time derivatives"""
    observables: list[Symbol]
    """Reactions (x, y of each joint), then torques"""
    ends: list[Symbol]
    """Square of each end's distance less that of the surface: N + 1"""
    middles: list[Symbol]
    """For each bar: square of the distance of the line it lies on less that of the surface, by (l/2)²"""
    feet: list[Symbol]
    """For each bar: square of the distance of that line's nearest point from its centre, less (l/2)², by (l/2)²"""
    event_functions: list[Symbol]
    """Event functions of the modes, in the order of `EffectShapes.modes`"""
    sunward: Symbol
    """Z0·s; 0 where there is no shadow"""
    bars: list[SymbolicBar]


def system(structure: Structure) -> System:
    """Equations of all scenes of one structure."""
    import heyoka as hy

    n = structure.bars
    zx, zy, vx, vy = hy.make_vars("zx", "zy", "vx", "vy")
    angle = [hy.expression(f"angle_{j}") for j in range(n)]
    rate = [hy.expression(f"rate_{j}") for j in range(n)]
    state = SymbolicState((zx, zy), (vx, vy), angle, rate, zx * zx + zy * zy)
    loads = SymbolicLoads(structure, state)
    bars = chain(structure, state, loads)
    laws = [law_acceleration(structure.law_offset + LAW_PARAMETERS * k) for k in range(len(structure.laws))]
    found = chain_motion(bars, structure, laws)
    share = [parameter(structure, BarParameter.SHARE, j) for j in range(n)]
    fall = [f + total(share, [b.tide[k] for b in bars]) for k, f in enumerate(loads.frame)]
    observables = [x for pair in found.reaction for x in pair] + found.torque
    return System(
        state.variables,
        [as_symbol(x) for x in [vx, vy, *fall, *rate, *found.turn]],
        [as_symbol(x) for x in observables],
        *surface(structure, bars),
        *loads.event_functions,
        bars,
    )


def as_symbol(x: Symbol) -> Any:
    """Convert a number to an expression."""
    import heyoka as hy

    return x if isinstance(x, hy.expression) else hy.expression(float(x))


def total(weights: list[Symbol], values: list[Symbol]) -> Symbol:
    """Weighted sum."""
    import heyoka as hy

    return hy.sum([as_symbol(w * x) for w, x in zip(weights, values, strict=True)])


def chain(structure: Structure, state: SymbolicState, loads: SymbolicLoads) -> list[SymbolicBar]:
    """All bars of the chain."""
    import heyoka as hy

    n, (zx, zy), (vx, vy) = structure.bars, state.centre, state.velocity
    half = [parameter(structure, BarParameter.HALF, j) for j in range(n)]
    along = [(hy.cos(q), hy.sin(q)) for q in state.angle]
    reach = [(h * c, h * s) for h, (c, s) in zip(half, along, strict=True)]
    dx, dy = (centre_offsets(structure, [p[k] for p in reach]) for k in (0, 1))
    wx = centre_offsets(structure, [-w * p[1] for w, p in zip(state.rate, reach, strict=True)])
    wy = centre_offsets(structure, [w * p[0] for w, p in zip(state.rate, reach, strict=True)])
    bars = []
    for j in range(n):
        mass, inertia, end_inertia, slender = (
            parameter(structure, part, j)
            for part in (BarParameter.MASS, BarParameter.INERTIA, BarParameter.END_INERTIA, BarParameter.SLENDER)
        )
        position, velocity = (zx + dx[j], zy + dy[j]), (vx + wx[j], vy + wy[j])
        rod = Rod((dx[j], dy[j]), reach[j], mass, half[j], slender)
        load = loads.load(
            rod, BarKinematics(j, mass, along[j], rod.offset, position, velocity, reach[j], state.rate[j])
        )
        bars.append(
            SymbolicBar(
                mass,
                inertia,
                end_inertia,
                reach[j],
                state.rate[j],
                load.push,
                load.torque,
                position,
                velocity,
                load.transverse_acceleration,
            )
        )
    return bars


def parameter(structure: Structure, part: BarParameter, bar: int) -> Symbol:
    """Parameter of a bar."""
    import heyoka as hy

    return hy.par[structure.bar_slot(part, bar)]


def centre_offsets(structure: Structure, reach: list[Symbol]) -> list[Symbol]:
    """Components of the bars' centres relative to the centre of mass; `reach` is from a centre to its right end."""
    n = structure.bars
    from_first: list[Symbol] = [0.0]
    for one, other in itertools.pairwise(reach):
        from_first.append(from_first[-1] + (one + other))
    mean = total([parameter(structure, BarParameter.SHARE, j) for j in range(n)], from_first)
    return [x - mean for x in from_first]


def law_acceleration(offset: int) -> Symbol:
    """Second derivative of eq. (28); parameters: amplitude over 16 (zero while held), pi/t_m, start."""
    import heyoka as hy

    amplitude, w = hy.par[offset], hy.par[offset + 1]
    x = w * (hy.time - hy.par[offset + 2])
    return 9.0 * amplitude * w * w * (hy.cos(x) - hy.cos(3.0 * x))


def surface(structure: Structure, bars: list[SymbolicBar]) -> tuple[list[Symbol], list[Symbol], list[Symbol]]:
    """Event functions that fall through zero where a bar touches the surface, at an end or between its ends."""
    import heyoka as hy

    r2 = hy.par[1] * hy.par[1]
    (x, y), (px, py) = bars[0].position, bars[0].reach
    points = [(x - px, y - py)] + [(b.position[0] + b.reach[0], b.position[1] + b.reach[1]) for b in bars]
    half2 = [
        parameter(structure, BarParameter.HALF, j) * parameter(structure, BarParameter.HALF, j)
        for j in range(len(bars))
    ]
    lines = [b.position[0] * b.across[0] + b.position[1] * b.across[1] for b in bars]
    feet = [b.position[0] * b.reach[0] + b.position[1] * b.reach[1] for b in bars]
    return (
        [x * x + y * y - r2 for x, y in points],
        [q * q - h2 * r2 for q, h2 in zip(lines, half2, strict=True)],
        [q * q - h2 * h2 for q, h2 in zip(feet, half2, strict=True)],
    )
