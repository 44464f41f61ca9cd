"""Rows of result folders: written when a study ends, and read or made of its tables by whoever asks."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

from reports.tables import cost, crossval, effects, ensemble, roundoff, scaling, stability
from reports.tables.faults import campaign, selftest
from reports.tables.files import StudyFiles
from reports.tables.nights import releases
from reports.tables.reading import TABLES, parquet_frame, recorded_content
from reports.tables.rows import COLUMNS, FOLDER, Rows, spread, typed
from reports.tables.writing import parquet

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path

    import pandas as pd

    from reports.tables.rows import Followed, Row


class Measuring(NamedTuple):
    """A study: its files, the rows of its tables, and those of its metrics that nights follow."""

    files: StudyFiles
    rows: Callable[[Path], Rows]
    followed: Mapping[str, Followed]


STUDIES = (
    Measuring(crossval.FILES, crossval.comparison_rows, crossval.FOLLOWED),
    Measuring(cost.FILES, cost.cost_rows, cost.FOLLOWED),
    Measuring(scaling.FILES, scaling.scaling_rows, scaling.FOLLOWED),
    Measuring(roundoff.FILES, roundoff.roundoff_rows, roundoff.FOLLOWED),
    Measuring(effects.FILES, effects.effects_rows, effects.FOLLOWED),
    Measuring(stability.FILES, stability.stability_rows, stability.FOLLOWED),
    Measuring(selftest.FILES, selftest.selftest_rows, selftest.FOLLOWED),
    Measuring(campaign.FILES, campaign.campaign_rows, campaign.FOLLOWED),
    Measuring(ensemble.FILES, ensemble.ensemble_rows, ensemble.FOLLOWED),
    Measuring(releases.FILES, releases.releases_rows, {}),
)
"""All studies, each with its rows; those without a followed metric are no part of a night"""


def rows_name(files: StudyFiles) -> str:
    """File of a study's rows, relative to the study's folder."""
    return f"{'../' if files.study else ''}{FOLDER}/{files.name}.parquet"


def rows_content(files: StudyFiles, folder: Path, summary: Iterable[Row] = ()) -> bytes:
    """Contents of the file of a study's rows, from its tables in a result folder.

    Rows of a `summary`, which follow from all results together, come last.

    Raises
    ------
    FileNotFoundError, DamagedResultsError, SchemaVersionError
        If a table or the record is missing, damaged, or of another version.
    """
    study = next((study for study in STUDIES if study.files.name == files.name), None) or own_study(files.name)
    found = study.rows(folder)
    found.found += summary
    return parquet(found.frame())


def studies_in(folder: Path) -> list[Measuring]:
    """Studies whose results a folder holds; those of one's own, which have no tables, by their rows."""
    known = {study.files.name for study in STUDIES}
    own = sorted(file.stem for file in (folder / FOLDER).glob("*.parquet") if file.stem not in known)
    return [study for study in (*STUDIES, *map(own_study, own)) if study.files.has_record(folder)]


def own_study(name: str) -> Measuring:
    """Study of one's own, all of whose rows are those that its cases return."""
    return Measuring(StudyFiles(name, {}), lambda _: Rows(name), {})


def spread_rows(files: StudyFiles, folder: Path) -> pd.DataFrame:
    """Rows of one study in a result folder with a column for each tag; errors as :func:`study_rows`."""
    return spread(study_rows(next(study for study in STUDIES if study.files is files), folder))


def study_rows(study: Measuring, folder: Path) -> pd.DataFrame:
    """Rows of one study in a result folder.

    They are read if the study ended there. Of one that was interrupted, is still running, or was run by a barchain
    without rows, they are made of the tables.

    Raises
    ------
    FileNotFoundError, DamagedResultsError, SchemaVersionError
        As :func:`rows_content`.
    """
    own, name = study.files.folder(folder), rows_name(study.files)
    if os.path.lexists(own / name):
        record = study.files.sound_record(folder)
        content = recorded_content(own, name, record) if record.get(TABLES) else None
        if content is not None:
            return typed(parquet_frame(own / name, content, COLUMNS))
    return study.rows(folder).frame()


def rows_of(folder: Path) -> pd.DataFrame:
    """Rows of all results in a folder, in the columns of :mod:`reports.tables.rows`.

    Raises
    ------
    FileNotFoundError
        If the folder holds no results, or a study lacks a table.
    DamagedResultsError, SchemaVersionError
        As :func:`study_rows`.
    """
    import pandas as pd  # noqa: PLC0415

    found = [study_rows(study, folder) for study in studies_in(folder)]
    if not found:
        kinds = ", ".join(study.files.name for study in STUDIES)
        said = "no results there" if os.path.lexists(folder) else "no such folder"
        raise FileNotFoundError(f"{folder}: {said}; give a folder with results of: {kinds}")
    return pd.concat(found, ignore_index=True)
