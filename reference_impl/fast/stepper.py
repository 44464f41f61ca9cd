"""Compiled integration over the samples, step by step, with a return code for each case that needs the caller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference_impl.fast.accelerations import evaluate
from reference_impl.fast.bar_positions import centres_from_first
from reference_impl.fast.dop853 import (
    EXPONENT,
    LARGEST_FACTOR,
    LEAST_FACTOR,
    POWER,
    ROWS,
    SAFETY,
    advance,
    advance_exactly,
    error_norm,
    first_step,
    interpolant,
    interpolate,
)  # fmt: skip
from reference_impl.fast.effect_calls import any_mode_ended, has_state_events
from reference_impl.fast.layout import LEVER, NO_GRAVITY, RX, RY, CompiledChain, Workspace
from reference_impl.fast.trigonometry import unit_vectors
from reference_impl.integrate.coordinate_sets import ANGLE_ROUNDOFF
from reference_impl.integrate.discrete_modes import EVENT_SAMPLES
from reference_impl.machine_code.functions import compiled
from reference_impl.machine_code.structs import Matrix, Struct, Vector

ARRIVED, CHECK_SURFACE, COLLAPSED, NOT_FINITE, LOST_JOINT, MODE_ENDED = range(6)
FROM_START = (0.0, *EVENT_SAMPLES)  # of a step
RTOL_FLOOR = 100.0 * float(np.finfo(float).eps)  # SciPy's smallest
# indices of Stepper.clock
NOW, STEP, TAKEN, STEPS, SAMPLED, EVALUATIONS, EXACT = range(7)


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
    EVALUATIONS; EXACT: 1 for steps by `advance_exactly`, else 0
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
    size, clock = len(y), np.zeros(7)
    clock[EXACT] = exact
    slopes, powers, residue = (np.zeros((rows, size)) for rows in (ROWS, POWER, 2))
    return Stepper(clock, y.copy(), y.copy(), np.zeros(size), slopes, powers, np.zeros(size), residue)


@compiled
def begin_segment(t_s: float, end_s: float, atol: Vector, s: Stepper, chain: CompiledChain, work: Workspace) -> int:
    """Begin a smooth segment: the current rate and the first step's size; ARRIVED, or the code of a failure."""
    s.clock[NOW], s.clock[TAKEN] = t_s, 0.0
    for i in range(len(s.y)):
        s.residue[0, i] = 0.0
    well = evaluate(t_s, s.y, s.slopes[0], chain, work)
    s.clock[EVALUATIONS] += 1
    if not well:
        return LOST_JOINT
    if not finite(s.y, s.slopes[0]):
        return NOT_FINITE
    s.clock[EVALUATIONS] += 1
    size = 2 * chain.bars.shape[1] + 4
    s.clock[STEP] = first_step(size, t_s, end_s - t_s, s.y, s.slopes, s.end, atol, RTOL_FLOOR, chain, work)
    set_allowed_error(atol, s, chain, work)
    return ARRIVED


@compiled
def finite(y: Vector, rates: Vector) -> bool:
    """Whether a state and its rates are finite."""
    total = 0.0
    for i in range(len(y)):
        total += abs(y[i]) + abs(rates[i])
    return bool(np.isfinite(total))


@compiled
def set_allowed_error(atol: Vector, s: Stepper, chain: CompiledChain, work: Workspace) -> None:
    """Set the error allowed in the next step: `atol`, but no less than the round-off of the angles.

    As :meth:`reference_impl.integrate.coordinate_sets.StateCoordinates.state_roundoff_floor`, by the reactions of the
    last evaluation.
    """
    n, rows = chain.bars.shape[1], work.bars
    before_x = before_y = 0.0
    for i in range(len(atol)):
        s.allowed[i] = atol[i]
    for i in range(n):
        x, y = (rows[RX, i], rows[RY, i]) if i < n - 1 else (0.0, 0.0)
        turned = abs(s.y[i])
        swing = max(turned, 1.0) * np.sqrt(chain.bars[LEVER, i] * np.hypot(x + before_x, y + before_y))
        s.allowed[i] = max(atol[i], ANGLE_ROUNDOFF * turned)
        s.allowed[n + 2 + i] = max(atol[n + 2 + i], ANGLE_ROUNDOFF * swing)
        before_x, before_y = x, y


