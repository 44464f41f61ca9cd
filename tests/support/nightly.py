"""The facts of a night as its folder holds them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.results.nights.document import NightlyFile

if TYPE_CHECKING:
    from pathlib import Path


def read_nightly(path: Path) -> NightlyFile:
    """Contents of a ``nightly.json``."""
    return NightlyFile.model_validate_json(path.read_bytes())
