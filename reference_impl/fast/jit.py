"""Compiler options of the fast reference: compilation on first use, for this processor, cached on disk.

Of the compiler's floating-point liberties only contraction is allowed: a product and a sum become one operation with
one rounding. Sums keep their order, so that code free of cancellation stays free of cancellation.
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
"""Constants that compiled code imports from other packages of the reference"""
OPTIONS = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"contract"}, "_nrt": False}


def compiled(function: F) -> F:
    """Compile `function` to machine code on first use, without the interpreter lock.

    Compiled code may use views of arrays but not allocate arrays. Reference counting is off, as it would take half of
    the time of a short chain.
    """
    return with_cache(function, OPTIONS)


def inlined(function: F) -> F:
    """Compile `function` into its callers' loops: for the few functions called once per bar or component."""
    return with_cache(function, OPTIONS | {"forceinline": True})


def with_cache(function: F, options: dict[str, object]) -> F:
    """Compile with a cache folder that depends on all sources: a function's own file does not identify its callees'."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        made: F = numba.njit(**options)(function)
    finally:
        numba.config.CACHE_DIR = before
    return made


def sources() -> list[Path]:
    """Files of all compiled code, sorted."""
    return sorted(Path(__file__).parent.rglob("*.py"))


@cache
def cache_folder() -> Path:
    """Folder of compiled code: Numba's own if set, otherwise the user's, by the hash of all compiled sources."""
    digest = hashlib.sha256(f"{numba.__version__} {scipy.__version__} {IMPORTED_CONSTANTS}".encode())
    for source in sources():
        digest.update(source.read_bytes())
    root = Path(numba.config.CACHE_DIR) if numba.config.CACHE_DIR else user_cache_path("barchain") / "compiled"
    return root / digest.hexdigest()[:16]
