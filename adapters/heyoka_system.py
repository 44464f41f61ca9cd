"""The oracle's equations of a whole scene as a heyoka system: state, parameters, observables, events."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

from adapters.heyoka_equations import Bar, Symbol, motion
from adapters.heyoka_structure import LAW_PARAMETERS, Part, Structure


@dataclass(frozen=True)
class System:
    """What heyoka compiles."""

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


def system(structure: Structure) -> System:
    """Equations of all scenes of one structure."""
    import heyoka as hy

    n = structure.bars
    zx, zy, vx, vy = centre = hy.make_vars("zx", "zy", "vx", "vy")
    angle = [hy.expression(f"angle_{j}") for j in range(n)]
    rate = [hy.expression(f"rate_{j}") for j in range(n)]
    r2 = zx * zx + zy * zy
    pull = hy.par[0] / (r2 * hy.sqrt(r2)) if structure.gravity != "none" else 0.0
    bars = chain(structure, centre, angle, rate, pull, r2)
    laws = [law_acceleration(structure.law_offset + LAW_PARAMETERS * k) for k in range(len(structure.laws))]
    found = motion(bars, structure, laws)
    share = [parameter(structure, Part.SHARE, j) for j in range(n)]
    fall = [-pull * zx + total(share, [b.tide[0] for b in bars]), -pull * zy + total(share, [b.tide[1] for b in bars])]
    observables = [x for pair in found.reaction for x in pair] + found.torque
    return System(
        [*centre, *angle, *rate],
        [as_symbol(x) for x in [vx, vy, *fall, *rate, *found.turn]],
        [as_symbol(x) for x in observables],
        *surface(structure, bars),
    )


def as_symbol(x: Symbol) -> Any:
    """Expression of a number or an expression."""
    import heyoka as hy

    return x if isinstance(x, hy.expression) else hy.expression(float(x))


def total(weights: list[Symbol], values: list[Symbol]) -> Symbol:
    """Weighted sum."""
    import heyoka as hy

    return hy.sum([as_symbol(w * x) for w, x in zip(weights, values, strict=True)])


def chain(
    structure: Structure, centre: list[Symbol], angle: list[Symbol], rate: list[Symbol], pull: Symbol, r2: Symbol
) -> list[Bar]:
    """All bars."""
    import heyoka as hy

    n, (zx, zy, vx, vy) = structure.bars, centre
    half = [parameter(structure, Part.HALF, j) for j in range(n)]
    reach = [(h * hy.cos(q), h * hy.sin(q)) for h, q in zip(half, angle, strict=True)]
    dx, dy = (strung(structure, [p[k] for p in reach]) for k in (0, 1))
    wx = strung(structure, [-w * p[1] for w, p in zip(rate, reach, strict=True)])
    wy = strung(structure, [w * p[0] for w, p in zip(rate, reach, strict=True)])
    bars = []
    for j in range(n):
        mass, inertia, end_inertia, slender = (
            parameter(structure, part, j) for part in (Part.MASS, Part.INERTIA, Part.END_INERTIA, Part.SLENDER)
        )
        tide, torque = gravity(structure, (zx, zy), r2, pull, (dx[j], dy[j]), reach[j], slender)
        place, velocity = (zx + dx[j], zy + dy[j]), (vx + wx[j], vy + wy[j])
        bars.append(Bar(mass, inertia, end_inertia, reach[j], rate[j], tide, torque, place, velocity))
    return bars


def parameter(structure: Structure, part: Part, bar: int) -> Symbol:
    """Parameter of a bar."""
    import heyoka as hy

    return hy.par[structure.place_of(part, bar)]


def strung(structure: Structure, reach: list[Symbol]) -> list[Symbol]:
    """Components of the bars' centres from their common centre; `reach` from each centre to its right end."""
    n = structure.bars
    from_first: list[Symbol] = [0.0]
    for one, other in itertools.pairwise(reach):
        from_first.append(from_first[-1] + (one + other))
    mean = total([parameter(structure, Part.SHARE, j) for j in range(n)], from_first)
    return [x - mean for x in from_first]


def gravity(
    structure: Structure,
    z: tuple[Symbol, Symbol],
    r2: Symbol,
    pull: Symbol,
    d: tuple[Symbol, Symbol],
    reach: tuple[Symbol, Symbol],
    slender: Symbol,
) -> tuple[tuple[Symbol, Symbol], Symbol]:
    """Tide and gravity torque of a bar; `pull` is mu/|Z0|³, and `slender` 3 J/(l/2)²."""
    if structure.gravity == "none":
        return (0.0, 0.0), 0.0
    q = ((2.0 * z[0] + d[0]) * d[0] + (2.0 * z[1] + d[1]) * d[1]) / r2
    y = (1.0 + q) ** -0.5
    square = y * y
    cube = pull * (square * y)
    change = pull * (q * square * (square + y + 1.0) / (1.0 + y))
    tide = (z[0] * change - d[0] * cube, z[1] * change - d[1] * cube)
    if structure.gravity == "point":
        return tide, 0.0
    # with rho the radial unit vector and psi the angle from it to the bar: K = -3 (mu/r³) J sin(psi) cos(psi)
    x, y_ = z[0] + d[0], z[1] + d[1]
    to_sine, to_cosine = y_ * reach[0] - x * reach[1], x * reach[0] + y_ * reach[1]
    return tide, slender * (to_sine * to_cosine * (cube * (square / r2)))


def law_acceleration(offset: int) -> Symbol:
    """Second derivative of eq. (28); parameters: amplitude over 16 (zero while held), pi/t_m, start."""
    import heyoka as hy

    amplitude, w = hy.par[offset], hy.par[offset + 1]
    x = w * (hy.time - hy.par[offset + 2])
    return 9.0 * amplitude * w * w * (hy.cos(x) - hy.cos(3.0 * x))


def surface(structure: Structure, bars: list[Bar]) -> tuple[list[Symbol], list[Symbol], list[Symbol]]:
    """What falls through zero where a bar touches the surface, by an end or between its ends."""
    import heyoka as hy

    r2 = hy.par[1] * hy.par[1]
    (x, y), (px, py) = bars[0].place, bars[0].reach
    points = [(x - px, y - py)] + [(b.place[0] + b.reach[0], b.place[1] + b.reach[1]) for b in bars]
    half2 = [parameter(structure, Part.HALF, j) * parameter(structure, Part.HALF, j) for j in range(len(bars))]
    lines = [b.place[0] * b.across[0] + b.place[1] * b.across[1] for b in bars]
    feet = [b.place[0] * b.reach[0] + b.place[1] * b.reach[1] for b in bars]
    return (
        [x * x + y * y - r2 for x, y in points],
        [q * q - h2 * r2 for q, h2 in zip(lines, half2, strict=True)],
        [q * q - h2 * h2 for q, h2 in zip(feet, half2, strict=True)],
    )
