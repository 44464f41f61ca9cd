"""The stability study: its settings, what it expects, and short hard scenes that leave the reference stable."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import pytest

from adapters.engine import AccuracyParameter, Setting
from adapters.registry import COMPILED, ENGINES
from barchain.cli.main import run as command
from barchain.runs.cases import Known
from barchain.runs.executors import LocalProcesses
from barchain.runs.job import JUDGING_ROLES, Job, Role, failure
from barchain.studies.stability.plan import (
    HUGE,
    SLOW,
    accept,
    change,
    chosen_engines,
    coarser,
    default_engines,
    hard_scenes,
    recorded,
    settings,
    stability_of,
)
from barchain.studies.stability.rules import Finding
from barchain.studies.stability.study import StabilityStudy, stability_study
from barchain.studies.study import run_study
from reports.chapters.stability import view_stability
from reports.render import render_study
from reports.results.outcome import Outcome
from reports.results.stability import FILES, Stability
from scenarios import load_scene
from tests.support import faulty_engines
from tests.support.stability_engines import FREE, CanNotFollow, registration, scene

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.runs.job import TimeLimit
    from tests.support.faulty_engines import Faulty


def test_coarser_settings_are_coarser_or_none() -> None:
    free = scene(FREE)
    for name, each in default_engines().items():
        main = each.declarations().sweep.setting()
        found = coarser(free, main)
        if found is not None:
            rises = found.value / main.value
            assert rises == (100.0 if main.parameter is AccuracyParameter.RTOL else 0.25), name
    close = dataclasses.replace(free, run=dataclasses.replace(free.run, samples=100_001))
    assert coarser(close, Setting(AccuracyParameter.STEPS_PER_ORBIT, 1000.0)) is None


def test_scipy_runs_at_its_own_default_tolerances_too() -> None:
    roles = {name: settings(scene(FREE), name, r.declarations()) for name, r in default_engines().items()}
    assert {name for name, by in roles.items() if Role.PLAIN in by} == {"scipy-dop853", "scipy-radau"}


@pytest.mark.skipif(ENGINES[COMPILED].missing is not None, reason="needs the compiled reference")
def test_recorded_time_outs_and_long_runs_in_numpy_are_left_to_a_full_study_or_to_a_named_engine() -> None:
    def long_runs(**options: Any) -> set[str]:
        plan = stability_study(["hard/whip", FREE], **options)
        assert plan.engines_of(plan.scenes[1]) == plan.engines
        return set(plan.engines_of(plan.scenes[0]))

    assert recorded()["hard/whip", "exudyn"] == SLOW
    late = {"reference", "reference-absolute", "exudyn"}
    assert not late & long_runs()
    assert {COMPILED, "exudyn-tree"} <= long_runs()
    assert late <= long_runs(full=True)
    many = stability_study(["hard/bars_1000", "hard/bars_100"]).left_out
    assert ("hard/bars_1000", "heyoka") in many
    assert ("hard/bars_100", "heyoka") not in many
    assert long_runs(engines=["reference"]) == {"reference"}


def found_as(word: str) -> Finding:
    """Finding as it would be recorded by a word."""
    return Finding(stability_of(word), slow=word == SLOW)


@pytest.mark.parametrize(
    ("before", "now", "direction"),
    [
        ("stable", "stable", None),
        ("stable", "unstable", "worse"),
        ("failed", "drifting", "better"),
        ("stable", SLOW, "worse"),
        ("failed", SLOW, None),
        (SLOW, "stable", None),
        (SLOW, "failed", None),
        (None, "failed", None),
    ],
)
def test_a_change_either_way_is_told_and_time_outs_alone_are_none(
    before: str | None, now: str, direction: str | None
) -> None:
    found = change("hard/x", "exudyn", before, found_as(now))
    assert (found.direction if found else None) == direction
    assert not found or f"{before} before, {now} now" in found.words


def test_what_is_accepted_is_what_is_expected(tmp_path: Path) -> None:
    path = tmp_path / "expected.toml"
    accept({("hard/a", "exudyn"): found_as("drifting"), ("hard/b", "pymunk"): found_as(SLOW)}, path)
    accept({("hard/a", "exudyn"): found_as("stable")}, path)
    assert recorded(path) == {("hard/a", "exudyn"): "stable", ("hard/b", "pymunk"): SLOW}


def test_what_is_recorded_is_of_scenes_and_engines_that_are_there() -> None:
    scenes = set(hard_scenes())
    for (name, engine), word in recorded().items():
        assert name in scenes or HUGE in load_scene(name).tags
        assert engine in ENGINES
        assert stability_of(word) in Stability


@pytest.mark.exhaustive
def test_an_engine_that_can_not_follow_is_left_out_and_no_engine_is_run_without_hope(tmp_path: Path) -> None:
    faulty: dict[str, type[Faulty]] = {"can-not-follow": CanNotFollow, "hangs": faulty_engines.Hangs}
    plan = StabilityStudy(
        (scene(FREE),), {n: registration(e) for n, e in faulty.items()}, time_limit_s=1.0, executor=LocalProcesses(1)
    )
    result = run_study(plan, tmp_path)
    follows = result.findings[FREE, "can-not-follow"]
    assert follows.stability is Stability.UNSUPPORTED
    assert "are too many for me" in follows.reason
    late = result.findings[FREE, "hangs"]
    assert (late.stability, late.slow) == (Stability.FAILED, True)
    assert late.reason.startswith("not run: the coarse setting already took longer than 1 s")
    assert result.passed


def ours() -> Iterable[str]:
    """Both forms of the reference, where they are there."""
    return [name for name in ("reference", "reference-fast") if ENGINES[name].missing is None]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a small study, run as a user would."""
    out = tmp_path_factory.mktemp("stability")
    named = [word for name in (*ours(), "scipy-dop853") for word in ("--engine", name)]
    few = ["--workers", "1", "--out", str(out)]  # the runs are short: starting processes takes longer
    assert command(["stability", "hard/vertical_fall", "hard/slews_overlapping", *named, *few]) == 0
    return out


