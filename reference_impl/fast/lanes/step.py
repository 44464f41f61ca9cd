"""One trial step of DOP853 for W chains in step, each with its own step size and error control.

Coefficients, error norm, step control and interpolant are those of :mod:`reference_impl.fast.dop853` and
:mod:`reference_impl.fast.stepper`. Two formulas differ in the last digit: the eighth root of the error is three square
roots, which vector registers have, and lengths are roots of sums of squares.
"""

from __future__ import annotations

import numpy as np

from reference_impl.fast.dop853 import EXTRA, LARGEST_FACTOR, LEAST_FACTOR, SAFETY, STAGES
from reference_impl.fast.lanes.evaluation import evaluate
from reference_impl.fast.lanes.layout import (
    ALLOWED,
    ATOL,
    BAR_ROWS,
    BLOCKS,
    END,
    LARGEST_PULL,
    LEAST_PERIGEE,
    LEAST_RADIUS,
    MU,
    NOW,
    POWERS,
    REACHED,
    REJECTED,
    RX,
    RY,
    SCRATCH,
    SLOPES,
    STATE,
    STEP,
    TAKEN,
    Y,
)
from reference_impl.fast.lanes.sums import DENSE, ERRORS, weighted_sum
from reference_impl.fast.layout import LEVER, NO_GRAVITY
from reference_impl.fast.stepper import RTOL_FLOOR
from reference_impl.fast.trigonometry import LARGEST_RAD
from reference_impl.integrate.coordinate_sets import ANGLE_ROUNDOFF
from reference_impl.machine_code.functions import compiled, inlined
from reference_impl.machine_code.lanes import (
    Lanes,
    Mask,
    bits,
    equal,
    flags,
    get,
    larger,
    put,
    root,
    select,
    size,
    smaller,
)
from reference_impl.machine_code.structs import Matrix

LEAST_STEP = 10.0 * float(np.finfo(float).eps)  # of the time
MOST_TURNED_RAD = 0.5 * LARGEST_RAD  # no stage of a step then leaves the range of the sine


@compiled
def begin(n: int, gravity: int, start_s: float, end_s: float, g: Matrix) -> int:
    """Current rates, allowed error and first step (Hairer et al., II.4) of all lanes; two evaluations.

    Returns
    -------
    int
        Bits of the lanes that one chain at a time must run instead.
    """
    s = 2 * n + 4
    y, end, rates, second = STATE + Y * s, STATE + END * s, STATE + SLOPES * s, STATE + (SLOPES + 1) * s
    requested, scale = STATE + ATOL * s, STATE + SCRATCH * s
    lost = evaluate(n, gravity, y, rates, g)
    lost |= bits(~sound(n, y, g))
    set_allowed_error(n, flags(-1), y, g)
    d0, d1, d2, span = equal(0.0), equal(0.0), equal(0.0), equal(end_s - start_s)
    for i in range(s):
        unit = 1.0 / (get(g, requested + i) + RTOL_FLOOR * size(get(g, y + i)))
        put(g, scale + i, unit)
        here, rate = get(g, y + i) * unit, get(g, rates + i) * unit
        d0, d1 = d0 + here * here, d1 + rate * rate
    d0, d1 = root(d0 / float(s)), root(d1 / float(s))
    h0 = smaller(select((d0 < 1e-5) | (d1 < 1e-5), equal(1e-6), 0.01 * d0 / d1), span)
    for i in range(s):
        put(g, end + i, get(g, y + i) + h0 * get(g, rates + i))
    evaluate(n, gravity, end, second, g)
    for i in range(s):
        bent = (get(g, second + i) - get(g, rates + i)) * get(g, scale + i)
        d2 = d2 + bent * bent
    d2 = root(d2 / float(s)) / h0
    h1 = root(root(root(0.01 / larger(d1, d2))))
    h1 = select((d1 <= 1e-15) & (d2 <= 1e-15), larger(equal(1e-6), 1e-3 * h0), h1)
    put(g, STEP, smaller(smaller(100.0 * h0, h1), span))
    put(g, NOW, equal(start_s))
    put(g, REJECTED, equal(0.0))
    return lost


