"""Needs of tests beyond Python: a test is skipped with the reason where its need is not met.

With the environment variable :data:`WHOLE`, as in CI, nothing is skipped: such a test fails then.
"""

from __future__ import annotations

import os
from importlib.util import find_spec

import pytest

WHOLE = "BARCHAIN_WHOLE_MACHINE"


def skipped(*, there: bool) -> bool:
    """Whether a test is left out, as what it needs is not there."""
    return not there and WHOLE not in os.environ


def needs(what: str, *, there: bool) -> pytest.MarkDecorator:
    """Mark that leaves a test out where something is missing."""
    return pytest.mark.skipif(skipped(there=there), reason=f"needs {what}, which is not there")


def need_postgresql() -> None:
    """Leave the calling test out where PostgreSQL is missing: its package has no wheel for every system."""
    if skipped(there=find_spec("pgserver") is not None):
        pytest.skip("needs PostgreSQL of the package pgserver, which is not there")