@compiled
def take_step(end_s: float, atol: Vector, s: Stepper, chain: CompiledChain, work: Workspace) -> int:
    """Take one accepted step towards `end_s`, with SciPy's step control."""
    t, h, rejected = s.clock[NOW], s.clock[STEP], False
    exact = s.clock[EXACT] != 0.0
    relative = 0.0 if exact else RTOL_FLOOR
    least = 10.0 * abs(np.nextafter(t, np.inf) - t)
    h = max(h, least)
    while h >= least:
        reached = min(t + h, end_s)
        h = reached - t
        if exact:
            well = advance_exactly(t, h, s.y, s.residue[0], s.slopes, s.end, s.residue[1], chain, work)
        else:
            well = advance(t, h, s.y, s.slopes, s.end, chain, work)
        s.clock[EVALUATIONS] += 12
        error = error_norm(2 * chain.bars.shape[1] + 4, h, s.y, s.end, s.slopes, s.allowed, relative)
        if not well:
            return LOST_JOINT
        if error < 1.0:
            factor = LARGEST_FACTOR if error == 0.0 else min(LARGEST_FACTOR, SAFETY * error**EXPONENT)
            s.clock[STEP] = h * (min(1.0, factor) if rejected else factor)
            s.clock[NOW], s.clock[TAKEN] = reached, h
            s.clock[STEPS] += 1
            for i in range(len(s.y)):
                s.before[i], s.y[i] = s.y[i], s.end[i]
                s.residue[0, i] = s.residue[1, i]
            set_allowed_error(atol, s, chain, work)
            return ARRIVED
        h *= max(LEAST_FACTOR, SAFETY * error**EXPONENT) if np.isfinite(error) else LEAST_FACTOR
        rejected = True
    return COLLAPSED


@compiled
def make_interpolant(s: Stepper, chain: CompiledChain, work: Workspace) -> None:
    """Compute the last step's interpolant."""
    h = s.clock[TAKEN]
    interpolant(s.clock[NOW] - h, h, s.before, s.y, s.slopes, s.end, s.powers, chain, work)
    s.clock[EVALUATIONS] += 3


@compiled
def begin_next_step(s: Stepper) -> None:
    """Copy the rate at the end of the last step to the start of the next."""
    for i in range(len(s.y)):
        s.slopes[0, i] = s.slopes[12, i]


@compiled
def take_samples(
    until_s: float, t_s: Vector, rows: Matrix, have_dense: bool, s: Stepper, chain: CompiledChain, work: Workspace
) -> None:
    """Samples of the last step up to `until_s`, from its end or its interpolant."""
    now, h = s.clock[NOW], s.clock[TAKEN]
    seen = int(s.clock[SAMPLED])
    while seen < len(t_s) and t_s[seen] <= until_s:
        if t_s[seen] == now:
            for i in range(len(s.y)):
                rows[seen, i] = s.y[i]
        else:
            if not have_dense:
                make_interpolant(s, chain, work)
                have_dense = True
            interpolate((t_s[seen] - (now - h)) / h, s.before, s.powers, rows[seen])
        seen += 1
    s.clock[SAMPLED] = seen


@compiled
def perigee_m(n: int, y: Vector, mu_m3_s2: float) -> float:
    """Perigee of the Kepler orbit through a state, m from the centre."""
    x, z, vx, vz = y[n], y[n + 1], y[2 * n + 2], y[2 * n + 3]
    swept = x * vz - z * vx
    energy = 0.5 * (vx * vx + vz * vz) - mu_m3_s2 / np.hypot(x, z)
    parameter = swept * swept / mu_m3_s2
    return parameter / (1.0 + np.sqrt(max(0.0, 1.0 + 2.0 * energy * parameter / mu_m3_s2)))


