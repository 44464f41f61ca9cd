"""Behaviour: what runs print, change and leave behind, whether two are the same, and whether one can be ended."""

from __future__ import annotations

import dataclasses
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.conform.checks import FAILED, PASSED, WARNING, Check, CheckState
from barchain.conform.physics import reason_against, unsupported_check
from barchain.conform.runs import START_S, TIME_LIMITS
from barchain.conform.scenes import PARTICLE, REPEATED
from barchain.runs import examination, questions
from barchain.runs.asking import ask
from barchain.runs.call import WAITED
from barchain.runs.phases import SIMULATE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.engine import Setting
    from barchain.conform.target import Examined
    from barchain.runs.asking import Reply
    from scenarios import Scene

TIMES = 6
"""Runs in one process"""
LOADED = "conform/together_7"
"""Scene of the runs in one process, if the engine supports it: some leave something behind with effects alone"""
MEMORY_B = 2**20
"""Growth of the memory in a run from which on a long comparison notices it"""
LATER_S = 1.5
"""Time after which a long run is ended, beyond that of a whole short one: it is inside `simulate` then"""
LONG_ORBITS = 2e4
STATE = {
    "folder": "changes the working folder",
    "handlers": "changes signal handlers",
    "float_errors": "changes NumPy's treatment of floating-point errors",
}
LATE_S = 5.0  # for a worker to end a process after its limit


def behaviour(engine: Examined) -> Iterator[Check]:
    """Checks of several runs in one process, of two processes, and of a run that is ended."""
    scenes = (*REPEATED, *PARTICLE)
    plain = next((n for n in scenes if reason_against(engine, n) is None), None)
    if plain is None:
        yield unsupported_check(engine, "several runs", scenes)
        return
    name = LOADED if reason_against(engine, LOADED) is None else plain
    scene, setting = engine.scene(name), engine.declarations.sweep.setting()
    asked = (engine.registration, scene, setting)
    engine.note(f"behaviour: {TIMES} runs of {name} in one process")
    first = ask(examination.behaviour, *asked, TIMES, limit_s=START_S + TIMES * engine.run_s)
    if first.problem:
        yield no_result("several runs", first, name)
        return
    yield from left_behind(first.header)
    reused = ", ".join(first.header["reused"])
    said = f"a later run writes into or shares {reused} of an earlier one; return copies" if reused else ""
    yield told("arrays of its own", said, FAILED)
    said = "twice the masses give the same bits: a model is kept by the scene's name" if first.header["kept"] else ""
    yield told("a model of each scene", said, FAILED)
    start = time.monotonic()
    again = ask(examination.behaviour, *asked, 1, limit_s=START_S + engine.run_s)
    if again.problem:
        yield no_result("a run in another process", again, name)
        return
    whole_s = time.monotonic() - start
    same = set(again.arrays) == set(first.arrays)
    same = same and all(np.array_equal(again.arrays[k], v) for k, v in first.arrays.items())
    repeated = {"in one process": bool(first.header["same"]), "in two processes": same}
    differ = " and ".join(words for words, equal in repeated.items() if not equal)
    if differ:
        yield Check("same bits again", FAILED, f"two runs {differ} differ", scene=name)
    else:
        yield Check("same bits again", PASSED)
    engine.note(f"behaviour: a run of {LONG_ORBITS:.0f} orbits, which is ended")
    yield end_check(engine, engine.scene(plain), setting, whole_s + LATER_S)


def no_result(name: str, reply: Reply, scene: str) -> Check:
    """Failed check of runs that gave no result."""
    page = TIME_LIMITS if reply.kind == "timed_out" else ""
    return Check(name, FAILED, reply.problem, page, scene=scene)


def left_behind(header: dict[str, Any]) -> Iterator[Check]:
    """Checks of output, state of the process, threads, files and memory."""
    before, after_first, after = header["before"], header["after_first"], header["after"]
    further = max(int(header["times"]) - 1, 1)
    printed = (after["printed_B"] - after_first["printed_B"]) / further
    yield told("output", f"prints {printed:.0f} bytes in a run" if printed > 0 else "", WARNING)
    changed = [words for key, words in STATE.items() if before[key] != after[key]]
    changed += [f"draws from or seeds {name}'s global random numbers in later runs" for name in header["random"]]
    changed += ["changes the scene that it is given"] if header["scene_changed"] else []
    changed += [f"sets {', '.join(header['sets'][:4])} in later runs"] if header["sets"] else []
    yield told("state of the process", "; ".join(changed), FAILED)
    threads, children = after["threads"] - after_first["threads"], after["children"] - before["children"]
    said = [f"{threads} more threads after {further} runs"] if threads >= further else []
    said += [f"{children} processes left"] if children > 0 else []
    yield told("threads and processes", "; ".join(said), FAILED)
    files = [name for name in after["files"] if name not in before["files"]]
    yield told("files", f"leaves {', '.join(files[:4])} in the working folder" if files else "", FAILED)
    grown = (after["memory_B"] - after_first["memory_B"]) / further
    said_memory = f"{grown / 2**20:.2f} MB more after each run; a warning from 1 MB on" if grown > MEMORY_B else ""
    yield told("memory", said_memory, WARNING)


def told(name: str, fault: str, state: CheckState) -> Check:
    """Check that passes without a fault."""
    return Check(name, state if fault else PASSED, fault)


def end_check(engine: Examined, scene: Scene, setting: Setting, limit_s: float) -> Check:
    """Check that a run can be ended at a time limit while the engine integrates."""
    run = dataclasses.replace(scene.run, duration_s=LONG_ORBITS * scene.step_period_s, samples=2)
    asked = (engine.registration, frozenset[str](), dataclasses.replace(scene, run=run), setting)
    start = time.monotonic()
    reply = ask(questions.run, *asked, limit_s=limit_s)
    spent_s = time.monotonic() - start
    if reply.kind != "timed_out":
        state = WARNING if reply.problem else PASSED
        said = f"the run ended by itself ({reply.problem or 'complete'})"
    elif spent_s > WAITED * limit_s + LATE_S:  # it may have waited for a processor
        state, said = FAILED, f"ended {spent_s - limit_s:.1f} s late"
    elif reply.phase != SIMULATE:
        state, said = WARNING, f"not tried while it integrates: {reply.problem}"
    else:
        state, said = PASSED, f"within {max(spent_s - limit_s, 0.0):.1f} s"
    return Check("end at a time limit", state, said)
