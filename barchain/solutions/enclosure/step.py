r"""One step of an enclosure: Taylor series of the centre, a bound on its remainder, and the growth of the radii.

A set of states is a centre c, exact numbers, and a frame B with sizes s: all c + B z with |z_i| <= s_i. Let p be the
Taylor polynomial of the solution through c, in balls, of order N - 1 in the rates. Its accelerations depart from the
equations' by d(t) = f(p(t)) - p''(t), whose first N - 1 coefficients are zero by the choice of p.

*Remainder.* Where f(p(t)) is analytic in the disc |t| <= rho, Schwarz' lemma gives |d(t)| <= D (|t|/rho)^(N-1) with D
the largest |d| on the circle, which complex balls on arcs bound. It is analytic if nothing the equations divide by
vanishes in the disc. Determinants and squares of distances are analytic themselves; one whose real part, over its value
at the centre, is positive on the circle has that inside as well.

*Growth.* The distance e of a solution from p obeys e' = J e + d with J some mean of the equations' derivatives near p.
On a part of the step of length h let them be within R of a matrix M. Then e(h) = F e(0) but for d, with F within
e^((|M| + R) h) - e^(|M| h) of e^(M h) (each term of the series of iterated integrals). What d adds on the whole step is
below e^(G h) D h (h/rho)^(N-1)/N with G >= |J|. The second coefficients of the same series, of balls that contain p
over the part, are the derivatives. They hold as long as the solution stays in a tube about p, which the bound shows.

*Frame.* The next frame is the orthogonal part of F B, its columns in the order of their sizes (Lohner): boxes along
unknowns would grow by their rotation at every step.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import TYPE_CHECKING

import numpy as np
from flint import acb, acb_poly, arb, arb_mat, arb_poly, ctx

from barchain.solutions.enclosure.equations import State
from barchain.solutions.enclosure.forces import number
from barchain.solutions.enclosure.series import Balls, Tape, TooWideError, coefficient, inverse_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from barchain.solutions.enclosure.equations import Equations
    from barchain.solutions.enclosure.series import Number

ROUGH_BITS = 64
"""Precision of bounds"""
EXACT_BITS = 4000
"""Precision in which no difference of numbers in double precision is rounded"""
TUBE = 2.0**-80
"""Radius of the tube about the path, in radians and lengths of the chain, and of their rates over the fastest one"""
MOST_PARTS, KNOWN = 256, 0.03
"""Most parts of a step for its growth, and the largest sum of the derivatives' radii in a row, over a part's length"""
LONGEST = 0.5
"""Longest step over the radius of the circle"""
SHARES, ARCS = (0.8, 0.65, 0.5, 0.4, 0.3, 0.2, 0.13, 0.08, 0.05, 0.02), (32, 96)
TRIALS = sorted(((share, arcs) for share in SHARES for arcs in ARCS), key=lambda t: -t[0] / (60 + t[1]))
"""Radii of the circle, over the estimated radius of convergence, and numbers of arcs, by their gain: a series costs as
much as some 60 arcs"""
MOST_DEFECT = 2.0**40
"""Largest defect on the circle, times its radius over the fastest speeds: more shortens a step by more than a smaller
circle does. Sines of wide balls grow exponentially"""
BEYOND = 1.0 + 2.0**-20
"""Widening of arcs, parts and circles, far above the rounding of their places"""
MOST_TURNED = 6.0
"""Largest radius of convergence times the fastest rate, for motions whose accelerations vanish"""
HOPE = 8
"""Steps after which a larger circle, and fewer parts, are tried"""


class FaceTurnedError(TooWideError):
    """A speed or cosine that decides on a face may be zero."""


@dataclass(frozen=True)
class Spread:
    """Distances of some states from a centre, over the scales of the unknowns: all B z with |z_i| <= s_i."""

    frame: arb_mat
    """B, (k, k)"""
    size: arb_mat
    """s, (k, 1)"""


@dataclass(frozen=True)
class Part:
    """Derivatives over a part of a step, over the scales of the unknowns: within R of M."""

    start: arb
    """Since the start of the step, exactly"""
    end: arb
    middle: arb_mat
    radius: arb_mat

    def transport(self, length: arb) -> arb_mat:
        """Matrices F of the distances' growth over some length."""
        size = magnitudes(self.middle) * length
        off = (size + self.radius * length).exp() - size.exp()
        return entries(lambda x, r: x + plus_minus(r.abs_upper()), (self.middle * length).exp(), off)


