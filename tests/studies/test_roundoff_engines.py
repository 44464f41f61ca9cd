"""Other engines in the round-off study: the frame decides what is left of the reactions, whoever computes them."""

import numpy as np
import pandas as pd
import pytest

import barchain.studies.roundoff.engines as module
from adapters.common.initial_state import initial_state
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES, Registration
from barchain.record.environment import provenance
from barchain.record.study_store import StudyStore
from barchain.studies.roundoff import study, third_parties
from barchain.studies.roundoff.engines import attempt, engine_rows, scene_at, setting_of
from barchain.studies.roundoff.evaluation import errors, rows_of
from barchain.studies.roundoff.formulations import EvaluationCase, StateKind, exact_case
from barchain.studies.roundoff.power_laws import NEAR, UNEXPLAINED, engine_laws, evaluation_laws, expected_exponent
from barchain.studies.roundoff.study import SWEEPS, tasks_of
from barchain.studies.roundoff.third_parties import THIRD_PARTIES, present
from barchain.studies.roundoff.trajectories import ScaledScene, solution_of
from reference_impl.precision.arithmetic import EXACT, FLOAT64, exact_numbers
from reports.results.roundoff import FILES
from scenarios import load_scene

RATIOS = (1e-3, 1e-5, 1e-7)
MEMBERS = 6
SCATTER = 3.0  # of a median of so few members, and of sizes at which roundings fall otherwise


@pytest.fixture(scope="module")
def solution():
    return solution_of(ScaledScene(load_scene("paper/fig15"), RATIOS, MEMBERS, 1.0 / 256.0))


def medians(solution, engine, size, value):
    """Median error of each quantity."""
    return {row["quantity"]: row["median"] for row in engine_rows(solution, engine, size, value)}


@pytest.mark.parametrize(
    ("engine", "value"), [("pymunk", 65536), ("exudyn-index3", 28672), ("exudyn", 36864), ("reference", 1e-9)]
)
def test_reactions_get_worse_as_the_chain_shrinks_in_the_inertial_frame_only(solution, engine, value):
    name, _, index = engine.partition("-")
    twin = f"{name}-absolute" + (f"-{index}" if index else "")
    moving, inertial = ([medians(solution, e, k, value)["reaction"] for k in (0, 2)] for e in (engine, twin))
    assert max(moving) / min(moving) < 2.0 * SCATTER
    grown = inertial[1] / inertial[0]
    # on long bars index 2 lies on the floor of a differenced derivative
    assert grown > 1e3 if engine == "exudyn" else 1e4 / SCATTER < grown < 1e4 * SCATTER
    assert min(inertial) > SCATTER * max(moving)


def test_reactions_of_index_3_grow_as_the_square_of_the_steps_and_those_of_index_2_have_a_floor(solution):
    """Index 3 closes its gaps to the rounding of a place."""
    coarse, fine = (medians(solution, "exudyn-absolute-index3", 2, steps) for steps in (12288, 49152))
    assert 16.0 / SCATTER < fine["reaction"] / coarse["reaction"] < 16.0 * SCATTER
    assert coarse["gap"] * 1e-7 * 6378e3 < 4.0 * np.spacing(load_scene("paper/fig15").radius0_m)
    coarse, fine = (medians(solution, "exudyn-absolute", 2, steps)["reaction"] for steps in (12288, 49152))
    assert 1.0 / SCATTER < fine / coarse < SCATTER


def test_index_3_from_the_body_s_centre_does_not_stall_on_long_bars():
    """A bar turned by a gap of one rounding: reactions of tens of newtons then leave torques above the usual floor."""
    family = ScaledScene(load_scene("paper/fig15"), (1e-2,), 4, 1.0 / 256.0)
    registration = ENGINES["exudyn-absolute-index3"]
    declared = registration.declarations()
    for longitude in (0.3, 2.37, 4.0, 5.5):
        scene = scene_at(family, 1e-2, longitude)
        found = attempt(registration, declared, scene, setting_of(declared, scene, 32768))
        assert not isinstance(found, module.RunFault), found
        assert found.gap_m.max() < 8.0 * np.spacing(scene.radius0_m)


def test_engines_start_where_the_truth_does():
    family = ScaledScene(load_scene("paper/fig15"), (1e-4,), 1, 1.0 / 256.0)
    start = initial_state(scene_at(family, 1e-4, 2.5))
    with exact_numbers():
        exact = family.start(np.array([2.5]), np.array([1e-4]))
        angle, place = exact.angle_rad[:, 0].astype(float), exact.position_m[..., 0].T.astype(float)
    eps = np.finfo(float).eps
    np.testing.assert_allclose(start.angle_rad, angle, rtol=0, atol=8.0 * eps)
    np.testing.assert_allclose(start.position_m, place, rtol=0, atol=64.0 * eps * np.abs(place).max())


