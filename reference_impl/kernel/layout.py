"""Layout of the kernel's arrays: one row per quantity, one column per bar.

The structs are those of ``c/kernel.h``, the rows and columns those of the headers named beside them. The state is one
vector, y = [theta (N), Z0 (2), theta' (N), Z0' (2)]: coordinates, then their rates. Zeros pad it to whole vector
registers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from reference_impl.kernel.effects import CompiledEffect, compiled_effect
from reference_impl.kernel.packing import DOUBLE, Matrix, Number, Struct, Vector
from reference_impl.model.chain import LAW_FRAMES, ill_conditioned

if TYPE_CHECKING:
    from reference_impl.model.arrays import Array
    from reference_impl.model.chain import BarTurn, ChainModel, GravityModel, Prescription

GRAVITY_CODES: dict[GravityModel, int] = {"none": 0, "point": 1, "gradient": 2}
NO_GRAVITY, GRADIENT = GRAVITY_CODES["none"], GRAVITY_CODES["gradient"]

REGISTER = 8  # numbers per widest vector register
# rows of CompiledChain.bars: c/chain/layout.h
HALF, WEIGHT, INVERSE_MASS, COMPLIANCE, LEVER, INVERSE_INERTIA, PASSED, FREED, ILL_CONDITIONED, REFINED = range(10)
UNEQUAL, ALPHA, BETA, PASSED_RIGHT, FREED_RIGHT = range(10, 15)
CONSTANT_ROWS, SCRATCH_ROWS = 15, 25
# rows of Workspace.bars that Python reads: c/chain/layout.h
GX, GY, RX, RY = 4, 5, 14, 15
# columns of CompiledChain.laws: c/chain/laws.h
BAR, REACTS_ON, FRAME, UNIT, FIRST_TURN = range(5)
AMPLITUDE, DURATION, START, COURSE, CONSTANT, LINEAR, SQUARE, CUBE, TURN_COLUMNS = range(9)
EQUATION_28, QUINTIC, SPLINE = range(3)
NO_TURN = (0.0, 1.0, *[0.0] * (TURN_COLUMNS - 2))
INERTIAL, LOCAL_HORIZONTAL, PREVIOUS_BAR = map(LAW_FRAMES.index, ("inertial", "local_horizontal", "previous_bar"))
# items of Stepper.clock, and return codes of the stepper: c/steps/stepper.h
NOW, STEP, TAKEN, STEPS, SAMPLED, EVALUATIONS, EXACT = range(7)
ARRIVED, CHECK_SURFACE, COLLAPSED, NOT_FINITE, LOST_JOINT, MODE_ENDED = range(6)
GIVEN_BACK = -1.0
"""Code of a chain that lanes can't run: c/lanes.c"""
SLOPE_ROWS, POWER_ROWS = 16, 7


@dataclass(frozen=True)
class CompiledChain(Struct):
    """Chain in compiled code; N bars, P prescribed rotations."""

    mu_m3_s2: float
    gravity: int
    """One of `GRAVITY_CODES`"""
    bars: Matrix
    """(15, N) rows HALF l/2, WEIGHT m/M, INVERSE_MASS w = 1/m, COMPLIANCE c = l²/4J, LEVER l/2J, INVERSE_INERTIA 1/J,
    PASSED 2 alpha/(w + alpha² c), FREED 4w/(w + alpha² c), ILL_CONDITIONED 1 in ill-conditioned chains, else 0, REFINED
    1 if reactions are refined, else 0, UNEQUAL 1 if any levers are unequal, else 0, ALPHA and BETA the levers over l/2,
    PASSED_RIGHT and FREED_RIGHT as PASSED and FREED with beta
    """
    laws: Matrix
    """(P, 4+8T) columns BAR, REACTS_ON (-1: none), FRAME, UNIT sqrt(J); of each of T turns AMPLITUDE rad, DURATION s,
    START s, COURSE, and CONSTANT, LINEAR, SQUARE, CUBE: acceleration of a spline's piece by powers of its share, rad/s²
    """
    effects: tuple[CompiledEffect, ...]
    """Effects of the chain"""

    @property
    def number(self) -> Number:
        """Type of its numbers, and of all arrays of a call."""
        found: Number = self.bars.dtype.type
        return found


