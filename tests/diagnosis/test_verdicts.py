"""Diagnosis beside the verdicts of a comparison, in independent engines too, and its words."""

import math

import numpy as np
import pytest

from adapters.common.equal_steps import finer_setting
from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from adapters.trajectory import Trajectory
from barchain.judge.diagnosis.diagnose import diagnose
from barchain.judge.diagnosis.motion.others import others
from barchain.judge.diagnosis.reading import Reading
from barchain.judge.diagnosis.readings import READINGS
from barchain.judge.diagnosis.starts import STARTS
from barchain.judge.diagnosis.verdicts import diagnosed_verdict, needs_diagnosis, verdict_tolerance
from barchain.studies.verdict_tasks import verdict_bytes, verdict_from
from reports.results.outcome import Outcome
from scenarios import Scene
from tests.diagnosis.planting import RTOL, diagnosis_of_runs, planted, unequal_chain, verdict_on
from tests.support.slow import one_in
from tests.support.solutions import run, solution_of

SCENE = unequal_chain()
BY_NAME = {m.name: m for m in (*READINGS, *STARTS)}
COARSE = {
    "exudyn-tree": Setting(AccuracyParameter.STEPS_PER_ORBIT, 200.0),
    "pymunk": Setting(AccuracyParameter.STEPS_PER_ORBIT, 4000.0),
}
PLANTED = (
    "reaction-sign", "angles-in-degrees", "reactions-in-axes-of-bar-after", "masses-in-reversed-order",
    "inertia-about-end", "gravity-point", "initial-rates-missing-orbital",
)  # fmt: skip


def wrong_runs(name: str) -> list[Trajectory]:
    """Main and finer run with a mistake of reading."""
    return [planted(SCENE, BY_NAME[name], rtol) for rtol in (RTOL, 0.1 * RTOL)]


def test_an_inconsistent_row_tells_size_unit_beginning_and_explanation_once() -> None:
    solved, (main, finer) = solution_of(SCENE), wrong_runs("angles-and-rates-in-degrees")
    verdict = verdict_on(main, finer, solved)
    assert needs_diagnosis(verdict)
    found = diagnosed_verdict(verdict, main, solved)
    assert found.outcome is verdict.outcome is Outcome.INCONSISTENT
    changed = [(new, old) for new, old in zip(found.rows, verdict.rows, strict=True) if new != old]
    assert [new["quantity"] for new, _ in changed] == ["attitude", "rate"]
    for new, old in changed:
        assert {k: v for k, v in new.items() if k != "reason"} == {k: v for k, v in old.items() if k != "reason"}
        assert new["reason"].endswith(old["reason"])
    first, second = (new["reason"] for new, _ in changed)
    assert " rad of " in first
    assert "from the first sample on; explained by: the angles and rates are in degrees (explained to " in first
    assert " rad/s of " in second
    assert "explained by" not in second
    assert verdict_from(verdict_bytes(found)).rows == found.rows


@pytest.mark.parametrize(("engine", "name"), one_in(8, (pytest.param(e, n) for e in COARSE for n in PLANTED)))
def test_a_mistake_in_an_engine_with_independent_physics_is_named(engine: str, name: str) -> None:
    solved, setting, loaded = solution_of(SCENE), COARSE[engine], ENGINES[engine].load()

    def made(scene: Scene, at: Setting) -> Trajectory:
        mistake = BY_NAME.get(name)
        if isinstance(mistake, Reading):
            return mistake.read(scene, loaded().run(scene, at))
        altered = mistake.change(scene) if mistake else next(a.scene for a in others(scene) if a.name == name)
        return loaded().run(altered, at)

    finer = finer_setting(SCENE, loaded.sweep, setting)
    main, second = made(SCENE, setting), made(SCENE, finer)
    verdict = verdict_on(main, second, solved, engine, setting=setting)
    found = diagnose(SCENE, main, solved, verdict_tolerance(verdict), lambda a, b: (made(a, setting), made(b, finer)))
    assert (name,) in found.names, str(found)


def test_the_sentence_addresses_the_author_and_gives_the_runner_up() -> None:
    found = diagnosis_of_runs(SCENE, *wrong_runs("reaction-sign"))
    assert str(found).startswith("Your reactions have the opposite sign (explained to ")
    assert found.next_best.fit.relative_error > 1e3 * found.explanations[0].fit.relative_error


def test_a_result_inside_its_tolerances_says_so() -> None:
    found = diagnosis_of_runs(SCENE, run(SCENE, RTOL), run(SCENE, 0.1 * RTOL))
    assert found.inside_tolerances
    assert str(found) == "The result is inside the tolerances."


def test_tolerances_of_a_verdict_end_at_the_predictability_limit() -> None:
    solved, main = solution_of(SCENE), run(SCENE, RTOL)
    verdict = verdict_on(main, run(SCENE, 0.1 * RTOL), solved)
    middle = math.floor(float(main.t_s[50]))
    rows = [row | {"limit_s": float(middle)} for row in verdict.rows]
    found = verdict_tolerance(type(verdict)(rows, verdict.series))
    assert np.isinf(found["attitude"]).sum() == np.count_nonzero(main.t_s > middle)
    assert np.isfinite(found["com"]).all()
