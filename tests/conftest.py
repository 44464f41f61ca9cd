"""What all tests share."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(autouse=True, scope="session")
def _compiled_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """One folder of compiled code for all workers of a session: the tests start from nothing, and compile once."""
    root = tmp_path_factory.getbasetemp()
    folder = (root.parent if os.environ.get("PYTEST_XDIST_WORKER") else root) / "compiled"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BARCHAIN_COMPILED", str(folder))
        yield