@dataclass(frozen=True)
class Workspace(Struct):
    """Scratch arrays of one evaluation, and its results besides the rates."""

    bars: Matrix
    """(25, N) rows of `c/chain/layout.h`, among them GX, GY, the accelerations without reactions minus that of the
    centre of mass, and RX, RY, the N-1 reactions
    """
    responses: Matrix
    """(2P, N) reactions to a unit of each prescribed torque, x and y"""
    torque_system: Matrix
    """(P, P+1) system of the prescribed torques"""
    torque_N_m: Vector
    """(P,)"""
    effect_bars: Matrix
    """(4, N) rows of `c/effects/effect.h`; (0, 0) without effects"""
    effect_common: Vector
    """(6,) sums of the effects; (0,) without effects"""


@dataclass(frozen=True)
class SurfaceBounds(Struct):
    """Bounds that exclude contact with the surface."""

    contact_free_radius_m: float
    """Orbital radius of the centre of mass above which no bar can touch the surface; 0: no surface"""
    contact_free_perigee_m: float
    """The same for the perigee of its orbit"""
    largest_pull_m_s2: float
    """Upper bound of the acceleration towards the body"""


@dataclass(frozen=True)
class Stepper(Struct):
    """State of an integration between steps."""

    clock: Vector
    """(7,) NOW, s; STEP, size of the next step, s; TAKEN, size of the last step, s; counts: STEPS, SAMPLED samples,
    EVALUATIONS; EXACT: 1 for steps with compensated summation and coefficients of thirty digits, else 0
    """
    y: Vector
    """(size,) current state; `size` is 2N+4, padded"""
    before: Vector
    """(size,) state before the last step"""
    end: Vector
    """(size,) scratch"""
    slopes: Matrix
    """(16, size) rates at the stages; row 0 is the current rate"""
    powers: Matrix
    """(7, size) interpolant of the last step"""
    allowed: Vector
    """(size,) error allowed in the next step"""
    residue: Matrix
    """(2, size) rounding residues of the current state and of the end of the trial step; zeros unless EXACT"""


def new_stepper(y: Vector, *, exact: bool = False) -> Stepper:
    """Stepper of an integration that starts at `y`."""
    size, number = len(y), y.dtype
    clock, end, allowed = (np.zeros(count, number) for count in (7, size, size))
    clock[EXACT] = exact
    slopes, powers, residue = (np.zeros((rows, size), number) for rows in (SLOPE_ROWS, POWER_ROWS, 2))
    return Stepper(clock, y.copy(), y.copy(), end, slopes, powers, allowed, residue)


@dataclass(frozen=True)
class VectorView(Struct):
    """One vector, for functions that take its address and length."""

    value: Vector


@dataclass(frozen=True)
class MatrixView(Struct):
    """One matrix, for functions that take its address and extents."""

    value: Matrix


@dataclass(frozen=True)
class BatchMembers(Struct):
    """Chains of a batch, of equal length, gravity, effects and number of laws; `runs` of them."""

    mu_m3_s2: Vector
    """(runs,)"""
    gravity: int
    """One of `GRAVITY_CODES`"""
    bars: Matrix
    """(15 runs, N) rows as in :class:`CompiledChain`, one chain after another"""
    laws: Matrix
    """(P runs, 4+8T)"""
    effects: tuple[CompiledEffect, ...]
    bounds: Matrix
    """(runs, 3) columns as in :class:`SurfaceBounds`"""
    y0: Matrix
    """(runs, size)"""
    atol: Matrix
    """(runs, size)"""


@dataclass(frozen=True)
class MemberResults(Struct):
    """Results of a batch of `runs` members at n samples."""

    angle_rad: Matrix
    """(runs n, N)"""
    reaction_N: Matrix
    """(runs n, N-1) magnitudes"""
    code: Vector
    """(runs,) return codes, or GIVEN_BACK"""
    steps: Vector
    """(runs,)"""
    evaluations: Vector
    """(runs,)"""


@dataclass(frozen=True)
class CvodeData(Struct):
    """CVODE's `user_data`."""

    numbers_of: int
    """Address of SUNDIALS' function from a vector to its numbers"""
    chain: Struct
    """:class:`CompiledChain`"""
    work: Struct
    """:class:`Workspace`"""
    left_m: Vector
    """(N,)"""
    right_m: Vector
    """(N,)"""
    weight: Vector
    """(N,)"""
    body_radius_m: float
    counts: Vector
    """(3,) calls of the rates and of the event function, and 1 after a joint was lost in round-off"""


