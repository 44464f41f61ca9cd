"""A batch of chains on the lanes of a group: a lane whose chain has arrived takes the next chain of the queue.

Chains begin W at a time in a second group, from which lanes are refilled. Samples of a step come from its interpolant,
W samples of a chain at a time. The reactions at the samples of a chain are evaluated when the chain has arrived, again
W at a time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference_impl.fast.batch import MemberResults
from reference_impl.fast.dop853 import EXTRA, POWER, STAGES
from reference_impl.fast.lanes.evaluation import evaluate
from reference_impl.fast.lanes.layout import (
    BAR_ROWS,
    BLOCKS,
    CONSTANTS,
    END,
    EVALUATIONS,
    MEMBER,
    MU,
    NOW,
    POWERS,
    REACHED,
    RX,
    RY,
    SAMPLED,
    SCRATCH,
    STARTED,
    STATE,
    STEPS,
    TAKEN,
    Y,
    new_group,
)
from reference_impl.fast.lanes.step import begin, go_on, make_interpolants, try_step
from reference_impl.fast.stepper import ARRIVED
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.lanes import equal, get, load, put, root, select, store
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Matrix, Struct, Vector, Words
from reference_impl.machine_code.values import WIDTH

GIVEN_BACK = -1.0
FOLLOWING, WAITING = range(2)


@dataclass(frozen=True)
class LaneBuffers(Struct):
    """Groups and buffers of a queue."""

    running: Matrix
    """Group of chains in step"""
    ready: Matrix
    """Group of chains at their start"""
    single: Matrix
    """Group of one chain in all lanes, at W of its samples"""
    samples: Matrix
    """(W, (2N+4) n') states at the samples of each lane's chain, component by component; n' is n and W more"""
    times: Vector
    """(n',) sample instants, then infinity"""
    queue: Words
    """(2,) FOLLOWING, number of the next chain that has not begun; WAITING, bits of the chains in `ready`"""


def new_lanes(bars: int, t_s: Vector) -> LaneBuffers:
    """Groups and buffers for chains of `bars` bars with samples at `t_s`."""
    times = np.concatenate([t_s, np.full(WIDTH, np.inf)])
    samples = np.zeros((WIDTH, (2 * bars + 4) * len(times)))
    return LaneBuffers(new_group(bars), new_group(bars), new_group(bars), samples, times, np.zeros(2, np.int64))


@compiled
def run_queue(gravity: int, columns: Matrix, lanes: LaneBuffers, result: MemberResults) -> None:
    """Run all chains of a batch; a chain that lanes can't run gets the code GIVEN_BACK and no samples.

    Parameters
    ----------
    gravity : int
    columns : ndarray, shape (runs, rows)
        See :func:`reference_impl.fast.lanes.layout.start_columns`.
    lanes : LaneBuffers
    result : MemberResults
        Output.
    """
    n, g, busy = result.angle_rad.shape[1], lanes.running, 0
    end_s = lanes.times[len(lanes.times) - WIDTH - 1]
    while True:
        busy = refill(n, gravity, end_s, busy, columns, lanes, result)
        if busy == 0:
            return
        accepted, lost = try_step(n, gravity, end_s, g)
        put(g, EVALUATIONS, get(g, EVALUATIONS) + float(STAGES))
        sample_step(n, gravity, accepted & busy, lanes)
        go_on(n, accepted, g)
        for lane in range(WIDTH):
            if busy >> lane & 1 == 0:
                continue
            g[STEPS, lane] += float(accepted >> lane & 1)
            if lost >> lane & 1 != 0:
                result.code[int(g[MEMBER, lane])] = GIVEN_BACK
                busy ^= 1 << lane
            elif g[NOW, lane] >= end_s:
                record(n, gravity, lane, lanes, result)
                busy ^= 1 << lane


@inlined
def refill(
    n: int, gravity: int, end_s: float, busy: int, columns: Matrix, lanes: LaneBuffers, result: MemberResults
) -> int:
    """Move waiting chains to idle lanes; returns the bits of busy lanes, 0 after the last chain."""
    queue, s, ready = lanes.queue, 2 * n + 4, lanes.ready
    bars = STATE + BLOCKS * s
    for lane in range(WIDTH):
        while busy >> lane & 1 == 0 and queue[WAITING] == 0 and queue[FOLLOWING] < len(columns):
            prepare(n, gravity, end_s, columns, lanes, result)
        if busy >> lane & 1 == 0 and queue[WAITING] != 0:
            slot = 0
            while queue[WAITING] >> slot & 1 == 0:
                slot += 1
            queue[WAITING] ^= 1 << slot
            busy |= 1 << lane
            for row in range(STATE + STARTED * s):
                lanes.running[row, lane] = ready[row, slot]
            for row in range(bars, len(ready)):
                lanes.running[row, lane] = ready[row, slot]
            for i in range(s):
                lanes.samples[lane, i * len(lanes.times)] = ready[STATE + Y * s + i, slot]
    return busy


@inlined
def prepare(n: int, gravity: int, end_s: float, columns: Matrix, lanes: LaneBuffers, result: MemberResults) -> None:
    """Begin the next W chains of a batch; `queue` tells those to be run, the others are given back."""
    ready, s, bars = lanes.ready, 2 * n + 4, STATE + BLOCKS * (2 * n + 4)
    first, last = lanes.queue[FOLLOWING], min(lanes.queue[FOLLOWING] + WIDTH, len(columns))
    for lane in range(WIDTH):
        r = min(first + lane, last - 1)  # lanes beyond the last chain repeat it
        for row in range(STATE + 2 * s):
            ready[row, lane] = columns[r, row]
        for i in range(n):
            for row in range(CONSTANTS):
                ready[bars + BAR_ROWS * i + row, lane] = columns[r, STATE + 2 * s + CONSTANTS * i + row]
    put(ready, EVALUATIONS, equal(2.0))
    lost = begin(n, gravity, lanes.times[0], end_s, ready)
    lanes.queue[FOLLOWING] = last
    for lane in range(last - first):
        if lost >> lane & 1 != 0:
            result.code[first + lane] = GIVEN_BACK
        else:
            lanes.queue[WAITING] |= 1 << lane


@inlined
def sample_step(n: int, gravity: int, accepted: int, lanes: LaneBuffers) -> None:
    """Samples of the accepted steps, from their ends or their interpolants."""
    g, times, inside = lanes.running, lanes.times, 0
    for lane in range(WIDTH):
        if accepted >> lane & 1 != 0 and times[int(g[SAMPLED, lane])] < g[REACHED, lane]:
            inside |= 1 << lane
            g[EVALUATIONS, lane] += float(EXTRA)
    if inside != 0:
        make_interpolants(n, gravity, g)
    for lane in range(WIDTH):
        while accepted >> lane & 1 != 0 and times[int(g[SAMPLED, lane])] <= g[REACHED, lane]:
            interpolate(n, lane, lanes)


@compiled
def interpolate(n: int, lane: int, lanes: LaneBuffers) -> None:
    """Next states of one lane's chain at up to W samples within the step; later steps overwrite those beyond it."""
    g, times, samples = lanes.running, lanes.times, lanes.samples[lane]
    s, first = 2 * n + 4, int(g[SAMPLED, lane])
    y, end, powers = STATE + Y * s, STATE + END * s, STATE + POWERS * s
    t, reached = load(times, first), g[REACHED, lane]
    x = (t - g[NOW, lane]) / g[TAKEN, lane]
    rest, at_end = 1.0 - x, t >= reached
    for i in range(s):
        total = g[powers + (POWER - 1) * s + i, lane] * x
        for p in range(POWER - 2, 0, -2):
            total = (total + g[powers + p * s + i, lane]) * rest
            total = (total + g[powers + (p - 1) * s + i, lane]) * x
        total = select(at_end, equal(g[end + i, lane]), g[y + i, lane] + total)
        store(samples, i * len(times) + first, total)
    while first < len(times) and times[first] <= reached and first < int(g[SAMPLED, lane]) + WIDTH:
        first += 1
    g[SAMPLED, lane] = float(first)


@inlined
def record(n: int, gravity: int, lane: int, lanes: LaneBuffers, result: MemberResults) -> None:
    """Counts of a chain that has arrived, and its angles and sizes of reactions at all samples."""
    g, one, room, s = lanes.running, lanes.single, len(lanes.times), 2 * n + 4
    y, bars = STATE + Y * s, STATE + BLOCKS * s
    r, count = int(g[MEMBER, lane]), room - WIDTH
    result.code[r], result.steps[r], result.evaluations[r] = ARRIVED, g[STEPS, lane], g[EVALUATIONS, lane]
    put(one, MU, equal(g[MU, lane]))
    for row in range(bars, len(g)):
        put(one, row, equal(g[row, lane]))
    for first in range(0, count, WIDTH):
        for i in range(s):
            put(one, y + i, load(lanes.samples[lane], i * room + first))
        evaluate(n, gravity, y, STATE + SCRATCH * s, one)
        for i in range(n - 1):
            x, z = get(one, bars + BAR_ROWS * i + RX), get(one, bars + BAR_ROWS * i + RY)
            put(one, bars + BAR_ROWS * i + RX, root(x * x + z * z))
        for k in range(min(WIDTH, count - first)):
            for i in range(n):
                result.angle_rad[r * count + first + k, i] = one[y + i, k]
            for i in range(n - 1):
                result.reaction_N[r * count + first + k, i] = one[bars + BAR_ROWS * i + RX, k]


Library("lanes", (run_queue, begin))
