"""The judgement of a gate: what is worse and not listed closes it, and nothing else does."""

from __future__ import annotations

import dataclasses
import datetime
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from barchain.nightly.errors import HistoryError, PinnedEnvironmentError
from barchain.nightly.figures.figure import NightPart
from barchain.nightly.figures.steps import discoveries, step_between
from barchain.nightly.gate.judging import judged_gate
from barchain.nightly.gate.known import KnownFailure, known_failures
from barchain.nightly.gate.measuring import SceneTimes, least_rounds
from reports.nightly.summary import gate_comment
from tests.nightly.history.synthetic import ENVIRONMENT, PARTS, bits, count, error, night, verdict

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.figures.figure import Figure, Night
    from reports.results.nights.gate import GateResult

BASE = (verdict(), error(), count(), bits())
TODAY = datetime.datetime.now(datetime.UTC).date()
DAY = datetime.timedelta(days=1)
RANDOM = np.random.default_rng(5)


def judged(
    *head: Figure, known: tuple[KnownFailure, ...] = (), times: dict[str, SceneTimes] | None = None, asked: int = 1
) -> GateResult:
    parts = (NightPart("engine:mujoco", "3.4.0", "ab"), *PARTS[1:])
    nights = night(*BASE), night(*head, number=1, parts=parts)
    return judged_gate("mujoco", ("mujoco==1", "mujoco==2"), nights, times or {}, known, asked)


def known(pattern: str = "*:attitude.max", **more: Any) -> KnownFailure:
    return KnownFailure(pattern=pattern, reason="looser tolerance", **more)


def turns(factor: float, rounds: int = 10, noise: float = 0.02) -> dict[str, SceneTimes]:
    base, head = (size * np.exp(RANDOM.normal(0.0, noise, rounds)) for size in (0.1, 0.1 * factor))
    return {"paper/fig05": SceneTimes((base.tolist(), head.tolist()), ({"00ff"}, {"00ff"}))}


WORSE = (verdict(), error(3e-5), count(), bits())


def test_equal_builds_open_the_gate_and_the_first_line_says_so() -> None:
    result = judged(*BASE)
    assert not result.failed
    assert gate_comment(result).startswith("### Nothing is worse, among 4 figures.\n")


def test_an_error_beyond_rounding_closes_the_gate() -> None:
    result = judged(*WORSE)
    assert result.failed
    comment = gate_comment(result)
    assert comment.startswith("### One figure is worse in one scene, among 4 figures.\n")
    assert "1000:attitude.max | 1e-5 rad | 3e-5 rad | ×3 |" in comment


def test_an_error_within_rounding_is_not_told() -> None:
    result = judged(verdict(), error(1e-5 + 1e-12), count(), bits())
    assert (result.worse, result.better, result.changed) == ((), (), ())


def test_other_bits_and_counts_are_told_and_close_nothing() -> None:
    result = judged(verdict(), error(), count(1200.0), bits("ee11"))
    assert not result.failed
    assert [entry.quantity for entry in result.changed] == ["steps"]
    assert "Trajectories have other bits in 1 of 1 scenes." in result.notes


def test_a_known_failure_lets_its_figure_pass_and_stands_in_the_comment() -> None:
    result = judged(*WORSE, known=(known(until=TODAY + DAY),))
    assert not result.failed
    comment = gate_comment(result)
    assert comment.startswith("### Nothing is worse but one figure that is known, among 4 figures.\n")
    assert "looser tolerance" in comment


def test_a_known_failure_lets_the_figures_of_its_pattern_pass_which_without_a_colon_is_of_a_scene() -> None:
    assert not judged(*WORSE, known=(known("paper/*"),)).failed
    assert judged(*WORSE, known=(known("basics/*"),)).failed
    assert judged(*WORSE, known=(known("*:verdict"),)).failed


@pytest.mark.parametrize("head", [BASE, WORSE])
def test_a_known_failure_past_its_day_closes_the_gate_whatever_the_figure_does(head: tuple[Figure, ...]) -> None:
    result = judged(*head, known=(known(until=TODAY),))
    assert result.failed
    assert f"looser tolerance (ended on {TODAY})" in result.ended[0]
    assert "one known failure ended" in result.answer


