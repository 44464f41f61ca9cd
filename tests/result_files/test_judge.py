"""Results in files: what people write, what of it is judged, and which mistakes are named."""

import dataclasses
import math
import re
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from adapters.trajectory import to_frame
from barchain import load_scene, simulate
from barchain.cli.main import cli
from barchain.judge.verdict import no_verdict
from barchain.judge.written import Declared
from barchain.metrics.quantities import differences
from barchain.result_files.table import TableError
from barchain.result_files.units import UnitError, factor
from barchain.result_files.verdict import other_order
from barchain.solutions.at_times import solution_at
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.reference import closely_sampled
from reports.results.outcome import Outcome
from scenarios.scene import Run
from tests.result_files.examples import frame_of

SCENE = "paper/fig05"
ROUGH = Declared(rtol=1e-8)


@pytest.fixture(scope="module")
def table():
    """A run at rtol = 1e-8, whose errors the paper's scene amplifies."""
    return frame_of(SCENE, rtol=1e-8)


@pytest.fixture
def judged(judged):
    """The same of the paper's scene and a run of that accuracy."""

    def made(frame, declared=ROUGH, scene=SCENE, **how):
        return judged(frame, declared, scene=scene, **how)

    return made


def test_a_right_result_passes_and_one_with_reversed_reactions_does_not_and_says_so(table, judged):
    assert judged(table).passed
    wrong = judged(table.assign(**{name: -table[name] for name in table if name.startswith("reaction")}))
    assert wrong.outcome is Outcome.INCONSISTENT
    assert wrong.mistakes.startswith("Your reactions have the opposite sign")


def test_units_in_the_header_are_followed_and_one_of_another_quantity_is_refused(table, judged):
    angles = {name: name.replace("_rad", " [deg]") for name in table if name.startswith("angle")}
    converted = table.assign(t_s=table.t_s / 3600.0, **{name: np.degrees(table[name]) for name in angles})
    assert judged(converted.rename(columns={"t_s": "time (h)"} | angles)).passed
    with pytest.raises(TableError, match=r"the unit km given, allowed: rad"):
        judged(table.rename(columns={"angle_1_rad": "angle_1 [km]"}))


def test_columns_of_any_name_or_none_are_read_with_a_mapping(table, judged):
    few = table[["t_s", *(f"angle_{j}_rad" for j in range(1, 6))]]
    named = few.rename(columns={"t_s": "Zeit"} | {f"angle_{j}_rad": f"phi{j}" for j in range(1, 6)})
    by_name = {"t": "Zeit"} | {f"angle_{j} [rad]": f"phi{j}" for j in range(1, 6)}
    assert judged(named, mapping=by_name).passed
    with_unit = few.rename(columns={"t_s": "sys.time {s}"})
    assert judged(with_unit, mapping={"t": "sys.time"}).passed
    by_number = {"t": "1"} | {f"angle_{j}": str(j + 1) for j in range(1, 6)}
    assert judged(few, mapping=by_number, header=False).passed
    both = few.assign(rate_1_rad_s=-table.rate_1_rad_s)
    assert not judged(both, mapping={"angle_1 [rad]": "angle_1_rad"}).passed  # what no mapping names counts too
    with pytest.raises(TableError, match=r"has no column 'phi6' \(did you mean phi"):
        judged(named, mapping=by_name | {"angle_5": "phi6"})


@pytest.mark.slow
def test_a_file_of_fewer_bars_that_does_not_pass_is_said_to_be_of_another_scene(judged):
    found = judged(frame_of("basics/two_bars_free"))
    assert found.advice == ["the file has columns of 2 bars, the scene has 5"]


@pytest.mark.slow
def test_reactions_of_which_a_part_is_missing_are_judged_beyond_the_limit_by_the_files_own_states(verdict_alone):
    run = frame_of(SCENE, rtol=1e-9).drop(columns="reaction_2_y_N")
    found = verdict_alone(run, Declared(rtol=1e-9))
    assert found.passed, found.reasons
    assert any("from the file's own states alone" in note for note in found.notes)
    late = run.t_s > 0.6 * run.t_s.iloc[-1]
    wrong = {name: run[name].where(~late, 0.0) for name in run if name.startswith("reaction")}
    found = verdict_alone(run.assign(**wrong), Declared(rtol=1e-9))
    assert not found.passed
    assert any("restarted from the engine's own state" in reason for reason in found.reasons)


