"""Tolerance tubes: where `judge` passes a quantity a table lies inside, and where it does not outside."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from barchain import simulate
from barchain.judge.written import Declared
from barchain.metrics.quantities import TRACK
from barchain.result_files.case import ACCURACIES, settings
from barchain.result_files.channels import read_channels
from barchain.result_files.judging import solution_of
from barchain.result_files.one_verdict import one_verdict
from barchain.result_files.samples import placed
from barchain.result_files.tube import curves, quantities, tube
from barchain.solutions.case_versions import case_solution, values
from barchain.solutions.reference import closely_sampled
from reports.results.outcome import Outcome
from scenarios import load_scene

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

CHAOTIC = "paper/fig05"


def outside(scene: str, rtol: float, run: pd.DataFrame) -> pd.Series:
    """Whether each column of a run leaves the tube at some sample."""
    solution = case_solution(scene)
    limits = curves(solution, tube(solution, rtol))
    columns = [name for name in limits["lower"] if name in run and name != "t_s"]
    lower, upper, run = limits["lower"][columns], limits["upper"][columns], run[columns]
    return ~((run >= lower) & (run <= upper) | lower.isna()).all()


@pytest.mark.parametrize("scene", ["basics/two_bars_free", "effects/impulse", "paper/fig17", CHAOTIC])
@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_a_run_that_keeps_its_request_stays_inside_the_tube(scene: str, rtol: float) -> None:
    run = simulate(load_scene(scene), "reference-fast", rtol=rtol).to_frame()
    assert not outside(scene, rtol, run).any()


@pytest.mark.parametrize(
    ("scene", "column"),
    [("basics/two_bars_free", "angle_1_rad"), ("effects/joint_springs", "com_x_m"), ("paper/fig15", "reaction_2_y_N")],
)
@pytest.mark.parametrize("share", [0.98, 1.02])
def test_a_tube_is_as_wide_as_judge_allows(tmp_path: Path, scene: str, column: str, share: float) -> None:
    solution, rtol = case_solution(scene), 1e-6
    quantity, table, k = quantities(solution.scene)[column], values(solution), 70
    table.loc[k, column] += share * tube(solution, rtol).width[quantity][k]
    path = tmp_path / "run.csv"
    table.to_csv(path, index=False)
    sampled = closely_sampled(solution.scene)
    main = placed(read_channels(path, sampled, {}, None), solution_of(sampled, 60.0))
    verdict, *_ = one_verdict("run", main, None, Declared(rtol=rtol), {}, restarts=False)
    ratio = next(r for r in verdict.rows if (r["quantity"], r["metric"]) == (quantity, "bound_ratio"))
    assert ratio["value"] == pytest.approx(share, rel=0.01)
    assert (Outcome(ratio["outcome"]) is Outcome.PASS) is not outside(scene, rtol, table)[column]


def test_a_chaotic_scene_has_a_tube_until_its_predictability_limit_and_of_its_track_to_the_end() -> None:
    solution = case_solution(CHAOTIC)
    found = tube(solution, 1e-9)
    until = solution.trajectory.t_s <= found.until_s
    assert 0 < until.sum() < len(until)
    for name, width in found.width.items():
        known = np.isfinite(width)
        assert known.all() if name in TRACK else (known == until).all()
    shown = settings(solution)
    assert [each["rtol"] for each in shown["accuracies"]] == list(ACCURACIES)
    assert shown["difficulty"]["grade"] == "4 chaotic"


@pytest.mark.parametrize(
    ("scene", "grade"),
    [("basics/libration", "1 smooth"), ("effects/impulse", "2 jumps"), ("paper/fig13", "3 sensitive")],
)
def test_the_difficulty_of_a_case_is_what_its_end_demands(scene: str, grade: str) -> None:
    assert settings(case_solution(scene))["difficulty"]["grade"] == grade