def test_a_known_failure_that_fails_no_more_is_told_and_closes_nothing() -> None:
    result = judged(*BASE, known=(known(), known("basics/*"), known(until=TODAY + DAY)))
    assert not result.failed
    assert len(result.passing) == 2  # nothing is known of the scene that was not run


def test_a_known_failure_of_a_verdict_that_was_and_is_wrong_is_not_told_to_pass() -> None:
    wrong = verdict("inconsistent", reason="off")
    other = dataclasses.replace(verdict(), identity=dataclasses.replace(verdict().identity, scene="paper/fig13"))
    nights = night(wrong, other), night(wrong, other, number=1)
    result = judged_gate("mujoco", ("a", "b"), nights, {}, (known("paper/fig05"),), 2)
    assert (result.failed, result.passing) == (False, ())


def test_times_that_grew_close_the_gate_and_shorter_ones_do_not() -> None:
    slower, faster = judged(*BASE, times=turns(1.2)), judged(*BASE, times=turns(0.8))
    assert [entry.quantity for entry in slower.worse] == ["time"]
    assert (faster.failed, [entry.quantity for entry in faster.better]) == (False, ["time"])
    low, high = slower.worse[0].factor_low, slower.worse[0].factor_high
    assert low is not None
    assert high is not None
    assert low < 1.2 < high


def test_too_few_rounds_are_told_and_judge_nothing() -> None:
    result = judged(*BASE, times=turns(2.0, least_rounds(1) - 1))
    assert not result.failed
    assert any(words.startswith("Times were not judged: 4 rounds of 5") for words in result.notes)


def test_runs_that_the_head_alone_does_not_reproduce_close_the_gate() -> None:
    times = turns(1.0)
    times["paper/fig05"].bits[1].add("ee11")
    assert [entry.irreproducible for entry in judged(*BASE, times=times).worse] == [True]
    times["paper/fig05"].bits[0].add("ee11")
    assert not judged(*BASE, times=times).failed


def test_scenes_that_had_no_time_stand_in_the_first_line() -> None:
    assert judged(*BASE, asked=3).answer == "Nothing is worse, among 4 figures; two scenes had no time."


def test_builds_on_two_processors_are_refused() -> None:
    other = night(*BASE, number=1, environment=dataclasses.replace(ENVIRONMENT, cpu="Other CPU"))
    with pytest.raises(PinnedEnvironmentError, match=r"different processors \(Example CPU, Other CPU\)"):
        judged_gate("mujoco", ("a", "b"), (night(*BASE), other), {}, (), 1)


def test_a_base_that_passes_nothing_is_refused() -> None:
    base: Night = night(verdict("failed", reason="no module"), bits())
    with pytest.raises(PinnedEnvironmentError, match=r"a: passes no scene, .*paper/fig05: failed, no module"):
        judged_gate("mujoco", ("a", "b"), (base, night(*BASE, number=1)), {}, (), 1)


def test_equal_groups_hardly_ever_differ_and_a_tenth_more_is_found() -> None:
    """At most the declared share of gates with four equal series tells a step; noise is 2 %."""

    def told(shift: float) -> bool:
        groups = [RANDOM.normal(0.0, 0.02, (2, 12)) for _ in range(4)]
        groups[0][1] += shift
        return bool(discoveries([step_between(old, new) for old, new in groups]))

    tries = 300
    alarms = sum(told(0.0) for _ in range(tries))
    assert alarms <= 9  # of 300 at 1 in 120 more than 9 have a probability of 2e-4
    assert sum(told(np.log(1.1)) for _ in range(50)) >= 48


def test_a_file_of_known_failures_is_read_with_its_faults_by_line(tmp_path: Path) -> None:
    file = tmp_path / "known_failures.toml"
    assert known_failures(file) == ()
    file.write_text('[[failure]]\npattern = "paper/*"\nreason = "soft joints"\nuntil = 2031-01-02\n', "utf-8")
    assert known_failures(file)[0].words == "paper/*: soft joints (until 2031-01-02)"
    file.write_text('[[failure]]\npattern = "paper/*"\nreasn = "soft joints"\n', "utf-8")
    with pytest.raises(HistoryError, match=r"reasn.*did you mean reason"):
        known_failures(file)
    file.write_text("[[failure", "utf-8")
    with pytest.raises(HistoryError, match="not valid TOML"):
        known_failures(file)
