"""Effects in compiled code: chosen by the type of a chain's tuple of them when code is made, never while it runs.

Each function here is a name that has code only for given types (Numba's `overload`): for no effects none at all, so
that a chain without them has the machine code that it would have if there were no effects; else that of the first,
then that of the rest. The module of an effect is imported when code with it is made. It has

acting(effect)
    `layout.Acting` of an effect of the reference.
act(effect, n, t_s, y, mean_x, mean_y, chain, work)
    Adds accelerations to rows A of `Pushed.bars` (towards the centre of the body: to rows G) and to `Pushed.common`,
    angular ones to row SPIN.
crossed(effect, n, t_s, y, mean_x, mean_y, chain, work), where the effect is watched
    Whether a margin of its mode is below zero.
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
"""What compiles: a function of the arguments of the name that it stands for"""
INLINED = {key: value for key, value in OPTIONS.items() if key != "cache"} | {"forceinline": True}


def by_type(name: Callable[..., object], inline: str = "never") -> Callable[[Code], Code]:
    """Let a function of types choose the code of `name`; kept on disk with its callers.

    It is not strict, as the annotations of types and of their values differ.
    """
    chosen: Callable[[Code], Code] = overload(name, jit_options=INLINED, inline=inline, strict=False)
    return chosen


def require_no_effects(effects: Effects) -> None:
    """What all names here are without a compiler: nothing, for a chain without effects.

    Raises
    ------
    NotImplementedError
        For effects, whose code is chosen by types that only a compiler has.
    """
    if effects:
        raise NotImplementedError("effects are in compiled code only")


def module_of(effect: Any) -> Any:  # a Numba type has no type that the checker knows
    """Module of the effect whose `Acting` has this Numba type."""
    (name,) = effect.types[0].dtype.fields
    return import_module(f"{__package__}.effects.{name}")


def keep_mean_position(effects: Effects, mean_x: float, mean_y: float, work: Workspace) -> None:
    """Keep for the effects where the centre of mass is, from the first bar's."""
    require_no_effects(effects)


@by_type(keep_mean_position)
def keep_mean_position_code(effects: Any, mean_x: Any, mean_y: Any, work: Any) -> Code:
    """Nothing without effects."""
    if not len(effects):
        return lambda effects, mean_x, mean_y, work: None

    def code(effects: Effects, mean_x: float, mean_y: float, work: Workspace) -> None:
        work.effect_sums.common[MEAN_X], work.effect_sums.common[MEAN_Y] = mean_x, mean_y

    return code


def add_effects(effects: Effects, n: int, t_s: float, y: Array, chain: CompiledChain, work: Workspace) -> None:
    """Add what all effects do to rows G, SPIN and to `Work.pushed`."""
    require_no_effects(effects)


@by_type(add_effects)
def add_effects_code(effects: Any, n: Any, t_s: Any, y: Any, chain: Any, work: Any) -> Code:
    """Nothing without effects; places are there where gravity is."""
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
    """Let one effect after another act."""
    require_no_effects(effects)


@by_type(add_each_effect)
def add_each_effect_code(
    effects: Any, n: Any, t_s: Any, y: Any, mean_x: Any, mean_y: Any, chain: Any, work: Any
) -> Code:
    """The first, then the rest."""
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
    """Add to the acceleration of the centre of mass what gravity's does not hold."""
    require_no_effects(effects)


@by_type(add_common_acceleration, inline="always")  # as a call, even an empty one leaves an instruction behind
def add_common_acceleration_code(effects: Any, n: Any, chain: Any, work: Any, rates: Any) -> Code:
    """The common part; where there is no gravity, the mean of the rest too."""
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
    """Add to what law `k` lacks the acceleration of its bar's longitude, the bar at (x, y), by the effects."""
    require_no_effects(effects)


@by_type(add_noncentral_acceleration)
def add_noncentral_acceleration_code(effects: Any, k: Any, law: Any, x: Any, y: Any, work: Any) -> Code:
    """Of accelerations that are not central."""
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
    """Whether the motion may carry any effect to where its mode no longer holds."""
    require_no_effects(effects)
    return False


@by_type(has_state_events)
def has_state_events_code(effects: Any) -> Code:
    """A constant of the code."""
    if any(hasattr(module_of(effect), "mode_ended") for effect in effects):
        return lambda effects: True
    return lambda effects: False


def mode_ended(
    effects: Effects, n: int, t_s: float, y: Array, mean_x: float, mean_y: float, chain: CompiledChain, work: Workspace
) -> bool:
    """Whether any effect's mode no longer holds at a state whose rows U and D are there."""
    require_no_effects(effects)
    return False


@by_type(mode_ended)
def mode_ended_code(effects: Any, n: Any, t_s: Any, y: Any, mean_x: Any, mean_y: Any, chain: Any, work: Any) -> Code:
    """The first that is watched, then the rest."""
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
        rest = mode_ended(effects[1:], n, t_s, y, mean_x, mean_y, chain, work)  # each of them looks
        return seen or rest

    return code
