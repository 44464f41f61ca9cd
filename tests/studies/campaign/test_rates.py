"""Sizes of faults, and rates with their intervals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest

from barchain.studies.selftest.rating import passed, rate, rates, sizes
from reports.results.faults.campaign import TABLES, CellClass
from reports.results.outcome import Outcome
from tests.studies.campaign.drawn import cells, with_fault

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from scenarios import Scene


def test_sizes_are_shares_of_scales(scene: Scene, unmodified: Trajectory) -> None:
    scale = {
        "com": 1e6,
        "com_velocity": 1.0,
        "attitude": 1.0,
        "rate": 1.0,
        "reaction": 2.0,
        "gap": 1.0,
        "com_residual": 1.0,
    }
    angle, reaction = unmodified.angle_rad.copy(), unmodified.reaction_N.copy()
    angle[30, 1] += 1e-3
    reaction[10, 0] += (3.0, 4.0)
    wrong = unmodified.replace(angle_rad=angle, reaction_N=reaction)
    found = sizes(unmodified, wrong, scale)
    assert found["attitude"] == pytest.approx(1e-3)
    assert found["reaction"] == pytest.approx(2.5)
    assert found["com"] == found["rate"] == found["gap"] == 0.0
    until = {"attitude": float(unmodified.t_s[29])}
    assert sizes(unmodified, wrong, scale, until)["attitude"] == 0.0
    assert sizes(unmodified, with_fault("invented-end", unmodified, scene), scale)["com"] == 1.0


def test_rates_have_the_intervals_of_the_textbook() -> None:
    """Wilson's: (p + z²/2n ± z sqrt(p (1 - p)/n + z²/4n²)) / (1 + z²/n)."""
    for n, k in ((200, 0), (200, 3), (7, 7)):
        z, p = 1.959963984540054, k / n
        centre, half = p + z**2 / (2 * n), z * math.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
        expected = [(centre + s * half) / (1 + z**2 / n) for s in (-1.0, 1.0)]
        found = rate(CellClass.MISSED, "all", "all", cells(CellClass.CAUGHT, n, "mu"), k)
        assert (found["low"], found["high"]) == pytest.approx(expected, abs=1e-12)
    nothing = rate(CellClass.MISSED, "all", "all", [])
    assert (nothing["low"], nothing["high"]) == (0.0, 1.0)
    assert set(nothing) == set(TABLES["rates_of_parts"].columns)


def test_rates_count_what_could_have_happened() -> None:
    alarm = str(Outcome.INCONSISTENT)
    found = [
        *cells(CellClass.PASS, 6), *cells(CellClass.UNSUPPORTED, 5), *cells(CellClass.LIMITED, 1),
        *cells(CellClass.FALSE_ALARM, 1, "", alarm),
        *cells(CellClass.CAUGHT, 3, "mu"), *cells(CellClass.MISSED, 1, "mu"), *cells(CellClass.BELOW, 4, "mu"),
        *cells(CellClass.NOTHING, 9, "mu"), *cells(CellClass.BROKEN, 2, "mu"), *cells(CellClass.BEYOND, 2, "mu"),
    ]  # fmt: skip
    by = {(r["what"], r["by"], r["name"]): (r["count"], r["n"]) for r in rates(found)}
    assert by["false alarm", "all", "all"] == (1, 8)
    assert by["false alarm", "outcome", "inconsistent"] == (1, 8)
    assert by["limited", "engine", "pymunk"] == (1, 8)
    assert by["missed", "all", "all"] == by["missed", "fault", "mu"] == by["missed", "engine", "pymunk"] == (1, 4)
    assert by["below the limit", "fault", "mu"] == (4, 10)
    assert by["beyond the predictability limit", "fault", "mu"] == (2, 10)


def test_one_missed_fault_fails_and_false_alarms_may_be_half_a_percent() -> None:
    assert passed([*cells(CellClass.PASS, 5), *cells(CellClass.BELOW, 5, "mu"), *cells(CellClass.BEYOND, 1, "mu")])
    assert not passed([*cells(CellClass.PASS, 5), *cells(CellClass.MISSED, 1, "mu")])
    assert passed([*cells(CellClass.PASS, 150), *cells(CellClass.FALSE_ALARM, 1)])
    assert not passed([*cells(CellClass.PASS, 150), *cells(CellClass.FALSE_ALARM, 2)])
    assert passed([*cells(CellClass.PASS, 399), *cells(CellClass.FALSE_ALARM, 2)])
