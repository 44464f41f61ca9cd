"""Simpler forms of a scene, and the search for the simplest one that still shows a finding."""

from __future__ import annotations

import dataclasses
import time
from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain.judge.verdict import no_verdict
from barchain.studies.selftest import trial
from benchmarks.random_campaign.rating import RatedTrial, Rating
from benchmarks.random_campaign.scenes import draw
from benchmarks.random_campaign.shrinking import Form, alike, effects_of, simplest, simplified, whole, written
from reports.results.outcome import Outcome
from scenarios import load_scene
from scenarios.toml.writing import scene_toml
from tests.support.here import HERE
from tests.support.slow import one_in

if TYPE_CHECKING:
    from pathlib import Path

    from scenarios import Scene

BUSY = 2
"""Scene with an impulse, a thrust and a slew"""


def test_a_simpler_form_has_less_in_it_and_the_whole_one_is_the_scene_itself() -> None:
    busy = draw(BUSY)
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
    same = simplified(busy, whole(busy))
    assert same is not None
    assert same.digest == busy.digest


@pytest.mark.parametrize("seed", one_in(8, range(20, 60)))
def test_any_form_of_any_scene_is_valid_or_none(seed: int) -> None:
    random, drawn = np.random.default_rng(seed), draw(seed)
    kept = tuple(bool(k) for k in random.integers(0, 2, len(effects_of(drawn))))
    found = simplified(drawn, Form(kept, int(random.integers(1, drawn.bars + 1)), 5, 0.2, 2))
    assert found is None or "[chain]" in scene_toml(found)


def test_shrinking_finds_what_matters() -> None:
    """An impulse on the third bar, seen at eleven samples."""
    busy, told = draw(BUSY), []

    def shows(one: Scene) -> bool:
        return bool(one.effects.impulse) and one.bars >= 3 and one.run.samples >= 11

    found = simplest(busy, shows, 20.0, told.append)
    assert shows(found)
    assert found.bars == 3
    assert found.run.samples == 11
    assert found.effects.names == {f"gravity.{busy.effects.gravity}", "impulse"}
    assert all(float(f"{m:.1g}") == m for m in found.chain.mass_kg)
    assert told[-1] == found
    assert simplest(busy, lambda _: False, 5.0) is busy


def test_shrinking_ends_in_its_time() -> None:
    busy, start = draw(BUSY), time.monotonic()
    simplest(busy, lambda _: time.sleep(0.05) is None, 0.2)
    assert time.monotonic() - start < 10.0


@pytest.mark.parametrize(("other", "is_alike"), [({"scene": "random/9"}, True), ({"engine": "exudyn"}, False)])
def test_a_finding_is_alike_only_in_its_kind(other: dict[str, str], is_alike: bool) -> None:
    alarm = RatedTrial("random/1", "pymunk", "", "inconsistent", Rating.FALSE_ALARM)
    assert alike(dataclasses.replace(alarm, **other), alarm) is is_alike


def test_a_findings_scene_is_written_simpler_and_simpler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a judge that sees nothing, two bars and three samples are enough to miss a sign."""

    def blind(of, results, solution, main):  # type: ignore[no-untyped-def]
        limit = {"quantity": "reaction", "metric": "detection_limit", "value": 1e-9, "limit_s": None}
        verdict = no_verdict(of.scene.name, of.engine, of.setting, Outcome.PASS, "")
        return dataclasses.replace(verdict, rows=[*verdict.rows, verdict.rows[0] | limit])

    monkeypatch.setattr(trial, "verdict_of", blind)
    finding = RatedTrial("random/8", "reference", "sign-reaction", "pass", Rating.MISSED, "reaction")
    path = written(finding, tmp_path / "found", 0.0, HERE)
    assert path == tmp_path / "found/8-reference-sign-reaction.toml"
    assert load_scene(path).digest == draw(8).digest
    assert written(finding, tmp_path / "found", 20.0, HERE) == path
    found = load_scene(path)
    assert (found.bars, found.run.samples) < (draw(8).bars, 3)
    assert "sign-reaction" in found.description
