"""View of a study of releases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.releases.charts import release_charts
from reports.tables.nights.releases import ReleaseState, read_releases
from reports.text.numerals import is_nan, significant
from reports.text.record import is_complete, mapping

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from reports.plotting.panels import Panel
    from reports.tables.nights.releases import ReleasesTables


@dataclass(frozen=True)
class ReleaseRow:
    """One release in words."""

    version: str
    released: str
    state: str
    runs: bool
    reason: str
    wheel: str
    installed: str
    importing: str
    ratio: str
    digits: str
    """Scenes in which the release gives other digits than the one before, and how many there are"""
    moved: str


@dataclass(frozen=True)
class ReleasesView:
    """Contents of the chapter."""

    record: dict[str, Any]
    charts: tuple[Panel, ...]
    rows: tuple[ReleaseRow, ...]
    summary: str

    @property
    def finished(self) -> bool:
        """Whether the study was finished."""
        return is_complete(self.record)

    @property
    def scenes(self) -> tuple[str, ...]:
        """Names of the scenes."""
        return tuple(mapping(self.record.get("scenes")))


def view_releases(folder: Path) -> ReleasesView:
    """View of the study in a result folder."""
    tables = read_releases(folder)
    rows = tuple(release_rows(tables))
    return ReleasesView(tables.record, release_charts(tables), rows, summary(tables, rows))


def summary(tables: ReleasesTables, rows: tuple[ReleaseRow, ...]) -> str:
    """Result in two sentences."""
    running = [row for row in rows if row.runs]
    states = f"{len(running)} of {len(rows)} releases of {tables.record.get('distribution')} run with this barchain"
    if not running:
        return f"{states}."
    changes = [row.version for row in running if row.digits not in {"", "the same digits"}]
    told = f"digits change with {', '.join(changes)}" if changes else "all of them agree in every digit"
    return f"{states}; {told}."


def release_rows(tables: ReleasesTables) -> list[ReleaseRow]:
    """Rows of the table, in the order of the releases."""
    found, before = [], None
    for row in tables.releases.to_dict("records"):
        version = str(row["version"])
        bits = digests(tables.runs, version)
        digits = ""
        if bits and before is not None:
            other = [scene for scene, word in bits.items() if before.get(scene) not in {None, word}]
            digits = f"other digits in {len(other)} of {len(bits)} scenes" if other else "the same digits"
        if bits:
            before = bits
        runs = row["state"] == ReleaseState.RUNS.value
        state, reason = partly(tables.errors, version) if runs else ("", "")
        found.append(
            ReleaseRow(
                version, row["released"], state or row["state"], runs, reason or row["reason"],
                megabytes(row["wheel_B"]), megabytes(row["installed_B"]), milliseconds(row["import_s"]),
                ratio_words(tables.times, version), digits, row["moved"],
            )
        )  # fmt: skip
    return found


def partly(errors: pd.DataFrame, version: str) -> tuple[str, str]:
    """State and reason of a release that runs in some scenes only; empty texts of one that runs in all."""
    own = errors[errors["version"].astype(str) == version]
    dead = own[own["quantity"] == ""]
    if not len(dead):
        return "", ""
    every = own["scene"].nunique()
    return f"runs in {every - dead['scene'].nunique()} of {every} scenes", str(dead["reason"].iloc[0])


def digests(runs: pd.DataFrame, version: str) -> dict[str, str]:
    """Trajectory of a release in each scene."""
    own = runs[runs["version"].astype(str) == version]
    return dict(zip(own["scene"], own["trajectory"], strict=True))


def ratio_words(times: pd.DataFrame, version: str) -> str:
    """Time at equal error relative to the anchor, at the finest common target."""
    own = times[times["version"].astype(str) == version]
    if not len(own):
        return ""
    row = own.iloc[-1]
    ends = f" ({significant(row['low'])} to {significant(row['high'])})" if not is_nan(row["low"]) else ""
    return f"{significant(row['ratio'])}{ends}"


def megabytes(size: float) -> str:
    """Size in MB; empty without one."""
    return "" if is_nan(size) else f"{significant(size / 1e6)} MB"


def milliseconds(time_s: float) -> str:
    """Time in ms; empty without one."""
    return "" if is_nan(time_s) else f"{significant(1e3 * time_s)} ms"
