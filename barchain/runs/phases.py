"""The three phases of a run in an engine's process: their time and memory, and words on what ended them.

A process that is ended at its time limit can't tell where it was: the phase is noted in a file.
"""

from __future__ import annotations

import contextlib
import importlib
import math
import os
import signal
import sys
import time
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import psutil

from adapters.engine import EngineError, UnsupportedMotionError
from barchain.runs.message import DeclarationError, MessageError, plain_text

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import FrameType

    from adapters.engine import Engine, Setting
    from scenarios import Scene

QUESTION = "BARCHAIN_QUESTION"
"""Variable that holds the folder of a worker's process, in it and its children"""
PHASE = "phase.txt"
MOST_LENGTH = 40
BUILD, SIMULATE = "build", "simulate"
CALLERS = {"barchain", "contextlib"}
"""Top-level packages that call an engine's code"""
IMPORTER = "importlib"
BASE = "adapters.engine"
"""Module of the class that every engine inherits; it calls the engine's methods"""
AGAIN_S = 0.5
"""Time after which the exception of a late run is raised again: a function that C calls swallows it"""
T = TypeVar("T")
WAITS = Path("/proc/thread-self/schedstat")
"""Linux: time on a processor and time in the queue for one, ns, and the number of time slices of this thread"""
STATUS, CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")
KIBI = 1024.0


def three_phases(
    engine: Engine, scene: Scene, setting: Setting, simulate_s: float | None = None
) -> tuple[Any, dict[str, float]]:
    """Build, simulate and read: what the engine returns, and the wall time of each phase, s.

    Parameters
    ----------
    engine : Engine
    scene : Scene
    setting : Setting
    simulate_s : float, optional
        Wall time after which the engine's ``simulate`` ends this process by SIGALRM, s.

    Raises
    ------
    BaseException
        Whatever the engine raises, with the phase as a note.
    """
    seconds: dict[str, float] = {}
    enter(BUILD)
    timed(seconds, BUILD, lambda: engine.build(scene, setting))
    enter(SIMULATE)
    with process_ended_after(simulate_s):
        timed(seconds, SIMULATE, engine.simulate)
    enter("read")
    return timed(seconds, "read", engine.read), seconds


@contextlib.contextmanager
def process_ended_after(limit_s: float | None, *, processor: bool = False) -> Iterator[None]:
    """Let the system end this process after a wall time, or a time of its processor; None: no limit.

    The signal, SIGALRM or SIGPROF, ends compiled code of an engine too.
    """
    if limit_s is None or not hasattr(signal, "setitimer"):
        yield
        return
    end, timer = (signal.SIGPROF, signal.ITIMER_PROF) if processor else (signal.SIGALRM, signal.ITIMER_REAL)
    signal.signal(end, signal.SIG_DFL)
    signal.setitimer(timer, limit_s)
    try:
        yield
    finally:
        signal.setitimer(timer, 0.0)


class RunLateError(BaseException):
    """Raised in a run at its limit of time; no `except Exception` of an engine holds it."""


@contextlib.contextmanager
def run_ended_after(limit_s: float) -> Iterator[None]:
    """Raise :class:`RunLateError` after a time as on an idle machine, s, where Python's own code runs.

    Compiled code of an engine goes on until it returns: there the limit of the process counts.
    """
    if not math.isfinite(limit_s) or not hasattr(signal, "setitimer"):
        yield
        return
    clock = Stopwatch()

    def late(*_: object) -> None:
        left_s = limit_s - clock.seconds()
        if left_s > 0.0:  # it waited for a processor
            signal.setitimer(signal.ITIMER_REAL, max(left_s, AGAIN_S), AGAIN_S)
            return
        raise RunLateError

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, limit_s, AGAIN_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def enter(phase: str) -> None:
    """Note the phase that begins, in a worker's process; nothing elsewhere."""
    folder = os.environ.get(QUESTION)
    if folder:
        with contextlib.suppress(OSError):  # an engine may have removed the folder
            Path(folder, PHASE).write_text(phase, encoding="ascii")


def entered(folder: Path) -> str:
    """Phase that a process noted last; empty if none is known."""
    try:
        path = folder / PHASE
        phase = path.read_text(encoding="ascii")[:MOST_LENGTH] if path.is_file() else ""  # no pipe of an engine's
    except (OSError, ValueError):
        return ""
    return phase if phase.replace(" ", "").isalpha() else ""


def late_words(phase: str, time_s: float) -> str:
    """Words on a run that was ended at its time limit: ``no result within 40 s, ended in build``."""
    return f"no result within {time_s:g} s{f', ended in {phase}' if phase else ''}"