@compiled
def try_step(n: int, gravity: int, end_s: float, g: Matrix) -> tuple[int, int]:
    """Try a step towards `end_s` in every lane; set the next step's size.

    Returns
    -------
    accepted, lost : int
        Bits of the lanes whose step is accepted, and of those that one chain at a time must run instead.
    """
    s = 2 * n + 4
    end, slopes, now = STATE + END * s, STATE + SLOPES * s, get(g, NOW)
    h, least = get(g, STEP), LEAST_STEP * size(now)
    reached = smaller(now + larger(h, least), equal(end_s))
    h, lost = reached - now, 0
    put(g, REACHED, reached)
    put(g, TAKEN, h)
    for k in range(STAGES):
        weighted_sum(k, n, 1.0, end, g)
        lost |= evaluate(n, gravity, end, slopes + (k + 1) * s, g)
    error = error_norm(n, g)
    accepted, factor = error < 1.0, SAFETY / root(root(root(error)))
    grown = smaller(factor, equal(LARGEST_FACTOR))
    grown = select(get(g, REJECTED) > 0.0, smaller(grown, equal(1.0)), grown)
    following = h * select(accepted, grown, larger(factor, equal(LEAST_FACTOR)))
    put(g, STEP, following)
    put(g, REJECTED, select(accepted, equal(0.0), equal(1.0)))
    set_allowed_error(n, accepted, end, g)
    clear = sound(n, end, g) & clears_surface(n, gravity, 0.5 * h, g)
    lost |= bits((accepted & ~clear) | ~(accepted | (following >= least)))
    return bits(accepted) & ~lost, lost


@inlined
def error_norm(n: int, g: Matrix) -> Lanes:
    """Error of the step relative to the allowed error, from the estimates of orders 5 and 3."""
    s = 2 * n + 4
    y, end, allowed, estimates = STATE + Y * s, STATE + END * s, STATE + ALLOWED * s, STATE + SCRATCH * s
    fifth, third = equal(0.0), equal(0.0)
    for k in range(2):
        weighted_sum(ERRORS + k, n, 0.0, estimates + k * s, g)  # the second into block POWERS, not in use yet
    for i in range(s):
        largest = larger(size(get(g, y + i)), size(get(g, end + i)))
        inverse = 1.0 / (get(g, allowed + i) + RTOL_FLOOR * largest)
        e5, e3 = get(g, estimates + i) * inverse, get(g, estimates + s + i) * inverse
        fifth, third = fifth + e5 * e5, third + e3 * e3
    divisor = (fifth + 0.01 * third) * float(s)
    return select(divisor > 0.0, fifth / root(divisor), fifth + third)  # 0 of no error, NaN of NaN


@inlined
def set_allowed_error(n: int, where: Mask, at: int, g: Matrix) -> None:
    """Block ALLOWED of the flagged lanes, for states whose reactions were evaluated last."""
    s = 2 * n + 4
    bars, requested, allowed = STATE + BLOCKS * s, STATE + ATOL * s, STATE + ALLOWED * s
    before_x, before_y = equal(0.0), equal(0.0)
    for i in range(n):
        bar, turned = bars + BAR_ROWS * i, size(get(g, at + i))
        x, y = get(g, bar + RX), get(g, bar + RY)
        sum_x, sum_y = x + before_x, y + before_y
        pulled = get(g, bar + LEVER) * root(sum_x * sum_x + sum_y * sum_y)
        turn = larger(get(g, requested + i), ANGLE_ROUNDOFF * turned)
        swing = ANGLE_ROUNDOFF * larger(turned, equal(1.0)) * root(pulled)
        swing = larger(get(g, requested + n + 2 + i), swing)
        put(g, allowed + i, select(where, turn, get(g, allowed + i)))
        put(g, allowed + n + 2 + i, select(where, swing, get(g, allowed + n + 2 + i)))
        before_x, before_y = x, y
    for i in (n, n + 1, 2 * n + 2, 2 * n + 3):
        put(g, allowed + i, get(g, requested + i))


