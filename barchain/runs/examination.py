"""Questions of an examination to an engine, in its own process: declarations, several runs, and what runs leave behind.

This module stands below those that judge the answers: each process of an engine imports it anew.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import inspect
import math
import os
import random
import signal
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import psutil

from adapters.engine import Engine
from barchain.runs.kept_answers import root_of
from barchain.runs.message import DeclarationError, plain_text
from barchain.runs.phases import RunLateError, failed, late_words, run_ended_after
from barchain.runs.questions import (
    DECLARED,
    Answer,
    declared,
    finished,
    loaded,
    noise,
    run,
    sendable,
)
from scenarios import nearest

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.engine import Setting
    from adapters.registry import Registration
    from adapters.trajectory import Array
    from scenarios import Scene

OWN_MODULES = frozenset({"adapters", "barchain", "numpy", "reference_impl", "scenarios", "scipy"})
"""Packages that an adapter may import at its top: barchain, and what it needs itself"""
REPORTED_LIBRARIES = 6
SLOWER = 3.0
"""Ratio of the times of two runs at neighbouring settings"""
LATE = "timed_out"
"""Kind of the answer to a run that was ended at its limit"""
SEED = 20_411_987
"""A seed that no engine chooses"""
CONSTANT = frozenset({"t_s"})
"""Arrays that a scene may give to all its runs"""


def examined_class(registration: Registration) -> Answer:
    """Facts of an engine's class: import time, imported libraries, and a fault for each step and declaration.

    ``steps`` holds, in order, a name and a fault (empty if there is none) of each step that could be taken.
    """
    before, start = set(sys.modules), time.perf_counter()
    steps: list[list[str]] = []
    header: dict[str, Any] = {"steps": steps}
    if registration.entry:  # checked when it was read
        steps += [[name, ""] for name in ("import", "class", *DECLARED)]
        return header | {"effects": registration.declarations().effects}, {}
    found = step(steps, "import", lambda: class_of(registration))
    header["import_s"] = time.perf_counter() - start
    header["libraries"] = imported_libraries(registration, before)
    if found is None or step(steps, "class", lambda: loaded(registration)) is None:
        return header, {}
    for name in DECLARED:
        step(steps, name, lambda name=name: declared(found, name) or True)  # type: ignore[misc]
    effects = getattr(found, "effects", ())
    header["effects"] = sorted(plain_text(e, 60) for e in effects) if isinstance(effects, (set, frozenset)) else []
    return header, {}


def class_of(registration: Registration) -> type[Engine]:
    """Class of an engine, imported.

    Raises
    ------
    DeclarationError
        If the module has no such class; the message gives the nearest one, or all engines of the module.
    """
    module, _, name = registration.target.partition(":")
    found = vars(importlib.import_module(module))
    if name not in found and "__getattr__" not in found:
        engines = [n for n, value in found.items() if inspect.isclass(value) and issubclass(value, Engine)]
        there = [n for n in engines if not inspect.isabstract(found[n])]
        near = nearest(name, there)
        said = near or (f"; its engines: {', '.join(map(plain_text, there))}" if there else "; it holds no engine")
        raise DeclarationError(f"{module} has no class {name}{said}")
    return registration.load()


def step(steps: list[list[str]], name: str, call: Callable[[], Any]) -> Any:
    """Result of a step; None with a fault."""
    try:
        result = call()
    except BaseException as error:  # also SystemExit: all are the engine's
        steps.append([name, failed(error)["words"]])
        return None
    steps.append([name, ""])
    return result


def imported_libraries(registration: Registration, before: set[str]) -> list[str]:
    """Installed packages outside Python's library and barchain's that an adapter imports at its top."""
    own = registration.target.partition(":")[0].partition(".")[0]
    known = {own, *OWN_MODULES, *sys.stdlib_module_names}
    loaded_now = [module for name, module in list(sys.modules.items()) if name.partition(".")[0] == own]
    names = {package_of(value) for module in loaded_now for value in list(vars(module).values())}
    new = {name.partition(".")[0] for name in set(sys.modules) - before}
    return sorted(name for name in (names & new) - known if root_of(name) is None)[:REPORTED_LIBRARIES]


def package_of(value: object) -> str:
    """Package of a module, or of a class or function; empty for other values."""
    if inspect.ismodule(value):
        return value.__name__.partition(".")[0]
    return str(value.__module__).partition(".")[0] if inspect.isclass(value) or inspect.isroutine(value) else ""


def several_runs(
    registration: Registration,
    runs: list[tuple[Scene, Setting, Array]],
    budget_s: float = math.inf,
    run_s: float = math.inf,
    first_s: float = 0.0,
) -> Answer:
    """Several runs in one process, each with the noise that the engine declares at some instants.

    Entry k of ``runs`` is the answer to run k; its arrays are called ``k.name``, and the noise ``k.noise.name``.
    No run begins that would last beyond the budget if it took :data:`SLOWER` times as long as the run before. A run
    that is late after `run_s`, the first one after `first_s` more, is the last: what it leaves is not to be trusted.
    ``first_s`` is the time of the first run, with what it imports.
    """
    headers: list[dict[str, Any]] = []
    arrays: dict[str, Array] = {}
    if not registration.entry:
        loaded(registration)
    start = before = time.perf_counter()
    took_s = 0.0
    for k, (scene, setting, t_s) in enumerate(runs):
        now = time.perf_counter()
        expected_s = SLOWER * (now - before) if k > 1 else 0.0  # the first run imports and compiles
        if k and now - start + expected_s > budget_s:
            break
        before = now
        try:
            with run_ended_after(run_s + (0.0 if k else first_s)):
                header, found = run(registration, (), scene, setting)
            errors = {} if registration.entry else noise(registration, scene, setting, t_s)
        except RunLateError as error:
            phase = next(iter(getattr(error, "__notes__", ())), "")
            headers.append({"failed": LATE, "words": late_words(phase, run_s), "phase": phase})
            break
        except Exception as error:
            header, found, errors = failed(error), {}, {}
        took_s = took_s or time.perf_counter() - start
        headers.append(header)
        arrays |= {f"{k}.{name}": values.copy() for name, values in found.items()}  # a later run may write into them
        arrays |= {f"{k}.noise.{name}": values for name, values in errors.items()}
    return {"runs": headers, "first_s": took_s}, arrays


def behaviour(registration: Registration, scene: Scene, setting: Setting, times: int) -> Answer:
    """Traces of runs: run several times, and look at the process before, after the first, and at the end.

    ``reused`` names arrays of the first run that a later run has written into, or that a later trajectory shares.
    """
    folder, given = Path.cwd(), scene.digest  # an engine may change to a folder that others use
    before, variables = process_state(folder), dict(os.environ)
    own = sendable(finished(registration, (), scene, setting)[1], keep_order=True)
    first = {name: values.copy() for name, values in own.items()}
    after_first, first_variables = process_state(folder), dict(os.environ)
    same, reused, drawn, set_again = True, set[str](), set[str](), set[str]()
    for k in range(times - 1):
        seed_globals(SEED + k)
        known = random_states()
        if k == times - 2:  # variables of the first run are looked for again: its import may have set them
            set_again |= changed_variables(first_variables)
            set_variables(variables)
        again = sendable(finished(registration, (), scene, setting)[1], keep_order=True)
        drawn |= {name for name, state in random_states().items() if state != known[name]}
        same &= set(again) == set(first) and all(np.array_equal(again[name], first[name]) for name in first)
        reused |= {name for name, values in own.items() if not np.array_equal(values, first[name], equal_nan=True)}
        reused |= {name for name in set(own) & set(again) if np.may_share_memory(own[name], again[name])}
    heavier = replace(scene, chain=replace(scene.chain, mass_kg=tuple(2.0 * m for m in scene.chain.mass_kg)))
    changed = sendable(finished(registration, (), heavier, setting)[1], keep_order=True)
    shown = bool(scene.effects.thrust) or first.get("reaction_N", np.empty(0)).size > 0  # else masses show nowhere
    kept = shown and set(changed) == set(first) and all(np.array_equal(changed[name], first[name]) for name in first)
    return {
        "before": before, "after_first": after_first, "after": process_state(folder), "same": bool(same),
        "kept": bool(kept),
        "times": times, "scene_changed": scene.digest != given, "reused": sorted(reused - CONSTANT),
        "random": sorted(drawn), "sets": sorted(plain_text(v, 80) for v in set_again | changed_variables(variables)),
    }, {name: np.ascontiguousarray(values) for name, values in first.items()}  # fmt: skip


def process_state(folder: Path) -> dict[str, Any]:
    """State of this process that other engines or runs would notice, and files in the folder where it began."""
    flush()
    own = psutil.Process()
    return {
        "printed_B": os.fstat(1).st_size,
        "threads": threads(),
        "children": len(own.children(recursive=True)),
        "files": sorted(plain_text(p.name, 60) for p in folder.iterdir())[:20],
        "folder": plain_text(Path.cwd()),
        "handlers": {int(n): handler_name(n) for n in signal.valid_signals()},
        "float_errors": {k: str(v) for k, v in np.geterr().items()},
        "memory_B": own.memory_info().rss,
    }


def random_states() -> dict[str, int]:
    """States of the global random numbers of NumPy and of Python."""
    state = np.random.get_state(legacy=True)  # noqa: NPY002
    return {"NumPy": hash((state[1].tobytes(), state[2])), "Python": hash(random.getstate())}  # type: ignore[index]


def seed_globals(seed: int) -> None:
    """Bring all global random numbers into a known state, another one before each run."""
    np.random.seed(seed)  # noqa: NPY002
    random.seed(seed)


def changed_variables(earlier: dict[str, str]) -> set[str]:
    """Names of variables that differ from an earlier moment."""
    return {name for name in {*earlier, *os.environ} if os.environ.get(name) != earlier.get(name)}


def set_variables(wanted: dict[str, str]) -> None:
    """Give the environment the variables of an earlier moment."""
    for name in set(os.environ) - set(wanted):
        del os.environ[name]
    os.environ.update(wanted)


def flush() -> None:
    """Write out what Python and C still hold back of the output."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, ValueError, OSError):
            stream.flush()
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).fflush(None)


def threads() -> int:
    """Number of threads of this process, those of compiled code included where the system tells."""
    tasks = Path("/proc/self/task")
    return len(list(tasks.iterdir())) if tasks.is_dir() else threading.active_count()


def handler_name(number: int) -> str:
    """Short name of a signal's handler."""
    handler = signal.getsignal(number)
    return "none" if handler is None else str(getattr(handler, "name", getattr(handler, "__qualname__", "other")))
