"""The round-off study: laws that theory gives, longitudes that do not matter, and a study that keeps what it has."""

import numpy as np
import pandas as pd
import pytest

from barchain.runs.executors import LocalProcesses
from barchain.studies.roundoff.evaluation import longitude_rows, many_states, one_state, rows_of
from barchain.studies.roundoff.formulations import EvaluationCase, StateKind
from barchain.studies.roundoff.power_laws import best_laws, best_table, evaluation_laws, growth_laws
from barchain.studies.roundoff.study import DECADES, PARTS, RoundoffStudy, RoundoffTask, tasks_of
from barchain.studies.roundoff.third_parties import present
from barchain.studies.roundoff.trajectories import (
    ScaledScene,
    chosen_step_rows,
    equal_step_rows,
    growth_rows,
    solution_of,
)
from barchain.studies.study import Reporter, run_study
from reports.results.roundoff import FILES
from scenarios import load_scene

MEMBERS = 12


@pytest.fixture(scope="module")
def evaluation():
    """Errors of an ordinary and of the horizontal state, at all sizes."""
    rows = []
    for kind in (StateKind.GENERIC, StateKind.HORIZONTAL):
        for ratio in DECADES:
            rows += rows_of(
                EvaluationCase(kind, 3, ratio, MEMBERS),
                ("relative", "minimal", "absolute", "absolute accelerations"),
                ("float64",),
            )
    return pd.DataFrame(rows)


@pytest.mark.parametrize(
    ("state", "yardstick", "in_absolute", "in_relative"),
    [("generic", "reaction", -1, 0), ("generic", "m n² l", -1, 0), ("horizontal", "reaction", -3, -2),
     ("horizontal", "m n² l", -1, 0)],
)  # fmt: skip
def test_errors_follow_the_laws_that_theory_gives(evaluation, state, yardstick, in_absolute, in_relative):
    found = evaluation_laws(evaluation)
    found = found[(found.state == state) & (found.yardstick == yardstick) & (found.source == "both")]
    for name, expected in {
        "absolute": in_absolute, "absolute accelerations": in_absolute, "relative": in_relative, "minimal": in_relative,
    }.items():  # fmt: skip
        law = found[found.formulation == name].iloc[0]
        assert law.points >= 3
        assert law.exponent == pytest.approx(expected, abs=0.1), name
        assert law.low - 0.05 <= expected <= law.high + 0.05, name
        assert law.expected == expected


def test_rounding_the_input_alone_costs_absolute_coordinates_as_much_as_the_formula(evaluation):
    own = evaluation[(evaluation.state == "generic") & (evaluation.yardstick == "reaction")]
    by_source = own.pivot(index=["formulation", "ratio"], columns="source", values="median")
    absolute, relative = by_source.loc["absolute"], by_source.loc["relative"]
    assert (absolute.input / absolute.formula).between(0.1, 10.0).all()
    assert (relative[["input", "formula"]] < 1e-15).all(axis=None)


def test_reactions_from_differenced_positions_keep_half_the_digits_in_relative_coordinates_and_fewer_in_absolute():
    """Noise and truncation of a second difference at their best: roots of u and of u/ratio."""
    rows = []
    for ratio in (1e-3, 1e-5, 1e-7, 1e-9):
        rows += rows_of(
            EvaluationCase(StateKind.STRAIGHT, 3, ratio, 6), ("absolute positions", "relative positions"), ("float64",)
        )
    found = evaluation_laws(pd.DataFrame(rows)).set_index(["formulation", "source", "yardstick"])
    assert found.exponent["absolute positions", "both", "reaction"] == pytest.approx(-0.5, abs=0.05)
    assert found.exponent["relative positions", "both", "reaction"] == pytest.approx(0.0, abs=0.1)
    u = 2.0**-53
    for name in ("relative positions", "absolute positions"):
        assert 0.1 < found.constant[name, "both", "reaction"] * u / np.sqrt(u) < 10.0


@pytest.fixture(scope="module")
def longitudes():
    """Errors in each eighth of the circle."""
    rows = longitude_rows(EvaluationCase(StateKind.GENERIC, 3, 1e-5, 256), ("relative", "absolute"), ("float64",))
    return pd.DataFrame(rows).set_index(["formulation", "source"])


