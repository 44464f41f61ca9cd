"""An error model is built once for a verdict, and each of its expensive members is computed once."""

from __future__ import annotations

import collections
import dataclasses
import pickle
from typing import TYPE_CHECKING, Any

import pytest

from adapters.engine import AccuracyParameter, Coordinates, Setting
from adapters.reference.numpy_engines import Reference
from barchain.judge import compare, error_model, residuals
from barchain.judge.compare import judge
from barchain.judge.error_model import ErrorModel
from barchain.judge.evidence import Evidence
from barchain.judge.local_errors import requested_errors, truncation_errors
from barchain.runs.job import RunResult
from reports.results.outcome import Outcome
from scenarios import load_scene
from tests.support.solutions import run, solution_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.solutions.reference import ReferenceSolution


SETTING = Setting(AccuracyParameter.RTOL, 1e-8)
ONCE = {
    error_model: ("requested_errors", "scales"),
    residuals: ("parted_track_bound",),
    compare: ("drift_bounds",),
}
MEMBERS = ("attitude_rad", "bound", "limit_s", "missed", "noise", "place_m")


@pytest.fixture(scope="module")
def solution() -> ReferenceSolution:
    scene = load_scene("paper/fig15")
    scene = dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=0.1 * scene.period_s, samples=21))
    return solution_of(scene)


def counted(counts: collections.Counter[str], name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*given: Any, **named: Any) -> Any:
        counts[name] += 1
        return function(*given, **named)

    return call


def test_floors_bounds_and_explained_errors_are_computed_once_for_a_verdict(
    solution: ReferenceSolution, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = collections.Counter[str]()
    for module, names in ONCE.items():
        for name in names:
            monkeypatch.setattr(module, name, counted(counts, name, getattr(module, name)))
    for name in ("floor_of", "explained", "__init__"):
        monkeypatch.setattr(ErrorModel, name, counted(counts, name, getattr(ErrorModel, name)))
    for name in MEMBERS:
        member = vars(ErrorModel)[name]
        monkeypatch.setattr(member, "func", counted(counts, name, member.func))
    main, finer = (RunResult(Outcome.PASS, trajectory=run(solution.scene, rtol)) for rtol in (1e-8, 1e-9))
    assert main.trajectory is not None
    errors = ErrorModel(Reference, SETTING, solution, main.trajectory)
    assert errors.limit_s > 0.0  # asked for before the verdict, to choose its process
    assert judge("x", Reference, SETTING, Evidence(main, finer), solution, errors).outcome is Outcome.PASS
    at_finer_setting = {"__init__", "floor_of", "noise", "place_m", "scales"}  # has a floor of its own
    assert counts.keys() >= {*MEMBERS, *sum(ONCE.values(), ())}
    assert all(n == 1 for name, n in counts.items() if name not in at_finer_setting), counts
    assert all(counts[name] <= 2 for name in at_finer_setting), counts


def test_a_model_goes_to_another_process_and_keeps_its_numbers(solution: ReferenceSolution) -> None:
    errors = ErrorModel(Reference.declarations(), SETTING, solution, run(solution.scene, 1e-8))
    floor = errors.floor["attitude"]
    there = pickle.loads(pickle.dumps(errors))
    assert (there.floor["attitude"] == floor).all()


def test_joint_coordinates_in_absolute_places_have_the_errors_of_angles_and_the_roundings_of_the_radius(
    solution: ReferenceSolution,
) -> None:
    """The centre of mass follows from the angles, and shares their errors; a place rounds as its distance does."""
    scene, made = solution.scene, Reference.declarations()
    equal = Setting(AccuracyParameter.STEPS_PER_ORBIT, 2000.0)

    def model(coordinates: Coordinates) -> ErrorModel:
        return ErrorModel(
            dataclasses.replace(made, coordinates=coordinates), SETTING, solution, run(scene, SETTING.value)
        )

    both, joints, places = map(model, (Coordinates.ABSOLUTE_JOINT, Coordinates.JOINT, Coordinates.ABSOLUTE))
    assert both.place_m == places.place_m == scene.radius0_m
    assert both.rounding_rad == places.rounding_rad > 1e3 * joints.rounding_rad
    asked = [requested_errors(each.engine, SETTING, solution, 0.0).com_rate for each in (both, joints, places)]
    assert (asked[0] == asked[1]).all()
    assert (asked[0] > asked[2]).all()
    stepped = dataclasses.replace(both.engine, order=4.0), dataclasses.replace(places.engine, order=4.0)
    shared, alone = (truncation_errors(each, equal, solution) for each in stepped)
    assert (shared.attitude_rate == alone.attitude_rate).all()
    assert (shared.com_rate > alone.com_rate).all()
