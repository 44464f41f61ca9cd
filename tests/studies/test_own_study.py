"""A study of one's own: cases ask for runs, rows are kept, an interruption costs nothing."""

import pytest

import barchain
from barchain.record.claim import ResultsInPlaceError
from barchain.runs.executors import LocalProcesses
from reports.results.rows import RowError
from tests.support.results import answers_folder

SCENE = barchain.change_scene(barchain.load_scene("basics/two_bars_free"), {"run": {"duration_s": 50.0, "samples": 3}})
HERE = LocalProcesses(1)


def turned(engine, **setting):
    """Case with the angle by which the first bar turns."""
    (run,) = yield [barchain.asked_run(SCENE, engine, **setting)]
    if run.trajectory is None:
        return [{"metric": "turned", "engine": engine, "outcome": str(run.outcome), "reason": run.reason}]
    angle = run.trajectory.angle_rad[:, 0]
    return [{"metric": "turned", "engine": engine, "value": angle[-1] - angle[0], "unit": "rad", **setting}]


def test_rows_of_all_cases_and_their_summary_are_kept_and_read(tmp_path):
    cases = {"loose": turned("reference", rtol=1e-6), "tight": turned("reference", rtol=1e-12)}
    most = lambda rows: [{"metric": "apart", "value": rows.value.max() - rows.value.min(), "unit": "rad"}]  # noqa: E731
    rows = barchain.measure("turning", cases, tmp_path, summary=most, executor=HERE)
    assert list(rows.metric) == ["turned", "turned", "apart"]
    assert list(rows.rtol[:2]) == [1e-6, 1e-12]
    assert 0.0 <= rows.value[2] < 1e-5
    assert list(barchain.rows(tmp_path).study) == ["turning"] * 3


@pytest.mark.slow
def test_a_study_that_goes_on_makes_what_is_missing_alone(tmp_path, monkeypatch):
    def interrupted():
        yield from turned("reference", rtol=1e-8)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        barchain.measure("turning", {"one": interrupted()}, tmp_path, executor=HERE)
    with pytest.raises(ResultsInPlaceError):
        barchain.measure("turning", {"one": turned("reference", rtol=1e-8)}, tmp_path, executor=HERE)
    kept = sorted(answers_folder(tmp_path, "turning").iterdir())
    assert len(kept) == 1
    cases = {"one": turned("reference", rtol=1e-8), "two": turned("reference", rtol=1e-10)}
    rows = barchain.measure("turning", cases, tmp_path, executor=HERE, resume=True)
    assert len(rows) == 2
    assert len(list(answers_folder(tmp_path, "turning").iterdir())) == 2


def test_a_run_that_is_asked_for_again_by_another_number_is_made_again(tmp_path):
    def case():
        asked = [barchain.asked_run(SCENE, "reference", rtol=1e-8, repetition=k) for k in (0, 0, 1, 2)]
        runs = yield asked
        first = runs[0].trajectory.angle_rad
        return [{"metric": "apart", "value": float(abs(run.trajectory.angle_rad - first).max()), "run": k}
                for k, run in enumerate(runs)]  # fmt: skip

    rows = barchain.measure("again", {"one": case()}, tmp_path, executor=HERE)
    assert list(rows.value) == [0.0] * 4
    assert len(list(answers_folder(tmp_path, "again").iterdir())) == 3


def test_an_engine_that_fails_costs_its_own_row(tmp_path):
    registered = barchain.change_scene(SCENE, {"chain": {"rate_factor": [1e9, -1e9]}})

    def case(engine):
        (run,) = yield [barchain.asked_run(registered, engine, time_limit_s=1e-3)]
        return [{"metric": "run", "engine": engine, "outcome": str(run.outcome), "reason": run.reason}]

    rows = barchain.measure("limits", {"a": case("reference"), "b": turned("reference")}, tmp_path, executor=HERE)
    assert list(rows.outcome) == ["timed_out", ""]


@pytest.mark.parametrize("name", ["Turning", "two words", "cost", ""])
def test_the_name_of_a_study_is_checked_before_any_run(tmp_path, name):
    with pytest.raises(ValueError, match="lower-case"):
        barchain.measure(name, {}, tmp_path)


def test_two_rows_of_one_identity_are_an_error(tmp_path):
    cases = {"one": turned("reference", rtol=1e-8), "two": turned("reference", rtol=1e-8)}
    with pytest.raises(RowError, match="identity"):
        barchain.measure("turning", cases, tmp_path, executor=HERE)