def test_steps_are_those_of_the_scenes_own_orbit_and_told_as_taken(solution):
    rows = engine_rows(solution, "pymunk", 1, 100)
    assert {row["steps_per_orbit"] for row in rows} == {4096.0}  # two steps a sample at least
    assert {(row["engine"], row["frame"], row["ratio"]) for row in rows} == {("pymunk", "moving", 1e-5)}
    rows = engine_rows(solution, "reference-absolute", 1, 1e-6)
    assert {(row["engine"], row["frame"], row["rtol"]) for row in rows} == {("reference", "inertial", 1e-6)}
    assert {(row["members"], row["outcome"]) for row in rows} == {(MEMBERS, "reported")}


@pytest.mark.parametrize(
    ("engine", "outcome", "reason"),
    [
        ("GivesUp", "failed", "step size became zero"),
        ("Raises", "failed", "ZeroDivisionError: inside"),
        ("ReturnsNan", "not_finite", "angle_rad is not finite"),
    ],
)
def test_an_engine_that_fails_costs_its_own_row_and_says_why(solution, monkeypatch, engine, outcome, reason):
    monkeypatch.setattr(module, "find_engine", lambda _: Registration(f"tests.support.faulty_engines:{engine}"))
    rows = engine_rows(solution, "it", 0, 1e-6)
    assert [row["quantity"] for row in rows] == ["attitude", "reaction", "gap"]
    for row in rows:
        assert (row["outcome"], row["members"]) == (outcome, 0)
        assert row["reason"].startswith(reason)
        assert np.isnan(row["median"])


def test_members_that_fail_count_as_lost(solution, monkeypatch):
    simulate, calls = Reference.simulate, []

    def sometimes(self):
        calls.append(self)
        if len(calls) == 3:
            raise ZeroDivisionError("once")
        simulate(self)

    monkeypatch.setattr(Reference, "simulate", sometimes)
    row = engine_rows(solution, "reference", 0, 1e-6)[0]
    assert (row["outcome"], row["members"]) == ("failed", MEMBERS)
    assert row["reason"].startswith(f"1 of {MEMBERS} runs: ZeroDivisionError: once")
    assert np.isinf(row["largest"])
    assert row["median"] < 1e-14


def test_what_is_missing_or_refused_says_so(solution, monkeypatch):
    monkeypatch.setattr(Reference, "unsupported", classmethod(lambda cls, scene: "not today"))
    rows = engine_rows(solution, "reference", 0, 1e-6)
    assert {(row["outcome"], row["reason"]) for row in rows} == {("unsupported", "not today")}
    missing = Registration("adapters.reference.numpy_engines:Reference", "no-such-thing", "no_such_thing", "get it")
    monkeypatch.setattr(module, "find_engine", lambda _: missing)
    rows = engine_rows(solution, "reference", 0, 1e-6)
    assert {(row["outcome"], row["reason"]) for row in rows} == {("missing", missing.missing)}
    monkeypatch.setitem(ENGINES, "mujoco", missing)
    assert [t.arguments for t in study.engines(full=False) if t.arguments[0] == "mujoco"] == [("mujoco", 0, 4096)]
    assert not any(name.startswith("mujoco") for name in present())


def curve(engine, frame, ratio, error, quantity="reaction"):
    """Rows of the engines along an accuracy sweep."""
    head = {"engine": engine, "frame": frame, "ratio": ratio, "quantity": quantity, "known": True}
    steps = 1000.0 * 2.0 ** np.arange(8)
    return [head | {"steps_per_orbit": n, "rtol": np.nan, "median": error(n)} for n in steps]


def noisy(noise):
    """Truncation of second order and round-off that grows as the square of the steps."""
    return lambda n: (n / 1e3) ** -2 * 1e-4 + noise * n**2


def test_laws_tell_truncation_from_round_off_and_one_size_from_another():
    rows = [r for ratio in RATIOS for r in curve("pymunk", "inertial", ratio, noisy(1e-22 / ratio))]
    rows += [{"engine": "mujoco", "frame": "moving", "ratio": 1e-3, "quantity": "reaction", "median": np.nan}]
    found = engine_laws(pd.DataFrame(rows)).set_index(["against", "ratio"]).sort_index()
    assert set(found.engine) == {"pymunk"}
    falling, rising = found.loc["steps, truncation", 1e-7], found.loc["steps", 1e-7]
    assert (falling["expected"], falling["remark"]) == (-2.0, "truncation")
    assert falling["exponent"] == pytest.approx(-2.0, abs=0.2)
    assert (rising["expected"], rising["remark"]) == (2.0, "round-off")
    assert rising["exponent"] == pytest.approx(2.0, abs=0.2)
    assert falling["last"] <= rising["first"]
    assert found.loc["steps", 1e-3].remark == "truncation still rules at the finest step"
    size = found.loc["ratio"].iloc[0]
    assert np.isnan(size.exponent)  # at one size in three truncation still rules
    assert size.remark == "truncation still rules the finest step at most sizes"


