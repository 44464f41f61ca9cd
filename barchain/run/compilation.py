"""Announcement of the code that the compiled reference has still to compile on this machine.

The code is specialised on a scene's set of effects and cached on disk. A marker file beside the cache is written when a
run with that set has returned. Without the marker file compiling is announced.
"""

from __future__ import annotations

import contextlib
import hashlib
from typing import TYPE_CHECKING

from adapters.common.initial_state import chain_model
from adapters.registry import ENGINES

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from barchain.run.job import Job
    from scenarios import Scene

COMPILED = "reference-fast"


def ours(job: Job) -> bool:
    """Whether a job runs the compiled reference, the only engine that caches its compiled code."""
    return job.registration == ENGINES[COMPILED]


def mark(scene: Scene) -> Path:
    """Marker file of a scene's set of effects, named by the types that the code is specialised on.

    Numba keys its cache by the place of a source file and the time of its last change, so that another checkout
    compiles anew. The name of the marker file therefore depends on both.
    """
    import numba  # noqa: PLC0415  # an extra

    from reference_impl.fast.jit import cache_folder, sources  # noqa: PLC0415
    from reference_impl.fast.layout import compiled_chain  # noqa: PLC0415

    kind = str(numba.typeof(compiled_chain(chain_model(scene))))
    stamps = [(str(source), source.stat().st_mtime_ns) for source in sources()]
    return cache_folder() / "sets" / hashlib.sha256(f"{kind} {stamps}".encode()).hexdigest()[:16]


def compiled(job: Job) -> None:
    """Write the marker file of a job whose run has returned."""
    if not ours(job):
        return
    path = mark(job.scene)
    with contextlib.suppress(OSError):  # a marker that can't be kept costs an announcement
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def announcement(jobs: Iterable[Job]) -> str:
    """Sentence on the code to compile before the runs; empty if there is none."""
    found = {path for job in jobs if ours(job) and not (path := mark(job.scene)).is_file()}
    if not found:
        return ""
    sets = "a set" if len(found) == 1 else f"{len(found)} sets"
    return f"{COMPILED} compiles {sets} of effects, once on this machine: about 40 s each, minutes if it is busy"