@pytest.mark.slow
def test_garbage_is_no_error_that_the_finer_file_shows(verdict_alone):
    scene = "basics/two_bars_free"
    coarse, finer = (frame_of(scene, "exudyn", steps_per_orbit=n)[["t_s", "angle_1_rad"]] for n in (5000, 10_000))
    assert verdict_alone(coarse, Declared(), scene, finer=finer).passed
    garbage = coarse.assign(angle_1_rad=coarse.angle_1_rad.where(coarse.t_s < 600.0, 0.0))
    found = verdict_alone(garbage, Declared(), scene, finer=finer)
    assert not found.passed
    assert found.advice[0].startswith("the two files part at t = 6")


@pytest.mark.exhaustive
def test_rows_after_the_end_are_left_out_however_few_digits_count(judged):
    scene = "basics/two_bars_free"
    run = frame_of(scene, rtol=1e-9)
    more = pd.concat([run, run.iloc[-1:].assign(t_s=[2020.0])])
    found = judged(more, Declared(rtol=1e-9), scene, digits=2)
    assert found.passed
    assert {"2 digits of each number count", "1 row after the scene's end, t = 2000 s, not judged"} <= set(found.notes)


def test_times_in_another_unit_are_asked_for(table, judged):
    found = judged(table.assign(t_s=table.t_s / 60.0))
    assert found.advice == ["the last row is at t = 457.677 s, and 457.677 min are the scene's end: time [min]?"]
    with pytest.raises(TableError, match="no row from t > 0"):
        judged(table.assign(t_s=table.t_s + 1e6))


@pytest.mark.slow
def test_a_sample_that_shows_the_motion_after_a_jump_is_named(judged):
    scene = "effects/impulse"
    right = frame_of(scene, rtol=1e-9)
    jumps = load_scene(scene).effects.breaks_s
    rows = []
    for t in jumps:
        solution = solution_at(shipped_solution(load_scene(scene)), np.array([0.0, t, t + 1e-6]))
        after = to_frame(solution.trajectory).iloc[[1, 2]]
        rows.append(after.iloc[0].where(after.columns == "t_s", after.iloc[1]))
    wrong = pd.concat([right, pd.DataFrame(rows)[right.columns]]).sort_values("t_s", kind="stable")
    found = judged(wrong.drop_duplicates("t_s", keep="last"), Declared(rtol=1e-9), scene)
    assert "show the motion after these" in found.mistakes


@pytest.mark.exhaustive
def test_a_promise_that_the_file_does_not_keep_is_told_with_the_one_that_it_keeps(table, judged):
    found = judged(table, Declared(rtol=1e-14))
    assert found.advice == ["no known mistake explains it, and it agrees at rtol=1e-09"]


@pytest.mark.exhaustive
def test_digits_of_a_curve_that_was_read_off_can_be_told(judged):
    curve = frame_of(SCENE)[["t_s", "angle_1_rad"]].iloc[5:60:5]
    shown = pd.DataFrame({"time [s]": curve.t_s, "angle_1 [deg]": np.degrees(curve.angle_1_rad)})
    read = shown.map(lambda value: round(float(f"{value:.2g}")))  # 1.1e2 is written as 110
    assert not judged(read, Declared()).passed
    assert judged(read, Declared(), digits=2).passed


@pytest.mark.exhaustive
def test_an_error_that_iterations_leave_is_no_mistake_of_the_motion_and_its_size_is_proposed(judged):
    scene = "basics/two_bars_free"
    coarse, finer = (frame_of(scene, "exudyn", steps_per_orbit=n) for n in (5000, 10_000))
    found = judged(coarse, Declared(order=2.0), scene, finer=finer)
    assert (found.outcome, found.mistakes) == (Outcome.INCONSISTENT, "")
    (proposed,) = re.findall(r"--noise reaction=(\S+)", found.advice[0])
    assert judged(coarse, Declared(order=2.0, noise={"reaction": float(proposed)}), scene, finer=finer).passed


