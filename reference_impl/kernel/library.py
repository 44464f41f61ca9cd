"""The kernel's library: the best one for this processor, and its functions with checked arguments.

Arrays of wrong shapes raise ValueError before a call, arrays of other numbers than the chain's TypeError.
"""

from __future__ import annotations

import ctypes
import itertools
import threading
from ctypes import c_bool, c_char_p, c_double, c_int64, c_void_p
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from reference_impl.kernel import effects, layout
from reference_impl.kernel.build import KernelMissingError, library_file
from reference_impl.kernel.packing import DOUBLE, WIDE, address_of, array_words, word_count

if TYPE_CHECKING:
    from collections.abc import Iterator

    from reference_impl.kernel.layout import (
        BatchMembers,
        CompiledChain,
        CvodeData,
        MemberResults,
        Stepper,
        SurfaceBounds,
        Workspace,
    )
    from reference_impl.kernel.packing import Matrix, Number, Struct, Vector
    from reference_impl.model.arrays import Array

LOCK = threading.Lock()
"""Held while the library is loaded: threads that call first at the same time build an edited one once"""
STRUCTS: dict[str, type[Struct]] = {
    "effect": effects.CompiledEffect, "chain": layout.CompiledChain, "workspace": layout.Workspace,
    "stepper": layout.Stepper, "surface_bounds": layout.SurfaceBounds, "batch_members": layout.BatchMembers,
    "batch_results": layout.MemberResults, "cvode_data": layout.CvodeData, "drag": effects.CompiledDrag,
    "joint_spring_damper": effects.CompiledSprings, "joint_torque": effects.CompiledJointTorque,
    "oblateness": effects.CompiledOblateness, "solar_pressure": effects.CompiledSunlight,
    "third_body": effects.CompiledThirdBody, "thrust": effects.CompiledThrust,
}  # fmt: skip
"""Structs by their names in C"""
NAMES = {"POINT": layout.GRAVITY_CODES["point"], "SLOPES": layout.SLOPE_ROWS, "POWERS": layout.POWER_ROWS}
"""Numbers of ``c/kernel.c`` that have another name, or none, in :mod:`reference_impl.kernel.layout`"""
SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "source_digest": (c_char_p, ()),
    "layout_name": (c_char_p, (c_int64,)),
    "layout_value": (c_int64, (c_int64,)),
    "effect_name": (c_char_p, (c_int64,)),
    "evaluate_state": (c_bool, (c_double, *[c_void_p] * 4)),
    "evaluate_repeatedly": (None, (c_int64, *[c_void_p] * 4)),
    "observe": (c_bool, (c_int64, c_void_p, c_void_p, c_int64, *[c_void_p] * 5)),
    "advance_to": (c_int64, (c_double, c_double, *[c_void_p] * 7)),
    "take_partial_step": (c_bool, (c_double, c_double, *[c_void_p] * 3)),
    "make_interpolant": (None, (c_void_p,) * 3),
    "interpolate_step": (None, (c_double, c_void_p, c_void_p)),
    "take_samples": (None, (c_double, c_void_p, c_void_p, c_bool, *[c_void_p] * 3)),
    "begin_next_step": (None, (c_void_p,)),
    "integrate_batch": (None, (c_void_p,) * 7),
    "lane_count": (c_int64, ()),
    "integrate_in_lanes": (c_bool, (c_void_p,) * 3),
    "evaluate_in_lanes": (c_int64, (c_void_p,) * 3),
    "height_above_surface": (c_double, (c_void_p, c_void_p)),
}
"""Result and parameters of each function of ``c/kernel.h``; the functions for CVODE are called by CVODE alone"""


IN_ALL_INSTANCES = (
    "source_digest", "layout_name", "layout_value", "effect_name", "evaluate_state", "evaluate_repeatedly", "observe",
    "advance_to", "take_partial_step", "make_interpolant", "interpolate_step", "take_samples", "begin_next_step",
    "integrate_batch",
)  # fmt: skip
"""Functions that the library has for each of `INSTANCES`"""
INSTANCES = ("", "wide_", "levers_", "wide_levers_")
"""Prefixes of functions: for doubles and equal levers, for the wide type, for unequal levers, and for both of these"""