def test_rows_tell_the_law_of_truncation_from_that_of_round_off(tmp_path):
    """Both are against steps, at one size."""
    store = StudyStore(FILES, tmp_path, provenance("barchain roundoff") | {"parts": {"engines": {}}})
    store.write("engine_laws", engine_laws(pd.DataFrame(curve("pymunk", "inertial", 1e-7, noisy(1e-15)))))
    found = FILES.rows(tmp_path)
    fitted = found[found.metric == "engine_laws.exponent"]
    assert {"steps", "steps, truncation"} <= {tags.partition("against=")[2].partition(";")[0] for tags in fitted.tags}


def test_what_is_not_as_expected_is_said():
    rows = curve("pymunk", "inertial", 1e-5, lambda n: 1e-12 * n) + curve("mujoco", "moving", 1e-5, lambda n: 1.0 / n)
    rows += curve("unheard of", "inertial", 1e-5, lambda n: 1e-12 * n)
    found = engine_laws(pd.DataFrame(rows))
    said = found[found.exponent.notna()].set_index("engine").remark
    assert said["pymunk"] == f"round-off; {UNEXPLAINED}"
    assert said["mujoco"] == f"truncation; {NEAR}"
    assert said["unheard of"] == f"round-off; {UNEXPLAINED}"


def test_the_plan_has_each_engine_in_both_frames_over_a_wide_range_of_steps():
    tasks = tasks_of(("engines",))
    assert {t.arguments[0] for t in tasks} == set(SWEEPS)
    assert min(t.solution.members for t in tasks) >= 30
    for name, values in SWEEPS.items():
        assert max(values) / min(values) >= 30.0
        if not ENGINES[name].missing:
            assert {t.arguments[1] for t in tasks if t.arguments[0] == name} == {0, 1, 2}
    assert len(tasks_of(("engines",), full=True)) > 3 * len(tasks)


@pytest.fixture(scope="module")
def libraries():
    """Errors of third parties at a few sizes."""
    if not present():
        pytest.skip("neither Pinocchio nor MuJoCo is installed")
    rows = []
    for ratio in (1e-3, 1e-4, 1e-5, 1e-6, 1e-9):
        rows += rows_of(EvaluationCase(StateKind.GENERIC, 3, ratio, 8), ("relative", *present()), ("float64",))
    return pd.DataFrame(rows)


@pytest.mark.parametrize("name", THIRD_PARTIES)
def test_a_library_keeps_its_digits_in_a_moving_frame_and_loses_them_in_the_inertial_one(libraries, name):
    if name not in present():
        pytest.skip(f"{THIRD_PARTIES[name].engine} is not installed")
    own = libraries[(libraries.formulation == name) & (libraries.yardstick == "reaction")]
    error = own[own.source == "both"].set_index("ratio")["median"]
    law = evaluation_laws(own).set_index("source").loc["both"]
    assert law.expected == expected_exponent("generic", name, "reaction")
    assert law.exponent == pytest.approx(law.expected, abs=0.15)
    if name.endswith("(moving frame)"):
        assert error.max() < 1e-13
    else:
        assert error[1e-6] > 1e-10
    # joint angles keep the shape of the chain wherever its root is
    assert own[own.source == "input"]["median"].max() < 1e-15


@pytest.mark.parametrize("name", ["pinocchio (inertial)", "mujoco (inertial)"])
def test_what_they_lose_beyond_that_is_the_square_of_the_orbital_speed(name, monkeypatch):
    if name not in present():
        pytest.skip(f"{THIRD_PARTIES[name].engine} is not installed")
    circular, found = third_parties.circular_m_s, {}
    with exact_numbers():
        exact = exact_case(EvaluationCase(StateKind.GENERIC, 3, 1e-4, 8))
        for faster in (1.0, 100.0):
            monkeypatch.setattr(third_parties, "circular_m_s", lambda e, f=faster: circular(e) * EXACT.cast(f))
            found[faster] = np.median(errors(THIRD_PARTIES[name], FLOAT64, exact)["formula", "reaction"])
    assert 1e4 / SCATTER < found[100.0] / found[1.0] < 1e4 * SCATTER
