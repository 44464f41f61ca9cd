"""Behaviour: what runs print, change and leave behind, whether two are the same, and whether one can be ended."""

from __future__ import annotations

import dataclasses
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.boundary.limits import OutsideLimits
from barchain.boundary.process import GRACE_S, ask
from barchain.conform.checks import Check, CheckState, Group
from barchain.conform.physics import reason_against
from barchain.conform.runs import START_S
from barchain.conform.scenes import REPEATED, scene_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.engine import Setting
    from barchain.conform.target import Examined
    from scenarios import Scene

PAGE = "docs/howto/conform.md#behaviour"
TIMES = 6
"""Runs in one process"""
MEMORY_B = 2**20
"""Growth of the memory in a run from which on a long comparison notices it"""
KILL_S = 1.5
"""Time limit of the run that is to be ended"""
LONG_ORBITS = 2e4
STATE = {
    "folder": "changes the working folder",
    "handlers": "changes signal handlers",
    "float_errors": "changes NumPy's treatment of floating-point errors",
}


def behaviour(engine: Examined) -> Iterator[Check]:
    """Checks of several runs in one process, of two processes, and of a run that is ended."""
    name = next((n for n in REPEATED if reason_against(engine, n) is None), None)
    if name is None:
        yield Check(Group.BEHAVIOUR, "several runs", CheckState.UNSUPPORTED, "supports no scene of this check")
        return
    scene, setting = scene_of(name), engine.load().sweep.setting()
    asked = (engine.registration, scene, setting)
    engine.note(f"behaviour: {TIMES} runs of {name} in one process")
    first = ask("behaviour", *asked, TIMES, limits=OutsideLimits(2.0 * START_S))
    if first.problem:
        yield Check(Group.BEHAVIOUR, "several runs", CheckState.FAILED, first.problem, PAGE, scene=name)
        return
    yield from left_behind(first.header)
    again = ask("behaviour", *asked, 1, limits=OutsideLimits(START_S))
    same = not again.problem and set(again.arrays) == set(first.arrays)
    same = same and all(np.array_equal(again.arrays[k], v) for k, v in first.arrays.items())
    yield same_check(bool(first.header["same"]), same, name)
    yield told("arrays of its own", reused_words(first.header["reused"]), CheckState.FAILED)
    yield end_check(engine, scene, setting)


def left_behind(header: dict[str, Any]) -> Iterator[Check]:
    """Checks of output, state of the process, threads, files and memory."""
    before, after_first, after = header["before"], header["after_first"], header["after"]
    further = max(int(header["times"]) - 1, 1)
    printed = (after["printed_B"] - after_first["printed_B"]) / further
    yield told("output", f"prints {printed:.0f} bytes in a run" if printed > 0 else "", CheckState.WARNING)
    changed = [words for key, words in STATE.items() if before[key] != after[key]]
    changed += [f"draws from or seeds {name}'s global random numbers in later runs" for name in header["random"]]
    changed += [f"sets {', '.join(header['sets'][:4])} in later runs"] if header["sets"] else []
    yield told("state of the process", "; ".join(changed), CheckState.FAILED)
    threads, children = after["threads"] - after_first["threads"], after["children"] - before["children"]
    said = [f"{threads} more threads after {further} runs"] if threads >= further else []
    said += [f"{children} processes left"] if children > 0 else []
    yield told("threads and processes", "; ".join(said), CheckState.FAILED)
    files = [name for name in after["files"] if name not in before["files"]]
    yield told("files", f"leaves {', '.join(files[:4])} in the working folder" if files else "", CheckState.FAILED)
    grown = (after["memory_B"] - after_first["memory_B"]) / further
    said_memory = f"{grown / 2**20:.2f} MB more after each run; a warning from 1 MB on" if grown > MEMORY_B else ""
    yield told("memory", said_memory, CheckState.WARNING)


def reused_words(names: list[str]) -> str:
    """Fault of arrays that several runs share; empty without one."""
    return f"a later run writes into or shares {', '.join(names)} of an earlier one; return copies" if names else ""


def told(name: str, fault: str, state: CheckState) -> Check:
    """Check that passes without a fault."""
    return Check(Group.BEHAVIOUR, name, state if fault else CheckState.PASSED, fault, PAGE)


def same_check(in_process: bool, between: bool, name: str) -> Check:
    """Check that a run gives the same bits again."""
    said = [words for same, words in ((in_process, "in one process"), (between, "in two processes")) if not same]
    if not said:
        return Check(Group.BEHAVIOUR, "same bits again", CheckState.PASSED, page=PAGE)
    return Check(
        Group.BEHAVIOUR, "same bits again", CheckState.FAILED, f"two runs {' and '.join(said)} differ", PAGE, scene=name
    )


def end_check(engine: Examined, scene: Scene, setting: Setting) -> Check:
    """Check that a run can be ended at a time limit."""
    long = dataclasses.replace(
        scene, run=dataclasses.replace(scene.run, duration_s=LONG_ORBITS * scene.step_period_s, samples=2)
    )
    start = time.monotonic()
    reply = ask("run", engine.registration, frozenset(), long, setting, limits=OutsideLimits(KILL_S))
    seconds = time.monotonic() - start
    if reply.kind != "timed_out":
        said = f"the run ended by itself ({reply.problem or 'complete'})"
        return Check(Group.BEHAVIOUR, "end at a time limit", CheckState.PASSED, said, PAGE)
    if seconds > KILL_S + GRACE_S:
        return Check(
            Group.BEHAVIOUR, "end at a time limit", CheckState.FAILED, f"ended {seconds - KILL_S:.1f} s late", PAGE
        )
    return Check(Group.BEHAVIOUR, "end at a time limit", CheckState.PASSED, f"within {seconds - KILL_S:.1f} s", PAGE)