@cache
def library() -> ctypes.CDLL:
    """Loaded library, its functions with types.

    Raises
    ------
    KernelMissingError
        If there is none, or its structures, extents, codes or effects are not those of this package.
    """
    with LOCK:
        path = library_file()
    found = ctypes.CDLL(str(path))
    for name, (result, parameters) in SIGNATURES.items():
        for prefix in INSTANCES if name in IN_ALL_INSTANCES else ("",):
            function = getattr(found, f"{prefix}{name}")
            function.restype, function.argtypes = result, parameters
    if other := [*other_numbers(found), *other_effects(found)]:
        raise KernelMissingError(f"{path}: not the layout of this package: {'; '.join(other)}")
    return found


def other_numbers(found: ctypes.CDLL) -> Iterator[str]:
    """Sentences on words of structures, extents and codes that are others in a library than here."""
    for k in itertools.count():
        name = (found.layout_name(k) or b"").decode("ascii")
        if not name:
            return
        here = word_count(STRUCTS[name]) if name in STRUCTS else NAMES.get(name, getattr(layout, name, None))
        if here != (there := found.layout_value(k)):
            yield f"{name} is {there} there, {here} here"


def other_effects(found: ctypes.CDLL) -> Iterator[str]:
    """Sentences on effects that stand at another place in a library than here."""
    for kind, name in enumerate([*effects.KINDS, ""]):
        there = (found.effect_name(kind) or b"").decode("ascii")
        if there != name:
            yield f"effect {kind} is {there or 'none'} there, {name or 'none'} here"


def function(name: str, chain: CompiledChain) -> Any:
    """Function of the library for the numbers and the levers of a chain."""
    wide, levers = "wide_" * (chain.number is WIDE), "levers_" * bool(chain.bars[layout.UNEQUAL].any())
    return getattr(library(), f"{wide}{levers}{name}")


def address(name: str) -> int:
    """Address of a function, for callers in C."""
    found = ctypes.cast(getattr(library(), name), c_void_p).value
    assert found is not None
    return found


def check(what: str, array: Array, shape: tuple[int, ...], number: Number = DOUBLE) -> int:
    """Address of an array of numbers.

    Raises
    ------
    TypeError, ValueError
        If it has other elements, gaps, or another shape.
    """
    words = array_words(array, "Vector" if len(shape) == 1 else "Matrix", "kernel", what)
    if array.dtype.type is not number:
        raise TypeError(f"{what} has numbers of {array.dtype}, allowed: {np.dtype(number)} as the chain's")
    if array.shape != shape:
        raise ValueError(f"{what} has the shape {array.shape}, allowed: {shape}")
    return words[0]


def check_chain(chain: CompiledChain, work: Workspace) -> tuple[int, int]:
    """Addresses of a chain and of a workspace that fits it.

    Raises
    ------
    TypeError, ValueError
        If an array of either does not fit the number of bars and laws.
    """
    bars, laws, number = chain.bars.shape[1], len(chain.laws), chain.number
    loaded = bool(chain.effects)
    check("chain.bars", chain.bars, (layout.CONSTANT_ROWS, max(bars, 1)), number)
    check("chain.laws", chain.laws, (laws, columns_of_laws(chain.laws)), number)
    if laws and not ((chain.laws[:, layout.BAR] >= 0) & (chain.laws[:, layout.BAR] < bars)).all():
        raise ValueError(f"chain.laws: bars {chain.laws[:, layout.BAR]}, allowed: 0 to {bars - 1}")
    for effect in chain.effects:
        for name, shape in effect.own.shapes(bars).items() if isinstance(effect.own, effects.EffectConstants) else ():
            check(f"{type(effect.own).__name__}.{name}", getattr(effect.own, name), shape, number)
    for name, shape in (
        ("bars", (layout.SCRATCH_ROWS, bars)), ("responses", (2 * laws, bars)), ("torque_system", (laws, laws + 1)),
        ("torque_N_m", (laws,)), ("effect_bars", (4 * loaded, bars * loaded)), ("effect_common", (6 * loaded,)),
    ):  # fmt: skip
        check(f"work.{name}", getattr(work, name), shape, number)
    return chain.address, work.address


