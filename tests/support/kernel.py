"""Tests that need the compiled kernel: skipped where it can't be used, but not where all engines must be there."""

from __future__ import annotations

import os

import pytest

from reference_impl.kernel.build import why_missing

MISSING = "" if os.environ.get("BARCHAIN_ALL_ENGINES") else why_missing()
needs_kernel = pytest.mark.skipif(bool(MISSING), reason=MISSING or "the kernel is there")


def skip_without_kernel() -> None:
    """Skip the running test where the kernel can't be used."""
    if MISSING:
        pytest.skip(MISSING)
