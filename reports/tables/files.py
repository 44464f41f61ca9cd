"""Reading of the tables that every study's folder has."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


def read_csv(path: Path, words: Sequence[str], columns: Sequence[str] | None = None) -> pd.DataFrame:
    """Read a table whose words are never missing: an empty word is ``""``, any other empty cell NaN.

    Parameters
    ----------
    path : Path
    words : sequence of str
        Columns of text; those that the table lacks are ignored.
    columns : sequence of str, optional
        Columns of the empty table that stands for a missing file.

    Raises
    ------
    FileNotFoundError
        If the file is missing and `columns` is not given.
    """
    if columns is not None and not path.is_file():
        return pd.DataFrame(columns=list(columns))
    table = pd.read_csv(path, keep_default_na=False, na_values=[""])
    for name in words:
        if name in table:
            table[name] = table[name].astype(object).fillna("").astype(str)
    return table
