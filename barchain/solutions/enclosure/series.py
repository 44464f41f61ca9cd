"""Taylor series of balls, order by order: the arithmetic in which the equations are evaluated for a step.

A :class:`Tape` records the operations of one evaluation. Afterwards coefficient k of every result follows from the
coefficients up to k of its operands, so that a solution's series grows by one order a pass: products by Cauchy's sum,
sine, cosine, powers and exponentials by their differential equations, linear systems by
M_0 a_k = b_k - sum M_j a_(k-j).
:class:`Balls` has the same operations on real or complex balls.
"""

from __future__ import annotations

from operator import mul
from typing import TYPE_CHECKING, Any

from flint import acb, acb_mat, arb, arb_mat

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

Number = Any
"""A ball (`arb`, `acb`), a series, or an integer"""


class TooWideError(ArithmeticError):
    """A ball is too wide for a division or a root: shorter steps, or more bits."""


class Balls:
    """Operations on real balls, or on complex ones; it records what the evaluation divides by."""

    def __init__(self) -> None:
        self.determinants: list[Number] = []

    @staticmethod
    def sin_cos(x: Number) -> tuple[Number, Number]:
        """Sine and cosine."""
        found: tuple[Number, Number] = x.sin_cos()
        return found

    @staticmethod
    def exp(x: Number) -> Number:
        """Exponential."""
        return x.exp()

    @staticmethod
    def half_power(x: Number, n: int) -> Number:
        """Power n/2 of a ball in the right half plane, where the root has one branch.

        Raises
        ------
        TooWideError
            If the ball leaves the half plane.
        """
        if not x.real > 0:
            raise TooWideError("a square of a distance may be zero")
        return x.rsqrt() ** -n

    def solve(self, matrix: Sequence[Sequence[Number]], right: Sequence[Number]) -> list[Number]:
        """Solution of a linear system."""
        numbers = [*right, *(x for row in matrix for x in row)]
        kind: Any = acb_mat if any(isinstance(x, acb) for x in numbers) else arb_mat
        n = len(right)
        system = kind([[+x for x in row] for row in matrix])
        self.determinants.append(system.det())
        found = inverse_of(system, kind(n, 1, list(right)))
        return [found[i, 0] for i in range(n)]