@pytest.mark.parametrize("formulation", ["relative", "absolute"])
def test_no_formula_knows_of_the_longitude(longitudes, formulation):
    """In each eighth of the circle the median error lies in the range that holds nine tenths of any eighth's errors."""
    found = longitudes.loc[formulation, "formula"]
    assert found.members.sum() == 256
    assert found["median"].between(found.q05.max(), found.q95.min()).all()
    assert found.p_value.iloc[0] > 0.01  # the seed is fixed: eighths drawn from one distribution


def test_rounding_the_input_knows_of_it_by_the_angle_alone(longitudes):
    """The ulp of an angle of up to 2 pi + 1.5 is at most 4 times that of one in [1, 2)."""
    found = longitudes.loc["relative", "input"]["median"]
    assert found.max() / found.min() < 8.0
    assert longitudes.loc["absolute", "input"].p_value.iloc[0] > 0.01


@pytest.fixture(scope="module")
def solution():
    family = ScaledScene(load_scene("paper/fig15"), (1e-3, 1e-6), 8, orbits=0.5, samples=4)
    return solution_of(family)


def test_the_truth_is_far_below_any_double(solution):
    assert max(solution.error["attitude"].max(), solution.error["reaction"].max()) < 1e-15


@pytest.mark.slow
def test_a_run_in_absolute_coordinates_ends_at_an_error_that_grows_as_the_chain_shrinks(solution):
    rows = []
    for name in ("minimal", "relative", "absolute"):
        for steps in (16, 32):
            rows += equal_step_rows(solution, "float64", name, "dop853", steps)
    found = pd.DataFrame(rows).query("quantity == 'attitude'").groupby(["coordinates", "ratio"])["median"].min()
    assert found["absolute", 1e-6] / found["absolute", 1e-3] == pytest.approx(1e3, rel=0.7)
    for name in ("minimal", "relative"):
        assert found[name].max() < 1e-13
        assert found[name].max() / found[name].min() < 3.0


def test_truncation_does_not_know_of_coordinates(solution):
    """Far above round-off the two redundant sets, which are linear images of each other, err alike."""
    found = {
        name: pd.DataFrame(equal_step_rows(solution, "float64", name, "rk4", 32)).query("quantity == 'attitude'")
        for name in ("relative", "absolute")
    }
    assert found["relative"]["median"].to_numpy() == pytest.approx(found["absolute"]["median"].to_numpy(), rel=0.01)


def test_own_steps_reach_the_tolerance_or_the_arithmetics_floor(solution):
    rows = pd.DataFrame(chosen_step_rows(solution, "float64", "minimal", (1e-6, 1e-9)))
    errors = rows.query("quantity == 'attitude' and ratio == 1e-3").set_index("rtol")["median"]
    assert errors[1e-6] < 1e-4
    assert errors[1e-9] < 1e-2 * errors[1e-6]
    assert (rows.evaluations > 0).all()


@pytest.mark.exhaustive
def test_errors_of_rounding_grow_with_time_as_a_random_walk_moves_things():
    family = ScaledScene(load_scene("paper/fig15"), (1e-4,), 12, orbits=3.0, samples=12)
    known = solution_of(family)
    rows = pd.DataFrame(growth_rows(known, "float64", "relative", "dop853", 32))
    found = growth_laws(rows).set_index("quantity")
    assert found.exponent["gap"] == pytest.approx(1.5, abs=0.25)
    closed = growth_laws(pd.DataFrame(growth_rows(known, "float64", "minimal", "dop853", 32)))
    assert closed.set_index("quantity").exponent["gap"] == pytest.approx(0.0, abs=0.25)


def row(ratio, median, **more):
    """One row of the evaluation."""
    head = {"state": "generic", "bars": 5, "ratio": ratio, "formulation": "absolute", "arithmetic": "float64"}
    return head | {"source": "both", "yardstick": "reaction", "median": median} | more


def test_points_at_total_loss_and_at_the_floor_are_in_no_fit():
    u = 2.0**-53
    table = pd.DataFrame([row(r, min(0.7, max(40 * u, 2.0 * u / r))) for r in DECADES] +
                         [row(r, 3 * u, formulation="relative", source="formula") for r in DECADES] +
                         [row(1e-12, 0.5, arithmetic="float32")])  # fmt: skip
    found = evaluation_laws(table).set_index(["formulation", "arithmetic"]).loc["absolute", "float64"]
    assert found.exponent == pytest.approx(-1.0)
    assert found.constant == pytest.approx(2.0)
    assert found["first"] > 1e-13
    assert found["last"] < 0.04
    assert found.last_digit_ratio == pytest.approx(2.0 * u / 0.1, rel=1e-6, abs=0.0)


