"""Scenes that nobody can run are rejected at once, in one line with the time of a run and what allows more."""

from __future__ import annotations

import dataclasses

import pytest

from adapters.registry import find_engine
from barchain import api
from barchain.cli.main import run
from barchain.runs.estimate import LONGEST_S, TooLongError, estimated_run_s, need_runnable
from scenarios import load_scene, make_scene, scene_names
from tests.support.slow import one_in, rows

TABLES = {
    "title": "Many", "source": "test", "orbit": {"altitude_m": 5e5},
    "chain": {"bars": 3, "mass_kg": 10.0, "length_m": 1.0, "angle_deg": 20.0}, "run": {"orbits": 1.0, "samples": 11},
}  # fmt: skip


def scene(bars: int = 3, orbits: float = 1.0):
    chain = TABLES["chain"] | {"bars": bars}
    return make_scene(TABLES | {"chain": chain, "run": {"orbits": orbits, "samples": 11}})


@pytest.mark.parametrize(("bars", "orbits"), [(3, 1e25), (3, 1e6), (100_000, 1.0)])
def test_a_scene_that_nobody_can_run_is_rejected(bars: int, orbits: float) -> None:
    with pytest.raises(TooLongError, match=r"one run takes about .* allowed: at most 2 min; .*MOST_RUN_SECONDS"):
        need_runnable([scene(bars, orbits)])


def test_no_scene_that_comes_with_barchain_is_rejected() -> None:
    need_runnable(map(load_scene, scene_names()))


@pytest.mark.parametrize("command", ["validate", "compare", "simulate", "cost --orbits 1e9", "effects", "stability",
                                     "ensemble --vary chain.mass_kg=uniform(9,11)"])  # fmt: skip
def test_every_command_that_runs_a_scene_rejects_it_in_one_line(command, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "long.toml").write_text(
        'title = "Long"\nsource = "test"\n[orbit]\naltitude_m = 5e5\n'
        "[chain]\nbars = 2\nmass_kg = 10.0\nlength_m = 1.0\n[run]\norbits = 1e9\n"
    )
    out = ["--out", "x.csv"] if command == "simulate" else []
    assert run([*command.split(), "long.toml", *out]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "one run takes about" in line
    assert LONGEST_S.variable in line
    assert not [p for p in tmp_path.iterdir() if p.name != "long.toml"]


def test_the_time_limit_and_the_variable_allow_more(monkeypatch: pytest.MonkeyPatch) -> None:
    long = scene(3, 1e6)
    need_runnable([long], 2.0 * estimated_run_s(long))
    monkeypatch.setenv(LONGEST_S.variable, "100000")
    need_runnable([long])
    monkeypatch.setenv(LONGEST_S.variable, "much")
    with pytest.raises(TooLongError, match="whole number"):
        need_runnable([long])


def test_python_functions_reject_too() -> None:
    for call in (lambda: api.simulate(scene(3, 1e9)), lambda: api.compare([scene(3, 1e9)])):
        with pytest.raises(TooLongError):
            call()


@pytest.mark.parametrize(("bars", "orbits"), one_in(4, rows([(10, 1.0), (3, 5.0), (1, 10.0), (100, 0.05)])))
def test_the_reference_evaluates_its_equations_no_less_often_than_estimated(bars: int, orbits: float) -> None:
    given = scene(bars, orbits)
    angles = tuple(0.2 * (1 + k % 3) for k in range(bars))
    given = dataclasses.replace(given, chain=dataclasses.replace(given.chain, angle_rad=angles))
    reference = find_engine("reference")
    engine = reference.engine()
    engine.build(given, reference.declarations().sweep.setting())
    engine.simulate()
    evaluations = estimated_run_s(given) / estimated_run_s(scene(bars, 1e-9)) * given.run.samples
    assert engine.read().info["evaluations"] > 0.5 * evaluations


def test_what_does_not_turn_is_not_rejected_however_long_it_lasts() -> None:
    """A chain at rest without gravity, and an open orbit: two runs of milliseconds."""
    free = make_scene(TABLES | {"effects": {"gravity": "none"}, "run": {"duration_s": 1e10, "samples": 11}})
    still = dataclasses.replace(free, chain=dataclasses.replace(free.chain, rate_factor=(0.0, 0.0, 0.0)))
    chain = TABLES["chain"] | {"bars": 1}
    open_orbit = {"altitude_m": 5e5, "speed_factor": 1.5}
    away = make_scene(TABLES | {"chain": chain, "orbit": open_orbit, "run": {"duration_s": 3e10, "samples": 11}})
    slow = dataclasses.replace(away, chain=dataclasses.replace(away.chain, rate_factor=(0.0,)))
    need_runnable([still, slow])
