"""Effects in compiled code, dispatched at compile time by the type of a chain's tuple of effects.

Each function is a name with an implementation per argument type (Numba's `overload`). For no effects the implementation
is empty, and a chain without effects has the same machine code as a program without effects. Otherwise the
implementation calls the first effect, then recurses on the rest. Compiling an effect imports its module, which defines

compiled_effect(effect)
    `layout.CompiledEffect` of an effect of the reference.
add_effect(effect, n, t_s, y, mean_x, mean_y, chain, work)
    Adds accelerations to rows A of `EffectSums.bars` (central ones to rows G) and to `EffectSums.common`, and angular
    accelerations to row ANGULAR.
mode_ended(effect, n, t_s, y, mean_x, mean_y, chain, work), for effects with state events
    Whether an event function of its mode is negative.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from numba.extending import overload

from reference_impl.fast.bar_positions import centres_from_first
from reference_impl.fast.jit import OPTIONS
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
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.fast.layout import CompiledChain, Effects, Workspace
    from reference_impl.model.arrays import Array

Code = Any
"""Compilable function with the arguments of the name that it implements"""
INLINED = {key: value for key, value in OPTIONS.items() if key != "cache"} | {"forceinline": True}


def by_type(name: Callable[..., object], inline: str = "never") -> Callable[[Code], Code]:
    """Register a function of types as the selector of the implementation of `name`; cached on disk with its callers.

    The match of signatures is not strict, as the annotations of types and of values differ.
    """
    chosen: Callable[[Code], Code] = overload(name, jit_options=INLINED, inline=inline, strict=False)
    return chosen


def require_no_effects(effects: Effects) -> None:
    """Interpreted implementation of all names of this module: no operation, for chains without effects.

    Raises
    ------
    NotImplementedError
        For effects, whose implementations require the compiler's types.
    """
    if effects:
        raise NotImplementedError("effects require compiled code")


def module_of(effect: Any) -> Any:  # the type checker has no types for Numba's
    """Module of the effect with a `CompiledEffect` of this Numba type."""
    (name,) = effect.types[0].dtype.fields
    return import_module(f"{__package__}.effects.{name}")


def keep_mean_position(effects: Effects, mean_x: float, mean_y: float, work: Workspace) -> None:
    """Store the position of the centre of mass from the first bar's centre, for the effects."""
    require_no_effects(effects)


@by_type(keep_mean_position)
def keep_mean_position_code(effects: Any, mean_x: Any, mean_y: Any, work: Any) -> Code:
    """Empty without effects."""
    if not len(effects):
        return lambda effects, mean_x, mean_y, work: None

    def code(effects: Effects, mean_x: float, mean_y: float, work: Workspace) -> None:
        work.effect_sums.common[MEAN_X], work.effect_sums.common[MEAN_Y] = mean_x, mean_y

    return code


def add_effects(effects: Effects, n: int, t_s: float, y: Array, chain: CompiledChain, work: Workspace) -> None:
    """Add all effects to rows G, ANGULAR and to `Workspace.effect_sums`."""
    require_no_effects(effects)


@by_type(add_effects)
def add_effects_code(effects: Any, n: Any, t_s: Any, y: Any, chain: Any, work: Any) -> Code:
    """Empty without effects; gravity, if any, has computed the positions."""
    if not len(effects):
        return lambda effects, n, t_s, y, chain, work: None

    def code(effects: Effects, n: int, t_s: float, y: Array, chain: CompiledChain, work: Workspace) -> None:
        rows, pushed, common = work.bars, work.effect_sums.bars, work.effect_sums.common
        if chain.gravity == NO_GRAVITY:
            common[MEAN_X], common[MEAN_Y] = centres_from_first(n, chain.bars, rows)
        for i in range(n):
            pushed[AX, i] = pushed[AY, i] = 0.0
        common[COMMON_X] = common[COMMON_Y] = common[NONCENTRAL_X] = common[NONCENTRAL_Y] = 0.0
        add_each_effect(effects, n, t_s, y, common[MEAN_X], common[MEAN_Y], chain, work)
        for i in range(n):
            rows[GX, i] += pushed[AX, i]
            rows[GY, i] += pushed[AY, i]

    return code


def add_each_effect(
    effects: Effects, n: int, t_s: float, y: Array, mean_x: float, mean_y: float, chain: CompiledChain, work: Workspace
) -> None:
    """Add the effects one after another."""
    require_no_effects(effects)