def failed(error: BaseException) -> dict[str, Any]:
    """Header of the answer of an engine whose code raised an exception; a failing import is a missing library.

    ``rejected`` tells whether the engine rejects the scene by an exception; failing arithmetic is no rejection.
    """
    phase = next(iter(getattr(error, "__notes__", ())), "")
    if isinstance(error, ImportError):
        return {"failed": "missing", "words": f"does not import ({plain_text(error)})", "phase": "", "rejected": False}
    if isinstance(error, UnsupportedMotionError):
        return {"failed": "unsupported", "words": plain_text(error), "phase": "", "rejected": False}
    if isinstance(error, (EngineError, DeclarationError, MessageError)):
        words = plain_text(error) or type(error).__name__
    elif isinstance(error, Exception):
        words = exception_words(error)
    else:  # an engine's library calls sys.exit: that ends its run and no more
        words = f"it ended its process by {type(error).__name__}({plain_text(error)}){place_words(error)}"
    rejects = isinstance(error, (EngineError, ValueError)) and not isinstance(error, np.linalg.LinAlgError)
    return {"failed": "failed", "words": words, "phase": plain_text(phase, 20), "rejected": rejects}


def exception_words(error: BaseException) -> str:
    """Type and text of an exception, and the last line of the engine's own code that its traceback names.

    The line where the exception was raised follows if it lies in another package, e.g. in NumPy.
    """
    return f"{type(error).__name__}: {plain_text(error)}{place_words(error)}"


def place_words(error: BaseException) -> str:
    """Place of an exception, in parentheses after a space; empty if no code but barchain's was running."""
    frames = [pair for pair in traceback.walk_tb(error.__traceback__) if package(pair[0]) != IMPORTER]
    outside = [k for k, (frame, _) in enumerate(frames) if package(frame) not in CALLERS and module(frame) != BASE]
    if not outside:
        return ""
    engine = package(frames[outside[0]][0])
    own = max(k for k in outside if package(frames[k][0]) == engine)
    places = [line(*frames[own])]
    if own < len(frames) - 1:
        places.append(f"raised in {line(*frames[-1])}")
    return f" ({', '.join(places)})"


def package(frame: FrameType) -> str:
    """Top-level package of a frame's code."""
    return module(frame).partition(".")[0]


def module(frame: FrameType) -> str:
    """Name of a frame's module."""
    return str(frame.f_globals.get("__name__", "?"))


def line(frame: FrameType, number: int) -> str:
    """Module, line and function of a frame."""
    return plain_text(f"{module(frame)}:{number} in {frame.f_code.co_name}", 200)


class Stopwatch:
    """Time of a call as on an idle machine: without the time in which its thread waited for a processor.

    On a busy machine the wall time of a run grows with what else runs, and a long run loses a larger share than one
    that ends within a time slice. Ratios of wall times are therefore wrong there. A run needs what it used of the
    processors, or what is left of the wall time without the wait in the scheduler's queue, whichever is more: an engine
    that waits for a child process or a file uses no processor meanwhile, and the scheduler settles a wait late, so that
    one may contain part of an earlier one. On an idle machine, and where the system does not tell the wait, this is the
    wall time.
    """

    def __init__(self) -> None:
        """Start; the wall clock last, so that it holds nothing of the other two."""
        self.waited_s = queue_time_s()
        self.used_s = time.process_time()
        self.start_s = time.perf_counter()

    def seconds(self) -> float:
        """Time since the start, s."""
        wall_s = time.perf_counter() - self.start_s
        used_s = time.process_time() - self.used_s
        return min(wall_s, max(used_s, wall_s - (queue_time_s() - self.waited_s)))


def queue_time_s(pid: int | None = None) -> float:
    """Time that this thread, or a process, has waited for a processor so far, s; 0 where the system does not tell."""
    try:
        return int((WAITS if pid is None else Path(f"/proc/{pid}/schedstat")).read_bytes().split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0


def timed(seconds: dict[str, float], phase: str, call: Callable[[], T]) -> T:
    """Result of `call`; its time is noted under `phase`, and an exception carries the phase as a note."""
    clock = Stopwatch()
    try:
        result = call()
    except BaseException as error:
        error.add_note(phase)
        raise
    seconds[phase] = clock.seconds()
    return result


class Peak:
    """Peak resident memory of this process beyond its memory at a moment.

    Linux's `ru_maxrss` can't be used: it is handed on through fork and exec, so a process that a large one started
    begins at that one's size. There the kernel's own high-water mark of the memory map is read, set back at the moment.
    """

    def __init__(self) -> None:
        """Begin."""
        with contextlib.suppress(OSError):
            CLEAR.write_text("5", encoding="ascii")  # sets the mark back to what is resident now
        self.base_B = mark()

    def beyond(self) -> float:
        """Bytes by which the peak exceeds the mark; NaN where the system does not report it."""
        return max(0.0, mark() - self.base_B) if math.isfinite(self.base_B) else math.nan


def mark() -> float:
    """Largest resident size so far, bytes; NaN where it is not known."""
    if STATUS.is_file():
        lines = dict(line.split(":", 1) for line in STATUS.read_text(encoding="utf-8").splitlines() if ":" in line)
        return KIBI * float(lines["VmHWM"].split()[0]) if "VmHWM" in lines else math.nan
    try:
        resource = importlib.import_module("resource")  # POSIX only
    except ImportError:
        return math.nan
    unit = 1.0 if sys.platform == "darwin" else KIBI
    return unit * float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


def installed() -> float:
    """Memory of this machine, bytes."""
    return float(psutil.virtual_memory().total)
