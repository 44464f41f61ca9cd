"""One run of barchain's own adapter, in a temporary folder."""

from __future__ import annotations

import contextlib
import signal
import tempfile
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import EngineError
from barchain.runs.environment import temporary_root
from barchain.runs.job import Job, RunResult, failure
from barchain.runs.raised import exception_words, place_words
from barchain.runs.stopwatch import timed
from barchain.runs.trajectory_checks import fault
from reports.tables.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.engine import Engine

BUILD = "build"


def run_job(job: Job, simulate_s: float | None = None) -> RunResult:
    """Run `job` in a temporary folder; every exception becomes a failure.

    Parameters
    ----------
    job : Job
    simulate_s : float, optional
        Wall time after which the engine's ``simulate`` ends this process by SIGALRM, s.
    """
    with temporary_folder() as folder, contextlib.chdir(folder):
        try:
            return run_phases(job, job.registration.load(), simulate_s)
        except ImportError as error:
            return failure(Outcome.MISSING, f"does not import ({error}); try: {job.registration.install}")
        except EngineError as error:
            return failure(Outcome.FAILED, str(error), rejected=rejection(error))
        except Exception as error:
            return failure(Outcome.FAILED, exception_words(error), rejected=rejection(error))
        except BaseException as error:  # an engine's library calls sys.exit: that ends its run and no more
            return failure(
                Outcome.FAILED, f"it ended its process by {type(error).__name__}({error}){place_words(error)}"
            )


def temporary_folder() -> tempfile.TemporaryDirectory[str]:
    """Folder for one run, removed with the comparing process's at the latest."""
    return tempfile.TemporaryDirectory(dir=temporary_root(), ignore_cleanup_errors=True)


def rejection(error: Exception) -> bool:
    """Whether an engine rejects the scene by an exception in `build`; failing arithmetic is no rejection."""
    said = isinstance(error, (EngineError, ValueError)) and not isinstance(error, np.linalg.LinAlgError)
    return said and BUILD in getattr(error, "__notes__", ())


def run_phases(job: Job, engine_class: type[Engine], simulate_s: float | None = None) -> RunResult:
    """Build, simulate and read, each timed, and check the trajectory; `simulate_s` as in :func:`run_job`."""
    engine = engine_class(**dict.fromkeys(job.options, True))
    seconds: dict[str, float] = {}
    timed(seconds, BUILD, lambda: engine.build(job.scene, job.setting))
    with process_ended_after(simulate_s):
        timed(seconds, "simulate", engine.simulate)
    seen = timed(seconds, "read", engine.read)
    found = fault(job.scene, engine_class, seen)
    if found:
        return RunResult(found[0], found[1], seen, seconds)
    return RunResult(Outcome.PASS, seen.ended, seen, seconds)


@contextlib.contextmanager
def process_ended_after(limit_s: float | None) -> Iterator[None]:
    """Let the system end this process after `limit_s`, compiled code of an engine included; None: no limit."""
    if limit_s is None:
        yield
        return
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, limit_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
