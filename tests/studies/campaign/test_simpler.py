"""Simpler forms of a scene, and the search for the simplest one that still shows a finding."""

from __future__ import annotations

import dataclasses
import time
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.studies.selftest.scenes import draw
from barchain.studies.selftest.shrinking import Form, alike, effects_of, kinds, simplest, simplified, whole
from reports.results.faults.campaign import CellClass
from scenarios.toml.writing import scene_toml
from tests.studies.campaign.drawn import EVENTS, cells
from tests.support.slow import one_in

if TYPE_CHECKING:
    from scenarios import Scene


def test_a_simpler_form_is_a_valid_scene_with_less_in_it() -> None:
    busy = draw(EVENTS)
    effects = effects_of(busy)
    assert {name for name, _ in effects} == {"drag", "impulse", "thrust", "prescribed_rotation"}
    kept = tuple(name in ("impulse", "drag") for name, _ in effects)
    found = simplified(busy, Form(kept, 2, 11, 0.5, 3))
    assert found is not None
    assert found.bars == 2
    assert found.run.samples == 11
    assert found.run.duration_s == pytest.approx(0.5 * busy.run.duration_s, rel=0.01)
    assert not found.effects.thrust
    assert found.effects.drag is not None
    assert len(found.effects.drag.width_m) == 2
    assert found.effects.impulse[0].at_s in found.times_s
    assert all(float(f"{m:.3g}") == m for m in found.chain.mass_kg)
    scene_toml(found)


def test_the_whole_form_is_the_scene_itself_and_impossible_ones_are_none() -> None:
    busy = draw(EVENTS)
    same = simplified(busy, whole(busy))
    assert same is not None
    assert same.digest == busy.digest
    without_inside = dataclasses.replace(whole(busy), samples=2)
    assert simplified(busy, without_inside) is None


@pytest.mark.parametrize("seed", one_in(8, range(20, 60)))
def test_any_form_of_any_scene_is_valid_or_none(seed: int) -> None:
    random, drawn = np.random.default_rng(seed), draw(seed)
    kept = tuple(bool(k) for k in random.integers(0, 2, len(effects_of(drawn))))
    found = simplified(drawn, Form(kept, int(random.integers(1, drawn.bars + 1)), 5, 0.2, 2))
    assert found is None or "[chain]" in scene_toml(found)


def test_shrinking_finds_what_matters() -> None:
    """An impulse on the third bar, seen at eleven samples."""
    busy, told = draw(EVENTS), []

    def shows(one: Scene) -> bool:
        return bool(one.effects.impulse) and one.bars >= 3 and one.run.samples >= 11

    found = simplest(busy, shows, 20.0, told.append)
    assert shows(found)
    assert found.bars == 3
    assert found.run.samples == 11
    assert found.effects.names == {f"gravity.{busy.effects.gravity}", "impulse"}
    assert all(float(f"{m:.1g}") == m for m in found.chain.mass_kg)
    assert told[-1] == found


def test_shrinking_ends_in_its_time_with_what_it_has() -> None:
    def slowly(one: Scene) -> bool:
        time.sleep(0.05)
        return one.bars >= 2

    busy, start = draw(EVENTS), time.monotonic()
    found = simplest(busy, slowly, 0.2)
    assert time.monotonic() - start < 10.0
    assert simplest(busy, lambda _: False, 5.0) is busy
    assert found.bars >= 2


def test_a_finding_is_alike_only_in_its_kind() -> None:
    (alarm,) = cells(CellClass.FALSE_ALARM, 1, "", "inconsistent")
    assert alike(dataclasses.replace(alarm, scene="random/9"), alarm)
    assert not alike(dataclasses.replace(alarm, outcome="failed"), alarm)
    assert not alike(dataclasses.replace(alarm, engine="exudyn"), alarm)
    assert not alike(None, alarm)
    assert [len(group) for group in kinds([alarm, alarm, *cells(CellClass.MISSED, 1, "mu")])] == [1, 2]
