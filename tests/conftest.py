"""What all tests share."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from typing import TYPE_CHECKING

import pytest

from barchain.crossval import suite
from barchain.solutions.reference import SolutionSource

if TYPE_CHECKING:
    from collections.abc import Iterator


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
    gc.collect()
    if sys.platform == "linux":
        ctypes.CDLL(None).malloc_trim(0)