@by_type(add_each_effect)
def add_each_effect_code(
    effects: Any, n: Any, t_s: Any, y: Any, mean_x: Any, mean_y: Any, chain: Any, work: Any
) -> Code:
    """The first effect, then the rest."""
    if not len(effects):
        return lambda effects, n, t_s, y, mean_x, mean_y, chain, work: None
    first = module_of(effects[0]).add_effect

    def code(
        effects: Effects,
        n: int,
        t_s: float,
        y: Array,
        mean_x: float,
        mean_y: float,
        chain: CompiledChain,
        work: Workspace,
    ) -> None:
        first(effects[0], n, t_s, y, mean_x, mean_y, chain, work)
        add_each_effect(effects[1:], n, t_s, y, mean_x, mean_y, chain, work)

    return code


def add_common_acceleration(effects: Effects, n: int, chain: CompiledChain, work: Workspace, rates: Array) -> None:
    """Add the effects' part of the acceleration of the centre of mass."""
    require_no_effects(effects)


@by_type(add_common_acceleration, inline="always")  # even an empty call costs an instruction
def add_common_acceleration_code(effects: Any, n: Any, chain: Any, work: Any, rates: Any) -> Code:
    """The common part; without gravity also the mean of the differences."""
    if not len(effects):
        return lambda effects, n, chain, work, rates: None

    def code(effects: Effects, n: int, chain: CompiledChain, work: Any, rates: Array) -> None:
        rates[2 * n + 2] += work.effect_sums.common[COMMON_X]
        rates[2 * n + 3] += work.effect_sums.common[COMMON_Y]
        if chain.gravity == NO_GRAVITY:
            for i in range(n):
                rates[2 * n + 2] += chain.bars[WEIGHT, i] * work.bars[GX, i]
                rates[2 * n + 3] += chain.bars[WEIGHT, i] * work.bars[GY, i]

    return code


def add_noncentral_acceleration(effects: Effects, k: int, law: Array, x: float, y: float, work: Workspace) -> None:
    """Subtract the effects' acceleration of the longitude of law `k`'s bar at (x, y) from the right-hand side."""
    require_no_effects(effects)


@by_type(add_noncentral_acceleration)
def add_noncentral_acceleration_code(effects: Any, k: Any, law: Any, x: Any, y: Any, work: Any) -> Code:
    """Sum over the noncentral accelerations."""
    if not len(effects):
        return lambda effects, k, law, x, y, work: None

    def code(effects: Effects, k: int, law: Array, x: float, y: float, work: Workspace) -> None:
        if law[LOCAL] == 0.0:
            return
        bar, pushed = int(law[BAR]), work.effect_sums
        across_x = pushed.common[NONCENTRAL_X] + pushed.bars[AX, bar]
        across_y = pushed.common[NONCENTRAL_Y] + pushed.bars[AY, bar]
        work.matrix[k, len(work.matrix)] += law[UNIT] * ((x * across_y - y * across_x) / (x * x + y * y))

    return code


def has_state_events(effects: Effects) -> bool:
    """Whether the motion may end a mode of any effect."""
    require_no_effects(effects)
    return False


@by_type(has_state_events)
def has_state_events_code(effects: Any) -> Code:
    """Constant of the compiled code."""
    if any(hasattr(module_of(effect), "mode_ended") for effect in effects):
        return lambda effects: True
    return lambda effects: False


def mode_ended(
    effects: Effects, n: int, t_s: float, y: Array, mean_x: float, mean_y: float, chain: CompiledChain, work: Workspace
) -> bool:
    """Whether a mode of any effect has ended, at a state with valid rows U and D."""
    require_no_effects(effects)
    return False


@by_type(mode_ended)
def mode_ended_code(effects: Any, n: Any, t_s: Any, y: Any, mean_x: Any, mean_y: Any, chain: Any, work: Any) -> Code:
    """The first effect with state events, then the rest."""
    if not len(effects):
        return lambda effects, n, t_s, y, mean_x, mean_y, chain, work: False
    first = getattr(module_of(effects[0]), "mode_ended", None)
    if first is None:
        return lambda effects, n, t_s, y, mean_x, mean_y, chain, work: mode_ended(
            effects[1:], n, t_s, y, mean_x, mean_y, chain, work
        )

    def code(
        effects: Effects,
        n: int,
        t_s: float,
        y: Array,
        mean_x: float,
        mean_y: float,
        chain: CompiledChain,
        work: Workspace,
    ) -> bool:
        seen = first(effects[0], n, t_s, y, mean_x, mean_y, chain, work)
        rest = mode_ended(effects[1:], n, t_s, y, mean_x, mean_y, chain, work)  # each effect samples its state
        return seen or rest

    return code
