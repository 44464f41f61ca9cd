"""Layout of the fast reference's arrays: one row per quantity, one column per bar.

The state is one vector, y = [theta (N), Z0 (2), theta' (N), Z0' (2)]: coordinates, then their rates. Zeros pad it to
whole vector registers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.machine_code.structs import Matrix, Struct, Vector
from reference_impl.model.chain import ill_conditioned

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import ChainModel, GravityModel
    from reference_impl.model.effect import ChainEffect

GRAVITY_CODES: dict[GravityModel, int] = {"none": 0, "point": 1, "gradient": 2}
NO_GRAVITY, GRADIENT = GRAVITY_CODES["none"], GRAVITY_CODES["gradient"]

REGISTER = 8  # numbers per widest vector register
# rows of CompiledChain.bars
HALF, WEIGHT, INVERSE_MASS, COMPLIANCE, LEVER, INVERSE_INERTIA, PASSED, FREED, ILL_CONDITIONED, REFINED = range(10)
# rows of Workspace.bars
UX, UY, DX, DY, GX, GY, ANGULAR, LEFT, LEFT_Y, RIGHT, RIGHT_Y, KXX, KXY, KYY = range(14)
RX, RY, PX, PY, HXX, HXY, HYX, HYY, BX, BY, LYY = range(14, 25)
LXX, LXY = PX, PY  # rows of a factor share those of a sweep
# columns of CompiledChain.laws
BAR, REACTS_ON, LOCAL, AMPLITUDE, DURATION, START, UNIT = range(7)
# rows of Workspace.effect_bars, indices of Workspace.effect_common
AX, AY, VX, VY = range(4)
COMMON_X, COMMON_Y, NONCENTRAL_X, NONCENTRAL_Y, MEAN_X, MEAN_Y = range(6)


@dataclass(frozen=True)
class CompiledEffect(Struct):
    """One effect in compiled code."""

    add: int
    """Address of its function of :func:`reference_impl.fast.effect_calls.add_effect`"""
    mode_ended: int
    """Address of its function of :func:`reference_impl.fast.effect_calls.mode_ended`; 0 for an effect without events"""
    own: Struct
    """Constants and arrays of the effect, defined by its module; an effect with modes has them in ``own.mode``"""

    @property
    def mode(self) -> Vector:
        """Mode of the effect, set by the caller; (0,) for an effect without modes."""
        found: Vector = getattr(self.own, "mode", np.zeros(0))
        return found


Effects = tuple[CompiledEffect, ...]


@dataclass(frozen=True)
class CompiledChain(Struct):
    """Chain in compiled code; N bars, P prescribed rotations."""

    mu_m3_s2: float
    gravity: int
    """One of `GRAVITY_CODES`"""
    bars: Matrix
    """(10, N) rows HALF l/2, WEIGHT m/M, INVERSE_MASS w = 1/m, COMPLIANCE c = l²/4J, LEVER l/2J, INVERSE_INERTIA 1/J,
    PASSED 2/(w+c), FREED 4w/(w+c), ILL_CONDITIONED 1 in ill-conditioned chains, else 0, REFINED 1 if reactions are
    refined, else 0
    """
    laws: Matrix
    """(P, 7) columns BAR, REACTS_ON (-1: none), LOCAL, AMPLITUDE rad, DURATION s, START s, UNIT sqrt(J)"""
    effects: tuple[CompiledEffect, ...]
    """Effects of the chain"""


@dataclass(frozen=True)
class Workspace(Struct):
    """Scratch arrays of one evaluation, and its results besides the rates."""

    bars: Matrix
    """(25, N) rows U unit vectors, D positions from the first bar's, G field, ANGULAR, LEFT and RIGHT accelerations of
    the ends without reactions, K = c n nᵀ, R reactions (N-1 of them), P and H of the sweep, L and H of the factors, B
    relative accelerations of the joined ends without reactions; after gravity, D and B serve the refinement of
    :mod:`reference_impl.fast.joints`
    """
    responses: Matrix
    """(2P, N) reactions to a unit of each prescribed torque, x and y"""
    matrix: Matrix
    """(P, P+1) system of the prescribed torques"""
    torque_N_m: Vector
    """(P,)"""
    effect_bars: Matrix
    """(4, N) rows A: noncentral accelerations of the effects minus the common part; rows V: velocities of the bars'
    centres from the first bar's, computed only for effects that use them; (0, 0) without effects
    """
    effect_common: Vector
    """(6,) sums of the effects: COMMON, acceleration common to all bars; NONCENTRAL, its noncentral part; MEAN, the
    centre of mass from the first bar's centre, computed with rows D of `bars`; (0,) without effects
    """


def compiled_chain(model: ChainModel) -> CompiledChain:
    """Arrays of `model`."""
    laws = [
        (p.bar, -1 if p.reacts_on is None else p.reacts_on, p.local_horizontal,
         p.amplitude_rad, p.duration_s, p.start_s, model.inertia_kg_m2[p.bar] ** 0.5)
        for p in model.prescriptions
    ]  # fmt: skip
    table = np.array(laws, dtype=float).reshape(len(laws), 7)
    bars = bar_rows(model.mass_kg, model.length_m, model.inertia_kg_m2)
    return CompiledChain(
        float(model.mu_m3_s2), GRAVITY_CODES[model.gravity], bars, table, tuple(map(compiled_effect, model.effects))
    )


def refined(chain: CompiledChain) -> CompiledChain:
    """Copy of a chain with refinement of reactions for any bars, for evaluation at samples."""
    bars = chain.bars.copy()
    bars[REFINED] = 1.0
    return replace(chain, bars=bars)


def compiled_effect(effect: ChainEffect) -> CompiledEffect:
    """Arrays and functions of one effect, by its own module, imported on first use."""
    module = import_module(f"{__package__}.effects.{effect.name}")
    ended = getattr(module, "mode_ended", None)
    return CompiledEffect(module.add_effect.address, ended.address if ended else 0, module.constants(effect))


def bar_rows(mass_kg: Array, length_m: Array, inertia_kg_m2: Array) -> Array:
    """`CompiledChain.bars` of one chain (N,) or of many (..., N); shape (..., 10, N)."""
    half, w = 0.5 * length_m, 1.0 / mass_kg
    c = half**2 / inertia_kg_m2
    weight = mass_kg / mass_kg.sum(axis=-1, keepdims=True)
    hard = np.zeros_like(w) + ill_conditioned(w, c)[..., None]
    rows = [half, weight, w, c, half / inertia_kg_m2, 1.0 / inertia_kg_m2, 2.0 / (w + c), 4.0 * w / (w + c), hard, hard]
    return np.stack(rows, axis=-2).astype(float)


def workspace(bars: int, laws: int, effects: bool = False) -> Workspace:
    """Workspace for a chain of `bars` bars with `laws` prescribed rotations, and with room for effects."""
    pushed, common = (np.zeros((4, bars)), np.zeros(6)) if effects else (np.zeros((0, 0)), np.zeros(0))
    return Workspace(
        np.zeros((25, bars)), np.zeros((2 * laws, bars)), np.zeros((laws, laws + 1)), np.zeros(laws), pushed, common
    )


def workspace_of(chain: CompiledChain) -> Workspace:
    """Workspace for `chain`."""
    return workspace(chain.bars.shape[1], len(chain.laws), bool(chain.effects))


def pack(com_m: Array, com_velocity_m_s: Array, angle_rad: Array, rate_rad_s: Array) -> Array:
    """State vector of one chain, or state vectors (..., size) of many."""
    return padded([angle_rad, com_m, rate_rad_s, com_velocity_m_s], 0.0)


def padded(parts: list[Array], value: float) -> Array:
    """Vectors concatenated along the last axis, padded with `value` to whole registers."""
    joined = np.concatenate(parts, axis=-1).astype(float)
    idle = np.full((*joined.shape[:-1], -joined.shape[-1] % REGISTER), value)
    return np.concatenate([joined, idle], axis=-1)
