"""Equations of a whole scene as a heyoka system: state, parameters, observables, events."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from adapters.heyoka.bars import SymbolicBar, cross
from adapters.heyoka.equations import chain_motion
from adapters.heyoka.loads import SymbolicLoads, SymbolicState, end_force
from adapters.heyoka.structure import IMPULSE, law_parts
from scenarios import Course

if TYPE_CHECKING:
    from adapters.heyoka.bars import Pair, Symbol
    from adapters.heyoka.structure import Structure


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
    """Event functions of the modes, in the order of `Structure.modes`"""
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
    laws = [law_acceleration(structure, k) for k in range(len(structure.laws))]
    found = chain_motion(bars, structure, laws)
    share = structure.of_bars("share")
    fall = [f + total(share, [b.load.push[k] for b in bars]) for k, f in enumerate(loads.frame)]
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
    """All bars of the chain, with their loads."""
    import heyoka as hy

    n, (zx, zy), (vx, vy) = structure.bars, state.centre, state.velocity
    mass, half, *inertias = (structure.of_bars(x) for x in ("mass", "half", "inertia", "end_inertia", "slender"))
    along = [(hy.cos(q), hy.sin(q)) for q in state.angle]
    reach = [(h * c, h * s) for h, (c, s) in zip(half, along, strict=True)]
    left, right, lean = reach, reach, mass
    if structure.levers:
        levers = (structure.of_bars("left"), structure.of_bars("right"))
        left, right = ([(h * c, h * s) for h, (c, s) in zip(lever, along, strict=True)] for lever in levers)
        lean = structure.of_bars("lean")
    dx, dy = (centre_offsets(structure, [p[k] for p in left], [p[k] for p in right]) for k in (0, 1))
    moving = ([(-w * p[1], w * p[0]) for w, p in zip(state.rate, ends, strict=True)] for ends in (left, right))
    left_velocity, right_velocity = moving
    wx, wy = (centre_offsets(structure, [p[k] for p in left_velocity], [p[k] for p in right_velocity]) for k in (0, 1))
    bars = []
    for j in range(n):
        inertia, end_inertia, slender = (values[j] for values in inertias)
        bar = SymbolicBar(
            j,
            mass[j],
            inertia,
            end_inertia,
            half[j],
            slender,
            along[j],
            reach[j],
            left[j],
            right[j],
            lean[j],
            state.rate[j],
            offset=(dx[j], dy[j]),
            position=(zx + dx[j], zy + dy[j]),
            velocity=(vx + wx[j], vy + wy[j]),
        )
        bars.append(dataclasses.replace(bar, load=loads.load(bar)))
    return bars


def centre_offsets(structure: Structure, left: list[Symbol], right: list[Symbol]) -> list[Symbol]:
    """Components of the bars' centres relative to the centre of mass, from those of their levers."""
    from_first: list[Symbol] = [0.0]
    for one, other in zip(right[:-1], left[1:], strict=True):
        from_first.append(from_first[-1] + (one + other))
    mean = total(structure.of_bars("share"), from_first)
    return [x - mean for x in from_first]


def law_acceleration(structure: Structure, k: int) -> Symbol:
    """Second derivative of law k: the sum of its courses', of which all but that of the present turn are zero."""
    import heyoka as hy

    found = []
    for course in sorted(structure.laws[k].courses):
        w, start, *parts = (structure.parameter(f"law_{k}_{course}_{x}") for x in law_parts(course))
        x = w * (hy.time - start)
        if course == Course.SPLINE:
            constant, linear, square, cube = parts
            found.append(constant + x * (linear + x * (square + x * cube)))
            continue
        (amplitude,) = parts
        shapes = {
            Course.PAPER: 9.0 * (hy.cos(x) - hy.cos(3.0 * x)),
            Course.QUINTIC: 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        }
        found.append(amplitude * w * w * shapes[Course(course)])
    return sum(found[1:], found[0])


