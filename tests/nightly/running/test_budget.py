"""The budget: jobs share the time that is left, and take on what is known to fit."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from barchain.nightly.running.budget import (
    ENDING_S,
    FAVOURED,
    LEAST_RESERVE_S,
    LEAST_S,
    fitting,
    last_of,
    leftovers,
    limit_s,
    running_s,
    waiting_parts,
    working_time_s,
)
from barchain.nightly.running.jobs import NightJob, night_jobs, part_scenes
from barchain.nightly.running.plan import LEAST_MINUTES, load_plan
from barchain.nightly.running.state import joined
from reports.results.nights.document import NightRun, PartResult, PartState

if TYPE_CHECKING:
    from barchain.nightly.running.plan import NightPlan

SCENES = tuple(f"hard/{k}" for k in range(10))


def job(share: float = 1.0) -> NightJob:
    return NightJob("hard", "hard", "stability", share, ("stability",), SCENES)


@given(st.floats(LEAST_MINUTES, 1440.0))
def test_the_jobs_leave_time_for_judging_and_telling(minutes: float) -> None:
    assert 0.8 * 60.0 * minutes <= working_time_s(minutes) <= 60.0 * minutes - LEAST_RESERVE_S


@given(st.lists(st.floats(0.1, 100.0), min_size=1, max_size=8), st.floats(1.0, 1e4))
def test_jobs_that_use_all_of_their_time_end_with_the_budget(shares: list[float], time_s: float) -> None:
    jobs, left = [job(share) for share in shares], time_s
    for k, one in enumerate(jobs):
        left -= limit_s(one, jobs[k + 1 :], left)
    assert abs(left) < 1e-9 * time_s


def test_a_job_takes_on_the_scenes_that_fit_at_the_pace_of_the_last_night() -> None:
    did = PartResult("hard", PartState.DONE, 100.0, 100.0, done=10)
    assert last_of("hard", NightRun("plan", 15.0, (did,))) is did
    assert fitting(job(), 50.0, did).scenes == SCENES[:4]


def test_a_job_takes_on_as_many_scenes_as_the_last_night_did_in_the_same_time() -> None:
    assert fitting(job(), 38.0, PartResult("hard", PartState.DONE, 45.0, 37.0, done=3)).scenes == SCENES[:3]


def test_a_job_takes_on_at_least_one_scene_and_all_where_no_pace_is_known() -> None:
    assert fitting(job(), 1.0, PartResult("hard", PartState.DONE, 1000.0, 1000.0, done=1)).scenes == SCENES[:1]
    assert fitting(job(), 1.0, None) == job()
    assert fitting(replace(job(), waits=True), 100.0, None).scenes == SCENES[:1]  # nothing of it was ever done
    assert last_of("hard", None) is None
    assert last_of("other", NightRun("plan", 15.0, (PartResult("hard", PartState.FAILED, 1.0, 1.0),))) is None


def test_a_part_that_waits_gets_enough_to_begin_and_the_one_whose_turn_it_is_gets_most() -> None:
    waits = replace(job(), waits=True)
    assert limit_s(waits, [job(100.0)], 50.0) == LEAST_S
    assert limit_s(replace(waits, favoured=True), [job(100.0)], 50.0) == FAVOURED * 50.0
    assert limit_s(waits, [job(100.0)], 1.0) == 1.0


def test_a_job_is_interrupted_so_early_that_it_ends_within_its_time() -> None:
    assert running_s(100.0) == 100.0 - ENDING_S
    assert LEAST_S > running_s(LEAST_S) >= 4.0


def test_a_night_that_ended_before_a_part_began_says_nothing_of_the_time_that_the_part_needs() -> None:
    parts = (
        PartResult("tried", PartState.LEFT, 6.0, 6.0, ("a",), "interrupted at its limit of 6 s"),
        PartResult("starved", PartState.LEFT, 1.0, 0.0, ("b",), "no time was left"),
        PartResult("cut", PartState.LEFT, 0.0, 0.0, ("c",), "the night was interrupted", begun=False),
        PartResult("going", PartState.LEFT, 9.0, 9.0, ("d",), "more scenes than fit", 2),
        PartResult("broken", PartState.FAILED, 9.0, 9.0, (), "an error"),
    )
    assert waiting_parts(NightRun("plan", 1.0, parts)) == ["tried", "starved"]
    assert waiting_parts(None) == []


COSTS_S = {"alarm": 4.0, "core": 3.0, "cost": 12.0, "memory": 20.0, "hard": 8.0, "roundoff": 27.0}
"""Time of a scene, or of a whole part without scenes, with a part's start"""


def simulated(plan: NightPlan, minutes: float, last: NightRun | None) -> tuple[NightRun, dict[str, list[str]]]:
    """One night of known costs, and the scenes that each part did, or its name."""
    turn, left_s, done = (last.turn + 1 if last else 0), working_time_s(minutes), {}
    results: dict[str, PartResult] = {}
    jobs = night_jobs(plan, turn, leftovers(last), waiting_parts(last))
    for k, one in enumerate(jobs):
        time_s = limit_s(one, jobs[k + 1 :], left_s)
        taken = fitting(one, running_s(time_s), last_of(one.part, last))
        beyond = one.scenes[len(taken.scenes) :]
        fit = int(running_s(time_s) / COSTS_S[one.part]) if time_s >= LEAST_S else 0
        finished = list(taken.scenes[:fit]) if one.scenes else [one.part] * min(fit, 1)
        rest = (*taken.scenes[fit:], *beyond) if one.scenes else (one.part,) * (not fit)
        used = min(COSTS_S[one.part] * (len(taken.scenes) or 1), time_s) if time_s >= LEAST_S else 0.0
        state = PartState.LEFT if rest else PartState.DONE
        result = PartResult(one.part, state, time_s, used, rest, "", len(finished))
        results[one.part] = joined(results[one.part], result) if one.part in results else result
        done.setdefault(one.part, []).extend(finished)
        left_s -= used
    return NightRun("plan", minutes, tuple(results.values()), None, turn), done


@pytest.mark.slow
def test_every_part_and_every_scene_comes_to_its_turn_also_in_short_nights() -> None:
    plan = load_plan()
    scenes = {name for part in plan.file.comparison for name in part_scenes(part, plan.folder)}
    runs: list[NightRun] = []
    done: dict[str, set[str]] = {}
    for _ in range(16):
        last, tonight = simulated(plan, 2.0, runs[-1] if runs else None)
        runs.append(last)
        for name, items in tonight.items():
            done.setdefault(name, set()).update(items)
    assert all(done[name] for name in COSTS_S), done
    assert done["core"] == scenes