class Evaluation:
    """Right-hand side of one chain, bound to its arrays, which are checked once.

    The call from Python takes as long as an evaluation of ten bars.
    """

    def __init__(self, y: Vector, rates: Vector, chain: CompiledChain, work: Workspace) -> None:
        """Bind state and rates, (size,) each with `size` at least 2N+4.

        Raises
        ------
        TypeError, ValueError
            If an array does not fit the chain.
        """
        size = 2 * chain.bars.shape[1] + 4
        if len(y) < size:
            raise ValueError(f"y has {len(y)} numbers, allowed: 2N+4 = {size} or more")
        number = chain.number
        words = check("y", y, y.shape, number), check("rates", rates, y.shape, number), *check_chain(chain, work)
        self.arrays = y, rates, chain, work
        self.words = tuple(map(c_void_p, words))
        self.function = function("evaluate_state", chain)

    def __call__(self, t_s: float) -> bool:
        """Compute the rates; False if the joint system is not positive definite in double precision."""
        well: bool = self.function(t_s, *self.words)
        return well

    def repeat(self, times: int) -> None:
        """Compute the rates a number of times, each after the one before."""
        function("evaluate_repeatedly", self.arrays[2])(times, *self.words)


def evaluate(t_s: float, y: Vector, rates: Vector, chain: CompiledChain, work: Workspace) -> bool:
    """Time derivative of a state into `rates`; reactions and torques into `work`.

    Parameters
    ----------
    t_s : float
        Time, for the prescribed laws.
    y, rates : ndarray, shape (size,)
        See :mod:`reference_impl.kernel.layout`.
    chain : CompiledChain
    work : Workspace

    Returns
    -------
    bool
        False if the joint system is not positive definite in double precision.
    """
    return Evaluation(y, rates, chain, work)(t_s)


class Observer:
    """Reactions and torques of one chain at samples, bound to its arrays, which are checked once."""

    def __init__(self, chain: CompiledChain, work: Workspace) -> None:
        """Bind a chain; errors as :class:`Evaluation`."""
        self.arrays = chain, work
        self.words = check_chain(chain, work)
        self.bars, self.laws, self.number = chain.bars.shape[1], len(chain.laws), chain.number
        self.scratch = np.zeros(0, dtype=self.number)

    def __call__(self, t_s: Vector, y: Matrix, reaction_N: Array, torque_N_m: Matrix) -> bool:
        """Reactions (n, N-1, 2) and torques (n, P) at states (n, size); False if a pivot is lost in round-off."""
        n, size = y.shape
        if size < 2 * self.bars + 4:
            raise ValueError(f"y has {size} columns, allowed: 2N+4 = {2 * self.bars + 4} or more")
        if len(self.scratch) < size:
            self.scratch = np.zeros(size, dtype=self.number)
        well: bool = function("observe", self.arrays[0])(
            n, check("t_s", t_s, (n,), self.number), check("y", y, (n, size), self.number), size,
            address_of(self.scratch), *self.words,
            check("reaction_N", reaction_N.reshape(-1), (n * (self.bars - 1) * 2,), self.number),
            check("torque_N_m", torque_N_m, (n, self.laws), self.number),
        )  # fmt: skip
        return well


