"""Parameter sweeps: numbers of any key of a scene, measures of any channel, and pages of both."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import barchain
from adapters.registry import ENGINES, Registration
from barchain.cli.main import run as command
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.results import read_night
from barchain.runs.executors import LocalProcesses
from barchain.runs.other_settings import default_engine
from barchain.studies.study import Reporter, run_study
from barchain.studies.sweep.measure import measures_of
from barchain.studies.sweep.study import sweep_study
from barchain.studies.sweep.variation import VariedScene, points_of, variations_of
from reports.chapters.sweep import view_sweep
from reports.render import render_study
from scenarios import load_scene, make_scene
from tests.support.faulty_engines import Faulty
from tests.support.page_policy import check_policy
from tests.support.results import read_record, read_table

if TYPE_CHECKING:
    from pathlib import Path

KEPLER = "basics/kepler_elliptic"  # one bar of 1 m under point gravity, which starts at the perigee
ENGINE = "reference"
ONE = LocalProcesses(1)
SHORT = "run.orbits=0.02"


def swept(scene: Any, vary: list[str], *measures: str, **how: Any) -> barchain.SweepResult:
    return barchain.sweep(scene, vary, measures, **{"engines": [ENGINE], "executor": ONE, **how})


def test_the_apogee_rises_with_the_speed_as_keplers_ellipse_has_it() -> None:
    """At the speed factor b the apsides are r and r b²/(2 - b²) from the centre."""
    found = swept(KEPLER, ["orbit.speed_factor=1.05:1.2:4", "run.orbits=0.5"], "final(altitude)", "least(altitude_m)")
    scene = load_scene(KEPLER)
    start_m = scene.central_body.radius_m + scene.orbit.altitude_m
    b2 = found.samples["orbit.speed_factor"] ** 2
    apogee_m = start_m * b2 / (2.0 - b2) - scene.central_body.radius_m
    assert found.passed
    assert found.samples["orbit.speed_factor"].tolist() == [1.05, 1.1, 1.15, 1.2]
    # a run asks for 1e-10 of the radius in a step or less, and takes some hundred
    expected: dict[str, Any] = {"final": apogee_m, "least": scene.orbit.altitude_m}
    for name, altitude_m in expected.items():
        assert np.abs(found.samples[f"{name}(altitude_m)"] - altitude_m).max() < 1e-8 * start_m


def test_a_measure_is_that_of_the_columns_that_simulate_writes() -> None:
    measures = (
        "largest(reaction)", "largest(reaction[1])", "rms(rate[2])", "p95(tension_1_right_N)", "least(tension)",
        "final(attitude)", "largest(com_x_m)", "largest(com)",
    )  # fmt: skip
    own = swept("paper/fig13", [SHORT], *measures).samples.iloc[0]
    scene = barchain.change_scene(load_scene("paper/fig13"), {"run": {"orbits": 0.02}})
    seen = barchain.simulate(scene, ENGINE)
    frame = seen.to_frame(derived=["tension"])
    size_N = np.linalg.norm(seen.reaction_N, axis=2)
    assert own["largest(reaction_N)"] == size_N.max()
    assert own["largest(reaction_N[1])"] == size_N[:, 0].max()
    assert own["rms(rate_rad_s[2])"] == np.sqrt(np.mean(seen.rate_rad_s[:, 1] ** 2))
    assert own["p95(tension_1_right_N)"] == np.percentile(frame["tension_1_right_N"], 95.0)
    assert own["least(tension_N)"] == frame.filter(like="tension").to_numpy().min()
    last = seen.angle_rad[-1]
    assert own["final(attitude_rad)"] == last[np.argmax(np.abs(last))]
    assert own["largest(com_x_m)"] == seen.com_m[:, 0].max()
    assert own["largest(com_m)"] == np.hypot(*seen.com_m.T).max()


def test_any_number_of_a_scene_varies_by_its_path() -> None:
    scene = load_scene("effects/everything")
    paths = {
        "chain.angle_deg[2]": 71.0, "effects.thrust[1].force_N": 0.5, "effects.drag.density_kg_m3": 1e-12,
        "effects.drag.width_m[3]": 0.25, "orbit.speed_factor": 1.01, "run.samples": 7,
    }  # fmt: skip
    found = VariedScene(scene).at(paths)
    assert found.chain.angle_rad[1] == pytest.approx(np.radians(71.0), rel=1e-15)
    assert found.chain.angle_rad[0] == scene.chain.angle_rad[0]
    assert set(found.effects.thrust[0].force_N) == {0.5}
    assert found.effects.thrust[1:] == scene.effects.thrust[1:]
    assert found.effects.drag.density_kg_m3 == 1e-12
    assert found.effects.drag.width_m[2] == 0.25
    assert (found.orbit.speed_factor, found.run.samples) == (1.01, 7)
    assert VariedScene(scene).at({}).digest == scene.digest


def test_one_bars_number_leaves_the_others_theirs_and_what_follows_from_whole_keys_follows() -> None:
    scene = load_scene("paper/fig13")
    halved = tuple(0.5 * inertia for inertia in scene.chain.inertia_kg_m2)
    half = 0.5 * scene.chain.mass_kg[0]
    assert VariedScene(scene).at({"chain.mass_kg": half}).chain.inertia_kg_m2 == halved
    both = VariedScene(scene).at({"chain.inertia_kg_m2[1]": 7.0, "chain.mass_kg": half}).chain
    assert both.inertia_kg_m2 == (7.0, *halved[1:])


def test_grids_and_lists_make_all_combinations_and_draws_are_the_same_at_each() -> None:
    scene = load_scene("paper/fig13")
    texts = ["chain.rate_factor=normal(1, 0.01)", "orbit.speed_factor=1:1.1:3", "run.samples=5,9"]
    points = points_of(variations_of(scene, texts), 4, seed=3)
    assert len(points) == 3 * 2 * 4
    assert [point[:2] for point in points[::4]] == [(s, n) for s in (1.0, 1.05, 1.1) for n in (5, 9)]
    assert len({tuple(point[2] for point in points[k : k + 4]) for k in range(0, 24, 4)}) == 1


SPUN = make_scene({
    "title": "two bars in line that turn about their joint", "source": "test", "orbit": {"altitude_m": 5e5},
    "chain": {"bars": 2, "mass_kg": 1.0, "length_m": 10.0, "angle_from": "inertial", "angle_deg": 0.0,
              "rate_rad_s": 0.1},
    "effects": {"gravity": "none"}, "run": {"duration_s": 10.0, "samples": 3},
})  # fmt: skip


@pytest.mark.parametrize(("vary", "masses_kg"), [
    (["chain.length_m=10,20,40 with chain.mass_kg=1,3,3"], [1.0, 3.0, 3.0]),
    (["chain.length_m=10:40:3 with chain.mass_kg=5,2,1 with chain.angle_deg=0:90:3"], [5.0, 2.0, 1.0]),
    (["chain.mass_kg=0.5*chain.length_m", "chain.length_m=10,20,40"], [5.0, 10.0, 20.0]),
])  # fmt: skip
def test_keys_that_go_together_are_one_grid_and_the_joint_carries_what_both_say(
    vary: list[str], masses_kg: list[float]
) -> None:
    """The joint carries the centrifugal force m w² l/2; a run asks for 1e-10 in a step or less, and takes some ten."""
    own = swept(SPUN, vary, "largest(reaction)").samples
    assert own["chain.mass_kg"].tolist() == masses_kg
    expected_N = 0.5 * own["chain.mass_kg"] * 0.1**2 * own["chain.length_m"]
    np.testing.assert_allclose(own["largest(reaction_N)"], expected_N, rtol=1e-8)


def test_a_multiple_of_a_draw_and_of_each_bars_draw_is_that_of_the_same_run() -> None:
    texts = [
        "chain.mass_kg[*]=2e-1*chain.length_m[*]", "chain.length_m[*]=normal(10, 1)", "run.samples=5,9",
        "orbit.speed_factor=uniform(1, 1.1)", "chain.rate_factor[*]=orbit.speed_factor",
    ]  # fmt: skip
    variations = variations_of(SPUN, texts)
    points = [
        dict(zip([each.path for each in variations], point, strict=True)) for point in points_of(variations, 3, 1)
    ]
    assert len(points) == 6
    for point in points:
        for bar in (1, 2):
            assert point[f"chain.mass_kg[{bar}]"] == 0.2 * point[f"chain.length_m[{bar}]"]
            assert point[f"chain.rate_factor[{bar}]"] == point["orbit.speed_factor"]
        assert point["chain.length_m[1]"] != point["chain.length_m[2]"]


def test_draws_depend_on_the_seed_and_their_own_key_alone() -> None:
    scene = load_scene("paper/fig13")
    angle, rate = "chain.angle_deg[*]=normal(80, 1)", "chain.rate_factor=uniform(0.9, 1.1)"
    alone, both = (points_of(variations_of(scene, texts), 6, seed=1) for texts in ([rate], [angle, rate]))
    assert [point[-1] for point in both] == [point[0] for point in alone]
    assert points_of(variations_of(scene, [rate]), 3, seed=1) == alone[:3]
    assert points_of(variations_of(scene, [rate]), 6, seed=2) != alone
    assert len(both[0]) == scene.bars + 1
    assert len(set(both[0][:-1])) == scene.bars


def test_equal_seeds_give_equal_samples_however_many_runs_share_a_call(monkeypatch: pytest.MonkeyPatch) -> None:
    vary = ["orbit.altitude_m=normal(4e5, 1e3)", SHORT]
    alone = swept(KEPLER, vary, runs=3).samples.drop(columns="seconds")
    monkeypatch.setattr("barchain.studies.sweep.study.BATCHES", 1)
    together = swept(KEPLER, vary, runs=3).samples.drop(columns="seconds")
    assert together.equals(alone)


@pytest.mark.parametrize(("vary", "words"), [
    ("orbit.sped_factor=1:2:3", "did you mean speed_factor?"),
    ("orbit.speed_factor", "allowed: KEY=LOW:HIGH:COUNT"),
    ("orbit.speed_factor=1:2:2.5", "LOW:HIGH:COUNT with a COUNT of 2"),
    ("orbit.speed_factor=1:2", "LOW:HIGH:COUNT with a COUNT of 2"),
    ("orbit.speed_factor=1,x", "allowed: KEY=LOW:HIGH:COUNT"),
    ("orbit.altitude_m=normal(1, 5)", "orbit.altitude_m"),
    ("orbit.altitude_m[*]=normal(4e5, 1)", "has no list there"),
    ("title=1,2", "title: 1 given"),
    ("orbit.speed_factor=nan", "numbers that a scene file may hold"),
    ("orbit.speed_factor=normall(1, 2)", "did you mean normal?"),
    ("chain.angle_deg[9]=1,2", "no such value in this scene, allowed: [1] to [5]"),
    ("chain.mass_kg[2]=0,1", "fig13: chain.mass_kg[2]: 0 given"),
    ("chain.angle_deg[*]=1,2", "with a distribution"),
    ("chain.bars=2.5,3", "allowed: a whole number"),
    ("effects.drag.density_kg_m3=1e-12,2e-12", "missing"),
    ("orbit.speed_factor=1:2:100000000", "with a COUNT of 2 to 100000"),
    ("chain.length_m=1,2 with chain.mass_kg=1,2,3", "grids and lists of equally many values beside `with`"),
    ("chain.length_m=2,2 with chain.mass_kg=1,2", "different ones of the first key"),
    ("chain.mass_kg=2*chain.lenght_m", "chain.lenght_m has no values of its own"),
    ("chain.mass_kg=nan*chain.length_m", "a factor that a scene file may hold"),
])  # fmt: skip
def test_a_wrong_variation_ends_in_one_line_before_any_run(
    vary: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(["sweep", "paper/fig13", "--vary", vary, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("options", "words"), [
    ("--measure largest(tensoin)", "did you mean tension?"),
    ("--measure tension", "allowed: largest, least, peak, final, rms or p95"),
    ("--measure p101(tension)", "p0 to p100"),
    ("--measure largest(tension[6])", "no bar 6, allowed: 1 to 5"),
    ("--measure largest(altitude[1])", "the number of a bar or joint"),
    ("--measure largest(tension_6_left_N)", "no bar 6"),
    ("--measure largest(torque)", "has no torques"),
    ("--runs 5", "no number is drawn"),
    ("--set steps_per_orbit=5", "steps_per_orbit"),
    ("--vary run.samples=5,6", "given twice"),
    ("--vary chain.rate_factor=1:2:1000 --vary orbit.speed_factor=1:1.2:1000", "allowed: at most 100000"),
])  # fmt: skip
def test_a_wrong_measure_or_option_ends_in_one_line(
    options: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "out")
    assert command(["sweep", "paper/fig13", "--vary", "run.samples=3,4", *options.split(), "--out", out]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_setting_is_that_of_the_engine_that_runs_by_default() -> None:
    engine = default_engine(load_scene(KEPLER))
    found = barchain.sweep(KEPLER, [SHORT], settings={engine: {"rtol": 1e-7}}, executor=ONE)
    assert found.samples["setting"].tolist() == ["rtol=1e-07"]


def test_the_command_shows_the_samples_of_few_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = "sweep basics/kepler_elliptic --vary run.samples=3,4 --measure final(altitude) --workers 1 --out"
    assert command(["-q", *words.split(), str(tmp_path / "out")]) == 0
    assert "final(altitude_m)" in capsys.readouterr().out


@pytest.mark.parametrize(("arguments", "words"), [
    ({"vary": "run.samples=3"}, "vary: 'run.samples=3' given, allowed: a list of texts"),
    ({"vary": ["run.samples=3"], "measures": "rms(rate)"}, "measures: 'rms(rate)' given, allowed: a list of texts"),
    ({"vary": ["run.samples=3"], "runs": 0}, "runs: 0 given, allowed: a number above 0"),
])  # fmt: skip
def test_an_argument_of_another_kind_is_said_in_one_line(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(barchain.ArgumentError, match=f"^{re.escape(words)}"):
        barchain.sweep(KEPLER, **arguments)


def test_the_usual_measures_are_those_that_the_scene_has() -> None:
    usual = [str(measure) for measure in measures_of([], load_scene(KEPLER))]
    assert usual == ["largest(altitude_m)", "least(altitude_m)"]
    assert len(measures_of([], load_scene("paper/fig13"))) == 3


def test_the_column_of_one_effect_is_measured_as_it_is_written() -> None:
    found = swept("effects/drag", ["run.samples=3", "run.orbits=0.01"], "peak(drag_force_1_x_N)")
    assert found.samples["peak(drag_force_1_x_N)"][0] > 0.0


def test_a_chain_of_other_numbers_of_bars_is_measured_where_it_has_the_bar() -> None:
    tables = {
        "title": "bars", "source": "test", "orbit": {"altitude_m": 4e5}, "run": {"orbits": 0.01, "samples": 3},
        "chain": {"bars": 2, "mass_kg": 10.0, "length_m": 10.0, "angle_deg": 90.0},
    }  # fmt: skip
    found = swept(make_scene(tables), ["chain.bars=2,3"], "final(attitude[3])", "final(attitude[last])")
    assert found.passed
    third = found.samples["final(attitude_rad[3])"]
    assert third.isna().tolist() == [True, False]
    assert found.samples["final(attitude_rad[last])"].notna().all()
    assert found.samples["final(attitude_rad[last])"][1] == third[1]
    assert "gives none" in found.samples["reason"][0]


def test_a_run_that_meets_the_surface_is_measured_up_to_there() -> None:
    own = swept(KEPLER, ["orbit.speed_factor=0.5,1"], "least(altitude)").samples
    assert own["outcome"].tolist() == ["pass", "pass"]
    assert "surface" in own["reason"][0]
    assert own["least(altitude_m)"][0] < 1e5 < own["least(altitude_m)"][1]


class DiesAtOnePointOne(Faulty):
    """Takes its process with it at one speed."""

    def build(self, scene: Any, setting: Any) -> None:
        if scene.orbit.speed_factor == 1.1:
            import os

            os.kill(os.getpid(), 9)
        super().build(scene, setting)  # type: ignore[no-untyped-call]


@pytest.mark.parametrize(
    "own", [True, pytest.param(False, marks=pytest.mark.slow)], ids=["in one call", "behind the boundary"]
)
def test_a_run_that_kills_its_process_costs_itself_alone(own: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    target = f"{__name__}:DiesAtOnePointOne"
    if own:
        monkeypatch.setitem(ENGINES, "dies", Registration(target))
    monkeypatch.setattr("barchain.studies.sweep.study.BATCHES", 1)
    found = swept(KEPLER, ["orbit.speed_factor=1,1.1", SHORT], engines=["dies" if own else target])
    assert found.samples["outcome"].tolist() == ["pass", "failed"]
    assert found.samples["largest(altitude_m)"].isna().tolist() == [False, True]
    assert len(found.failures) == 1
    assert "1 of 2 runs gave no result, the first of them run 2: failed" in found.failures[0]


def test_an_engine_behind_the_boundary_is_measured_as_one_of_barchains_own(monkeypatch: pytest.MonkeyPatch) -> None:
    other = "tests.support.faulty_engines:Unmodified"
    monkeypatch.setattr("barchain.studies.sweep.study.BATCHES", 1)
    found = swept(KEPLER, ["orbit.speed_factor=1,1.1", SHORT], "largest(altitude)", engines=[ENGINE, other])
    own, same = (of_engine["largest(altitude_m)"].tolist() for _, of_engine in found.samples.groupby("engine"))
    assert own == same


def test_an_engine_without_the_effect_is_left_out_and_one_that_runs_nowhere_is_a_failure() -> None:
    found = swept("effects/drag", [SHORT], engines=[ENGINE, "rebound"])
    outcomes = found.samples.set_index("engine")["outcome"]
    assert outcomes[ENGINE] == "pass"
    if outcomes["rebound"] == "unsupported":
        assert "rebound: 1 of 1 runs gave no result" in found.failures[0]


def test_a_sweep_goes_on_from_the_runs_that_are_there(tmp_path: Path) -> None:
    notes: list[str] = []

    def run(values: str, **how: Any) -> None:
        study = sweep_study(load_scene(KEPLER), [f"orbit.speed_factor={values}", SHORT], engines=[ENGINE], executor=ONE)
        run_study(study, tmp_path, reporter=Reporter(note=notes.append), **how)

    run("1,1.1")
    run("1,1.1,1.2", resume=True)
    assert notes == ["kept 2 of 3 answers"]
    assert read_table(tmp_path, "sweep", "runs")["outcome"].tolist() == ["pass"] * 3
    assert read_record(tmp_path, "sweep")["complete"]
    with pytest.raises(HistoryError, match="results of sweep, of which nights follow no figure"):
        read_night(tmp_path)


def page_of(folder: Path, *vary: str, engines: tuple[str, ...] = (ENGINE,), **how: Any) -> tuple[str, Any]:
    """HTML and view of a sweep of the apogee."""
    measures = ["final(altitude)", "largest(eccentricity)"]
    swept(KEPLER, [*vary, SHORT], *measures, out=folder, engines=engines, **how)
    page = render_study("sweep", folder).page
    check_policy(page)
    return page.read_text("utf-8"), view_sweep(folder)


def test_one_number_gives_curves_with_units_a_curve_for_each_engine(tmp_path: Path) -> None:
    html, view = page_of(tmp_path, "orbit.altitude_m=4e5:5e5:3", engines=(ENGINE, "reference-absolute"))
    assert [panel.title for panel in view.panels] == ["final(altitude_m)", "largest(eccentricity)"]
    assert [entry.label for entry in view.panels[0].legend] == [ENGINE, "reference-absolute"]
    assert "horizontal axis: orbit.altitude_m, m" in html
    assert len(view.rows) == 6


def test_few_values_of_a_second_number_are_curves(tmp_path: Path) -> None:
    _, view = page_of(tmp_path, "orbit.altitude_m=4e5,5e5", "orbit.speed_factor=1,1.1")
    assert [entry.label for entry in view.panels[0].legend] == ["orbit.speed_factor = 1", "orbit.speed_factor = 1.1"]


def test_a_chart_over_numbers_that_go_together_is_over_the_first_and_the_table_has_both(tmp_path: Path) -> None:
    html, view = page_of(tmp_path, "orbit.altitude_m=4e5,5e5,6e5 with orbit.speed_factor=1,1.1,1.2")
    assert "horizontal axis: orbit.altitude_m, m" in html
    assert view.panels[0].legend == ()  # one curve
    assert view.headings[:2] == ["#orbit.altitude_m", "#orbit.speed_factor"]
    assert [row["values"][:2] for row in view.rows] == [["400000", "1"], ["500000", "1.1"], ["600000", "1.2"]]


def test_many_values_of_a_second_number_make_a_map_that_marks_runs_that_ended_early(tmp_path: Path) -> None:
    _, view = page_of(tmp_path, "orbit.altitude_m=1e3:5e5:3", "orbit.speed_factor=0.1:1.1:5")
    early = [row for row in view.remarks if "surface" in row["reason"]]
    assert early
    svg = str(view.panels[0].svg)
    assert svg.count("†") == len(early)
    assert len(re.findall(r"fill:var\(--d(\d)\)", svg)) == 3 * 5 + 7  # cells, and the bar of colours


def test_draws_give_quantiles_with_the_digits_that_tell_them_apart(tmp_path: Path) -> None:
    """With three digits of their spread they are off by up to a 200th of it."""
    _, view = page_of(tmp_path, "orbit.altitude_m=normal(4e5, 0.5)", runs=9)
    assert [row["measure"] for row in view.quantiles] == ["final(altitude_m)", "largest(eccentricity)"]
    own = read_table(tmp_path, "sweep", "measures").query("quantity == 'final(altitude_m)'")["value"]
    shown = [float(text) for text in view.quantiles[0]["values"]]
    rounding = (own.quantile(0.95) - own.quantile(0.05)) / 200.0
    np.testing.assert_allclose(shown, own.quantile([0.05, 0.25, 0.5, 0.75, 0.95]), rtol=0.0, atol=rounding)
    (median,) = re.findall(r"median, ([\d.]+\d)\.", view.panels[0].note)
    assert float(median) == pytest.approx(own.median(), rel=0.0, abs=np.ptp(own) / 200.0)
    at = view.headings.index("#final(altitude_m)")
    listed = [float(row["values"][at]) for row in view.rows]
    np.testing.assert_allclose(listed, own, rtol=0.0, atol=np.ptp(own) / 200.0)


def test_draws_along_a_grid_give_quantiles_at_each_of_its_values(tmp_path: Path) -> None:
    _, view = page_of(tmp_path, "orbit.altitude_m=normal(4e5, 1e3)", "orbit.speed_factor=1,1.1", runs=3)
    assert [row["of"] for row in view.quantiles[:2]] == ["orbit.speed_factor = 1", "orbit.speed_factor = 1.1"]
