"""Needs of tests beyond Python: a test is skipped with the reason where its need is not met.

With the environment variable :data:`WHOLE`, as in CI, nothing is skipped: such a test fails then.
"""

from __future__ import annotations

import os

import pytest

WHOLE = "BARCHAIN_WHOLE_MACHINE"


def skipped(*, there: bool) -> bool:
    """Whether a test is left out, as what it needs is not there."""
    return not there and WHOLE not in os.environ


def needs(what: str, *, there: bool) -> pytest.MarkDecorator:
    """Mark that leaves a test out where something is missing."""
    return pytest.mark.skipif(skipped(there=there), reason=f"needs {what}, which is not there")
