"""An empty history."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from barchain.nightly.history.nights import open_store

if TYPE_CHECKING:
    from pathlib import Path

    from barchain.nightly.history.nights import NightStore


@pytest.fixture
def url(tmp_path: Path) -> str:
    """Folder of a history that does not exist yet."""
    return str(tmp_path / "history")


@pytest.fixture
def store(url: str) -> NightStore:
    """Empty history."""
    return open_store(url, create=True)
