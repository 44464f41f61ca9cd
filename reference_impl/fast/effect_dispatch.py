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

from reference_impl.fast.bar_positions import hang_from_first
from reference_impl.fast.jit import OPTIONS
from reference_impl.fast.layout import (
    ASIDE_X,
    ASIDE_Y,
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
    UNIT,
    WEIGHT,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from reference_impl.fast.layout import Chain, Effects, Work
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


def uncompiled(effects: Effects) -> None:
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


def keep(effects: Effects, mean_x: float, mean_y: float, work: Work) -> None:
    """Keep for the effects where the centre of mass is, from the first bar's."""
    uncompiled(effects)


@by_type(keep)
def keep_code(effects: Any, mean_x: Any, mean_y: Any, work: Any) -> Code:
    """Nothing without effects."""
    if not len(effects):
        return lambda effects, mean_x, mean_y, work: None

    def code(effects: Effects, mean_x: float, mean_y: float, work: Work) -> None:
        work.pushed.common[MEAN_X], work.pushed.common[MEAN_Y] = mean_x, mean_y

    return code


def push(effects: Effects, n: int, t_s: float, y: Array, chain: Chain, work: Work) -> None:
    """Add what all effects do to rows G, SPIN and to `Work.pushed`."""
    uncompiled(effects)


@by_type(push)
def push_code(effects: Any, n: Any, t_s: Any, y: Any, chain: Any, work: Any) -> Code:
    """Nothing without effects; places are there where gravity is."""
    if not len(effects):
        return lambda effects, n, t_s, y, chain, work: None

    def code(effects: Effects, n: int, t_s: float, y: Array, chain: Chain, work: Work) -> None:
        rows, pushed, common = work.bars, work.pushed.bars, work.pushed.common
        if chain.gravity == NO_GRAVITY:
            common[MEAN_X], common[MEAN_Y] = hang_from_first(n, chain.bars, rows)
        for i in range(n):
            pushed[AX, i] = pushed[AY, i] = 0.0
        common[COMMON_X] = common[COMMON_Y] = common[ASIDE_X] = common[ASIDE_Y] = 0.0
        act(effects, n, t_s, y, common[MEAN_X], common[MEAN_Y], chain, work)
        for i in range(n):
            rows[GX, i] += pushed[AX, i]
            rows[GY, i] += pushed[AY, i]

    return code


def act(effects: Effects, n: int, t_s: float, y: Array, mean_x: float, mean_y: float, chain: Chain, work: Work) -> None:
    """Let one effect after another act."""
    uncompiled(effects)


@by_type(act)
def act_code(effects: Any, n: Any, t_s: Any, y: Any, mean_x: Any, mean_y: Any, chain: Any, work: Any) -> Code:
    """The first, then the rest."""
    if not len(effects):
        return lambda effects, n, t_s, y, mean_x, mean_y, chain, work: None
    first = module_of(effects[0]).act

    def code(
        effects: Effects, n: int, t_s: float, y: Array, mean_x: float, mean_y: float, chain: Chain, work: Work
    ) -> None:
        first(effects[0], n, t_s, y, mean_x, mean_y, chain, work)
        act(effects[1:], n, t_s, y, mean_x, mean_y, chain, work)

    return code


def move(effects: Effects, n: int, chain: Chain, work: Work, rates: Array) -> None:
    """Add to the acceleration of the centre of mass what gravity's does not hold."""
    uncompiled(effects)


@by_type(move, inline="always")  # as a call, even an empty one leaves an instruction behind
def move_code(effects: Any, n: Any, chain: Any, work: Any, rates: Any) -> Code:
    """The common part; where there is no gravity, the mean of the rest too."""
    if not len(effects):
        return lambda effects, n, chain, work, rates: None

    def code(effects: Effects, n: int, chain: Chain, work: Any, rates: Array) -> None:
        rates[2 * n + 2] += work.pushed.common[COMMON_X]
        rates[2 * n + 3] += work.pushed.common[COMMON_Y]
        if chain.gravity == NO_GRAVITY:
            for i in range(n):
                rates[2 * n + 2] += chain.bars[WEIGHT, i] * work.bars[GX, i]
                rates[2 * n + 3] += chain.bars[WEIGHT, i] * work.bars[GY, i]

    return code


def sideways(effects: Effects, k: int, law: Array, x: float, y: float, work: Work) -> None:
    """Add to what law `k` lacks the acceleration of its bar's longitude, the bar at (x, y), by the effects."""
    uncompiled(effects)


@by_type(sideways)
def sideways_code(effects: Any, k: Any, law: Any, x: Any, y: Any, work: Any) -> Code:
    """Of accelerations that are not central."""
    if not len(effects):
        return lambda effects, k, law, x, y, work: None

    def code(effects: Effects, k: int, law: Array, x: float, y: float, work: Work) -> None:
        if law[LOCAL] == 0.0:
            return
        bar, pushed = int(law[BAR]), work.pushed
        across_x = pushed.common[ASIDE_X] + pushed.bars[AX, bar]
        across_y = pushed.common[ASIDE_Y] + pushed.bars[AY, bar]
        work.matrix[k, len(work.matrix)] += law[UNIT] * ((x * across_y - y * across_x) / (x * x + y * y))

    return code


def watched(effects: Effects) -> bool:
    """Whether the motion may carry any effect to where its mode no longer holds."""
    uncompiled(effects)
    return False


@by_type(watched)
def watched_code(effects: Any) -> Code:
    """A constant of the code."""
    if any(hasattr(module_of(effect), "crossed") for effect in effects):
        return lambda effects: True
    return lambda effects: False


def crossed(
    effects: Effects, n: int, t_s: float, y: Array, mean_x: float, mean_y: float, chain: Chain, work: Work
) -> bool:
    """Whether any effect's mode no longer holds at a state whose rows U and D are there."""
    uncompiled(effects)
    return False


@by_type(crossed)
def crossed_code(effects: Any, n: Any, t_s: Any, y: Any, mean_x: Any, mean_y: Any, chain: Any, work: Any) -> Code:
    """The first that is watched, then the rest."""
    if not len(effects):
        return lambda effects, n, t_s, y, mean_x, mean_y, chain, work: False
    first = getattr(module_of(effects[0]), "crossed", None)
    if first is None:
        return lambda effects, n, t_s, y, mean_x, mean_y, chain, work: crossed(
            effects[1:], n, t_s, y, mean_x, mean_y, chain, work
        )

    def code(
        effects: Effects, n: int, t_s: float, y: Array, mean_x: float, mean_y: float, chain: Chain, work: Work
    ) -> bool:
        seen = first(effects[0], n, t_s, y, mean_x, mean_y, chain, work)
        rest = crossed(effects[1:], n, t_s, y, mean_x, mean_y, chain, work)  # each of them looks
        return seen or rest

    return code
