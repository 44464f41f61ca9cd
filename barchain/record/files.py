"""Atomic writing of files."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd


def write_parquet(frame: pd.DataFrame, path: Path) -> None:
    """Write a table and make its folder; an interruption leaves no partial file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_name(path.name + ".part")
    frame.to_parquet(half, index=False)
    os.replace(half, path)  # noqa: PTH105


def write_atomically(path: Path, text: str) -> None:
    """Write a text file; an interruption leaves no partial file."""
    half = path.with_name(path.name + ".part")
    half.write_text(text, encoding="utf-8")
    os.replace(half, path)  # noqa: PTH105
