"""Parts whose process was interrupted at its limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from barchain.nightly.running.jobs import NightJob
from barchain.nightly.running.night import result_of
from barchain.runs.processes import Finished
from reports.results.comparison import FILES
from reports.results.nights.document import PartState
from tests.support.results import write_results

if TYPE_CHECKING:
    from pathlib import Path

SCENES = ("basics/a", "basics/b")
JOB = NightJob("core", "core", "comparison", 1.0, ("compare",), SCENES, 0)


@pytest.mark.parametrize(("judged", "state", "left"), [(2, PartState.DONE, ()), (1, PartState.LEFT, ("basics/b",))])
def test_a_part_is_done_once_all_of_it_was_judged_whatever_was_cut(
    judged: int, state: PartState, left: tuple[str, ...], tmp_path: Path
) -> None:
    rows = [
        {"scene": scene, "engine": "exudyn", "metric": "verdict", "outcome": "pass", "quantity": "run"}
        for scene in SCENES[:judged]
    ]
    record = {"complete": False, "scenes": {name: {} for name in SCENES}, "engines": {"exudyn": {}}}
    folder = write_results(tmp_path / "core", FILES, {"metrics": rows}, record)
    result = result_of(JOB, JOB, 10.0, Finished(None, 10.0), folder)
    assert (result.state, result.left) == (state, left)
