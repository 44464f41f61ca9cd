"""What all tests share."""

from __future__ import annotations

import ctypes
import functools
import gc
import os
import platform
import sys
from typing import TYPE_CHECKING

import pyarrow
import pytest

from barchain.crossval import suite
from barchain.solutions.reference import SolutionSource

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import ModuleType


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
def _little_memory(request: pytest.FixtureRequest) -> Iterator[None]:
    """Give memory back after each module: its caches, compilers' code, and memory that allocators keep once freed."""
    yield
    forget(request.module)
    if "jax" in sys.modules:
        sys.modules["jax"].clear_caches()
    if "heyoka" in sys.modules:
        for name in ("compiled", "integrator"):
            forget(sys.modules.get(f"adapters.heyoka.{name}"))
        sys.modules["heyoka"].llvm_state.clear_memcache()
    gc.collect()
    pyarrow.default_memory_pool().release_unused()
    if platform.libc_ver()[0] == "glibc":
        ctypes.CDLL(None).malloc_trim(0)


def forget(module: ModuleType | None) -> None:
    """Clear the caches of a module's own functions."""
    for function in vars(module).values() if module else ():
        if isinstance(function, functools._lru_cache_wrapper) and function.__module__ == vars(module)["__name__"]:
            function.cache_clear()
