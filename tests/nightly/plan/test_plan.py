"""A plan says what each night does: errors name the key, scenes and faults rotate, what was left goes first."""

from __future__ import annotations

import os
import shlex
from typing import TYPE_CHECKING

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from barchain.cli.main import cli, run
from barchain.nightly.running.jobs import night_jobs, tonights
from barchain.nightly.running.plan import PlanError, SelftestTable, load_plan
from barchain.studies.selftest.faults.catalogue import FIXED_SCENES
from scenarios.load import SHIPPED

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.running.plan import NightPlan

CORE = '[[comparison]]\nname = "core"\n'


def plan_of(folder: Path, text: str) -> NightPlan:
    path = folder / "plan.toml"
    path.write_text(f'name = "own"\n{text}', "utf-8")
    return load_plan(path)


def test_the_shipped_plan_has_every_part_that_a_night_needs() -> None:
    plan = load_plan()
    jobs = night_jobs(plan, 0, {})
    assert [job.study for job in jobs] == ["selftest", "comparison", "cost", "scaling", "stability", "roundoff"]
    assert plan.file.minutes == 15
    assert jobs[0].items >= 20
    assert len(plan.file.cost[0].scenes) == 2
    assert plan.file.stability[0].nights == 7
    assert len(plan.file.roundoff[0].sizes) == 3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[[comparison]]\nname = "core"\nscene = ["paper/fig05"]', "did you mean scenes"),
        ('[[comparison]]\nname = "logs"', "folder of the night's logs"),
        (f"{CORE}engines = []", "empty list"),
        (f'{CORE}engines = ["pymunk"]\nsettings = {{ exudyn = {{ steps_per_orbit = 2000 }} }}', "engines of the part"),
        ('[[comparison]]\nname = "Core!"', "name"),
        (f"{CORE}share = -1", "greater than 0"),
        (f"{CORE}{CORE}", "more than once"),
        ("", "no parts"),
        (f"minutes = 0.2\n{CORE}", "at least 0.5"),
        (f'{CORE}[[campaign]]\nname = "random"\nscenes = 4', "run `python benchmarks/random_scenes.py N --seed K`"),
    ],
)
def test_a_faulty_plan_is_told_with_its_key_and_the_nearest_name(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(PlanError, match=r"plan\.toml") as told:
        plan_of(tmp_path, text)
    assert said in str(told.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f'{CORE}scenes = ["paper/fig5"]', "did you mean paper/fig05"),
        (f'{CORE}scenes = ["papers/*"]', "fits none"),
        (f'{CORE}engines = ["exudym"]', "exudyn"),
        (f"{CORE}settings = {{ exudyn = {{ rtol = 1e-6 }} }}", "steps_per_orbit"),
        ('[[roundoff]]\nname = "r"\nsizes = [3e-4]', "powers of ten"),
        ('[[roundoff]]\nname = "r"\nparts = ["evaluations"]', "evaluation, trajectories"),
    ],
)
def test_names_of_a_plan_are_checked_before_anything_runs(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(PlanError, match=r"plan\.toml: \w+: ") as told:
        night_jobs(plan_of(tmp_path, text), 0, {})
    assert said in str(told.value)


def test_a_plan_that_differs_in_its_minutes_only_is_the_same_plan(tmp_path: Path) -> None:
    assert plan_of(tmp_path, CORE).identity == "own f6ba72b4"  # as in 0.7: its nights go on
    first = plan_of(tmp_path, f"minutes = 5\n{CORE}").identity
    assert plan_of(tmp_path, f"minutes = 50\n{CORE}").identity == first
    assert plan_of(tmp_path, f"minutes = 5\n{CORE}share = 2").identity != first


@given(st.lists(st.integers(), unique=True, max_size=40), st.integers(1, 12), st.integers(0, 100))
def test_every_scene_is_done_once_in_as_many_nights_as_the_plan_says(
    scenes: list[int], nights: int, first: int
) -> None:
    names = [str(scene) for scene in scenes]
    done = [name for turn in range(first, first + nights) for name in tonights(names, nights, turn)]
    assert sorted(done) == sorted(names)


@given(st.integers(1, 150), st.integers(0, 50), st.integers(0, 1000))
def test_faults_rotate_until_all_were_planted(count: int, turn: int, seed: int) -> None:
    part = SelftestTable(name="alarm", faults=count, seed=seed)
    each = min(count, len(FIXED_SCENES))
    nights = -(-len(FIXED_SCENES) // each)
    drawn = [part.tonights(FIXED_SCENES, k) for k in range(turn, turn + nights)]
    assert all(len(set(faults)) == each for faults in drawn)
    assert {fault for faults in drawn for fault in faults} == set(FIXED_SCENES)


def test_scenes_that_were_left_are_a_job_of_their_own_and_go_before_all_parts_but_the_alarm(tmp_path: Path) -> None:
    text = (
        f'{CORE}scenes = ["paper/fig05", "paper/fig13"]\n[[stability]]\nname = "hard"\nnights = 7\n'
        '[[selftest]]\nname = "alarm"'
    )
    plan = plan_of(tmp_path, text)
    jobs = night_jobs(plan, 0, {"hard": ["hard/whip", "hard/folded"], "core": ["paper/fig13"]})
    assert [job.name for job in jobs] == ["alarm", "core-left", "hard-left", "core", "hard"]
    assert jobs[1].scenes == ("paper/fig13",)
    assert jobs[3].scenes == ("paper/fig05",)
    assert jobs[2].scenes == ("hard/whip", "hard/folded")  # in the order in which they wait
    assert "hard/whip" not in jobs[4].scenes


def test_parts_that_wait_come_before_scenes_that_were_left_and_each_has_its_turn(tmp_path: Path) -> None:
    text = (
        f'{CORE}scenes = ["paper/fig05", "paper/fig13"]\n[[cost]]\nname = "cost"\n[[scaling]]\nname = "memory"\n'
        '[[roundoff]]\nname = "roundoff"\nsizes = [1e-4]'
    )
    plan, left = plan_of(tmp_path, text), {"core": ["paper/fig13"], "memory": ["memory"], "roundoff": ["roundoff"]}
    orders = [[j.name for j in night_jobs(plan, turn, left, ["memory", "roundoff"])] for turn in range(4)]
    begins = [["memory", "roundoff"], ["memory", "roundoff"], ["memory", "roundoff"], ["roundoff", "memory"]]
    assert orders == [[*begin, "core-left", "core", "cost"] for begin in begins]
    favoured = [job.name for job in night_jobs(plan, 3, left, ["memory", "roundoff"]) if job.favoured]
    assert favoured == ["roundoff"]


def test_scenes_tagged_huge_are_done_only_where_they_are_named(tmp_path: Path) -> None:
    (all_hard,) = night_jobs(plan_of(tmp_path, '[[stability]]\nname = "hard"'), 0, {})
    assert "hard/bars_10000" not in all_hard.scenes
    named = plan_of(tmp_path, '[[stability]]\nname = "hard"\nscenes = ["hard/bars_10000"]')
    assert night_jobs(named, 0, {})[0].scenes == ("hard/bars_10000",)


def test_a_scene_file_is_looked_for_beside_the_plan(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, f'{CORE}scenes = ["mine.toml"]')
    with pytest.raises(PlanError, match=r"'mine.toml' given, and there is no such file"):
        night_jobs(plan, 0, {})
    (tmp_path / "mine.toml").touch()
    (job,) = night_jobs(plan, 0, {})
    assert job.scenes == (str(tmp_path / "mine.toml"),)


def test_commands_and_scenes_that_were_left_name_files_by_their_path_from_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_bytes((SHIPPED / "basics/two_bars_free.toml").read_bytes())
    plan = plan_of(tmp_path, f'{CORE}scenes = ["paper/fig05", "mine.toml"]')
    for left in ("mine.toml", str(tmp_path / "mine.toml")):  # as earlier versions named it
        first, _ = night_jobs(plan, 1, {"core": [left]})
        assert (first.name, first.scenes) == ("core-left", (str(tmp_path / "mine.toml"),))
        assert " mine.toml --out nights/core" in first.shown(tmp_path / "nights" / "core")


def test_each_job_tells_the_command_that_repeats_it(tmp_path: Path) -> None:
    text = (
        f'{CORE}scenes = ["paper/fig05"]\nengines = ["exudyn"]\nsettings = {{ exudyn = {{ steps_per_orbit = 500.0 }} }}'
    )
    (job,) = night_jobs(plan_of(tmp_path, text), 0, {})
    assert shlex.split(job.shown(tmp_path)) == [
        "barchain", "compare", "--engine", "exudyn", "--set", "exudyn:steps_per_orbit=500", "--time-limit", "120",
        "paper/fig05", "--out",
        os.path.relpath(tmp_path),
    ]  # fmt: skip


def test_the_list_of_a_night_s_commands_makes_no_history(tmp_path: Path) -> None:
    history = tmp_path / "below" / "history"
    done = CliRunner().invoke(cli, ["nightly", "--list", "--history", str(history)])
    assert done.exit_code == 0
    assert "barchain selftest" in done.output
    assert not history.parent.exists()


def test_a_wrong_name_in_a_plan_makes_no_history(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, history = tmp_path / "plan.toml", tmp_path / "nights.sqlite"
    plan.write_text('name = "own"\n' + CORE + 'scenes = ["paper/fig55"]\n', "utf-8")
    words = ["--plan", str(plan), "--history", str(history), "--out", str(tmp_path / "nights")]
    assert run(["nightly", *words]) == 2
    assert "paper/fig05" in capsys.readouterr().err
    assert not history.exists()
    assert not (tmp_path / "nights").exists()


def test_a_run_that_hangs_takes_a_sixth_of_its_part_s_time_at_most(tmp_path: Path) -> None:
    core, more = (f'[[comparison]]\nname = "{name}"\nscenes = ["paper/fig05"]\n' for name in ("core", "more"))
    (core_job, _) = night_jobs(plan_of(tmp_path, f"minutes = 4\n{core}{more}"), 0, {})
    assert core_job.arguments[-2:] == ("--time-limit", "20")


def test_times_of_a_single_engine_are_measured_beside_the_one_that_they_are_relative_to(tmp_path: Path) -> None:
    text = '[[cost]]\nname = "cost"\nscenes = ["paper/fig05"]\nengines = ["mujoco"]\n'
    (job,) = night_jobs(plan_of(tmp_path, text), 0, {})
    assert [job.arguments[k + 1] for k, word in enumerate(job.arguments) if word == "--engine"] == [
        "mujoco", "reference-fast"
    ]  # fmt: skip
