"""The test of the alarm and parts that were interrupted: a missed fault makes a night void, what was judged is done."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

import pytest

from barchain.nightly.running.jobs import NightJob
from barchain.nightly.running.night import result_of
from barchain.nightly.running.state import alarm_test
from barchain.runs.processes import Finished
from barchain.studies.selftest.faults.catalogue import CONTROLS
from barchain.studies.selftest.matrix import selftest_study
from barchain.studies.study import Reporter, run_study
from reports.results import comparison
from reports.results.nights.document import AlarmTest, PartState
from reports.results.selftest import FILES
from tests.nightly.history.synthetic import night
from tests.support.here import HERE
from tests.support.results import write_results

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

SCENES = ("basics/a", "basics/b")
JOB = NightJob("alarm", "alarm", "selftest", 1.0, ("selftest",), (), 4)


def selftest(folder: Path, *cells: tuple[str, str, str], complete: bool) -> Path:
    """Folder of a self-test with some cells: fault, scene and fate."""
    rows = [{"fault": fault, "scene": scene, "fate": fate} for fault, scene, fate in cells]
    record = {"complete": complete, "scenes": {name: {} for name in SCENES}}
    return write_results(folder, FILES, {"fates": rows}, record)


def everywhere(fault: str, fate: str) -> list[tuple[str, str, str]]:
    return [(fault, scene, fate) for scene in SCENES]


def test_a_fault_that_survives_an_interrupted_self_test_makes_the_night_void(tmp_path: Path) -> None:
    folder = selftest(tmp_path, *everywhere("cut", "killed"), *everywhere("length", "survives"), complete=False)
    found = alarm_test(folder)
    assert found is not None
    assert found.void == "1 of 2 planted faults missed: length"


def test_a_fault_that_an_interrupted_self_test_did_not_try_in_all_scenes_does_not_count(tmp_path: Path) -> None:
    folder = selftest(tmp_path, *everywhere("cut", "killed"), ("length", "basics/a", "survives"), complete=False)
    assert alarm_test(folder) == AlarmTest(1)


def test_an_alarm_that_planted_nothing_is_a_failed_part_and_not_a_silent_one(tmp_path: Path) -> None:
    folder = selftest(tmp_path, *everywhere("cut", "not applicable"), complete=True)
    result = result_of(JOB, JOB, 10.0, Finished(0, 1.0), folder)
    assert (result.state, result.done) == (PartState.FAILED, 0)
    assert result.reason == "no fault was inserted: the alarm was not tried"


def test_an_interrupted_alarm_counts_the_faults_that_it_tried(tmp_path: Path) -> None:
    folder = selftest(tmp_path, *everywhere("cut", "killed"), ("length", "basics/a", "killed"), complete=False)
    result = result_of(JOB, JOB, 10.0, Finished(None, 10.0), folder)
    assert (result.state, result.done, result.left) == (PartState.LEFT, 1, ("alarm",))


@pytest.mark.parametrize("count", [40, 1000])
def test_a_night_that_misses_many_faults_names_some_and_counts_the_others(count: int) -> None:
    names = tuple(f"a-fault-with-a-rather-long-name-{k}" for k in range(count))
    said = AlarmTest(count, names).void
    assert said is not None
    assert said.endswith(f"missed: {names[0]}, {names[1]}, {names[2]} and {count - 3} more")
    assert night(void=said).void == said
    assert night(void=AlarmTest(1, (), 0, ("s" * 500,) * count).void).void


def test_an_interrupted_self_test_keeps_the_cells_that_it_has(tmp_path: Path) -> None:
    @contextlib.contextmanager
    def counted(what: str, total: int) -> Iterator[Callable[[int], None]]:
        def done(number: int) -> None:
            if what == "faults":
                raise KeyboardInterrupt

        yield done

    study = selftest_study(["basics/two_bars_free"], ["sign-reaction"], executor=HERE)
    with pytest.raises(KeyboardInterrupt):
        run_study(study, tmp_path, reporter=Reporter(counted=counted))
    (kept,) = FILES.contents(tmp_path).fates["fault"]
    assert kept in CONTROLS  # the first that ended: unmodified engines are tried before any fault


COMPARED = NightJob("core", "core", "comparison", 1.0, ("compare",), SCENES, 0)


@pytest.mark.parametrize(("judged", "state", "left"), [(2, PartState.DONE, ()), (1, PartState.LEFT, ("basics/b",))])
def test_a_part_is_done_once_all_of_it_was_judged_whatever_was_cut(
    judged: int, state: PartState, left: tuple[str, ...], tmp_path: Path
) -> None:
    rows = [
        {"scene": scene, "engine": "exudyn", "metric": "verdict", "outcome": "pass", "quantity": "run"}
        for scene in SCENES[:judged]
    ]
    record = {"complete": False, "scenes": {name: {} for name in SCENES}, "engines": {"exudyn": {}}}
    folder = write_results(tmp_path / "core", comparison.FILES, {"metrics": rows}, record)
    result = result_of(COMPARED, COMPARED, 10.0, Finished(None, 10.0), folder)
    assert (result.state, result.left) == (state, left)
