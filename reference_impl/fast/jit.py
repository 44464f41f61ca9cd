"""How the fast reference is compiled: on first use, for this processor, and kept on disk for the next process.

Of the liberties that a compiler may take with floating point only one is allowed: a product and a sum become one
operation with one rounding. Sums keep their order, so that nothing that was written free of cancellation loses it.
"""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numba
import scipy
from platformdirs import user_cache_path

from reference_impl.integrate.coordinate_sets import ANGLE_ROUNDOFF
from reference_impl.integrate.discrete_modes import EVENT_SAMPLES
from reference_impl.model.effect import EDGE_ON
from reference_impl.model.joints import CONVERGED, DIVERGED, REFINEMENTS, ROUNDING

if TYPE_CHECKING:
    from collections.abc import Callable

F = TypeVar("F", bound="Callable[..., object]")
IMPORTED_CONSTANTS = DIVERGED, EDGE_ON, ANGLE_ROUNDOFF, EVENT_SAMPLES, REFINEMENTS, ROUNDING, CONVERGED
"""Constants that compiled code takes from other sources of ours"""
OPTIONS = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"contract"}, "_nrt": False}


def compiled(function: F) -> F:
    """Compile `function` to machine code on first use; it holds no interpreter lock while it runs.

    It may take views of arrays but not make new ones: nothing in compiled code counts references, which would take
    half of the time of a short chain.
    """
    return with_cache(function, OPTIONS)


def inlined(function: F) -> F:
    """Compile `function` into its callers' loops: for the few that are called once a bar or a component."""
    return with_cache(function, OPTIONS | {"forceinline": True})


def with_cache(function: F, options: dict[str, object]) -> F:
    """Compile with the cache in a folder of this very source: a function's own file does not tell of its callees'."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        made: F = numba.njit(**options)(function)
    finally:
        numba.config.CACHE_DIR = before
    return made


@cache
def cache_folder() -> Path:
    """Folder for compiled code: numba's own if one is set, else the user's, by the hash of all that is compiled in."""
    digest = hashlib.sha256(f"{numba.__version__} {scipy.__version__} {IMPORTED_CONSTANTS}".encode())
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(source.read_bytes())
    root = Path(numba.config.CACHE_DIR) if numba.config.CACHE_DIR else user_cache_path("barchain") / "compiled"
    return root / digest.hexdigest()[:16]
