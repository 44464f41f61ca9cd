"""Trends: what is drawn of a short and of a long history."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from barchain.nightly.figures.figure import FigureKind
from barchain.nightly.history.judging import judge
from barchain.nightly.telling.trends import MOST_POINTS, trend_charts
from tests.nightly.history.synthetic import count, error, night

if TYPE_CHECKING:
    from barchain.nightly.history.nights import NightStore


def test_each_night_of_a_short_history_is_drawn(store: NightStore) -> None:
    for k in range(5):
        store.add(night(error(1e-5 * (k + 1)), count(), number=k))
    nights = store.nights()
    charts = trend_charts(store.numbers(), nights)
    (drawn,) = [c for c in charts if c.kind == FigureKind.ERROR]
    assert drawn.curves[0].night == (0.0, 1.0, 2.0, 3.0, 4.0)
    assert drawn.curves[0].factor == pytest.approx([k / 3.0 for k in (1, 2, 3, 4, 5)])


def test_a_figure_whose_setting_got_another_value_is_drawn_as_one(store: NightStore) -> None:
    for k, steps in enumerate((1000, 1000, 500, 500)):
        own = error(1e-5 if steps == 1000 else 4e-5)
        renamed = replace(own, identity=replace(own.identity, setting=f"steps_per_orbit={steps}"))
        store.add(night(renamed, count(), number=k))
    charts = trend_charts(store.numbers(), store.nights(), names=judge(store).earlier)
    (drawn,) = [c for c in charts if c.kind == FigureKind.ERROR]
    (curve,) = drawn.curves
    assert curve.night == (0.0, 1.0, 2.0, 3.0)
    assert curve.factor == pytest.approx([0.4, 0.4, 1.6, 1.6])


@pytest.mark.slow
def test_a_step_years_ago_shows_in_a_long_history_of_which_few_points_are_drawn(store: NightStore) -> None:
    total, step = 300, 100
    for k in range(total):
        store.add(night(error(1e-5 if k < step else 3e-5), number=k))
    (chart,) = trend_charts(store.numbers(), store.nights(), names=judge(store).earlier)
    (curve,) = chart.curves
    assert len(curve.night) <= MOST_POINTS
    before = [f for n, f in zip(curve.night, curve.factor, strict=True) if n < step - 10]
    after = [f for n, f in zip(curve.night, curve.factor, strict=True) if n > step + 10]
    assert math.isclose(min(after) / max(before), 3.0, rel_tol=1e-9)
