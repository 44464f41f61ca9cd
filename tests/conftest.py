"""What all tests share."""

from __future__ import annotations

import ctypes
import functools
import gc
import os
import platform
import sys
from typing import TYPE_CHECKING

import pytest

from barchain.crossval import suite
from barchain.solutions.reference import SolutionSource

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator


@pytest.fixture(autouse=True, scope="session")
def _compiled_quickly(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """One folder of compiled code for all workers of a session; own scenes are judged without heyoka's compilation."""
    root = tmp_path_factory.getbasetemp()
    folder = (root.parent if os.environ.get("PYTEST_XDIST_WORKER") else root) / "compiled"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BARCHAIN_COMPILED", str(folder))
        patch.setattr(suite, "source_to_run", lambda scene: SolutionSource.REFERENCE)  # heyoka compiles
        yield


@pytest.fixture(autouse=True, scope="module")
def _little_memory() -> Iterator[None]:
    """Give memory back after each module: compilers keep all code, and the C library keeps what was freed."""
    yield
    if "jax" in sys.modules:
        sys.modules["jax"].clear_caches()
    if "heyoka" in sys.modules:
        for name in ("compiled", "integrator"):
            forget(vars(sys.modules.get(f"adapters.heyoka.{name}", object)).values())
        sys.modules["heyoka"].llvm_state.clear_memcache()
    gc.collect()
    if platform.libc_ver()[0] == "glibc":
        ctypes.CDLL(None).malloc_trim(0)


def forget(functions: Iterable[object]) -> None:
    """Clear the caches of those functions that have one."""
    for function in functions:
        if isinstance(function, functools._lru_cache_wrapper):
            function.cache_clear()