class Integrator:
    """Stepper of one chain, bound to its arrays, which are checked once."""

    def __init__(self, s: Stepper, atol: Vector, ground: SurfaceBounds, chain: CompiledChain, work: Workspace) -> None:
        """Bind a stepper; :meth:`sample_into` gives it the samples.

        Raises
        ------
        TypeError, ValueError
            If an array does not fit the chain.
        """
        check_stepper(s, chain)
        self.number = chain.number
        check("atol", atol, s.y.shape, self.number)
        self.stepper, self.ground, self.atol = s, ground, layout.VectorView(atol)
        self.chain_words = check_chain(chain, work)
        self.chain, self.work = chain, work

    def sample_into(self, t_s: Vector, rows: Matrix) -> None:
        """Bind sample instants (n,) and their states (n, size), which are filled as they are reached.

        Raises
        ------
        TypeError, ValueError
            If an array does not fit the stepper.
        """
        check("t_s", t_s, (len(rows),), self.number)
        check("rows", rows, (len(rows), len(self.stepper.y)), self.number)
        self.samples = layout.VectorView(t_s), layout.MatrixView(rows)

    def advance_to(self, start_s: float, end_s: float) -> int:
        """Integrate to `end_s`, from `start_s` if that is the current time, over a smooth segment.

        Returns
        -------
        int
            ARRIVED, CHECK_SURFACE, COLLAPSED, NOT_FINITE, LOST_JOINT or MODE_ENDED of the layout. After CHECK_SURFACE
            and MODE_ENDED the caller examines the step and calls again.
        """
        t_s, rows = (view.address for view in self.samples)
        code: int = function("advance_to", self.chain)(
            start_s, end_s, self.ground.address, t_s, rows, self.atol.address, self.stepper.address, *self.chain_words
        )
        return code

    def make_interpolant(self) -> None:
        """Compute the last step's interpolant."""
        function("make_interpolant", self.chain)(self.stepper.address, *self.chain_words)

    def interpolate(self, share: float, found: Vector) -> None:
        """State at a fraction of the last step into `found`, (size,)."""
        place = check("found", found, self.stepper.y.shape, self.number)
        function("interpolate_step", self.chain)(share, self.stepper.address, place)

    def take_samples(self, until_s: float) -> None:
        """Samples of the last step up to `until_s`, from its end or its interpolant, which is there."""
        t_s, rows = (view.address for view in self.samples)
        function("take_samples", self.chain)(until_s, t_s, rows, True, self.stepper.address, *self.chain_words)

    def begin_next_step(self) -> None:
        """Copy the rate at the end of the last step to the start of the next."""
        function("begin_next_step", self.chain)(self.stepper.address)

    def take_partial_step(self, t_s: float, h_s: float) -> bool:
        """State at ``t_s + h_s`` into ``stepper.end``, from the start of the last step; False if a joint is lost."""
        well: bool = function("take_partial_step", self.chain)(t_s, h_s, self.stepper.address, *self.chain_words)
        return well


def check_stepper(s: Stepper, chain: CompiledChain) -> None:
    """Reject a stepper that does not fit a chain.

    Raises
    ------
    ValueError
        If an array has another shape.
    """
    size = len(s.y)
    if size < 2 * chain.bars.shape[1] + 4:
        raise ValueError(f"stepper.y has {size} numbers, allowed: 2N+4 = {2 * chain.bars.shape[1] + 4} or more")
    for name, shape in (
        ("clock", (7,)), ("before", (size,)), ("end", (size,)), ("slopes", (layout.SLOPE_ROWS, size)),
        ("powers", (layout.POWER_ROWS, size)), ("allowed", (size,)), ("residue", (2, size)),
    ):  # fmt: skip
        check(f"stepper.{name}", getattr(s, name), shape, chain.number)


