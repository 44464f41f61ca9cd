"""Tables of the studies of releases, from the record: one of each library, and one of all for their page."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from pictures.pages.record import MeasuredRecord, rows
from pictures.pages.words import SIGNS, outcome_text, short, table
from pictures.record.releases import STUDIED
from reports.results.releases import ReleaseState

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from pictures.pages.libraries import EngineLibrary
    from pictures.pages.record import Row

NAME = "releases"
RUNS = ReleaseState.RUNS.value
SAME = "the same digits"
HEAD = ("releases", "released", "result", "digits", "time at equal error", "import, s:", "wheel, MB:")


def library_releases(library: EngineLibrary, measured: MeasuredRecord) -> str:
    """Table of a library's releases; those in a row that give the same digits share a line. Empty without a record."""
    found = of_engines(measured, library.engines)
    return table(HEAD, map(line, spans(found))) if found else ""


def is_studied(library: EngineLibrary) -> bool:
    """Whether the releases of one of a library's engines are measured."""
    return any(engine in STUDIED for engine in library.engines)


def of_engines(measured: MeasuredRecord, engines: Iterable[str]) -> list[Row]:
    """Releases of the one of some engines whose releases were measured."""
    frame = measured.releases
    return rows(frame[frame.engine.isin(list(engines))])


def spans(found: Sequence[Row]) -> list[list[Row]]:
    """Releases in a row that give the same result."""
    joined: list[list[Row]] = [[row] for row in found[:1]]
    for before, row in pairwise(found):
        if alike(before, row):
            joined[-1].append(row)
        else:
            joined.append([row])
    return joined


def alike(before: Row, row: Row) -> bool:
    """Whether a release gives the result of the one before."""
    if before["state"] != row["state"] or before["verdicts"] != row["verdicts"]:
        return False
    return bool(row["digits"] == SAME if row["state"] == RUNS else before["reason"] == row["reason"])


def line(span: Sequence[Row]) -> list[str]:
    """Line of releases that give the same result."""
    first, last = span[0], span[-1]
    many = len(span) > 1
    return [
        f"{first['version']} to {last['version']} ({len(span)})" if many else first["version"],
        f"{first['released']} to {last['released']}" if many else first["released"],
        result(first),
        first["digits"],
        times(span),
        spread(row["import_s"] for row in span),
        spread(row["wheel_MB"] for row in span),
    ]


def result(row: Row) -> str:
    """Outcomes of a release on its scenes, or why it does not run."""
    if row["state"] != RUNS:
        return f"✗ {row['state']}: {row['reason']}"
    words = row["verdicts"].split(", ")
    return ", ".join(outcome_text(word) if word in SIGNS else word for word in words)


def times(span: Sequence[Row]) -> str:
    """Times of releases relative to the compiled reference, each with the error at which they were compared."""
    errors = dict.fromkeys(row["at"] for row in span if row["ratio"] is not None)
    return ", ".join(f"×{spread(r['ratio'] for r in span if r['at'] == at)} at {at}" for at in errors)


def spread(values: Iterable[float | None]) -> str:
    """Least and largest of some numbers; empty without any."""
    known = sorted({value for value in values if value is not None})
    if not known:
        return ""
    low, high = short(known[0]), short(known[-1])
    return low if low == high else f"{low} to {high}"


def releases_of_engines() -> str:
    """Line of each engine whose releases were measured."""
    measured = MeasuredRecord()
    frame = measured.releases
    own = [of_engines(measured, [engine]) for engine in dict.fromkeys(frame.engine)]
    head = ("engine", "releases", "run", "digits change with", "verdicts", "time at equal error", "import, s:")
    return f"{introduction(measured)}\n\n{table(head, map(summary, own))}"


def introduction(measured: MeasuredRecord) -> str:
    """Sentence on the measurement."""
    run = next(facts for stage, facts in measured.runs.items() if stage.startswith(NAME))
    return (
        f"Measured on {run['created']} with barchain {run['barchain']} on {run['environment']['cpu']}, Python "
        f"{run['environment']['python']}. Times are relative to `reference-fast`."
    )


def summary(found: Sequence[Row]) -> list[str]:
    """Line of an engine."""
    running = [row for row in found if row["state"] == RUNS]
    other = [row["version"] for row in running if row["digits"] not in {"", SAME}]
    words = sorted({word for row in running for word in row["verdicts"].split(", ") if word})
    return [
        f"`{found[0]['engine']}`",
        f"{found[0]['version']} to {found[-1]['version']}",
        f"{len(running)} of {len(found)}",
        ", ".join(other) or "none",
        ", ".join(map(outcome_text, words)),
        times(running),
        spread(row["import_s"] for row in running),
    ]


TABLES: dict[str, Callable[[], str]] = {"releases": releases_of_engines}
"""Tables by their names"""