class Series:
    """A series of a tape: coefficients `c`, and `grow`, which appends coefficient k."""

    __slots__ = ("c", "grow", "tape")

    def __init__(self, tape: Tape, grow: Callable[[int], Number] | None = None) -> None:
        self.tape, self.grow = tape, grow
        self.c: list[Number] = []
        if grow is not None:
            tape.results.append(self)

    def __add__(self, other: Number) -> Series:
        if isinstance(other, Series):
            return Series(self.tape, lambda k: self.c[k] + other.c[k])
        return self if is_zero(other) else Series(self.tape, lambda k: self.c[k] if k else self.c[0] + other)

    __radd__ = __add__

    def __neg__(self) -> Series:
        return Series(self.tape, lambda k: -self.c[k])

    def __sub__(self, other: Number) -> Series:
        return self.__add__(-other)

    def __rsub__(self, other: Number) -> Series:
        return (-self).__add__(other)

    def __mul__(self, other: Number) -> Number:
        if not isinstance(other, Series):
            return 0 if is_zero(other) else Series(self.tape, lambda k: self.c[k] * other)
        if other is self:
            return Series(self.tape, self.squared)
        return Series(self.tape, lambda _: cauchy(self.c, other.c))

    __rmul__ = __mul__

    def __truediv__(self, other: int) -> Number:
        return self * (arb(1) / other)

    def squared(self, k: int) -> Number:
        """Coefficient k of the square, at half the products."""
        c = self.c
        found = 2 * sum(map(mul, c[: (k + 1) // 2], c[k : k // 2 : -1]), ZERO)
        return found if k % 2 else found + c[k // 2] * c[k // 2]


ZERO = arb(0)


def is_zero(x: Number) -> bool:
    """Whether a number is the integer zero, which stands for what is absent."""
    return isinstance(x, int) and x == 0


def cauchy(a: list[Number], b: list[Number]) -> Number:
    """Sum of the products of coefficients whose orders add up to the last; of equally long lists, or tails of them."""
    return sum(map(mul, a, reversed(b)), ZERO)


def inverse_of(system: Any, right: Any = None) -> Any:
    """Inverse of a matrix of balls, or its product with a right side.

    Raises
    ------
    TooWideError
        If the matrix may be singular.
    """
    try:
        return system.inv() if right is None else system.solve(right)
    except ZeroDivisionError:
        raise TooWideError("the system of the accelerations may be singular") from None


class Tape:
    """Operations on series, in the order of their evaluation."""

    def __init__(self) -> None:
        self.results: list[Series] = []
        self.resets: list[list[Number]] = []

    def variable(self) -> Series:
        """A series whose coefficients are set from outside."""
        found = Series(self)
        self.resets.append(found.c)
        return found

    def clear(self) -> None:
        """Forget all coefficients."""
        self.cut(0)

    def cut(self, order: int) -> None:
        """Forget coefficients from an order on."""
        for found in self.results:
            del found.c[order:]
        for kept in self.resets:
            del kept[order:]

    def advance(self, k: int) -> None:
        """Coefficient k of every result."""
        for found in self.results:
            assert found.grow is not None
            found.c.append(found.grow(k))

    def kept(self) -> list[Number]:
        """A list of an operation's own, cleared with the coefficients."""
        self.resets.append([])
        return self.resets[-1]

    def sin_cos(self, x: Number) -> tuple[Number, Number]:
        """Sine and cosine, by s' = x' c and c' = -x' s."""
        if not isinstance(x, Series):
            return Balls.sin_cos(x)
        slope = self.kept()

        def sine_of(k: int) -> Number:
            slope.append(x.c[k] * k)
            return cauchy(slope[1:], cosine.c) / k if k else x.c[0].sin()

        sine = Series(self, sine_of)
        cosine = Series(self, lambda k: -cauchy(slope[1:], sine.c[:k]) / k if k else x.c[0].cos())
        return sine, cosine

    def exp(self, x: Number) -> Series:
        """Exponential z, by z' = x' z."""
        slope = self.kept()

        def grow(k: int) -> Number:
            slope.append(x.c[k] * k)
            return cauchy(slope[1:], found.c) / k if k else x.c[0].exp()

        found = Series(self, grow)
        return found

    def half_power(self, x: Number, n: int) -> Series:
        """Power z = x^(n/2), by x z' = (n/2) x' z."""
        slope, own = self.kept(), self.kept()

        def grow(k: int) -> Number:
            slope.append(x.c[k] * k)
            if not k:
                own.append(ZERO)
                return Balls.half_power(x.c[0], n)
            rest = cauchy(own[1:], x.c[1:k])
            new = (cauchy(slope[1:], found.c) * n / 2 - rest) / (x.c[0] * k)
            own.append(new * k)
            return new

        found = Series(self, grow)
        return found

    def solve(self, matrix: Sequence[Sequence[Number]], right: Sequence[Number]) -> list[Series]:
        """Solution of a linear system: one inverse, of the matrix's first coefficients."""
        n, inverse, rest = len(right), self.kept(), self.kept()

        def first(x: Number) -> Number:
            return x.c[0] if isinstance(x, Series) else x

        def known(i: int, k: int) -> Number:
            """Right-hand side of row i, order k, less the products with lower orders of the solution."""
            value = right[i].c[k] if isinstance(right[i], Series) else (right[i] if not k else ZERO)
            for x, a in zip(matrix[i], found, strict=True):
                if k and isinstance(x, Series):
                    value = value - cauchy(x.c[1:], a.c[:k])
            return value

        def grow(i: int, k: int) -> Number:
            if i == 0:
                if not k:
                    inverse.append(inverse_of(arb_mat([[+first(x) for x in row] for row in matrix])))
                rest[:] = [known(j, k) for j in range(n)]
            return sum((inverse[0][i, j] * rest[j] for j in range(n)), ZERO)

        found = [Series(self, lambda k, i=i: grow(i, k)) for i in range(n)]  # type: ignore[misc]
        return found


def summed(weights: Sequence[Number], values: Sequence[Number]) -> Number:
    """Weighted sum of balls or of series; an integer zero stands for a value that is absent."""
    present = [(w, x) for w, x in zip(weights, values, strict=True) if not is_zero(x)]
    series = [(w, x) for w, x in present if isinstance(x, Series)]
    constant = sum((w * x for w, x in present if not isinstance(x, Series)), 0)
    if not series:
        return constant
    found = Series(series[0][1].tape, lambda k: sum((w * x.c[k] for w, x in series), ZERO))
    return found + constant


def coefficient(x: Number, k: int) -> Number:
    """Coefficient of a series, or of a constant."""
    return x.c[k] if isinstance(x, Series) else arb(0 if k else x)
