"""Synthetic nights."""

from __future__ import annotations

import datetime
import itertools
from typing import Any

from hypothesis import strategies as st

from barchain.nightly.figures.figure import (
    WORDED,
    Environment,
    Figure,
    FigureIdentity,
    FigureKind,
    FigureUnit,
    Night,
    NightPart,
)

ENVIRONMENT = Environment("Example CPU", "avx avx2 fma", 2, "x86_64", "Linux 6.1", "glibc 2.36", "openblas", "3.11.7")
FIRST = datetime.datetime(2026, 1, 1, 2, 0, tzinfo=datetime.UTC)
PARTS = (
    NightPart("engine:mujoco", "3.3.0", "aa"),
    NightPart("adapter:mujoco", "0.6.0", "bb"),
    NightPart("reference", "0.6.0", "cc"),
    NightPart("judge", "0.6.0", "dd"),
)
NAMES = tuple(part.name for part in PARTS)
UNITS_OF = {
    FigureKind.BITS: {FigureUnit.NONE},
    FigureKind.VERDICT: {FigureUnit.NONE},
    FigureKind.COUNT: {FigureUnit.ONE},
    FigureKind.RATIO: {FigureUnit.ONE},
    FigureKind.MEMORY: {FigureUnit.BYTE},
    FigureKind.ERROR: set(FigureUnit) - {FigureUnit.NONE, FigureUnit.BYTE},
    FigureKind.VALUE: set(FigureUnit) - {FigureUnit.NONE},
}


def identity(quantity: str = "attitude.max", kind: FigureKind = FigureKind.ERROR, **more: Any) -> FigureIdentity:
    unit = more.pop("unit", min(UNITS_OF[kind]))
    anchor = more.pop("anchor", "reference-fast" if kind is FigureKind.RATIO else "")
    place = {"scene": "paper/fig05", "engine": "mujoco", "setting": "steps_per_orbit=1000"} | more
    return FigureIdentity(quantity=quantity, kind=kind, unit=unit, anchor=anchor, **place)


def error(value: float = 1e-5, quantity: str = "attitude.max", **more: Any) -> Figure:
    options = {"tolerance": 1e-12, "depends": NAMES} | more
    return Figure(identity(quantity, unit=FigureUnit.RADIAN), value, **options)


def verdict(word: str = "pass", **more: Any) -> Figure:
    return Figure(identity("verdict", FigureKind.VERDICT), word=word, depends=more.pop("depends", NAMES), **more)


def bits(word: str = "00ff") -> Figure:
    return Figure(identity("trajectory", FigureKind.BITS), word=word, depends=("adapter:mujoco", "engine:mujoco"))


def count(value: float = 1000.0, quantity: str = "steps") -> Figure:
    return Figure(identity(quantity, FigureKind.COUNT), value, depends=NAMES)


def ratio(value: float = 2.0, quantity: str = "time_ratio", **more: Any) -> Figure:
    return Figure(identity(quantity, FigureKind.RATIO), value, depends=NAMES, **more)


def night(*figures: Figure, number: int = 0, **more: Any) -> Night:
    """Night of the given number, a day after the one before."""
    return Night(
        started=FIRST + datetime.timedelta(days=number),
        duration_s=more.pop("duration_s", 600.0),
        plan=more.pop("plan", "plan"),
        barchain="0.6.0",
        environment=more.pop("environment", ENVIRONMENT),
        parts=more.pop("parts", PARTS),
        figures=figures,
        **more,
    )


def large_night(number: int, count: int, shift: float = 0.0) -> Night:
    """Night of many figures of all kinds."""
    kinds = itertools.cycle(FigureKind)
    return night(*(one(next(kinds), k, number, shift) for k in range(count)), number=number)


def one(kind: FigureKind, k: int, number: int, shift: float) -> Figure:
    """Figure number k of a night."""
    own = identity(f"quantity.{k}", kind, scene=f"paper/fig{k % 30}", engine=f"engine-{k % 13}")
    if kind in WORDED:
        return Figure(own, word=f"{k:032x}", depends=NAMES)
    value = float(k + 1) if kind is FigureKind.COUNT else (k + 1) * (1.0 + 0.01 * ((number * 7919 + k) % 101) / 101)
    return Figure(own, value + (shift if kind is FigureKind.ERROR else 0.0), depends=NAMES)


names = st.text(st.characters(codec="utf-8", categories=["L", "N", "P", "S"]), max_size=30)
numbers = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def figures(draw: st.DrawFn) -> Figure:
    """Any figure that the model allows."""
    kind = draw(st.sampled_from(FigureKind))
    unit = draw(st.sampled_from(sorted(UNITS_OF[kind])))
    anchor = draw(names.filter(bool)) if kind is FigureKind.RATIO else ""
    own = FigureIdentity(draw(names), draw(names), draw(names), draw(names.filter(bool)), kind, unit, anchor)
    depends = tuple(draw(st.lists(st.sampled_from((*NAMES, "machine")), unique=True)))
    if draw(st.booleans()):
        return Figure(own, reason=draw(names.filter(bool)), depends=depends)
    trajectory = draw(names)
    if kind in WORDED:
        word = draw(names.filter(bool))
        return Figure(own, word=word, trajectory=trajectory, depends=depends, reason=draw(names))
    value = draw(values_of(kind))
    low = draw(st.none() | st.floats(max_value=value, allow_nan=False, allow_infinity=False))
    high = draw(st.none() | st.floats(min_value=value, allow_nan=False, allow_infinity=False))
    bounded = kind in {FigureKind.ERROR, FigureKind.VALUE}
    tolerance = draw(st.none() | st.floats(0.0, 1e300)) if bounded else None
    return Figure(own, value, "", low, high, tolerance, trajectory, depends)


def values_of(kind: FigureKind) -> st.SearchStrategy[float]:
    """Values of a kind."""
    if kind is FigureKind.COUNT:
        return st.integers(0, 2**53).map(float)
    if kind in {FigureKind.RATIO, FigureKind.MEMORY}:
        return st.floats(0.0, exclude_min=True, allow_nan=False, allow_infinity=False)
    return st.floats(0.0, allow_nan=False, allow_infinity=False) if kind is FigureKind.ERROR else numbers


@st.composite
def nights(draw: st.DrawFn) -> Night:
    """Any night that the model allows."""
    found = draw(st.lists(figures(), max_size=12, unique_by=lambda f: f.identity))
    return night(
        *found,
        number=draw(st.integers(0, 20_000)),
        duration_s=draw(st.floats(0.0, 1e9)),
        plan=draw(names),
        commit=draw(st.none() | names),
        complete=draw(st.booleans()),
        void=draw(st.none() | names.filter(bool)),
    )