def compiled_chain(model: ChainModel, number: Number = DOUBLE) -> CompiledChain:
    """Arrays of `model`, of one type of numbers."""
    most = max((len(p.turns) for p in model.prescriptions), default=1)
    table = np.array([law_row(model, p, most) for p in model.prescriptions], dtype=number)
    table = table.reshape(len(model.prescriptions), FIRST_TURN + most * TURN_COLUMNS)
    share = None if model.com_share is None else model.com_share.astype(number)
    mass, length, inertia = (each.astype(number) for each in (model.mass_kg, model.length_m, model.inertia_kg_m2))
    bars = bar_rows(mass, length, inertia, share)
    effects = tuple(compiled_effect(effect, number) for effect in model.effects)
    return CompiledChain(float(model.mu_m3_s2), GRAVITY_CODES[model.gravity], bars, table, effects)


def law_row(model: ChainModel, p: Prescription, most: int) -> list[float]:
    """Row of `CompiledChain.laws` with `most` turns."""
    turns = [turn_row(turn) for turn in p.turns]
    turns += [NO_TURN] * (most - len(turns))
    reacts_on = -1 if p.reacts_on is None else p.reacts_on
    unit = float(model.inertia_kg_m2[p.bar]) ** 0.5
    return [p.bar, reacts_on, LAW_FRAMES.index(p.frame), unit, *(x for turn in turns for x in turn)]


def turn_row(turn: BarTurn) -> tuple[float, ...]:
    """Columns of one turn."""
    course = SPLINE if turn.spline_rad else QUINTIC if turn.quintic else EQUATION_28
    _, *second = turn.spline_rad or [0.0] * 5
    by_power = (n * (n - 1.0) * c / turn.duration_s**2 for n, c in enumerate(second, 2))
    return (turn.amplitude_rad, turn.duration_s, turn.start_s, course, *by_power)


def refined(chain: CompiledChain) -> CompiledChain:
    """Copy of a chain with refinement of reactions for any bars, for evaluation at samples."""
    bars = chain.bars.copy()
    bars[REFINED] = 1.0
    return replace(chain, bars=bars)


def bar_rows(mass_kg: Array, length_m: Array, inertia_kg_m2: Array, com_share: Array | None = None) -> Array:
    """`CompiledChain.bars` of one chain (N,) or of many (..., N), with the same shares (N,); shape (..., 15, N)."""
    half, w = 0.5 * length_m, 1.0 / mass_kg
    c = half**2 / inertia_kg_m2
    weight = mass_kg / mass_kg.sum(axis=-1, keepdims=True)
    alpha = np.ones_like(w) if com_share is None else 2.0 * com_share + np.zeros_like(w)
    beta = np.ones_like(w) if com_share is None else 2.0 * (1.0 - com_share) + np.zeros_like(w)
    hard = np.zeros_like(w) + ill_conditioned(w, np.maximum(alpha, beta) ** 2 * c)[..., None]
    unequal = np.full_like(w, com_share is not None)
    left, right = w + alpha**2 * c, w + beta**2 * c
    rows = [
        half, weight, w, c, half / inertia_kg_m2, 1.0 / inertia_kg_m2, 2.0 * alpha / left, 4.0 * w / left, hard, hard,
        unequal, alpha, beta, 2.0 * beta / right, 4.0 * w / right,
    ]  # fmt: skip
    return np.stack(rows, axis=-2)


def workspace(bars: int, laws: int, effects: bool = False, number: Number = DOUBLE) -> Workspace:
    """Workspace for a chain of `bars` bars with `laws` prescribed rotations, and with room for effects."""
    shapes = (25, bars), (2 * laws, bars), (laws, laws + 1), (laws,), (4 * effects, bars * effects), (6 * effects,)
    return Workspace(*(np.zeros(shape, number) for shape in shapes))


def workspace_of(chain: CompiledChain) -> Workspace:
    """Workspace for `chain`."""
    return workspace(chain.bars.shape[1], len(chain.laws), bool(chain.effects), chain.number)


def pack(com_m: Array, com_velocity_m_s: Array, angle_rad: Array, rate_rad_s: Array) -> Array:
    """State vector of one chain, or state vectors (..., size) of many."""
    return padded([angle_rad, com_m, rate_rad_s, com_velocity_m_s], 0.0)


def padded(parts: list[Array], value: float) -> Array:
    """Vectors concatenated along the last axis, padded with `value` to whole registers."""
    joined = np.concatenate(parts, axis=-1).astype(float)
    idle = np.full((*joined.shape[:-1], -joined.shape[-1] % REGISTER), value)
    return np.concatenate([joined, idle], axis=-1)