def columns_of_laws(laws: Matrix) -> int:
    """Columns that laws with as many whole turns have, at least one."""
    turns: int = max((laws.shape[1] - layout.FIRST_TURN) // layout.TURN_COLUMNS, 1)
    return layout.FIRST_TURN + turns * layout.TURN_COLUMNS


def check_batch(members: BatchMembers, t_s: Vector, results: MemberResults) -> CompiledChain:
    """First chain of a batch; rejects one whose arrays do not fit its results.

    Raises
    ------
    ValueError
        If an array has another shape.
    """
    runs, bars = len(members.mu_m3_s2), members.bars.shape[1]
    laws, size = len(members.laws) // max(runs, 1), members.y0.shape[1]
    if runs < 1 or size < 2 * bars + 4:
        raise ValueError(f"{runs} runs of {size} numbers, allowed: 1 or more, of 2N+4 = {2 * bars + 4} or more")
    for name, array, shape in (
        ("bars", members.bars, (layout.CONSTANT_ROWS * runs, bars)),
        ("laws", members.laws, (laws * runs, columns_of_laws(members.laws))),
        ("bounds", members.bounds, (runs, 3)), ("y0", members.y0, (runs, size)), ("atol", members.atol, (runs, size)),
        ("angle_rad", results.angle_rad, (runs * len(t_s), bars)),
        ("reaction_N", results.reaction_N, (runs * len(t_s), bars - 1)),
        ("code", results.code, (runs,)), ("steps", results.steps, (runs,)),
        ("evaluations", results.evaluations, (runs,)),
    ):  # fmt: skip
        check(name, array, shape)
    rows, own_laws = members.bars[: layout.CONSTANT_ROWS], members.laws[:laws]
    return layout.CompiledChain(float(members.mu_m3_s2[0]), members.gravity, rows, own_laws, members.effects)


def integrate_batch(
    members: BatchMembers, t_s: Vector, segments_s: Matrix, s: Stepper, work: Workspace, results: MemberResults
) -> None:
    """Run all chains of a batch in sequence, without the interpreter lock.

    Parameters
    ----------
    members : BatchMembers
    t_s : ndarray, shape (n,)
    segments_s : ndarray, shape (k, 2)
        Starts and ends of the smooth segments between known instants.
    s : Stepper
        Used for all runs, one after the other.
    work : Workspace
    results : MemberResults
        Output.
    """
    first = check_batch(members, t_s, results)
    check_stepper(s, first)
    check_chain(first, work)
    check("stepper.y", s.y, members.y0[0].shape)
    check("segments_s", segments_s, (len(segments_s), 2))
    samples = members.y0[:1].repeat(len(t_s), axis=0)
    views = layout.VectorView(t_s), layout.MatrixView(segments_s), layout.MatrixView(samples)
    instants, segments, states = (view.address for view in views)
    function("integrate_batch", first)(
        members.address, instants, segments, s.address, work.address, states, results.address
    )


def integrate_in_lanes(members: BatchMembers, t_s: Vector, results: MemberResults) -> None:
    """Run all chains of a batch in lanes; one that lanes can't run gets the code GIVEN_BACK and no samples.

    Raises
    ------
    ValueError
        If the batch does not fit, or has effects or laws.
    MemoryError
    """
    check_batch(members, t_s, results)
    view = layout.VectorView(t_s)
    if len(members.laws) or members.effects or len(t_s) < 2:
        raise ValueError("lanes run free chains with gravity alone over two samples or more")
    if not library().integrate_in_lanes(members.address, view.address, results.address):
        raise MemoryError


def lane_count() -> int:
    """Chains side by side in the vector registers."""
    found: int = library().lane_count()
    return found


def evaluate_in_lanes(members: BatchMembers, rates: Matrix, reaction_N: Array) -> None:
    """Rates (runs, 2N+4) and reactions (runs, 2, N-1) of the starts of at most `lane_count` chains."""
    runs, bars = len(members.mu_m3_s2), members.bars.shape[1]
    if runs > lane_count():
        raise ValueError(f"{runs} chains, allowed: {lane_count()} or fewer")
    place = check("rates", rates, (runs, 2 * bars + 4))
    lost = library().evaluate_in_lanes(
        members.address, place, check("reaction_N", reaction_N.reshape(-1), (runs * 2 * (bars - 1),))
    )
    if lost < 0:
        raise MemoryError


def height_above_surface(y: Vector, data: CvodeData) -> float:
    """Least distance of any point of a chain from the surface, m; `y` (size,) in the kernel's order."""
    if len(y) < len(data.left_m) + 2:
        raise ValueError(f"y has {len(y)} numbers, allowed: N+2 = {len(data.left_m) + 2} or more")
    found: float = library().height_above_surface(check("y", y, y.shape), data.address)
    return found