@inlined
def sound(n: int, at: int, g: Matrix) -> Mask:
    """Flags of finite states, with angles that the sine of all lanes supports."""
    total, turned = equal(0.0), equal(0.0)
    for i in range(2 * n + 4):
        total = total + size(get(g, at + i))
    for i in range(n):
        turned = larger(turned, size(get(g, at + i)))
    return (total < np.inf) & (turned < MOST_TURNED_RAD)


@inlined
def clears_surface(n: int, gravity: int, half: Lanes, g: Matrix) -> Mask:
    """Flags of lanes whose last step excludes contact, as in :func:`reference_impl.fast.stepper.clears_surface`.

    `half` is half of the step's size.
    """
    s = 2 * n + 4
    floor, drop = get(g, LEAST_RADIUS), 0.5 * get(g, LARGEST_PULL) * half * half
    low, perigee = equal(np.inf), equal(0.0)
    for at, sign in ((STATE + Y * s, 1.0), (STATE + END * s, -1.0)):
        x, y, vx, vy = get(g, at + n), get(g, at + n + 1), get(g, at + 2 * n + 2), get(g, at + 2 * n + 3)
        radius = root(x * x + y * y)
        falling = smaller(equal(0.0), sign * (x * vx + y * vy) / radius)
        low = smaller(low, radius + falling * half - drop)
        perigee = perigee_m(radius, x * vy - y * vx, vx * vx + vy * vy, get(g, MU))
    clear = (floor <= 0.0) | (low > floor)
    if gravity != NO_GRAVITY:
        clear = clear | (perigee > get(g, LEAST_PERIGEE))
    return clear


@inlined
def perigee_m(radius: Lanes, swept: Lanes, speed2: Lanes, mu: Lanes) -> Lanes:
    """Perigee of the Kepler orbit of an angular momentum per mass `swept`, m from the centre."""
    parameter, energy = swept * swept / mu, 0.5 * speed2 - mu / radius
    return parameter / (1.0 + root(larger(equal(0.0), 1.0 + 2.0 * energy * parameter / mu)))


@compiled
def make_interpolants(n: int, gravity: int, g: Matrix) -> None:
    """Block POWERS: interpolants of the last step in every lane; three evaluations."""
    s = 2 * n + 4
    y, end, slopes, scratch, powers = (
        STATE + Y * s, STATE + END * s, STATE + SLOPES * s, STATE + SCRATCH * s, STATE + POWERS * s
    )  # fmt: skip
    for k in range(STAGES, STAGES + EXTRA):
        weighted_sum(k, n, 1.0, scratch, g)
        evaluate(n, gravity, scratch, slopes + (k + 1) * s, g)
    h, last = get(g, TAKEN), slopes + STAGES * s
    for i in range(s):
        change, start = get(g, end + i) - get(g, y + i), h * get(g, slopes + i)
        put(g, powers + i, change)
        put(g, powers + s + i, start - change)
        put(g, powers + 2 * s + i, 2.0 * change - (h * get(g, last + i) + start))
    for k in range(4):
        weighted_sum(DENSE + k, n, 0.0, powers + (3 + k) * s, g)


@compiled
def go_on(n: int, accepted: int, g: Matrix) -> None:
    """Begin the next step of the lanes whose step is accepted: the step's end becomes the current state."""
    s = 2 * n + 4
    y, end, rates, last, where = (
        STATE + Y * s, STATE + END * s, STATE + SLOPES * s, STATE + (SLOPES + STAGES) * s, flags(accepted)
    )  # fmt: skip
    put(g, NOW, select(where, get(g, REACHED), get(g, NOW)))
    for i in range(s):
        put(g, y + i, select(where, get(g, end + i), get(g, y + i)))
        put(g, rates + i, select(where, get(g, last + i), get(g, rates + i)))
