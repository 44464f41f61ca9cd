"""What all tests share."""

from __future__ import annotations

import ctypes
import functools
import gc
import platform
import sys
from typing import TYPE_CHECKING

import pyarrow
import pytest
from hypothesis import HealthCheck, settings

from reference_impl.kernel.build import KernelMissingError
from tests.support.kernel import skip_without_kernel
from tests.support.shared_workers import shared_workers  # noqa: F401

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator
    from types import ModuleType


settings.register_profile("barchain", suppress_health_check=[HealthCheck.too_slow])  # a busy machine is no fault
settings.load_profile("barchain")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Take the mark "slow" from what is exhaustive, so that `-m slow` leaves it out."""
    for item in items:
        if item.get_closest_marker("exhaustive"):
            item.own_markers[:] = [mark for mark in item.own_markers if mark.name != "slow"]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Keep the garbage collector from what is collected: thousands of tests, which stay to the end."""
    gc.disable()
    result = yield
    gc.freeze()
    gc.enable()
    return result


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call() -> Generator[None, object, object]:
    """Skip a test that calls the kernel where it can't be used, with the reason."""
    try:
        return (yield)
    except KernelMissingError:
        skip_without_kernel()
        raise


@pytest.fixture(autouse=True, scope="module")
def _little_memory(request: pytest.FixtureRequest) -> Iterator[None]:
    """Give memory back after each module: its caches, and memory that allocators keep once freed."""
    yield
    forget(request.module)
    if "heyoka" in sys.modules:
        for name in ("compiled", "integrator"):
            forget(sys.modules.get(f"adapters.heyoka.{name}"))
        sys.modules["heyoka"].llvm_state.clear_memcache()
    gc.collect()
    gc.freeze()  # what modules and engines have loaded stays: the next look leaves it out
    pyarrow.default_memory_pool().release_unused()
    if platform.libc_ver()[0] == "glibc":
        ctypes.CDLL(None).malloc_trim(0)


def forget(module: ModuleType | None) -> None:
    """Clear the caches of a module's own functions."""
    for function in vars(module).values() if module else ():
        if isinstance(function, functools._lru_cache_wrapper) and function.__module__ == vars(module)["__name__"]:
            function.cache_clear()
