"""Trends of figures over the nights and the calendar of nights, as a page shows them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class TrendCurve:
    """One figure over the nights, as a factor relative to its median."""

    quantity: str
    kind: str
    night: tuple[float, ...]
    """Numbers of nights, from 0; means of the nights behind a point"""
    factor: tuple[float, ...]


@dataclass(frozen=True)
class TrendChart:
    """Curves of one kind, of one engine in one scene."""

    scene: str
    engine: str
    kind: str
    curves: tuple[TrendCurve, ...]
    """Those that moved"""
    still: int
    """Number of figures that had the same value on all nights"""
    steps: tuple[int, ...] = ()
    """Numbers of the nights on which a figure of the chart changed"""


@dataclass(frozen=True)
class CalendarNight:
    """A night in the calendar."""

    name: str
    date: str
    """UTC, ISO 8601"""
    state: str
    """``worse``, ``changed``, ``first``, ``quiet``, ``void``, ``incomplete``"""
    changes: int = 0
