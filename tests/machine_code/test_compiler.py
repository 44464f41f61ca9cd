"""The compiler of the compiled reference: what it computes is Python's, what it does not know it names."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip("llvmlite", reason="compiled code needs it")

from typing import TYPE_CHECKING

from reference_impl.machine_code.functions import compiled, inlined, through_address
from reference_impl.machine_code.lanes import bits, digit, equal, flags, larger, load, put, root, select, size, smaller
from reference_impl.machine_code.library import Library
from reference_impl.machine_code.structs import Matrix, Struct, Vector, Words
from reference_impl.machine_code.values import WIDTH, CompilationError

if TYPE_CHECKING:
    from pathlib import Path

FACTORS = (1.5, -2.0, 4.0)
TABLE = np.array([[1.0, 2.0], [3.0, 4.0]])


@dataclass(frozen=True)
class Point(Struct):
    """Struct of every kind of field."""

    weight: float
    number: int
    place: Vector
    grid: Matrix


@dataclass(frozen=True)
class Points(Struct):
    """Struct with structs."""

    items: tuple[Point, ...]
    any: Struct


@inlined
def both_signs(x: float) -> tuple[float, float]:
    """Two values from two returns."""
    if x > 0.0:
        return x, -x
    return -x, x


@compiled
def arithmetic(x: float, y: float) -> float:
    """Every operator of reals, and a power."""
    a, b = both_signs(x)
    return (a - b * y) / (1.0 + y * y) + abs(-x) + x**2 + 2 * FACTORS[0]


@compiled
def counted(n: int, stop: int) -> int:
    """Loops with break and continue, halving, parity, and, or, not."""
    total, k = 0, 0
    for i in range(1, n):
        if i & 1 == 1 and i != 7:
            continue
        if total > 50 or i > stop:
            break
        total += i // 2
    for j in range(n, 0, -3):
        total = total + (j << 1 ^ 5 | 8) - (~j >> 1)
    while k < n:
        k += 1
        total = total + (1 if k < 3 else 2)
    return total


@compiled
def compare_with_nan(x: float, y: float) -> int:
    """Comparisons as bits."""
    bits = 0
    bits += 1 if x < y else 0
    bits += 2 if x <= y else 0
    bits += 4 if x == y else 0
    bits += 8 if x != y else 0
    bits += 16 if not x > y else 0
    bits += 32 if np.isfinite(x) else 0
    return bits


@compiled
def extremes(x: float, y: float) -> float:
    """Least and largest, as Python takes them."""
    return min(x, y, 1.0) + max(x, y)


@compiled
def library_functions(x: float) -> float:
    """Functions of the mathematical library."""
    return math.sqrt(x) + math.exp(-x) + math.cos(x) * math.sin(x) + np.hypot(x, 2.0) + np.nextafter(x, np.inf) + x**0.3


@compiled
def total(point: Point) -> float:
    """Sum over a struct, its rows, constants and an unrolled tuple."""
    found = point.weight * point.number
    for factor in FACTORS:
        found += factor * point.place[0]
    for i in range(len(point.grid)):
        row = point.grid[i]
        for j in range(point.grid.shape[1]):
            found += row[j] * TABLE[i, j]
            point.grid[i, j] = -row[j]
    return found


@through_address
def total_at(address: int, point: Struct) -> float:
    """Call of a function like `total`."""
    raise NotImplementedError


@compiled
def total_of_all(points: Points, address: int) -> float:
    """Sum over structs, through an address."""
    found = total_at(address, points.any)
    for k in range(len(points.items)):
        found += points.items[k].weight
    return found


@compiled
def in_lanes(a: Vector, b: Vector, result: Matrix) -> int:
    """Every operator of lanes, row by row into `result`; returns the bits of a mask."""
    x, y = load(a, 0), load(b, 0)
    put(result, 0, x + y * 2.0)
    put(result, 1, (x - y) / (1.0 + y * y))
    put(result, 2, -root(size(x)))
    put(result, 3, select((x < y) | (x > 1.0), x, y))
    put(result, 4, smaller(x, y))
    put(result, 5, larger(x, y))
    put(result, 6, select(digit(y, 1), equal(1.0), equal(0.0)))
    put(result, 7, select(flags(bits(x >= y) & 6), equal(1.0), equal(0.0)))
    return bits(~(x <= y))


@compiled
def counted_words(words: Words) -> int:
    """Integers in memory."""
    for i in range(len(words)):
        words[i] = words[i] + i
    return words[0] * words[1]


Library(
    "tried",
    (in_lanes, counted_words, arithmetic, counted, compare_with_nan, extremes, library_functions, total, total_of_all),
)
REAL = st.floats(-1e6, 1e6)
ANY = st.floats(allow_nan=True, allow_infinity=True)


def python(function):
    return function.__wrapped__


@settings(deadline=None)
@given(x=REAL, y=REAL)
def test_sums_and_products_are_pythons_to_the_contraction_of_a_product_and_a_sum(x: float, y: float) -> None:
    """A contracted operation saves one rounding of a product: an ulp of the largest term each."""
    largest = max(abs(x) * max(abs(y), 1.0), x * x, 3.0)
    assert abs(arithmetic(x, y) - python(arithmetic)(x, y)) <= 4.0 * np.finfo(float).eps * largest


@settings(deadline=None)
@given(n=st.integers(0, 40), stop=st.integers(0, 40))
def test_loops_and_branches_go_as_in_python(n: int, stop: int) -> None:
    assert counted(n, stop) == python(counted)(n, stop)


@settings(deadline=None)
@given(x=ANY, y=ANY)
def test_comparisons_are_pythons_with_nan_too(x: float, y: float) -> None:
    assert compare_with_nan(x, y) == python(compare_with_nan)(x, y)
    np.testing.assert_equal(extremes(x, y), python(extremes)(x, y))


@settings(deadline=None)
@given(x=st.floats(1e-3, 700.0))
def test_mathematical_functions_are_the_librarys(x: float) -> None:
    assert library_functions(x) == pytest.approx(python(library_functions)(x), rel=8.0 * np.finfo(float).eps)


def point(weight: float = 0.5) -> Point:
    return Point(weight, 3, np.array([2.0]), np.array([[1.0, -1.0], [0.5, 8.0]]))


def test_structs_are_read_and_written_in_place() -> None:
    given_here, given_there = point(), point()
    assert total(given_here) == python(total)(given_there)
    np.testing.assert_array_equal(given_here.grid, [[-1.0, 1.0], [-0.5, -8.0]])


def test_a_function_is_called_through_its_address() -> None:
    assert total_of_all(Points((point(1.0), point(2.0)), point()), total.address) == 3.0 + python(total)(point())


@pytest.mark.parametrize("bad", [np.zeros((2, 2)), np.zeros(3, dtype=np.float32), np.zeros(6)[::2]])
def test_an_array_of_another_kind_is_refused_before_it_is_read(bad: np.ndarray) -> None:
    with pytest.raises(TypeError, match=r"Point.place: .*allowed: 1 dimensions of contiguous float64"):
        Point(1.0, 1, bad, np.zeros((2, 2)))


def test_each_lane_computes_as_a_number_alone() -> None:
    random = np.random.default_rng(3)
    x, y = random.normal(size=WIDTH), np.round(random.normal(scale=9.0, size=WIDTH))
    found = np.zeros((8, WIDTH))
    assert in_lanes(x, y, found) == sum(1 << k for k in range(WIDTH) if not x[k] <= y[k])
    eps, largest = np.finfo(float).eps, 1.0 + np.abs(x) + 2.0 * np.abs(y)
    assert np.all(np.abs(found[0] - (x + y * 2.0)) <= eps * largest)
    assert np.all(np.abs(found[1] - (x - y) / (1.0 + y * y)) <= 4.0 * eps * np.abs(found[1]))
    np.testing.assert_array_equal(found[2], -np.sqrt(np.abs(x)))
    np.testing.assert_array_equal(found[3], np.where((x < y) | (x > 1.0), x, y))
    np.testing.assert_array_equal(found[4], np.minimum(x, y))
    np.testing.assert_array_equal(found[5], np.maximum(x, y))
    np.testing.assert_array_equal(found[6], y.astype(int) >> 1 & 1)
    np.testing.assert_array_equal(found[7], (x >= y) & (np.isin(np.arange(WIDTH), (1, 2))))


def test_integers_stand_in_memory_too() -> None:
    words = np.array([7, 5, 3])
    assert counted_words(words) == 7 * 6
    np.testing.assert_array_equal(words, [7, 6, 5])


def test_a_call_with_too_few_arguments_is_refused() -> None:
    with pytest.raises(TypeError, match="1 arguments, allowed: 2"):
        arithmetic(1.0)


REFUSED = {
    "a string": ("x = 'text'", "constant 'text'; allowed: numbers and Booleans"),
    "an object": ("x = print", "print is no number, array or tuple of the module"),
    "an unknown call": ("print(x)", r"print\(\) is not compiled; allowed: compiled and inlined functions"),
    "a with statement": ("with x:\n        pass", "a With statement is not compiled"),
    "a real for an integer": ("n = 1\n    n = x", "float given, int needed"),
    "a step of a loop that is not known": (
        "for i in range(0, 3, int(x)):\n        pass",
        "a loop counts in steps known",
    ),
    "a Boolean of a number": ("n = ~(x > 0.0)", "allowed: - of numbers, not of bool, ~ of int and Mask"),
    "a chain of comparisons": ("x = 1.0 if 0.0 < x < 1.0 else 0.0", "one comparison at a time"),
    "a list": ("y = [x]", "a List is not compiled"),
    "a rebound array": ("v = a\n    v = b", "v names an array or a struct, and is assigned once only"),
    "named arguments": ("x = max(x, key=x)", "arguments are given in order, without names"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_anything_else_is_refused_with_module_line_and_reason(what: str, tmp_path: Path) -> None:
    body, reason = REFUSED[what]
    name = f"refused_{list(REFUSED).index(what)}"
    lines = [
        "from __future__ import annotations",
        "from reference_impl.machine_code.functions import compiled",
        "@compiled",
        "def tried(x: float, a: Vector, b: Vector) -> None:",
        f"    {body}",
    ]
    (tmp_path / f"{name}.py").write_text("\n".join(lines), encoding="utf-8")
    sys.path.insert(0, str(tmp_path))
    try:
        function = __import__(name).tried
    finally:
        sys.path.remove(str(tmp_path))
    Library(name, (function,))
    with pytest.raises(CompilationError, match=rf"{name}, line \d: .*{reason}"):
        function(1.0, np.zeros(1), np.zeros(1))


def test_a_function_of_no_library_says_so() -> None:
    with pytest.raises(CompilationError, match="is an entry of no library: only compiled code can call it"):
        compiled(python(arithmetic))(1.0, 2.0)