@dataclass(frozen=True)
class Path:
    """Solutions over one step: near polynomials in the time since its start."""

    start_s: float
    end_s: float
    polynomials: list[arb_poly]
    scale: list[arb]
    parts: list[Part]
    spread: Spread
    """At the start"""
    remainder: arb_mat
    """(k, 1) of the polynomials at any instant of the step, over the scales"""

    @cached_property
    def frames(self) -> list[arb_mat]:
        """Frames at the start of each part, and at the end."""
        found = [self.spread.frame]
        for part in self.parts:
            found.append(part.transport(part.end - part.start) * found[-1])
        return found

    def carried(self, since: arb) -> arb_mat:
        """Frame at an instant."""
        with ctx.workprec(ROUGH_BITS):
            m = next(m for m, part in enumerate(self.parts) if since <= part.end)
            part = self.parts[m]
            return self.frames[m + 1] if since == part.end else part.transport(since - part.start) * self.frames[m]

    def at(self, t_s: float) -> list[arb]:
        """Unknowns at an instant, as balls."""
        since = exact_difference(t_s, self.start_s)
        radii = magnitudes(self.carried(since)) * self.spread.size + self.remainder
        values = [p(since) for p in self.polynomials]
        return [x + plus_minus(radii[i, 0] * w) for i, (x, w) in enumerate(zip(values, self.scale, strict=True))]

    def end(self) -> tuple[list[arb], Spread]:
        """Centre and spread at the end."""
        since = exact_difference(self.end_s, self.start_s)
        values, carried, rows = [p(since) for p in self.polynomials], self.carried(since), range(len(self.scale))
        with ctx.workprec(ROUGH_BITS):
            lengths = np.array([[float(carried[i, j].mid() * self.spread.size[j, 0]) for j in rows] for i in rows])
            ordered = lengths[:, np.argsort(-np.linalg.norm(lengths, axis=0), kind="stable")]
            frame = arb_mat(np.linalg.qr(ordered / (np.abs(ordered).max() or 1.0))[0].tolist())
            inverse = inverse_of(frame)
            rounded = column([x.rad() / w for x, w in zip(values, self.scale, strict=True)])
            size = magnitudes(inverse * carried) * self.spread.size + magnitudes(inverse) * (rounded + self.remainder)
        return [x.mid() for x in values], Spread(frame, magnitudes(size))


def exact_difference(a: float, b: float) -> arb:
    """Difference of two numbers in double precision, without rounding."""
    with ctx.workprec(EXACT_BITS):
        return number(a) - number(b)


def plus_minus(radius: Number) -> arb:
    """Ball about zero."""
    return arb(0, arb(radius).upper())


def column(values: Sequence[Number]) -> arb_mat:
    """Column of upper bounds."""
    return arb_mat(len(values), 1, [arb(x).upper() for x in values])


def entries(of: Callable[..., Number], *matrices: arb_mat) -> arb_mat:
    """Matrix of a function of the entries of some."""
    rows, columns = range(matrices[0].nrows()), range(matrices[0].ncols())
    return arb_mat([[of(*(m[i, j] for m in matrices)) for j in columns] for i in rows])


def magnitudes(matrix: arb_mat) -> arb_mat:
    """Upper bounds of absolute values."""
    return entries(lambda x: arb(x.abs_upper()), matrix)


