"""Certified solutions: their sources, their error bars, and the reference's difference from them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from adapters.engine import AccuracyParameter, Setting
from adapters.heyoka.adapter import HeyokaLong
from adapters.reference.compiled_engine import ReferenceFast
from adapters.registry import Registration
from barchain.cli.certified import certified_solutions
from barchain.judge.error_model import ErrorModel
from barchain.metrics.quantities import differences
from barchain.solutions import certified as certified_module
from barchain.solutions import certified_file
from barchain.solutions.certified import CertifiedSolutionError, certified, check
from barchain.solutions.certified_file import head_of, read_table, shipped_path, write_file
from barchain.solutions.reference import (
    SOLUTION_CHECK_RTOL,
    SOLUTION_RTOL,
    closely_sampled,
    establish,
    with_perturbed_start,
)
from scenarios import load_scene
from tests.support.scene_lists import HARD, TAME, TOLD
from tests.support.slow import exhaustive_but, one_in

LONG_RUNS = ("paper/fig05", "paper/fig05_bar_horizontal", "paper/fig09")  # five chaotic orbits each
QUICK = "basics/two_bars_free"
LONG_ROUNDOFF = 2.0**-64


def over(name, *, orbits=None, samples=21):
    """A shipped scene over its run, or its first orbits, at 21 instants: those of its committed table."""
    scene = load_scene(name)
    duration = scene.run.duration_s if orbits is None else min(orbits * scene.period_s, scene.run.duration_s)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration, samples=samples))


@pytest.fixture
def quick():
    """A scene whose instants are in no table, and which runs in a moment."""
    return over(QUICK, orbits=0.01, samples=4)


@pytest.mark.parametrize("name", one_in(6, TOLD))
def test_every_shipped_scene_has_a_committed_solution_of_its_run_and_its_first_orbit(name, tmp_path):
    for scene in (over(name), over(name, orbits=1.0)):
        found = certified(scene, cache=tmp_path)
        assert found.source == "committed"
        assert list(tmp_path.iterdir()) == []
        seen = len(found.trajectory.t_s)
        assert seen == len(scene.times_s) or "surface" in found.trajectory.ended
        np.testing.assert_array_equal(found.trajectory.t_s, scene.times_s[:seen])
        assert {"com", "com_velocity", "attitude", "rate"} <= set(found.error)
        assert ("torque" in found.error) == bool(scene.effects.prescribed_rotation)
        assert ("reaction" in found.error) == (scene.bars > 1)
        assert ("impulse" in found.error) == (scene.bars > 1 and bool(scene.effects.impulse))
        for bound in found.error.values():
            assert bound.shape == (seen,)
            assert np.all(np.diff(bound) >= 0.0)
            assert bound[-1] > 0.0


MANY_STEPS = ("effects/slews", "effects/everything")  # of the NumPy reference: half a minute each


def reference_runs(scene):
    settings = [Setting(AccuracyParameter.RTOL, rtol) for rtol in (SOLUTION_RTOL, SOLUTION_CHECK_RTOL)]
    tight, looser = (ReferenceFast().run(scene, s) for s in settings)
    return establish(scene, tight, looser, ReferenceFast().run(with_perturbed_start(scene), settings[0])), settings[0]


@pytest.mark.parametrize(
    ("name", "orbits"),
    [pytest.param(name, None, marks=[pytest.mark.exhaustive] if name in (*LONG_RUNS, *MANY_STEPS, *HARD) else [])
     for name in [*TAME, *HARD] if name in TOLD]
    + [(name, 1.0) for name in LONG_RUNS],
)  # fmt: skip
def test_the_reference_agrees_inside_the_stated_error_bars_up_to_its_predictability_limit(name, orbits):
    """|reference - certified| <= 2 E_reference + E_certified + floor.

    E_reference from a run ten times looser; 2 is Richardson's. Floor: the comparison's own round-off of double
    precision, amplified as measured.
    """
    scene = over(name, orbits=orbits)
    judge = certified(scene)
    assert judge.source == "committed"
    seen, setting = reference_runs(scene)
    n = int(np.searchsorted(seen.trajectory.t_s, seen.limit_s, side="right"))
    assert n > 10
    floor = ErrorModel(ReferenceFast, setting, seen, seen.trajectory).floor
    for quantity, apart in differences(seen.trajectory, judge.trajectory).items():
        allowed = 2.0 * seen.error[quantity][:n] + judge.error[quantity][:n] + floor[quantity][:n]
        assert np.all(apart[:n] <= allowed), (quantity, (apart[:n] / allowed).max())


@pytest.mark.parametrize("name", exhaustive_but([QUICK, *(n for n in TAME if n.startswith("paper/"))], [QUICK]))
def test_a_fresh_run_agrees_with_the_committed_table_inside_both_error_bars(name):
    found = check(load_scene(name))
    assert found.agrees, found.said


def test_long_double_agrees_to_its_own_round_off():
    """Another arithmetic: a random walk of its roundings, amplified over the first orbit by e^(sqrt(3) 2 pi)."""
    scene = over("paper/fig05", orbits=1.0)
    seen = HeyokaLong().run(scene, Setting(AccuracyParameter.RTOL, 1e-19))
    amplification, lengths, roundings = np.exp(np.sqrt(3.0) * 2.0 * np.pi), 5.0, 16.0
    walk = roundings * np.sqrt(float(seen.info["evaluations"])) * LONG_ROUNDOFF * lengths
    apart = differences(seen, certified(scene).trajectory)["attitude"].max()
    assert apart <= walk * amplification + certified(scene).error["attitude"][-1]


def test_a_solution_is_computed_once_and_then_served_from_the_cache_bit_for_bit(quick, tmp_path, monkeypatch):
    monkeypatch.setenv("BARCHAIN_CACHE", str(tmp_path))
    first, again = certified(quick), certified(quick)
    assert list((tmp_path / "certified_solutions").glob("*.parquet"))
    assert (first.source, again.source) == ("computed", "cache")
    assert first.precision == again.precision
    assert "real128" in first.precision
    for name in ("t_s", "com_m", "com_velocity_m_s", "angle_rad", "rate_rad_s", "reaction_N"):
        np.testing.assert_array_equal(getattr(first.trajectory, name), getattr(again.trajectory, name))
    for name, bound in first.error.items():
        np.testing.assert_array_equal(bound, again.error[name])


@pytest.mark.parametrize("damage", ["cut", "number", "other"])
def test_a_damaged_file_in_the_cache_is_made_again(damage, quick, tmp_path):
    certified(quick, cache=tmp_path)
    (path,) = tmp_path.rglob("*.parquet")
    whole = path.read_bytes()
    frame = pd.read_parquet(path)
    frame.iloc[-1, 0] *= 1.0 + 2.0**-52
    harm = {
        "cut": whole[: len(whole) * 2 // 3],
        "number": frame.to_parquet(index=False),
        "other": read_table(path).trajectory.to_frame().to_parquet(),
    }[damage]
    assert harm != whole
    path.write_bytes(harm)
    assert certified(quick, cache=tmp_path).source == "computed"
    assert path.read_bytes() == whole
    assert certified(quick, cache=tmp_path).source == "cache"


@pytest.mark.parametrize("what", ["versions", "code", "physics", "instants"])
def test_another_version_code_or_scene_is_another_solution(what, quick, tmp_path, monkeypatch):
    certified(quick, cache=tmp_path)
    if what == "versions":
        monkeypatch.setattr(certified_module, "package_version", lambda name: f"{name} 99")
    elif what == "code":
        monkeypatch.setattr(certified_module, "code_digest", lambda: "other")
    elif what == "physics":
        quick = dataclasses.replace(quick, orbit=dataclasses.replace(quick.orbit, altitude_m=351e3))
    else:
        quick = dataclasses.replace(quick, run=dataclasses.replace(quick.run, samples=5))
    assert certified(quick, cache=tmp_path).source == "computed"
    assert len(list(tmp_path.rglob("*.parquet"))) == 2
    assert not list(tmp_path.rglob("*.part"))


def test_instants_that_differ_in_their_last_bits_are_served_with_what_that_moves(tmp_path):
    """The name of a scene is no part of its physics."""
    scene = over(QUICK)
    later = dataclasses.replace(
        scene, name="mine", run=dataclasses.replace(scene.run, duration_s=scene.run.duration_s * (1 + 2.0**-51))
    )
    one, other = certified(scene, cache=tmp_path), certified(later, cache=tmp_path)
    assert other.source == "committed"
    np.testing.assert_array_equal(other.trajectory.t_s, later.times_s)
    late = later.times_s - scene.times_s
    assert late.max() > 0.0
    speed = np.linalg.norm(one.trajectory.com_velocity_m_s, axis=1)
    moved = np.linalg.norm(other.trajectory.com_m - one.trajectory.com_m, axis=1)
    assert np.all(np.abs(moved - speed * late) <= 4 * np.spacing(scene.radius0_m))
    assert other.error["rate"][-1] > one.error["rate"][-1]


def test_without_heyoka_tables_are_served_and_all_else_says_how_to_install_it(quick, tmp_path, monkeypatch):
    monkeypatch.setattr(Registration, "missing", "heyoka is not installed; try: pip install '.[certified]'")
    assert certified(over(QUICK), cache=tmp_path).source == "committed"
    with pytest.raises(CertifiedSolutionError, match=r"no certified solution comes .* pip install '\.\[certified\]'"):
        certified(quick, cache=tmp_path)
    made = CliRunner().invoke(certified_solutions, [QUICK, "--out", str(tmp_path)])
    assert made.exit_code == 3
    assert "pip install" in made.output


@pytest.mark.exhaustive
def test_the_command_makes_tables_checks_them_and_fails_where_they_differ(tmp_path, monkeypatch):
    monkeypatch.setattr(certified_file, "CERTIFIED_SOLUTIONS", tmp_path)
    certified_file.shipped_files.cache_clear()
    run = CliRunner().invoke
    try:
        assert run(certified_solutions, [QUICK, "--check"]).exit_code == 1
        made = run(certified_solutions, [QUICK, "--out", str(tmp_path)])
        assert (made.exit_code, len(list(tmp_path.rglob("*.parquet")))) == (0, 1)
        fine = run(certified_solutions, [QUICK, "--check"])
        assert (fine.exit_code, "agrees" in fine.output) == (0, True)
        path = shipped_path(QUICK)
        assert head_of(path)["digest"] == closely_sampled(load_scene(QUICK)).digest  # it judges, too
        table = read_table(path)
        write_file(path, dataclasses.replace(table, trajectory=table.trajectory.replace(
            angle_rad=table.trajectory.angle_rad + 1e-13)))  # fmt: skip
        off = run(certified_solutions, [QUICK, "--check"])
        assert (off.exit_code, "DIFFERS" in off.output) == (1, True)
        path.write_text("nothing")
        assert run(certified_solutions, [QUICK, "--check"]).exit_code == 1
        assert run(certified_solutions, ["paper/none", "--check"]).exit_code == 2
    finally:
        certified_file.shipped_files.cache_clear()