@pytest.mark.exhaustive
def test_what_is_missing_is_not_judged_and_said(table, judged):
    few = table[["t_s", "angle_3_rad", "reaction_1_x_N", "reaction_1_y_N"]]
    found = judged(few)
    assert found.passed
    assert {quantity for quantity, *_ in found.sizes} == {"attitude", "reaction"}
    assert any("not judged" in note and "rate_1" in note and "angle_3" not in note for note in found.notes)
    assert not judged(few.assign(angle_3_rad=few.angle_3_rad + 0.01)).passed
    extra = judged(table.assign(temperature=1.0))
    assert extra.passed
    assert any("temperature" in note for note in extra.notes)


@pytest.mark.exhaustive
def test_the_solution_at_other_times_is_the_one_at_its_own_samples_and_the_run_of_the_reference_between():
    for name in SCENE, "conform/impulse_alone":
        solution = shipped_solution(closely_sampled(load_scene(name)))
        own = solution.trajectory.t_s
        between = dataclasses.replace(solution.scene, run=Run(float(own[-1]), 3 * (len(own) - 1) + 1))
        right = simulate(between, rtol=1e-13)
        seen = solution_at(solution, right.t_s)
        apart = differences(seen.trajectory, right)
        allowed = 100.0 * 1e-13 * seen.amplification
        for quantity in ("attitude", "rate", "reaction"):
            scale = np.maximum(seen.response[quantity], load_scene(name).fastest_rate_rad_s)
            assert np.all(apart[quantity] <= allowed * scale + 1e-12 * scale), quantity
        assert differences(seen.trajectory.samples(slice(None, None, 3)), solution.trajectory)["attitude"].max() < 1e-12


@pytest.mark.slow
def test_a_finer_result_estimates_the_error_and_an_order_is_held_to_it(verdict_alone):
    coarse, fine = (frame_of("basics/two_bars_free", "exudyn", steps_per_orbit=n) for n in (1000, 2000))

    def outcome(order, finer=fine):
        declared = Declared(order=order, noise={"reaction": 1e-8})
        return verdict_alone(coarse, declared, "basics/two_bars_free", finer=finer)

    assert outcome(None).passed
    assert outcome(2.0).passed
    for wrong in 1.0, 4.0:
        assert outcome(wrong).advice == [f"the two files show errors of order 2; order {wrong:g} is declared"]
    with pytest.raises(TableError, match="has the numbers of"):
        outcome(None, finer=coarse)
    exchanged = verdict_alone(fine, Declared(order=2.0, noise={"reaction": 1e-8}), "basics/two_bars_free", finer=coarse)
    assert exchanged.advice == ["the errors of the finer file are larger: are the two files exchanged?"]
    undeclared = verdict_alone(coarse, Declared(), "basics/two_bars_free", finer=fine)
    assert not undeclared.passed, "Newton's tolerance is undeclared"
    with pytest.raises(TableError, match="both need the same rows"):
        outcome(2.0, finer=fine.iloc[::2])


def test_a_promise_that_is_too_loose_says_nothing_of_an_order():
    solution = shipped_solution(load_scene(SCENE))
    samples = SimpleNamespace(trajectory=solution.trajectory, solution=solution)
    coarse = no_verdict(SCENE, "run", None, Outcome.TOO_COARSE, "too loose")
    assert other_order(coarse, samples, samples, 2.0) == []


