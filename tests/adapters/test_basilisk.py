"""Basilisk, an engine of barchain's in an environment of its own: it runs where it is named, and conforms."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import barchain
from adapters.basilisk.chain import Chain, steps_of_sample, why_left_out
from adapters.command.entries import found_entries
from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ALL, built_in, engines
from adapters.request import run_request
from barchain.conform.scenes import candidates
from barchain.runs.choices import chosen_engines, programs_here
from scenarios import load_scene
from tests.support.solutions import run

if TYPE_CHECKING:
    from pathlib import Path

BASILISK = built_in()["basilisk"]
MISSING = BASILISK.missing
CARRIED = "conform/three_bars_point"
in_basilisk = pytest.mark.skipif(bool(MISSING), reason=MISSING or "it is there")


def request_of(scene: str, parameter: str = AccuracyParameter.RTOL, value: float = 1e-10) -> dict:
    return run_request(load_scene(scene), Setting(AccuracyParameter(parameter), value))


def test_it_runs_only_where_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert engines()["basilisk"] == BASILISK
    assert programs_here() == []
    assert "basilisk" not in chosen_engines(None) | chosen_engines([ALL])
    assert list(chosen_engines(["basilisk"])) == ["basilisk"]


def test_an_engine_of_that_name_in_a_users_file_takes_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = ("[[engine]]", 'name = "basilisk"', 'command = "mine {request} {samples}"', "effects = []", "rtol = [1e-9]")
    (tmp_path / "engines.toml").write_text("\n".join(lines))
    monkeypatch.chdir(tmp_path)
    assert [entry.command for _, entry in found_entries() if entry.name == "basilisk"] == ["mine {request} {samples}"]
    assert built_in()["basilisk"] == BASILISK


def test_short_bars_in_orbit_are_left_out_as_rounding_would_turn_them() -> None:
    assert "rounding" in why_left_out(request_of("basics/kepler_elliptic"))
    for carried in ("basics/point_chain", "basics/two_bars_free", CARRIED):
        assert not why_left_out(request_of(carried)), carried


def test_the_steps_are_those_asked_for_or_make_the_error_asked_for() -> None:
    equal = request_of(CARRIED, AccuracyParameter.STEPS_PER_ORBIT, 2000)
    between = equal["sample_times_s"][1]
    assert steps_of_sample(equal) * equal["setting"]["step_s"] == pytest.approx(between, rel=1e-12)
    close = request_of(CARRIED, value=1e-14)
    turned = close["setting"]["rate_rad_s"] * between / steps_of_sample(close)
    assert turned**5 / 120 == pytest.approx(1e-14, rel=0.5)
    least = request_of(CARRIED, value=1e-4)
    assert between / steps_of_sample(least) <= least["setting"]["step_period_s"] / 2000


def test_the_centre_of_mass_stands_where_the_angles_put_it_and_moves_as_they_turn() -> None:
    """Places of all bars by the chain, weighed by their masses: that of the first bar is left."""
    chain = Chain(request_of("conform/com_share_alone"))
    seen = run(load_scene("conform/com_share_alone"), 1e-8)
    offset, drift = chain.from_first_bar(seen.angle_rad, seen.rate_rad_s)
    u = np.exp(1j * seen.angle_rad)
    left = np.cumsum(chain.length * u, axis=1) - chain.length * u
    centres = left + chain.lever * u
    centre = centres @ chain.mass / chain.mass.sum()
    assert offset == pytest.approx(centre - centres[:, 0], abs=1e-12 * chain.length.sum())
    h = 1e-6
    later, _ = chain.from_first_bar(seen.angle_rad + h * seen.rate_rad_s, seen.rate_rad_s)
    assert drift == pytest.approx((later - offset) / h, abs=1e-5 * np.abs(drift).max())


@in_basilisk
@pytest.mark.exhaustive
@pytest.mark.parametrize("name", [CARRIED, "conform/together_8"])
def test_it_agrees_with_the_certified_solution_of_what_it_carries(tmp_path: Path, name: str) -> None:
    scene = candidates(BASILISK.declarations(), name)[0]
    assert scene.effects.names == {"gravity.point"}
    found = barchain.compare([scene], ["basilisk"], tmp_path / "out")
    assert found.passed, found.metrics[found.metrics.reason.notna()][["quantity", "reason"]]
    assert set(found.metrics.quantity) >= {"com", "attitude", "rate"}
