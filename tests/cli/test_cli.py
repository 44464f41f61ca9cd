"""The command line: what it writes, what names and folders of scenes stand for, and how it fails."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import pytest

from adapters.registry import ENGINES, Registration
from barchain.cli.common.options import scenes_of
from barchain.cli.compare import show_verdict
from barchain.cli.main import run
from barchain.result_files.drawn_runs import read_run_table
from barchain.studies.comparison.run import ComparisonResult
from reports.results.outcome import Outcome
from scenarios import load_scene, scene_names
from tests.support.results import read_record

if TYPE_CHECKING:
    from pathlib import Path

QUICK = "basics/libration"


@pytest.mark.slow
def test_a_torque_is_named_by_the_bar_that_it_turns_whatever_the_order_of_the_rotations(tmp_path):
    rotation = "[[effects.prescribed_rotation]]\nbar = {}\namplitude_deg = {}\nduration_s = 60.0\n"
    shared = (
        'title = "mine"\nsource = "me"\n[orbit]\naltitude_m = 5e5\n[chain]\nbars = 3\nmass_kg = 10.0\nlength_m = 5.0\n'
        "angle_deg = 80.0\n[run]\nduration_s = 60.0\nsamples = 7\n"
    )
    tables = []
    for order in ((3, 1), (1, 3)):
        scene, out = tmp_path / "mine.toml", tmp_path / f"run{order[0]}.csv"
        scene.write_text(shared + "".join(rotation.format(bar, 30.0 * bar) for bar in order))
        assert run(["simulate", str(scene), "--out", str(out)]) == 0
        tables.append(pd.read_csv(out))
    torques = ["torque_bar_1_N_m", "torque_bar_3_N_m"]
    assert [c for c in tables[0] if c.startswith("torque")] == torques[::-1]
    assert sorted(tables[0].columns) == sorted(tables[1].columns)
    assert (tables[0][torques] - tables[1][torques]).abs().max().max() < 1e-9 * tables[0][torques].abs().max().max()
    assert tables[0][torques[1]].abs().max() > 1.5 * tables[0][torques[0]].abs().max(), "three times the angle"


@pytest.mark.slow
def test_the_condition_number_of_the_joints_comes_on_request(tmp_path):
    out = tmp_path / "run.csv"
    assert run(["simulate", "basics/two_bars_free", "--condition", "--out", str(out)]) == 0
    assert pd.read_csv(out).condition.between(1.0, 100.0).all()
    assert run(["simulate", "basics/two_bars_free", "--engine", "exudyn", "--condition", "--out", str(out)]) == 2


def test_simulate_writes_chosen_channels_alone_stored_or_derived(tmp_path):
    out = tmp_path / "run.parquet"
    words = ["simulate", "basics/two_bars_free", "--set", "rtol=1e-8", "--out", str(out)]
    assert run([*words, "--columns", "joint_angle,attitude", "--columns", "total_energy"]) == 0
    table = pd.read_parquet(out)
    assert list(table.columns) == ["t_s", "joint_angle_1_rad", "angle_1_rad", "angle_2_rad", "total_energy_J"]
    assert np.allclose(table.joint_angle_1_rad, table.angle_2_rad - table.angle_1_rad, rtol=0.0, atol=1e-12)


def test_simulate_writes_named_columns_in_degrees_too_that_judge_and_plot_read_back(tmp_path):
    """A number that is turned into degrees and back is off by three roundings at most."""
    paths = [tmp_path / "radians.csv", tmp_path / "degrees.csv"]
    for path, more in zip(paths, ([], ["--degrees"]), strict=True):
        words = ["-q", "simulate", "basics/two_bars_free", "--set", "rtol=1e-9", "--out", str(path)]
        assert run([*words, *more]) == 0
    written, columns = pd.read_csv(paths[0]), list(pd.read_csv(paths[1]).columns)
    assert len(written) == load_scene("basics/two_bars_free").run.samples
    motion = "t_s com_x_m com_y_m com_vx_m_s com_vy_m_s angle_1_rad angle_2_rad rate_1_rad_s rate_2_rad_s"
    assert {*motion.split(), "reaction_1_x_N", "reaction_1_y_N", "gap_1_m"} <= set(written)
    assert not [name for name in written if name.startswith("torque")]
    assert {"angle_1_deg", "angle_2_deg", "rate_1_deg_s", "rate_2_deg_s", "com_x_m", "reaction_1_x_N"} <= set(columns)
    assert not [name for name in columns if "rad" in name]
    radians, degrees = map(read_run_table, paths)
    pd.testing.assert_frame_equal(degrees[list(radians)], radians, rtol=3.0 * np.finfo(float).eps, atol=0.0)
    assert run(["-q", "judge", "basics/two_bars_free", str(paths[1]), "--rtol", "1e-9"]) == 0


def test_a_channel_that_the_engine_can_not_give_is_bad_usage(tmp_path, capsys):
    words = ["simulate", QUICK, "--engine", "rebound", "--out", str(tmp_path / "run.csv")]
    assert run([*words, "--columns", "tension"]) == 2
    assert "tension needs angles (angle_rad), which this trajectory lacks" in capsys.readouterr().err


def test_what_an_engine_lacks_is_absent_not_zero(tmp_path):
    out = tmp_path / "run.csv"
    assert run(["simulate", QUICK, "--engine", "rebound", "--out", str(out)]) == 0
    assert not [c for c in pd.read_csv(out).columns if c.startswith(("angle", "rate", "reaction", "gap"))]


def test_a_users_own_scene_is_compared_and_its_report_rendered_again_from_tables(tmp_path, capsys):
    scene = tmp_path / "mine.toml"
    scene.write_text(
        'title = "mine"\nsource = "me"\n[orbit]\naltitude_m = 5e5\n[chain]\nbars = 2\nmass_kg = 10.0\nlength_m = 5.0\n'
        "angle_deg = 80.0\n[run]\norbits = 0.2\nsamples = 21\n"
    )
    out = tmp_path / "out"
    code = run(["compare", str(scene), "--engine", "reference", "--engine", "exudyn-tree", "--out", str(out)])
    shown = capsys.readouterr()
    assert code == 0, shown
    assert {p.name for p in out.iterdir()} >= {"index.html", "summary.md", "rows", "record", "series"}
    record = read_record(out)
    assert record["finished"]
    roles = {"solution", "solution-check", "solution-dense", "perturbed-start", "main", "finer"}
    assert {r["role"] for r in record["runs"]} - {"close-start"} == roles
    first = (out / "summary.md").read_bytes()
    for made in ("index.html", "summary.md"):
        (out / made).unlink()
    assert run(["report", str(out)]) == 0
    assert (out / "summary.md").read_bytes() == first


def test_a_failed_comparison_exits_with_1(tmp_path, capsys):
    code = run(["compare", "paper/fig09", "--engine", "exudyn", "--time-limit", "0.01", "--out", str(tmp_path)])
    assert code == 1
    assert "failed" in capsys.readouterr().out


@pytest.mark.slow
def test_an_engine_asked_for_by_name_that_can_do_no_scene_exits_with_1_and_the_report_says_why(
    tmp_path, capsys, monkeypatch
):
    monkeypatch.setitem(ENGINES, "can-not", Registration("tests.support.stability_engines:CanNot"))
    asked = ["compare", QUICK, "--engine", "reference", "--engine", "can-not", "--out", str(tmp_path)]
    assert run(asked) == 1
    assert "can-not  nothing_compared: run: compared on no scene: does not support gravity" in capsys.readouterr().out
    (tmp_path / "summary.md").unlink()
    assert run(["report", str(tmp_path)]) == 0
    text = (tmp_path / "summary.md").read_text()
    assert "can-not was compared on no scene: does not support gravity" in text


def test_lists_name_every_scene_and_engine_and_the_remedy_for_a_missing_one(capsys, monkeypatch):
    remedy = "pip install '.[certified]'"
    monkeypatch.setitem(ENGINES, "nothing", Registration("nowhere:Nothing", "nowhere", install=remedy))
    assert run(["scenes"]) == 0
    assert "paper/fig05_bar_horizontal" in capsys.readouterr().out
    for command in ("engines", "doctor"):
        assert run([command]) == 0
        shown = capsys.readouterr().out
        assert "exudyn-index3" in shown
        assert remedy in shown


def test_the_gravest_failures_of_a_comparison_come_first_and_ten_at_most(tmp_path, capsys):
    pairs = {("s", f"e{k}"): Outcome.EXCEEDS_BOUND for k in range(11)} | {("s", "worst"): Outcome.FAILED}
    rows = [
        {"scene": scene, "engine": engine, "quantity": quantity, "outcome": str(outcome), "reason": f"why\n{quantity}"}
        for (scene, engine), outcome in pairs.items()
        for quantity in ("rate", "attitude")
    ]
    show_verdict(ComparisonResult(pd.DataFrame(rows), pairs), tmp_path)
    counts, *lines, more = capsys.readouterr().out.splitlines()
    assert counts == "11 exceeds_bound, 1 failed"
    assert lines[0] == "  s  worst  failed: rate: why rate (also attitude)"
    assert len(lines) == 10
    assert more.strip() == f"and 2 more: barchain show {tmp_path} --where metric=verdict"


@pytest.mark.parametrize("command", [["compare", QUICK, "--engine", "reference"], ["roundoff"]])
def test_a_file_where_a_folder_should_be_is_one_readable_line(command, tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert run([*command, "--out", str(tmp_path / "file" / "x")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "file" in error
    assert "Not a directory" in error


OWN = """\
title = "One bar"
source = "mine"
[orbit]
altitude_m = 500e3
[chain]
bars = 1
mass_kg = 100.0
length_m = 20.0
[run]
orbits = 0.01
samples = 3
"""


@pytest.mark.parametrize(
    ("given", "folders"), [("paper", "paper/"), ("paper/", "paper/"), ("core", ("paper/", "basics/"))]
)
def test_a_folder_or_a_suite_of_barchain_stands_for_its_scenes(given: str, folders: str | tuple[str, ...]) -> None:
    assert scenes_of(given) == [name for name in scene_names() if name.startswith(folders)]
    assert scenes_of("paper/fig05") == ["paper/fig05"]


@pytest.mark.slow
def test_a_folder_of_ones_own_stands_for_its_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("b", "a"):
        (tmp_path / f"{name}.toml").write_text(OWN)
    line = ["compare", str(tmp_path), str(tmp_path / "a.toml"), "--engine", "rebound", "--out", str(tmp_path / "out")]
    assert run(line) == 0
    assert "2 pass" in capsys.readouterr().out


def test_a_folder_without_scenes_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compare", str(tmp_path), "--engine", "rebound", "--out", str(tmp_path / "out")]) == 2
    assert "a folder without scenes" in capsys.readouterr().err