def surface(structure: Structure, bars: list[SymbolicBar]) -> tuple[list[Symbol], list[Symbol], list[Symbol]]:
    """Event functions that fall through zero where a bar touches the surface, at an end or between its ends."""
    r2 = structure.parameter("surface") * structure.parameter("surface")
    (x, y), (px, py) = bars[0].position, bars[0].left
    points = [(x - px, y - py)] + [(b.position[0] + b.right[0], b.position[1] + b.right[1]) for b in bars]
    half2 = [half * half for half in structure.of_bars("half")]
    lines = [b.position[0] * b.across[0] + b.position[1] * b.across[1] for b in bars]
    feet = [b.position[0] * b.reach[0] + b.position[1] * b.reach[1] for b in bars]
    return (
        [x * x + y * y - r2 for x, y in points],
        [q * q - h2 * r2 for q, h2 in zip(lines, half2, strict=True)],
        [between(structure, q, h2, j) for j, (q, h2) in enumerate(zip(feet, half2, strict=True))],
    )


def between(structure: Structure, foot: Symbol, half2: Symbol, j: int) -> Symbol:
    """Negative where the nearest point of a bar's line is between its ends: `foot` is its place from the centre."""
    if not structure.levers:
        return foot * foot - half2 * half2
    half, left, right = (structure.parameter(f"{x}_{j}") for x in ("half", "left", "right"))
    return (foot - half * left) * (foot + half * right)


def jumps(structure: Structure, whole: System) -> list[Symbol]:
    """Jumps of Z0' (2) and of theta' (N), and the impulsive reactions on bar j from bar j+1 (2 each).

    They obey the equations of the articulated chain with impulses for forces, and jumps for accelerations: Newton's and
    Euler's laws integrated over an instant. m (c - t) is the impulse of a bar's joints, with c the jump of its centre's
    velocity and t the applied impulse over the mass; J times the jump of the rate is the moment of all impulses.
    Quantities that stay finite drop out: rates, gravity, springs, air. A prescribed bar keeps the rate of its law: its
    jump is 0 relative to inertial axes, and relative to the local horizontal it is the jump of its longitude's rate,
    (Z x c)/r². The motor, or an external torque, provides the impulsive torque for that.
    """
    angle = whole.variables[4 : 4 + structure.bars]
    impulses = [impulse(structure, j, bar, angle[j]) for j, bar in enumerate(whole.bars)]
    bars = [with_impulse(bar, *applied_impulse) for bar, applied_impulse in zip(whole.bars, impulses, strict=True)]
    found = chain_motion(bars, structure, [0.0] * len(structure.laws))
    share = structure.of_bars("share")
    track = [total(share, [b.load.push[k] for b in bars]) for k in (0, 1)]
    return [as_symbol(x) for x in [*track, *found.turn, *(x for pair in found.reaction for x in pair)]]


def impulse(structure: Structure, j: int, bar: SymbolicBar, angle: Symbol) -> tuple[Pair, Symbol]:
    """Sum of the impulses on a bar, and their moment about its centre."""
    x: Symbol = 0.0
    y: Symbol = 0.0
    moment: Symbol = 0.0
    for k, shape in enumerate(structure.impulses):
        if shape.bar == j:
            direction, size = (structure.parameter(f"impulse_{k}_{x}") for x in IMPULSE)
            applied_impulse = end_force(shape, direction, size, angle)
            x, y = x + applied_impulse[0], y + applied_impulse[1]
            moment = moment + cross(bar.arm(shape.side), applied_impulse)
    return (x, y), moment


def with_impulse(bar: SymbolicBar, applied_impulse: Pair, moment: Symbol) -> SymbolicBar:
    """A bar with jumps for accelerations: no rates, and the impulse for gravity."""
    return dataclasses.replace(bar, rate=0.0, velocity=(0.0, 0.0), load=bar.pushed(applied_impulse, moment))