class Stepper:
    """Steps of one piece of a run, between two breaks of the effects."""

    def __init__(self, equations: Equations, scales: tuple[float, float], bits: int, order: int) -> None:
        """Record the equations on a tape; `scales` are a length and a rate."""
        self.equations, self.bits, self.order, n = equations, bits, order, equations.bars
        self.tape = Tape()
        self.time = self.tape.variable()
        self.series = [self.tape.variable() for _ in range(4 + 2 * n)]
        self.bend = [self.tape.variable() for _ in range(n - 1)]
        motion = equations.motion(self.tape, State.of(self.time, self.series, self.bend))
        self.slopes, self.watched = [*motion.fall, *motion.turn], list(equations.forces.watched)
        self.first, self.second = [0, 1, *range(4, 4 + n)], [2, 3, *range(4 + n, 4 + 2 * n)]
        """Unknowns that are positions, and their rates"""
        length_m, self.rate_rad_s = scales
        sizes = [length_m] * 2 + [length_m * self.rate_rad_s] * 2 + [1.0] * n + [self.rate_rad_s] * n
        self.scale = [number(x) for x in sizes]
        self.trial = self.steps = 0
        self.count = 1

    def start(self, time: arb, values: Sequence[arb], bend: Sequence[arb]) -> None:
        """First coefficients of the time and of all unknowns."""
        self.tape.clear()
        for series, x in zip([self.time, *self.series, *self.bend], [time, *values, *bend], strict=True):
            series.c.append(x)

    def bent(self, values: Sequence[Number]) -> list[Number]:
        """Differences of the bars' angles from the first, in a row of numbers or polynomials of all unknowns."""
        return [values[4 + j] - values[4] for j in range(1, self.equations.bars)]

    def polynomials(self, start_s: float, centre: Sequence[arb]) -> list[arb_poly]:
        """Taylor polynomials of the solution through `centre`: order N of positions, N - 1 of rates."""
        self.start(number(start_s), centre, self.bent(centre))
        for k in range(self.order - 1):
            self.tape.advance(k)
            for i, j, slope in zip(self.first, self.second, self.slopes, strict=True):
                self.series[i].c.append(self.series[j].c[k] / (k + 1))
                self.series[j].c.append(coefficient(slope, k) / (k + 1))
            self.time.c.append(arb(0 if k else 1))
            for series, x in zip(self.bend, self.bent([s.c[-1] for s in self.series]), strict=True):
                series.c.append(x)
        for i, j in zip(self.first, self.second, strict=True):
            self.series[i].c.append(self.series[j].c[-1] / self.order)
        return [arb_poly(series.c) for series in self.series]

    def convergence_s(self, polynomials: list[arb_poly]) -> float:
        """Estimate of the radius of convergence, by the last coefficients of the rates over the first."""
        found = [MOST_TURNED / self.rate_rad_s]
        for j in self.second:
            c = polynomials[j].coeffs()
            largest = max((float(x.abs_upper()) for x in c[:2]), default=0.0)
            tail = [k for k in range(max(len(c) - 4, 2), len(c)) if largest and c[k].abs_lower() > 0]
            found += [math.exp(float((c[k].abs_upper() / largest).log()) / -k) for k in tail]
        return min(found)

    def defect(self, start_s: float, polynomials: list[arb_poly], rho_s: float, arcs: int) -> list[arb]:
        """Bounds D of the defects of all accelerations on a circle.

        The equations are real: the upper half of the circle has all sizes.

        Raises
        ------
        TooWideError
            If something that the equations divide by may vanish in the disc.
        """
        width, rho = number(rho_s * math.pi / (2 * arcs) * BEYOND), number(rho_s)
        paths = [Neighbourhood(p, rho) for p in [*polynomials, *self.bent(polynomials)]]
        slopes = [Neighbourhood(polynomials[j].derivative(), rho) for j in self.second]
        centre, found, size = Balls(), [arb(0)] * len(slopes), len(polynomials)
        self.equations.motion(centre, State.of(number(start_s), [p(0) for p in polynomials]))
        for m in range(arcs):
            angle = arb.pi() * (2 * m + 1) / (2 * arcs)
            at, ops = acb((angle.cos() * rho).mid(), (angle.sin() * rho).mid()), Balls()
            time = around(at, width) + number(start_s)
            values = [p(at, width) for p in paths]
            seen = self.equations.motion(ops, State.of(time, values[:size], values[size:]))
            if not all((x / x0).real > 0 for x, x0 in zip(ops.determinants, centre.determinants, strict=True)):
                raise TooWideError("a determinant may vanish in the disc")
            off = [a - slope(at, width) for a, slope in zip([*seen.fall, *seen.turn], slopes, strict=True)]
            found = [f.max(x.abs_upper()) for f, x in zip(found, off, strict=True)]
        scale = [self.scale[j] for j in self.second]
        if not all(x * rho < MOST_DEFECT * unit for x, unit in zip(found, scale, strict=True)):
            raise TooWideError("no bound on the circle")
        return [x.upper() for x in found]

    def circle(self, start_s: float, polynomials: list[arb_poly]) -> tuple[float, list[arb]]:
        """Radius of a circle on which the defects are bounded, and the bounds.

        The first trial is that of the last step, now and then a larger one.

        Raises
        ------
        TooWideError
            If there is none.
        """
        radius_s = self.convergence_s(polynomials)
        if not self.steps % HOPE:
            self.trial = max(self.trial - 2, 0)
        while self.trial < len(TRIALS):
            share, arcs = TRIALS[self.trial]
            rho_s = float(f"{radius_s * share:.3g}")
            try:
                return rho_s, self.defect(start_s, polynomials, rho_s, arcs)
            except TooWideError:
                self.trial += 1
        raise TooWideError("no circle on which the equations are bounded")

    def parts(self, start_s: float, polynomials: list[arb_poly], length: arb, count: int) -> list[Part]:
        """Derivatives of the equations along equal parts of a step.

        Raises
        ------
        TooWideError
            If a ball is too wide.
        FaceTurnedError
            If a bar may turn its other face.
        """
        size, half = len(self.series), length * (0.5 * BEYOND / count)
        marks = [*(number(float(length) * m / count) for m in range(count)), length]
        paths = [Neighbourhood(p, length) for p in [*polynomials, *self.bent(polynomials)]]
        tube = [plus_minus(TUBE * w) for w in [*self.scale, *[number(2.0)] * len(self.bend)]]
        zero, one, found = arb(0), arb(1), []
        for begin, end in itertools.pairwise(marks):
            at = (begin + end) / 2
            time = at + number(start_s) + plus_minus(half)
            state = [p.real(at, half) + off for p, off in zip(paths, tube, strict=True)]
            self.start(time, state[:size], state[size:])
            self.tape.advance(0)
            signs = self.equations.forces.faces
            if not all(coefficient(x, 0) * sign > 0 for x, sign in zip(self.watched, signs, strict=True)):
                raise FaceTurnedError("a bar may turn its other face to the air or the Sun")
            rows = [[zero] * size for _ in range(size)]
            for j in range(size):
                self.tape.cut(1)
                unit = [one if i == j else zero for i in range(size)]
                new = [zero, *unit, *self.bent(unit)]
                for series, x in zip([self.time, *self.series, *self.bend], new, strict=True):
                    series.c.append(x)
                self.tape.advance(1)
                for i, k, slope in zip(self.first, self.second, self.slopes, strict=True):
                    rows[i][j] = unit[k] * self.scale[j] / self.scale[i]
                    rows[k][j] = coefficient(slope, 1) * self.scale[j] / self.scale[k]
            if not all(x.is_finite() for row in rows for x in row):
                raise TooWideError("no bound on the derivatives")
            middle, radius = ([[f(x) for x in row] for row in rows] for f in (arb.mid, arb.rad))
            found.append(Part(begin, end, arb_mat(middle), arb_mat(radius)))
        return found

    def few_parts(self, start_s: float, polynomials: list[arb_poly], length: arb) -> list[Part]:
        """Parts of a step, as many as let the distances' growth be known well.

        Raises
        ------
        TooWideError
            If no number does.
        """
        reason = TooWideError("no bound on the derivatives")
        if not self.steps % HOPE:
            self.count = max(self.count // 2, 1)
        while self.count <= MOST_PARTS:
            try:
                found = self.parts(start_s, polynomials, length, self.count)
            except TooWideError as error:
                reason = error
            else:
                ones = column([1] * len(self.series))
                unknown = [part.radius * (part.end - part.start) * ones for part in found]
                if all(sums[i, 0] < KNOWN for sums in unknown for i in range(len(self.series))):
                    return found
            self.count *= 2
        raise reason

    def step(self, start_s: float, end_s: float, centre: list[arb], spread: Spread) -> Path:
        """Path of the solutions from a set of states, at most to an instant.

        Raises
        ------
        TooWideError
            If the set is too wide, or no step is short enough.
        """
        ctx.prec = self.bits
        polynomials = self.polynomials(start_s, centre)
        ctx.prec = ROUGH_BITS
        rho_s, defect = self.circle(start_s, polynomials)
        share = (arb(2) ** -self.bits * self.order / max(map(float, defect)) / number(rho_s)).log() / self.order
        length_s = rho_s * min(LONGEST, math.exp(float(share)))
        stop_s = end_s if start_s + 1.01 * length_s >= end_s else start_s + length_s
        h = exact_difference(stop_s, start_s)
        parts = self.few_parts(start_s, polynomials, h)
        factor = h * (h / number(rho_s)) ** (self.order - 1) / self.order
        left = [arb(0)] * len(self.series)
        for i, x in zip(self.second, defect, strict=True):
            left[i] = x * factor / self.scale[i]
        sizes = [magnitudes(part.middle) + part.radius for part in parts]
        exponential = (entries(lambda *x: reduce(arb.max, x).upper(), *sizes) * h).exp()
        within = exponential * (magnitudes(spread.frame) * spread.size + column(left))
        if not all(within[i, 0] < TUBE for i in range(len(left))):
            raise TooWideError(f"the ball is too wide at {stop_s:.6g} s: more bits are needed")
        ctx.prec = self.bits
        self.steps += 1
        return Path(start_s, stop_s, polynomials, self.scale, parts, spread, magnitudes(exponential * column(left)))


class Neighbourhood:
    """A polynomial near points: its value there, widened by a bound of its slope."""

    def __init__(self, polynomial: arb_poly, radius: arb) -> None:
        """Bound the slope within `radius` of zero, and a little beyond."""
        sizes = [arb(x.abs_upper()) for x in polynomial.derivative().coeffs()]
        self.polynomial = arb_poly([+x for x in polynomial.coeffs()])
        self.complex_polynomial = acb_poly(self.polynomial)
        self.slope = arb_poly(sizes)(radius * BEYOND).abs_upper()

    def __call__(self, at: acb, width: arb) -> acb:
        """Ball of the values within `width` of a complex number."""
        return around(self.complex_polynomial(at), self.slope * width)

    def real(self, at: arb, width: arb) -> arb:
        """Ball of the values within `width` of a real number."""
        return self.polynomial(at) + plus_minus(self.slope * width)


def around(x: acb, width: Number) -> acb:
    """Complex ball that contains all numbers within `width` of `x`."""
    return acb(x.real + plus_minus(width), x.imag + plus_minus(width))
