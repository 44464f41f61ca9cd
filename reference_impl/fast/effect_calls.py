"""Calls of a chain's effects, each compiled by itself, through the addresses in `CompiledEffect`.

An effect's module defines

constants(effect)
    Struct with the constants and arrays of an effect of the reference, and its ``mode`` if it has modes.
add_effect(own, n, t_s, y, mean_x, mean_y, chain, work)
    Adds accelerations to rows A of `Workspace.effect_bars` (central ones to rows G) and to `Workspace.effect_common`,
    and angular accelerations to row ANGULAR.
mode_ended(own, n, t_s, y, mean_x, mean_y, chain, work), for effects with state events
    Whether an event function of its mode is negative.

A chain without effects makes no call, and imports and compiles nothing of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from reference_impl.fast.bar_positions import centres_from_first
from reference_impl.fast.layout import (
    AX,
    AY,
    BAR,
    COMMON_X,
    COMMON_Y,
    GX,
    GY,
    LOCAL,
    MEAN_X,
    MEAN_Y,
    NO_GRAVITY,
    NONCENTRAL_X,
    NONCENTRAL_Y,
    UNIT,
    WEIGHT,
    CompiledChain,
    Workspace,
)
from reference_impl.machine_code.functions import inlined, through_address
from reference_impl.machine_code.structs import Struct, Vector

if TYPE_CHECKING:
    from reference_impl.machine_code.structs import Matrix


@through_address
def add_effect(
    address: int,
    own: Struct,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> None:
    """Add one effect."""


@through_address
def mode_ended(
    address: int,
    own: Struct,
    n: int,
    t_s: float,
    y: Vector,
    mean_x: float,
    mean_y: float,
    chain: CompiledChain,
    work: Workspace,
) -> bool:
    """Whether a mode of one effect has ended."""
    raise NotImplementedError


@inlined
def add_effects(
    n: int, t_s: float, y: Vector, mean_x: float, mean_y: float, chain: CompiledChain, work: Workspace
) -> None:
    """Add all effects to rows G, ANGULAR and to the sums of the effects; gravity, if any, has computed positions."""
    rows, pushed, common = work.bars, work.effect_bars, work.effect_common
    common[MEAN_X], common[MEAN_Y] = mean_x, mean_y
    if chain.gravity == NO_GRAVITY:
        common[MEAN_X], common[MEAN_Y] = centres_from_first(n, chain.bars, rows)
    for i in range(n):
        pushed[AX, i] = pushed[AY, i] = 0.0
    common[COMMON_X] = common[COMMON_Y] = common[NONCENTRAL_X] = common[NONCENTRAL_Y] = 0.0
    for e in range(len(chain.effects)):
        effect = chain.effects[e]
        add_effect(effect.add, effect.own, n, t_s, y, common[MEAN_X], common[MEAN_Y], chain, work)
    for i in range(n):
        rows[GX, i] += pushed[AX, i]
        rows[GY, i] += pushed[AY, i]


@inlined
def add_common_acceleration(n: int, chain: CompiledChain, work: Workspace, rates: Vector) -> None:
    """Add the effects' part of the acceleration of the centre of mass; without gravity also the mean of differences."""
    rates[2 * n + 2] += work.effect_common[COMMON_X]
    rates[2 * n + 3] += work.effect_common[COMMON_Y]
    if chain.gravity == NO_GRAVITY:
        for i in range(n):
            rates[2 * n + 2] += chain.bars[WEIGHT, i] * work.bars[GX, i]
            rates[2 * n + 3] += chain.bars[WEIGHT, i] * work.bars[GY, i]


@inlined
def add_noncentral_acceleration(k: int, law: Vector, x: float, y: float, matrix: Matrix, work: Workspace) -> None:
    """Subtract the effects' acceleration of the longitude of law `k`'s bar at (x, y) from the right-hand side."""
    if law[LOCAL] != 0.0:
        bar = int(law[BAR])
        across_x = work.effect_common[NONCENTRAL_X] + work.effect_bars[AX, bar]
        across_y = work.effect_common[NONCENTRAL_Y] + work.effect_bars[AY, bar]
        matrix[k, len(matrix)] += law[UNIT] * ((x * across_y - y * across_x) / (x * x + y * y))


@inlined
def any_mode_ended(
    n: int, t_s: float, y: Vector, mean_x: float, mean_y: float, chain: CompiledChain, work: Workspace
) -> bool:
    """Whether a mode of any effect has ended, at a state with valid rows U and D; each effect samples its state."""
    seen = False
    for e in range(len(chain.effects)):
        effect = chain.effects[e]
        if effect.mode_ended != 0:
            seen = mode_ended(effect.mode_ended, effect.own, n, t_s, y, mean_x, mean_y, chain, work) or seen
    return seen


@inlined
def has_state_events(chain: CompiledChain) -> bool:
    """Whether the motion may end a mode of any effect."""
    found = False
    for e in range(len(chain.effects)):
        found = found or chain.effects[e].mode_ended != 0
    return found
