"""Solutions that judge: shipped with barchain, run by heyoka, or the reference's; their files and their honesty."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.heyoka.adapter import CLOSE_START_RAD, HeyokaQuad
from adapters.reference import WIDE_UNTIL
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES, WIDE, Registration
from adapters.trajectory import Trajectory
from barchain.judge.compare import judge
from barchain.judge.evidence import Evidence
from barchain.metrics.quantities import differences
from barchain.record.study_store import StudyStore
from barchain.runs.job import CERTIFIED_ROLES, Role, RunResult, failure
from barchain.runs.run import run_job
from barchain.solutions.certified_file import (
    DamagedTableError,
    head_of,
    read_solution,
    read_table,
    rounded_up,
    shipped_files,
    shipped_path,
    shipped_solution,
    write_file,
)
from barchain.solutions.judging import (
    CERTIFIER,
    affordable,
    certified_jobs,
    judging_engine,
    shares_equations,
    solution_jobs,
    solution_of,
    why_not_certified,
)
from barchain.solutions.reference import (
    ROUNDED,
    UNIT_ROUNDOFF,
    SolutionSource,
    amplification_of,
    closely_sampled,
    densely_sampled,
    establish,
    joint_condition,
    with_perturbed_start,
)
from barchain.studies.comparison.run import Comparison, run_comparison
from barchain.studies.comparison.suite import Suite
from barchain.studies.selftest.faults.equations import no_tide
from barchain.studies.study import Reporter
from reports.results.comparison import FILES
from reports.results.outcome import Outcome
from scenarios import change_scene, load_scene, make_scene, scene_names
from tests.support.results import read_record, series_folder
from tests.support.scene_lists import TAME
from tests.support.slow import exhaustive_but, one_in

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

QUICK = "basics/two_bars_free"
MOST_BYTES = 9.5e6
ROUNDING = 2.0**-53


def shipped(name: str) -> ReferenceSolution:
    found = shipped_solution(closely_sampled(load_scene(name)))
    assert found is not None
    return found


def other_run(name: str, **changes: Any) -> Scene:
    scene = load_scene(name)
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, **changes))


@pytest.mark.parametrize("name", one_in(5, TAME))
def test_core_and_effects_have_judging_solutions_at_the_samples_of_a_comparison(name: str) -> None:
    found, scene = shipped(name), closely_sampled(load_scene(name))
    seen, n = found.trajectory, len(found.amplification)
    assert found.source is SolutionSource.SHIPPED
    assert len(seen.t_s) == scene.run.samples or "surface" in seen.ended
    np.testing.assert_array_equal(seen.t_s, scene.times_s[: len(seen.t_s)])
    dense = densely_sampled(scene).times_s[: len(found.fine.t_s)]
    np.testing.assert_allclose(found.fine.t_s, dense, rtol=4.0 * ROUNDING, atol=0.0)
    assert set(found.error) == set(found.response) == set(differences(seen, seen))
    assert found.amplification[0] == 1.0
    for values in (*found.error.values(), *found.response.values(), found.amplification):
        assert values.shape == (n,)
        assert np.all(np.diff(values) >= 0.0)
    assert all(bar[-1] > 0.0 for bar in found.error.values())


@pytest.mark.parametrize("name", one_in(5, TAME))
def test_the_judging_solution_agrees_with_the_committed_table_inside_both_error_bars(name: str) -> None:
    """Two runs of heyoka with other samples: the table's instants of the whole run are among the scene's own."""
    found, table = shipped(name), read_table(shipped_path(name))
    mine = np.searchsorted(found.trajectory.t_s, table.trajectory.t_s * (1.0 - 4.0 * ROUNDING))
    mine = np.minimum(mine, len(found.trajectory.t_s) - 1)
    same = np.abs(found.trajectory.t_s[mine] - table.trajectory.t_s) == 0.0
    assert same.sum() > 2
    rows, theirs = mine[same], np.nonzero(same)[0]
    apart = differences(found.trajectory.samples(rows), table.trajectory.samples(theirs))
    for quantity, distance in apart.items():
        assert np.all(distance <= found.error[quantity][rows] + table.error[quantity][theirs]), quantity


def test_shipped_solutions_are_a_few_megabytes_in_all() -> None:
    assert sum(path.stat().st_size for path in set(shipped_files().values())) < MOST_BYTES


# no proof encloses events
@pytest.mark.parametrize("name", ["conform/together_1", "effects/everything", "effects/solar_shadow"])
def test_what_is_written_is_read_back_bit_for_bit(name: str, tmp_path: Path) -> None:
    made, table = shipped(name), read_table(shipped_path(name))
    path = shipped_path(name, tmp_path)
    write_file(path, table, made)
    again, instants = read_solution(path, made.scene), read_table(path)
    for mine, theirs in (
        (vars(made.fine), vars(again.fine)),
        (vars(made.trajectory), vars(again.trajectory)),
        (vars(table.trajectory), vars(instants.trajectory)),
        (made.error, again.error),
        (made.response, again.response),
        (table.error, instants.error),
        (head_of(shipped_path(name)), head_of(path)),
        ({"amplification": made.amplification}, {"amplification": again.amplification}),
    ):
        assert mine.keys() == theirs.keys()
        assert all(np.array_equal(mine[key], theirs[key]) for key in mine)


@pytest.mark.parametrize("name", ["hard/compact", "hard/tip_mass"])
def test_files_of_hard_scenes_have_instants_and_judge_nothing(name: str) -> None:
    assert len(read_table(shipped_path(name)).trajectory.t_s) > 2
    assert shipped_solution(closely_sampled(load_scene(name))) is None


def test_rounding_up_keeps_zero_and_never_shrinks() -> None:
    values = np.array([0.0, 1.0, 1.0 + 1e-12, 1e-300])
    assert np.all(rounded_up(values).astype(float) >= values)
    assert rounded_up(values)[0] == 0.0


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_a_damaged_file_is_told_in_one_line(share: float, tmp_path: Path) -> None:
    scene = closely_sampled(load_scene(QUICK))
    whole = bytearray(shipped_files()[scene.digest].read_bytes())
    whole[int(share * len(whole))] ^= 0x40
    path = tmp_path / "damaged.parquet"
    path.write_bytes(bytes(whole))
    with pytest.raises(DamagedTableError, match=r"damaged\.parquet") as told:
        read_solution(path, scene)
    assert "\n" not in str(told.value)


def test_a_solution_is_certified_where_heyoka_is_installed_and_takes_minutes_at_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = other_run(QUICK, samples=7)
    assert shipped_solution(closely_sampled(own)) is None
    assert not why_not_certified(own)
    assert "too long" in why_not_certified(load_scene("hard/long_10000"))
    assert not affordable(load_scene("hard/bars_100"))
    monkeypatch.setitem(ENGINES, CERTIFIER, dataclasses.replace(ENGINES[CERTIFIER], requires="not-there"))
    assert "not-there" in why_not_certified(own)


def test_engines_that_share_the_judges_equations_are_no_independent_evidence() -> None:
    assert shares_equations(ENGINES["heyoka"], SolutionSource.SHIPPED)
    assert not shares_equations(ENGINES["reference"], SolutionSource.SHIPPED)
    assert shares_equations(ENGINES["reference"], SolutionSource.REFERENCE)
    assert not shares_equations(ENGINES["exudyn"], SolutionSource.HEYOKA)


@pytest.mark.slow
def test_a_comparison_on_a_core_scene_runs_no_solution_and_says_what_judged(tmp_path: Path) -> None:
    engine = {"Unmodified": Registration("tests.support.faulty_engines:Unmodified")}
    result = run_comparison([QUICK], out=tmp_path, registered=engine)
    assert result.passed
    record = read_record(tmp_path)
    assert {run["role"] for run in record["runs"]} == {Role.MAIN, Role.FINER}
    assert record["scenes"][QUICK]["solution_source"] == "certified solution that comes with barchain"
    assert "real128" in record["scenes"][QUICK]["solution_setting"]
    assert (series_folder(tmp_path) / "trajectories" / QUICK / "solution.parquet").is_file()


def test_the_reference_judges_where_heyoka_fails_and_why_it_fails_too_is_said(tmp_path: Path) -> None:
    scene = other_run(QUICK, samples=7)
    comparison = Comparison([scene], {}, certify=True)
    store = StudyStore(FILES, tmp_path, comparison.record())
    notes: list[str] = []
    suite = Suite(comparison, store, Reporter(note=notes.append))
    progress = suite.progress[scene.name]
    assert suite.shipped(progress) is None
    assert [job.role for job in suite.judging] == list(CERTIFIED_ROLES)
    case = suite.solution(progress)
    next(case)
    asked = case.send([failure(Outcome.FAILED, "no steps left") for _ in CERTIFIED_ROLES])
    assert judging_engine(scene) in {task.call.given[0].engine for task in asked}
    assert (progress.source, progress.solution_failed) == (SolutionSource.REFERENCE, "")
    assert notes == [f"{scene.name}: no certified solution (no steps left); the reference judges"]
    with pytest.raises(StopIteration):
        case.send([failure(Outcome.FAILED, "singular") for _ in asked])
    assert progress.solution_failed == "the judging solution could not be run (singular)"


def made_here(scene: Scene) -> ReferenceSolution:
    runs = {job.role: run_job(job) for job in solution_jobs(scene)}
    found = solution_of(scene, runs)
    assert found is not None
    return found


TELLING = [
    "paper/fig05",
    "paper/fig09",  # at an equilibrium every evaluation is rounded alike: two runs do not differ by it
    "effects/everything",
    "effects/slews",
    "effects/tip_masses",  # rounding bounds the steps
    "conform/impulse_alone",  # impulses act in double precision
]


@pytest.mark.parametrize(
    "name",
    exhaustive_but(
        (
            name
            for name in scene_names()
            if name.startswith(("basics/", "paper/", "effects/", "published/", "conform/"))
        ),
        TELLING,
    ),
)
def test_extended_precision_meets_the_certified_solution_within_both_error_bars(name: str) -> None:
    certified = shipped(name)
    if judging_engine(certified.scene) != WIDE:
        pytest.skip("no extended precision here")
    made = made_here(certified.scene)
    inside = made.trajectory.t_s[: len(made.amplification)] <= min(made.limit_s, certified.limit_s)
    for quantity, apart in differences(made.trajectory, certified.trajectory).items():
        if quantity in made.error:
            allowed = made.error[quantity] + certified.error[quantity][: len(inside)]
            assert np.all(apart[: len(inside)][inside] <= allowed[inside]), quantity
    grown = made.amplification[inside][-1]
    if grown < 100.0:
        most_rad, scene = 2e-13, certified.scene  # a thousand roundings of double precision
        if scene.effects.impulse:  # solved in double precision, as well as the joints are conditioned
            assert made.trajectory.angle_rad is not None
            size = float(np.abs(made.trajectory.angle_rad).max())
            most_rad = max(most_rad, 1.1 * ROUNDED * UNIT_ROUNDOFF * joint_condition(scene) * (grown + size))
        assert made.error["attitude"][inside][-1] < most_rad


UNEQUAL = {"bars": 3, "mass_kg": [1000.0, 1.0, 1000.0], "length_m": 10.0, "angle_deg": [10.0, 40.0, 80.0]}
STRUCK = {"impulse": [{"bar": 2, "impulse_N_s": 10.0, "at_s": 5.0, "direction_deg": 60.0}]}


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("chain", "effects", "duration_s"),
    [
        (UNEQUAL, STRUCK, 2000.0),  # an impulse is solved in double precision, on joints of unequal masses
        pytest.param(  # a rounded step of the velocity drifts along the orbit
            {"bars": 1, "mass_kg": 100.0, "length_m": 5.0, "angle_deg": 30.0},
            {"impulse": [STRUCK["impulse"][0] | {"bar": 1}]}, 2.0e4, marks=pytest.mark.slow),
        ({"bars": 4, "mass_kg": [1.0, 1e4, 1.0, 1e4], "length_m": 10.0, "angle_deg": [5.0, 60.0, -20.0, 100.0]}, {},
         1500.0),  # the looser run may be rounded less by chance
    ],
)  # fmt: skip
def test_error_bars_hold_where_rounding_is_large(
    chain: dict[str, Any], effects: dict[str, Any], duration_s: float
) -> None:
    scene = make_scene({
        "title": "Rounded", "source": "test", "orbit": {"altitude_m": 5e5}, "chain": chain,
        "effects": {"gravity": "gradient"} | effects, "run": {"duration_s": duration_s, "samples": 11},
    })  # fmt: skip
    if judging_engine(scene) != WIDE:
        pytest.skip("no extended precision here")
    made, right = made_here(scene), HeyokaQuad().run(scene, Setting(AccuracyParameter.RTOL, 1e-26))
    for quantity, apart in differences(made.trajectory, right).items():
        if quantity in made.error:
            assert np.all(apart <= made.error[quantity]), quantity


@pytest.mark.exhaustive
def test_extended_precision_ends_where_the_growth_of_errors_has_made_it_worthless() -> None:
    scene = change_scene(load_scene("paper/fig09"), {"run": {"orbits": 40.0, "samples": 801}})
    if judging_engine(scene) != WIDE:
        pytest.skip("no extended precision here")
    made = made_here(scene)
    assert made.trajectory.info[WIDE_UNTIL] < 0.5 * scene.run.duration_s
    assert made.limit_s <= made.trajectory.info[WIDE_UNTIL]
    assert len(made.trajectory.t_s) == scene.run.samples
    assert made.error["com"][-1] > 1e3 * made.error["com"][1]  # double precision's beyond


def motion(t_s: np.ndarray, angle_rad: np.ndarray) -> Trajectory:
    return Trajectory(t_s, np.zeros((len(t_s), 2)), np.zeros((len(t_s), 2)), angle_rad[:, None])


def test_amplification_stays_honest_far_beyond_the_growth_that_parts_the_perturbed_run() -> None:
    """True growth e^t, in angles of some turns, rounded; runs that have parted differ by a radian at most."""
    t = np.linspace(0.0, 30.0, 301)
    angle = np.array(10.0 + np.sin(t))
    far, near = (angle + np.tanh(size * np.exp(t)) for size in (1e-10, float(CLOSE_START_RAD)))
    grown = amplification_of(*(motion(t, x) for x in (angle, far, near)), float(CLOSE_START_RAD))
    true = np.exp(t)
    assert np.all(grown >= 0.99 * true)
    assert np.all(grown <= 1.01 * true)


def test_the_chaotic_scenes_amplify_more_than_a_run_in_double_precision_could_show() -> None:
    found = shipped("paper/fig09")
    assert found.amplification[-1] > 1e11
    assert found.error["attitude"][-1] > 1e2 * found.error["attitude"][1]


def test_the_close_start_is_off_by_less_than_double_precision_can_hold() -> None:
    scene = other_run("basics/kepler_circular", samples=2)
    runs = [HeyokaQuad(close_start=close) for close in (False, True)]
    for run in runs:
        run.build(scene, Setting(AccuracyParameter.RTOL, 1e-20))
    apart = np.array(runs[1].ran.start) - np.array(runs[0].ran.start)
    angles = apart[4 : 4 + scene.bars]
    assert np.all(apart[:4].astype(float) == 0.0)
    np.testing.assert_allclose(np.abs(angles.astype(float)), float(CLOSE_START_RAD), rtol=1e-12)
    assert {job.role: job.options for job in certified_jobs(scene)}[Role.CLOSE_START]


FAULT = 1e-6
"""Share of the tide that is missing: far below what any two engines of second order would show"""


def runs_of(scene: Scene) -> list[RunResult]:
    settings = (Setting(AccuracyParameter.RTOL, rtol) for rtol in (1e-10, 1e-11))
    return [RunResult(Outcome.PASS, trajectory=Reference().run(scene, s)) for s in settings]


def own_solution(scene: Scene) -> ReferenceSolution:
    def run(of: Scene, rtol: float) -> Trajectory:
        return Reference().run(of, Setting(AccuracyParameter.RTOL, rtol))

    return establish(scene, run(scene, 1e-13), run(scene, 1e-12), run(with_perturbed_start(scene), 1e-13))


def test_a_fault_in_the_references_own_equations_is_caught_by_the_certified_solution_and_not_by_itself() -> None:
    """The tide without a millionth part: the faulty reference agrees with the faulty reference solution."""
    solution = shipped("basics/radial_equilibrium")
    setting = Setting(AccuracyParameter.RTOL, 1e-10)
    right = judge("reference", Reference, setting, Evidence(*runs_of(solution.scene)), solution)
    assert right.outcome is Outcome.PASS
    with no_tide(FAULT):
        faulty = Evidence(*runs_of(solution.scene))
        itself = own_solution(solution.scene)
    assert judge("reference", Reference, setting, faulty, itself).outcome is Outcome.PASS
    assert judge("reference", Reference, setting, faulty, solution).outcome in (
        Outcome.INCONSISTENT,
        Outcome.EXCEEDS_BOUND,
    )
