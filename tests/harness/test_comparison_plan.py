"""Choices of a comparison that nobody made: engines of a quick look, settings, and the order of runs."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import ENGINES
from barchain.judge.verdict import no_verdict
from barchain.runs.choices import chosen_engines, one_of_each
from barchain.runs.job import Job, Role, TimeLimit
from barchain.runs.tasks import run_task
from barchain.solutions.certified_file import shipped_solution
from barchain.solutions.reference import closely_sampled
from barchain.studies.comparison import suite
from barchain.studies.comparison.plan import (
    KEPT_LIMIT,
    STEPS_PER_TURN,
    WANTED_SHARE,
    ComparisonPlan,
    SceneProgress,
    coarse_first,
    comparison_setting,
    expected_share,
    promise,
    required_verdicts,
    turns_per_orbit,
)
from barchain.studies.comparison.run import Comparison
from barchain.studies.comparison.suite import Suite
from reports.results.outcome import Outcome
from scenarios import load_scene


def judge_of(name: str):  # type: ignore[no-untyped-def]
    found = shipped_solution(closely_sampled(load_scene(name)))
    assert found is not None
    return found


def test_a_quick_look_takes_one_engine_of_each_library() -> None:
    everything = {name: r for name, r in chosen_engines(None).items() if name in ENGINES and name != "heyoka"}
    assert list(one_of_each(everything)) == ["reference", "exudyn", "rebound", "pymunk"]
    assert one_of_each({"exudyn-tree": ENGINES["exudyn-tree"]}).keys() == {"exudyn-tree"}


@pytest.mark.parametrize("engine", ["exudyn", "exudyn-index3", "exudyn-absolute", "exudyn-tree", "pymunk"])
@pytest.mark.parametrize("scene", ["basics/libration", "basics/two_bars_free"])
def test_the_setting_is_the_coarsest_that_still_shows_something(engine: str, scene: str) -> None:
    loaded, solution = ENGINES[engine].declarations(), judge_of(scene)
    chosen, default = comparison_setting(loaded, solution.scene, solution), loaded.sweep.setting()
    least = STEPS_PER_TURN * turns_per_orbit(solution)
    assert min(least, default.value) <= chosen.value <= default.value
    if expected_share(promise(loaded, default, solution)) <= WANTED_SHARE:
        assert expected_share(promise(loaded, chosen, solution)) <= WANTED_SHARE
        coarser = [s for s in coarse_first(loaded, default) if least <= s.value < chosen.value]
        assert all(expected_share(promise(loaded, s, solution)) > WANTED_SHARE for s in coarser)
    else:
        kept = KEPT_LIMIT * promise(loaded, default, solution).limit_s
        assert promise(loaded, chosen, solution).limit_s >= kept


def test_a_chain_that_tumbles_beyond_the_predictability_limit_is_resolved_there() -> None:
    """Bounds hold up to the limit: at 120 steps an orbit, nine a turn, Exudyn's solver gave up."""
    scene = load_scene("paper/fig05_bar_horizontal")
    solution = judge_of("paper/fig05_bar_horizontal")
    assert turns_per_orbit(solution) == pytest.approx(12.9, abs=0.1)
    setting = comparison_setting(ENGINES["exudyn"].declarations(), scene, solution)
    assert setting.value >= STEPS_PER_TURN * 12.8
    seen = ENGINES["exudyn"].load()().run(scene, setting)
    assert seen.t_s[-1] == pytest.approx(scene.run.duration_s)


def test_a_given_setting_a_method_that_chooses_its_steps_and_an_unknown_solution_change_nothing() -> None:
    loaded, solution = ENGINES["pymunk"].declarations(), judge_of("basics/libration")
    given = Setting(AccuracyParameter.STEPS_PER_ORBIT, 777.0)
    plan = Comparison([], {}, settings={"pymunk": given})
    assert plan.setting("pymunk", loaded, solution.scene, solution) == given
    assert Comparison([], {}).setting("pymunk", loaded, solution.scene) == loaded.sweep.setting()
    assert Comparison([], {}).setting("another-package", loaded, solution.scene, solution) == loaded.sweep.setting()
    reference = ENGINES["reference"].declarations()
    assert comparison_setting(reference, solution.scene, solution) == reference.sweep.setting()


def test_a_swing_of_an_end_body_is_resolved_in_a_scene_without_a_solution_too() -> None:
    scene, tree = load_scene("published/tips"), ENGINES["exudyn-tree"].declarations()
    assert comparison_setting(tree, scene, None).value >= scene.swing_rate_rad_s * scene.step_period_s


def test_runs_of_solutions_begin_first_then_those_that_compile_and_then_the_longest() -> None:
    def job(engine: str, scene: str, role: Role = Role.MAIN) -> Job:
        return Job(load_scene(scene), engine, ENGINES[engine], ENGINES[engine].declarations().sweep.setting(), role)

    small, large = job("heyoka", "basics/libration"), job("heyoka", "paper/fig05")
    short, long = job("pymunk", "basics/libration"), job("pymunk", "paper/fig05")
    solution = job("reference", "basics/libration", Role.SOLUTION)
    asked = [short, small, long, large, solution]
    assert sorted(asked, key=lambda each: run_task(each, TimeLimit(60.0)).priority) == [
        solution, large, small, long, short,
    ]  # fmt: skip


def test_an_engine_that_was_compared_on_no_scene_always_says_why() -> None:
    engines = {"exudyn": ENGINES["exudyn"]}
    scene = load_scene("basics/libration")
    for outcome in (Outcome.UNSUPPORTED, Outcome.TOO_COARSE):
        for reason in ("", "why"):
            progress = SceneProgress(scene, {"exudyn": no_verdict(scene.name, "exudyn", None, outcome, reason)})
            plan = ComparisonPlan([scene], engines, named=True)
            ((_, _, told),) = required_verdicts(plan, {scene.name: progress})
            parts = told.rows[0]["reason"].partition("compared on no scene: ")[2].split(";")
            assert all(part.strip() for part in parts)


def test_no_engine_runs_on_samples_that_no_setting_predicts(monkeypatch: pytest.MonkeyPatch) -> None:
    runs, notes = [], []
    monkeypatch.setattr(suite, "beyond_any_setting", lambda _: "samples too far apart")
    monkeypatch.setattr(Suite, "run_of", lambda _, job: runs.append(job))
    scene = load_scene("paper/fig05")
    comparison = Comparison([scene], {"reference-fast": ENGINES["reference-fast"]})
    store = SimpleNamespace(
        record={"scenes": {scene.name: {}}}, write=lambda *_: None, write_series=lambda *_: None
    )  # fmt: skip
    reporter = SimpleNamespace(step=lambda *_: None, note=notes.append)
    found = Suite(comparison, store, reporter).run()  # type: ignore[arg-type]
    assert found[scene.name, "reference-fast"].outcome is Outcome.TOO_COARSE
    assert (runs, notes) == ([], [f"{scene.name}: samples too far apart"])