@pytest.mark.slow
def test_ours_are_stable_in_short_hard_scenes(folder: Path) -> None:
    tables = FILES.contents(folder)
    own = tables.outcomes[tables.outcomes.engine.isin(list(ours()))]
    assert len(own) == 2 * len(list(ours()))
    assert set(own.stability) == {"stable"}
    assert tables.record["finished"]
    assert not view_stability(folder).unstable
    text = render_study("stability", folder).page.read_text(encoding="utf-8")
    for words in ("stable in all 2 hard scenes", "a bar reached the surface", "SciPy at its defaults"):
        assert words in text, words


@pytest.mark.slow
def test_scipy_at_its_defaults_reports_success_and_is_told_on(folder: Path) -> None:
    plain = FILES.contents(folder).plain.set_index("scene")
    assert set(plain.run) == {"pass"}
    assert plain.attitude_rad["hard/slews_overlapping"] > 1e-4  # it asks for 1e-3 a step
    assert view_stability(folder).wrong["succeeded"] == 2


def test_forms_of_the_reference_get_ten_times_as_long_as_other_engines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    allowed_s: dict[str, float] = {}

    def noted(job: Job, limit: TimeLimit, **_: object) -> Known:
        if job.role not in JUDGING_ROLES:
            allowed_s[job.engine] = limit.time_s
        return Known(failure(Outcome.FAILED, "not run here"))

    monkeypatch.setattr("barchain.studies.stability.study.run_task", noted)
    plan = StabilityStudy(
        (load_scene("hard/vertical_fall"),), chosen_engines(["reference", "exudyn"]), time_limit_s=7.0
    )
    run_study(plan, tmp_path)
    assert allowed_s == {"reference": 70.0, "exudyn": 7.0}


@pytest.mark.exhaustive
@pytest.mark.timeout(0)  # an hour on two cores
def test_ours_are_stable_in_all_hard_scenes_and_nothing_changed(tmp_path: Path) -> None:
    scenes = tuple(load_scene(name) for name in hard_scenes())
    result = run_study(StabilityStudy(scenes, default_engines()), tmp_path)
    assert not result.ours
    assert not result.changes