@compiled
def clears_surface(n: int, h: float, before: Vector, y: Vector, chain: CompiledChain, ground: SurfaceBounds) -> bool:
    """Whether contact with the surface is impossible in the last step.

    As :meth:`reference_impl.integrate.simulate.Simulation.clears_surface`.
    """
    if chain.gravity != NO_GRAVITY and perigee_m(n, y, chain.mu_m3_s2) > ground.contact_free_perigee_m:
        return True
    pull = ground.largest_pull_m_s2
    half = 0.5 * h
    r0, r1 = np.hypot(before[n], before[n + 1]), np.hypot(y[n], y[n + 1])
    fall0 = (before[n] * before[2 * n + 2] + before[n + 1] * before[2 * n + 3]) / r0
    fall1 = -(y[n] * y[2 * n + 2] + y[n + 1] * y[2 * n + 3]) / r1
    low0 = r0 + min(0.0, fall0) * half - 0.5 * pull * half * half
    low1 = r1 + min(0.0, fall1) * half - 0.5 * pull * half * half
    return bool(min(low0, low1) > ground.contact_free_radius_m)


@compiled
def mode_ended_in_step(s: Stepper, chain: CompiledChain, work: Workspace) -> bool:
    """Whether a mode of any effect has ended at a sample of the last step, by its interpolant.

    As :meth:`reference_impl.integrate.discrete_modes.DiscreteModes.find_event`, which then locates the instant.
    """
    n, h = chain.bars.shape[1], s.clock[TAKEN]
    for share in FROM_START:
        interpolate(share, s.before, s.powers, s.end)
        unit_vectors(n, s.end, work.bars)
        mean_x, mean_y = centres_from_first(n, chain.bars, work.bars)
        seen = any_mode_ended(n, s.clock[NOW] - h + share * h, s.end, mean_x, mean_y, chain, work)
        if seen and share > 0.0:
            return True
    return False


@compiled
def advance_to(start_s: float, end_s: float, ground: SurfaceBounds, t_s: Vector, rows: Matrix, atol: Vector, s: Stepper,
       chain: CompiledChain, work: Workspace) -> int:  # fmt: skip
    """Integrate to `end_s`, from `start_s` if that is the current time.

    The function returns CHECK_SURFACE after a step with possible contact, and MODE_ENDED after a step in which a mode
    of an effect ended, with its interpolant computed. The caller examines the step and calls again.

    Parameters
    ----------
    start_s, end_s : float
        Smooth segment, without a break of a law or an effect inside.
    ground : SurfaceBounds
    t_s : ndarray, shape (n,)
        Sample instants.
    rows : ndarray, shape (n, size)
        States at the sample instants, filled as they are reached.
    atol : ndarray, shape (size,)
    s : Stepper
    chain : CompiledChain
    work : Workspace

    Returns
    -------
    int
        ARRIVED, CHECK_SURFACE, COLLAPSED, NOT_FINITE, LOST_JOINT or MODE_ENDED.
    """
    n, code, watches_events = chain.bars.shape[1], ARRIVED, has_state_events(chain)
    if s.clock[NOW] == start_s:
        code = begin_segment(start_s, end_s, atol, s, chain, work)
    while code == ARRIVED and s.clock[NOW] < end_s:
        code = take_step(end_s, atol, s, chain, work)
        if code == ARRIVED and not finite(s.y, s.y):
            code = NOT_FINITE
        if watches_events and code == ARRIVED:
            make_interpolant(s, chain, work)
            code = MODE_ENDED if mode_ended_in_step(s, chain, work) else ARRIVED
        if code != ARRIVED:
            continue
        if ground.contact_free_radius_m > 0.0 and not clears_surface(n, s.clock[TAKEN], s.before, s.y, chain, ground):
            code = CHECK_SURFACE
        else:
            take_samples(s.clock[NOW], t_s, rows, watches_events, s, chain, work)
            begin_next_step(s)
    return code