def test_a_formulation_that_loses_everything_has_no_law_but_a_remark():
    found = evaluation_laws(pd.DataFrame([row(r, np.inf) for r in DECADES])).iloc[0]
    assert np.isnan(found.exponent)
    assert np.isnan(found.last_digit_ratio)
    assert found.remark == "no digit left at most sizes"


def trajectory(ratio, steps, median, known=True):
    """One row of the trajectories."""
    head = {"ratio": ratio, "quantity": "attitude", "coordinates": "absolute", "arithmetic": "float64", "method": "rk4"}
    return head | {"steps_per_orbit": steps, "rtol": np.nan, "median": median, "known": known}


def test_the_least_error_of_a_method_that_still_gains_from_steps_is_no_floor():
    rows = [trajectory(r, n, max(n**-4.0, 1e-14 / r)) for r in (1e-3, 1e-5, 1e-7) for n in (100, 1000, 10000)]
    settled = best_table(pd.DataFrame(rows))
    assert settled.settled.all()
    assert best_laws(settled).exponent.iloc[0] == pytest.approx(-1.0)
    unsettled = best_table(pd.DataFrame([r for r in rows if r["steps_per_orbit"] == 100]))
    law = best_laws(unsettled).iloc[0]
    assert np.isnan(law.exponent)
    assert law.remark == "truncation still rules at the finest setting"


def test_the_plan_has_every_state_size_and_arithmetic_and_at_least_30_members():
    tasks = tasks_of(PARTS)
    evaluated = [t.arguments for t in tasks if t.table == "evaluation"]
    assert {c.kind for c, *_ in evaluated} == set(StateKind)
    assert {c.ratio for c, *_ in evaluated if c.bars == 5} == set(DECADES)
    assert min(c.members for c, *_ in evaluated) >= 30
    assert {a for _, _, arithmetics in evaluated for a in arithmetics} == {"float32", "float64", "long double"}
    assert {t.arguments[1] for t in tasks if t.table == "trajectories"} == {"minimal", "relative", "absolute"}
    assert {n for _, names, _ in evaluated for n in names} >= set(present())
    assert len(tasks_of(PARTS, full=True)) > len(tasks)


@pytest.mark.slow
def test_a_study_writes_its_tables_and_a_task_that_fails_costs_its_own_rows(tmp_path):
    told, ways = [], (("relative", "absolute"), ("float64",))
    cases = [EvaluationCase(StateKind.GENERIC, 2, r, 4) for r in (1e-3, 1e-5, 1e-7)]
    good = [RoundoffTask("evaluation", f"{c.ratio:g}", rows_of, (c, *ways)) for c in cases]
    wrong = RoundoffTask("evaluation", "wrong", rows_of, (cases[0], ("nonsense",), ("float64",)))
    study = RoundoffStudy((*good, wrong), executor=LocalProcesses(1))
    run_study(study, tmp_path, command="barchain roundoff", reporter=Reporter(lambda *a: told.append(a)))
    tables = FILES.contents(tmp_path)
    assert sorted(outcome for *_, outcome in told) == ["failed", "pass", "pass", "pass"]
    assert len(tables.evaluation) == 3 * 2 * 3 * 2
    assert tables.evaluation.ratio.is_monotonic_decreasing  # in the plan's order, however they came
    assert set(tables.laws.formulation) == {"relative", "absolute"}
    assert tables.record["finished"]
    assert tables.record["failed"] == [{"table": "evaluation", "task": "wrong", "reason": "KeyError: 'nonsense'"}]


@pytest.mark.exhaustive
@pytest.mark.parametrize("timed", [lambda: one_state(3), lambda: many_states("float32", 3)])
def test_a_timing_is_a_ratio_with_an_interval(timed):
    row = timed()
    assert row["ratio"] == pytest.approx(row["relative_s"] / row["absolute_s"])
    assert row["low"] <= row["ratio"] <= row["high"]


def test_parts_are_known_to_the_command_line():
    from barchain.cli.studies import PARTS as OFFERED

    assert OFFERED == PARTS
