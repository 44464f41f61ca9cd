"""What the compiled reference has still to compile on this machine, so that it can be told beforehand.

Its code is specialised on a scene's set of effects and kept on disk. A file beside it, written when a run of the set
has come back, says that the set is there; without the file nothing is known, and compiling is announced.
"""

from __future__ import annotations

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
    """Whether a job runs the compiled reference, which alone keeps what it compiled."""
    return job.registration == ENGINES[COMPILED]


def mark(scene: Scene) -> Path:
    """File that says that the code of a scene's effects is there: named by the types that code is specialised on."""
    import numba  # noqa: PLC0415  # an extra

    from reference_impl.fast.jit import cache_folder  # noqa: PLC0415
    from reference_impl.fast.layout import compiled_chain  # noqa: PLC0415

    kind = str(numba.typeof(compiled_chain(chain_model(scene))))
    return cache_folder() / "sets" / hashlib.sha256(kind.encode()).hexdigest()[:16]


def compiled(job: Job) -> None:
    """Note that a run of a job has come back."""
    if not ours(job):
        return
    path = mark(job.scene)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()


def announcement(jobs: Iterable[Job]) -> str:
    """What is to be compiled first, in words; empty if nothing is."""
    found = {path for job in jobs if ours(job) and not (path := mark(job.scene)).is_file()}
    if not found:
        return ""
    sets = "a set" if len(found) == 1 else f"{len(found)} sets"
    return f"{COMPILED} compiles {sets} of effects, once on this machine: about 40 s each, minutes if it is busy"
