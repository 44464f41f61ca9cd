"""One run in a worker process: output redirected, in a temporary folder."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import time
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from adapters.engine import EngineError
from barchain.boundary.threads import temporary_root
from barchain.run.job import Job, RunResult, failure
from barchain.run.trajectory_checks import fault
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    from adapters.engine import Engine

T = TypeVar("T")
BUILD = "build"


def run_job(job: Job, log: Path) -> RunResult:
    """Run `job`; the engine's output goes to `log`, and every exception becomes a failure.

    Parameters
    ----------
    job : Job
    log : Path
        File for the engine's output; it outlives a crash of the process.
    """
    with quietly(log), temporary_folder() as folder, contextlib.chdir(folder):
        try:
            return run_phases(job, job.registration.load())
        except ImportError as error:
            return failure(Outcome.MISSING, f"does not import ({error}); try: {job.registration.install}")
        except EngineError as error:
            return failure(Outcome.FAILED, str(error), rejected=rejection(error))
        except Exception as error:
            return failure(Outcome.FAILED, f"{type(error).__name__}: {error}", rejected=rejection(error))
        except BaseException as error:  # an engine's library calls sys.exit: that ends its run and no more
            return failure(Outcome.FAILED, f"it ended its process by {type(error).__name__}({error})")


def temporary_folder() -> tempfile.TemporaryDirectory[str]:
    """Folder for one run, removed with the comparing process's at the latest."""
    return tempfile.TemporaryDirectory(dir=temporary_root(), ignore_cleanup_errors=True)


def rejection(error: Exception) -> bool:
    """Whether an engine rejects the scene by an exception in `build`; failing arithmetic is no rejection."""
    said = isinstance(error, (EngineError, ValueError)) and not isinstance(error, np.linalg.LinAlgError)
    return said and BUILD in getattr(error, "__notes__", ())


def run_phases(job: Job, engine_class: type[Engine]) -> RunResult:
    """Build, simulate and read, each timed, and check the trajectory."""
    engine = engine_class(**dict.fromkeys(job.options, True))
    seconds: dict[str, float] = {}
    timed(seconds, BUILD, lambda: engine.build(job.scene, job.setting))
    timed(seconds, "simulate", engine.simulate)
    seen = timed(seconds, "read", engine.read)
    found = fault(job.scene, engine_class, seen)
    if found:
        return RunResult(found[0], found[1], seen, seconds)
    return RunResult(Outcome.PASS, seen.ended, seen, seconds)


def timed(seconds: dict[str, float], phase: str, call: Callable[[], T]) -> T:
    """Result of `call`; its wall time is noted, and an exception carries the phase as a note."""
    start = time.perf_counter()
    try:
        result = call()
    except Exception as error:
        error.add_note(phase)
        raise
    seconds[phase] = time.perf_counter() - start
    return result


@contextlib.contextmanager
def quietly(log: Path) -> Iterator[None]:
    """Redirect the output of this process and its libraries, C code included, to `log`."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = os.dup(1), os.dup(2)
    with log.open("wb") as sink:
        os.dup2(sink.fileno(), 1)
        os.dup2(sink.fileno(), 2)
        try:
            yield
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for target, copy in zip((1, 2), kept, strict=True):
                os.dup2(copy, target)
                os.close(copy)
