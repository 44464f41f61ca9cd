"""A night that was killed: what it had no time for is no news, on this night or the next one."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from barchain.cli.main import run
from barchain.nightly.figures import dependencies as installed
from barchain.nightly.figures.figure import NightPart
from barchain.nightly.history.judging import judge
from barchain.nightly.history.nights import open_store
from barchain.nightly.running import night as running
from barchain.nightly.running.night import run_night
from barchain.nightly.running.plan import load_plan
from barchain.runs.processes import Finished
from reports.results.comparison import FILES
from reports.results.nights import STATE
from reports.results.nights.document import NightRun, PartState
from reports.results.reading import TABLES
from tests.support.results import write_results

if TYPE_CHECKING:
    from collections.abc import Sequence

    from barchain.nightly.history.levels import JudgedNight
    from barchain.nightly.history.nights import NightStore
    from barchain.nightly.running.plan import NightPlan

FIRST, SECOND = "basics/kepler_circular", "basics/kepler_elliptic"
ENGINES = ("reference", "pymunk")
PLAN = f"""
name = "small"
minutes = 2
[[comparison]]
name = "core"
scenes = ["{FIRST}", "{SECOND}"]
engines = ["{ENGINES[0]}", "{ENGINES[1]}"]
"""
USED_S = 9.0


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of all runs of the plan."""
    folder = tmp_path_factory.mktemp("measured") / "core"
    named = [word for engine in ENGINES for word in ("--engine", engine)]
    assert run(["-q", "compare", *named, FIRST, SECOND, "--workers", "1", "--out", str(folder)]) == 0
    return folder


def plan_in(folder: Path) -> NightPlan:
    (folder / "plan.toml").write_text(PLAN, "utf-8")
    return load_plan(folder / "plan.toml")


def one_night(plan: NightPlan, folder: Path) -> NightStore:
    """A night that begins with a second of its own."""
    time.sleep(1.0 - time.time() % 1.0)
    store = open_store(str(folder / "history"), create=True)
    run_night(plan, 2.0, store, folder / "nights")
    return store


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory, measured: Path) -> list[tuple[JudgedNight, NightRun]]:
    """Two whole nights, one that was killed after half of its runs, and a whole one with another engine."""

    def whole(arguments: Sequence[str], *_: Any, **__: Any) -> Finished:
        out = Path(arguments[arguments.index("--out") + 1])
        shutil.copytree(measured, out, dirs_exist_ok=True)
        return Finished(0, 1.0)

    def half(arguments: Sequence[str], *given: Any, **more: Any) -> Finished:
        whole(arguments, *given, **more)
        out = Path(arguments[arguments.index("--out") + 1])
        found = FILES.contents(out)
        rows = found.tables["metrics"]
        rows = rows[(rows["scene"] == FIRST) | (rows["engine"] == ENGINES[0])]
        record = {name: value for name, value in found.record.items() if name != TABLES} | {"complete": False}
        record["runs"] = [one for one in record["runs"] if one["scene"] == FIRST or one["engine"] != ENGINES[1]]
        write_results(out, FILES, {"metrics": rows}, record | {"finished": False})
        began = (out.parent / STATE).stat().st_mtime
        for path in (p for p in (*out.glob("*"), *out.glob("*/*")) if p.exists()):
            os.utime(path, (began + USED_S, began + USED_S))
        raise SystemError("killed")  # nothing after a kill is run

    real, folder = installed.installed_parts, tmp_path_factory.mktemp("judged")
    plan = plan_in(folder)

    def rebuilt(*given: Any) -> tuple[NightPart, ...]:
        return tuple(NightPart(p.name, "0.0.1", "other") if p.name == "engine:pymunk" else p for p in real(*given))

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(running, "run_barchain", whole)
        one_night(plan, folder)
        one_night(plan, folder)
        patched.setattr(running, "run_barchain", half)
        with pytest.raises(SystemError):
            one_night(plan, folder)
        patched.setattr(running, "run_barchain", whole)
        patched.setattr(installed, "installed_parts", rebuilt)
        store = one_night(plan, folder)
    return [(judge(store, night.name), night.run) for night in store.nights() if night.run is not None]


@pytest.mark.slow
def test_a_killed_night_with_another_engine_at_the_next_call_is_no_news_and_neither_is_the_next_one(
    judged: list[tuple[JudgedNight, NightRun]],
) -> None:
    assert [each.night.complete for each, _ in judged] == [True, True, False, True]
    killed, after = judged[2][0], judged[3][0]
    assert (killed.tonight, after.tonight) == ((), ())
    assert after.judged > killed.judged > 10


@pytest.mark.slow
def test_a_killed_night_says_what_it_did_and_how_long_it_took(judged: list[tuple[JudgedNight, NightRun]]) -> None:
    killed, run_then = judged[2]
    (part,) = run_then.parts
    assert (part.state, part.done, part.left, part.reason) == (
        PartState.LEFT, 1, (SECOND,), "the night was interrupted",
    )  # fmt: skip
    assert part.share_s > 100.0
    assert part.duration_s == killed.night.duration_s == pytest.approx(USED_S, abs=0.1)


def test_what_a_part_without_a_turn_left_is_known_too(tmp_path: Path) -> None:
    def no_time(_: float) -> float:
        return 1.0

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(running, "working_time_s", no_time)
        store = one_night(plan_in(tmp_path), tmp_path)
    (night,) = store.nights()
    assert night.run is not None
    assert night.run.left == {("comparison", FIRST), ("comparison", SECOND)}
