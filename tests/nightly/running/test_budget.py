"""The budget: jobs share the time that is left, and take on what is known to fit."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from barchain.nightly.plan.jobs import NightJob
from barchain.nightly.plan.tables import LEAST_MINUTES
from barchain.nightly.run_facts import NightRun, PartResult, PartState
from barchain.nightly.running.budget import LEAST_RESERVE_S, fitting, limit_s, pace_s, working_time_s

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


def test_time_that_a_job_did_not_use_goes_to_the_later_ones() -> None:
    first, second = job(), job()
    assert limit_s(first, [second], 100.0) == 50.0
    assert limit_s(second, [], 90.0) == 90.0


def test_a_job_takes_on_the_scenes_that_fit_at_the_pace_of_the_last_night() -> None:
    last = NightRun("plan", 15.0, (PartResult("hard", PartState.DONE, 100.0, 100.0, done=10),))
    assert pace_s("hard", last) == 10.0
    taken, left = fitting(job(), 50.0, 10.0)
    assert (taken.scenes, left) == (SCENES[:4], SCENES[4:])


def test_a_job_takes_on_at_least_one_scene_and_all_where_no_pace_is_known() -> None:
    assert fitting(job(), 1.0, 1000.0)[0].scenes == SCENES[:1]
    assert fitting(job(), 1.0, None) == (job(), ())
    assert pace_s("hard", None) is None
    assert pace_s("other", NightRun("plan", 15.0, (PartResult("hard", PartState.FAILED, 1.0, 1.0),))) is None