def test_numbers_of_a_publication_with_two_digits_are_judged_as_a_file(judged):
    """The turns after one orbit as two independent integrations found them, and as somebody prints them."""
    start = to_frame(shipped_solution(closely_sampled(load_scene(SCENE))).trajectory).filter(like="angle").iloc[0]
    turned = [-0.77351466, -0.28699644, 0.11854976, 0.41158638, 0.59243057]
    rows = [[0, *start.round(2)], [1, *np.round(start + 2.0 * math.pi + turned, 2)]]
    printed = pd.DataFrame(rows, columns=["time [orbits]", *(f"angle_{j} [rad]" for j in range(1, 6))])
    assert judged(printed, Declared()).passed
    printed.loc[1, "angle_3 [rad]"] += 0.02
    assert not judged(printed, Declared()).passed


def test_a_curve_that_was_read_off_a_figure_is_compared_with_what_its_digits_tell(judged):
    scene = load_scene(SCENE)
    seen = to_frame(shipped_solution(closely_sampled(scene)).trajectory).iloc[:220:10]
    orbits, degrees = (seen.t_s / scene.period_s).round(2), np.degrees(seen.angle_3_rad).round()
    read = pd.DataFrame({"time [orbits]": orbits, "angle_3 [deg]": degrees.astype(int)})
    assert judged(read, Declared()).passed
    below = read.assign(**{"angle_3 [deg]": -read["angle_3 [deg]"]})
    assert not judged(below, Declared()).passed


def test_few_rows_and_those_beyond_the_predictability_limit_alone_are_no_agreement(table, judged):
    assert judged(table.iloc[:20]).outcome is Outcome.TOO_COARSE
    late = table[table.t_s > 20_000.0][["t_s", "angle_1_rad", "reaction_1_x_N"]]
    for frame, declared in ((late, ROUGH), (late.assign(angle_1_rad=42.0), Declared())):
        found = judged(frame, declared)
        assert not found.passed
        assert not any("agrees" in line for line in found.advice)


@pytest.mark.slow
def test_a_file_with_one_wrong_column_is_not_said_to_be_inside_the_tolerances(table, judged):
    found = judged(table[["t_s"]].assign(angle_1_rad=1.001 * table.angle_1_rad).iloc[::8], Declared(rtol=1e-9))
    assert not found.passed
    assert "inside the tolerances" not in found.mistakes


def test_units_of_the_same_quantity_convert_and_others_do_not():
    for given, wanted, size in [
        ("deg/s", "rad/s", math.pi / 180), ("km/h", "m/s", 1 / 3.6), ("N*m", "N m", 1.0), ("m s^-1", "m/s", 1.0),
        ("orbits", "s", 5000.0), ("kNm", "N m", 1e3), ("rpm", "rad/s", math.pi / 30), ("°", "rad", math.pi / 180),
    ]:  # fmt: skip
        assert factor(given, wanted, 5000.0) == pytest.approx(size), given
    with pytest.raises(UnitError, match=r"furlong"):
        factor("furlong", "m", 1.0)
    for numbered in ("1000 m", "10^3 m", "1/s"):
        with pytest.raises(UnitError, match="without numbers"):
            factor(numbered, "m", 1.0)


@pytest.mark.slow
def test_the_command_ends_with_the_verdict_and_writes_a_report(table, tmp_path):
    table = table.iloc[:121:4]
    table.to_csv(tmp_path / "my run.csv", index=False)
    table.assign(angle_1_rad=0.0).to_csv(tmp_path / "wrong.csv", index=False)

    def ended(*words):
        return CliRunner().invoke(cli, ["judge", SCENE, *map(str, words)])

    good = [tmp_path / "my run.csv", "--rtol", "1e-8"]
    found = ended(*good, "--out", tmp_path / "out")
    assert found.exit_code == 0, found.output
    assert "my-run" in (tmp_path / "out" / "index.html").read_text()
    assert ended(tmp_path / "wrong.csv", "--rtol", "1e-8").exit_code == 1
    assert ended(tmp_path / "my run.csv", "--order", "4").exit_code == 2
    assert ended(tmp_path / "my run.csv", "--noise", "rection=1").exit_code == 2
    columns = tmp_path / "columns.toml"
    columns.write_text('t = 1\n"angle_1 [rad]" = "angle_1_rad"\n')
    assert ended(*good, "--columns", columns, "--column", "rate_1=rate_1_rad_s").exit_code == 0
