"""Round-off with the noise to declare, the time of the physics, and what is judged after a failure without a name."""

from __future__ import annotations

import dataclasses
import re
import time
from typing import TYPE_CHECKING

import pytest

from barchain.conform import physics
from barchain.conform.checks import FAILED, NOT_RUN, PASSED, Check
from barchain.conform.scenes import STAGES, TOGETHER
from barchain.conform.target import Examined, examined
from barchain.runs.job import Role, failure
from reports.results.outcome import Outcome
from tests.support.kernel import needs_kernel

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = needs_kernel
NAME = "conform/three_bars_gradient"


def checked(engine: str) -> Check:
    """Check of a wrong engine on one scene."""
    given = examined(f"tests.conform.wrong_engines:{engine}")
    return physics.scene_check(given, NAME, physics.main_and_finer(given, [NAME])[NAME])


def test_errors_of_the_size_of_rounding_are_told_with_the_noise_to_declare() -> None:
    found = checked("Rounding")
    assert found.state is FAILED
    assert not found.stops
    declared = re.search(r"Round-off.* declare `noise` of com = (\S+)", found.words)
    assert declared is not None
    assert 1e-6 < float(declared[1]) < 1e-4


@pytest.mark.slow
def test_noise_that_is_declared_passes() -> None:
    assert checked("DeclaredRounding").state is not FAILED


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["LargeRounding", "SharedRounding"])
def test_larger_errors_and_those_that_two_settings_share_are_no_rounding(engine: str) -> None:
    found = checked(engine)
    assert found.state is FAILED
    assert found.stops
    assert "Round-off" not in found.words


def stages_with(
    monkeypatch: pytest.MonkeyPatch, *, explained: bool = False, stops: bool = True, first: str = "with one effect"
) -> list[Check]:
    """Checks of two stages of one scene each, of which the first fails."""

    def made(_: Examined, names: list[str], *__: object) -> Iterator[Check]:
        for name in names:
            failed = name == "a"
            yield Check(name, FAILED if failed else PASSED, explained=failed and explained, stops=not failed or stops)

    monkeypatch.setattr(physics, "stage_checks", made)
    monkeypatch.setattr(physics, "reason_against", lambda *_: None)
    monkeypatch.setattr(physics, "main_and_finer", lambda _, names: {name: {} for name in names})
    return list(physics.physics(examined("reference-fast"), {first: ("a",), TOGETHER: ("b",)}))


def test_effects_together_are_judged_where_failures_of_effects_alone_have_no_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert stages_with(monkeypatch)[-1].state is PASSED
    assert stages_with(monkeypatch, explained=True)[-1].state is NOT_RUN
    assert stages_with(monkeypatch, first="in gravity")[-1].state is NOT_RUN
    assert stages_with(monkeypatch, first="in gravity", stops=False)[-1].state is PASSED


def test_scenes_for_which_no_time_is_left_fail_with_that_reason() -> None:
    engine = dataclasses.replace(examined("reference-fast"), end=time.monotonic())
    found = list(physics.physics(engine, {"in gravity": (NAME,)}))
    assert [c.state for c in found] == [FAILED]
    assert "no time is left" in found[0].words
    assert "--time-limit" in found[0].words


def test_a_scene_that_hangs_costs_its_own_limit_and_is_told_by_its_name() -> None:
    said: list[str] = []
    given = examined("tests.conform.wrong_engines:HangsInOneScene")
    engine = dataclasses.replace(given, run_s=2.0, note=said.append)
    names = [f"conform/{name}_free" for name in ("one_bar", "two_bars", "three_bars")]
    made = physics.main_and_finer(engine, names)
    assert [{run.outcome for run in made[name].values()} for name in names] == [
        {Outcome.PASS}, {Outcome.TIMED_OUT}, {Outcome.PASS},
    ]  # fmt: skip
    assert len(made[names[1]]) == 2
    assert sum(names[1] in line for line in said) == 1
    assert not any(name in line for name in (names[0], names[2]) for line in said)


def test_after_several_late_scenes_no_further_part_begins_and_its_scenes_say_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    late = dict.fromkeys((Role.MAIN, Role.FINER), failure(Outcome.TIMED_OUT, "no result"))
    monkeypatch.setattr(physics, "main_and_finer", lambda _, names: dict.fromkeys(names, late))
    monkeypatch.setattr(physics, "collapse", lambda *_: "")
    names = tuple(name for stage in list(STAGES.values())[:3] for name in stage)
    found = list(physics.physics(examined("reference-fast"), {"some": names}))
    states = [check.state for check in found]
    assert physics.MOST_LATE <= states.count(FAILED) < len(names)
    assert states.count(NOT_RUN) == len(names) - states.count(FAILED)
    assert all("are late" in check.words for check in found if check.state is NOT_RUN)
