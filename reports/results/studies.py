"""The registry of studies, and the rows of result folders: read by whoever asks."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from reports.results import comparison, cost, effects, ensemble, releases, roundoff, scaling, selftest, stability, sweep
from reports.results.files import StudyFiles
from reports.results.rows import FOLDER

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

STUDIES = (
    comparison.FILES,
    cost.FILES,
    scaling.FILES,
    roundoff.FILES,
    effects.FILES,
    stability.FILES,
    selftest.FILES,
    ensemble.FILES,
    sweep.FILES,
    releases.FILES,
)
"""All studies but those of one's own, in the order in which pages and rows show them"""


def studies_in(folder: Path) -> list[StudyFiles]:
    """Studies whose results a folder holds; those of one's own by their rows."""
    known = {files.study for files in STUDIES}
    own = sorted(file.stem for file in (folder / FOLDER).glob("*.parquet") if file.stem not in known)
    return [files for files in (*STUDIES, *map(StudyFiles, own)) if files.has_record(folder)]


def rows_of(folder: Path) -> pd.DataFrame:
    """Rows of all results in a folder, in the columns of :mod:`reports.results.rows`.

    Raises
    ------
    FileNotFoundError
        If the folder holds no results, or a study lacks its rows.
    DamagedResultsError, SchemaVersionError
        As :meth:`reports.results.files.StudyFiles.rows`.
    """
    import pandas as pd  # noqa: PLC0415

    found = [files.rows(folder) for files in studies_in(folder)]
    if not found:
        raise FileNotFoundError(no_results(folder))
    return pd.concat(found, ignore_index=True)


def no_results(folder: Path) -> str:
    """One line on a folder in which no study has results."""
    if not os.path.lexists(folder):
        return f"{folder}: no such folder"
    if (folder / "record.json").is_file() and (folder / "figures.parquet").is_file():
        return (
            f"{folder}: a night of a history; copied into the folder of another history, it is a night there. Give the "
            f"folder of one of its parts, or `barchain history report --baseline {folder}`"
        )
    if any(folder.glob("*/figures.parquet")):
        return f"{folder}: a history; its nights are copied as folders into that of another history"
    if any(folder.glob("record.json")) or any(folder.glob("*/record.json")):
        return f"{folder}: results of barchain 0.6 or earlier, which this one does not read; run the study again"
    if any(studies_in(part) for part in folder.glob("*/")):
        return f"{folder}: results are in folders of it; give one of these"
    return f"{folder}: no results there; give a folder with results of: {', '.join(files.study for files in STUDIES)}"
