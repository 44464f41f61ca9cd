"""A night from result folders: figures from rows by the rules that each study declares, one figure of each name."""

from __future__ import annotations

import datetime
import math
from collections import defaultdict
from typing import TYPE_CHECKING, Any

from adapters.registry import engines
from barchain.nightly.errors import HistoryError
from barchain.nightly.figures.changes import SCALES
from barchain.nightly.figures.dependencies import (
    VARIABLES,
    Installation,
    depends_on,
    environment_parts,
    recorded_environment,
)
from barchain.nightly.figures.figure import (
    MACHINE,
    WORDED,
    Figure,
    FigureIdentity,
    FigureKind,
    FigureUnit,
    Night,
    NightPart,
    content_digest,
)
from barchain.nightly.figures.steps import LEAST_EFFECT
from reports.results import studies
from reports.results.comparison import FILES as COMPARISON
from reports.results.comparison import is_engine
from reports.results.reading import brief, damaged
from reports.results.rows import BITS, NOT_COMPARED, NOT_RUN, RELATIVE_TO, is_count, parsed_tags, records, was_run

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    import pandas as pd

    from reports.results.files import StudyFiles
    from reports.results.rows import Followed, Row


NO_NUMBER = "no number is stored"
STUDY_SEPARATOR = "."
PAGE_B = 4096
LEAST_MEMORY_B = PAGE_B / LEAST_EFFECT
"""What a smaller peak memory counts as: of one of 20 pages, a page more or less would be a step"""
Key = tuple[str, ...]


def figures_of(rows: pd.DataFrame, followed: Mapping[str, Followed]) -> tuple[Figure, ...]:
    """Figures of the rows of one study.

    Of two rows of one name, which differ in what the name leaves out, a rule of their kind says which stands.

    Parameters
    ----------
    rows : DataFrame
        Columns of :mod:`reports.results.rows`.
    followed : mapping
        Rule of each metric that nights follow.
    """
    every = {key_of(row): row for row in records(rows)}
    depends: dict[tuple[str, str, FigureKind, str], Key] = {}
    found: dict[FigureIdentity, Figure] = {}
    for row in every.values():
        rule = followed.get(row["metric"])
        identity = None if rule is None else identity_of(row, rule)
        if rule is None or identity is None:
            continue
        parts = (identity.scene, identity.engine, identity.kind, identity.anchor)
        if parts not in depends:
            depends[parts] = depends_on(*parts)
        worded = identity.kind in WORDED
        figure = word(identity, row, depends[parts]) if worded else number(identity, row, rule, every, depends[parts])
        there = found.setdefault(identity, figure)
        if there is not figure and identity.kind is FigureKind.VERDICT:
            found[identity] = preferred(there, figure)
    return tuple(found.values())


def key_of(row: Row, **other: str) -> Key:
    """Identity of a row, or that of a row that differs in some columns."""
    columns = ("scene", "engine", "setting", "tags", "quantity", "metric")
    return tuple(str(other.get(name, row[name])) for name in columns)


def identity_of(row: Row, rule: Followed) -> FigureIdentity | None:
    """Identity of a row's figure; None of a row that is not followed: about several engines, or not worth it."""
    kind, value = FigureKind(rule.kind), row["value"]
    several = row["scene"].startswith("(") or (row["study"] == COMPARISON.study and not is_engine(row["engine"]))
    unknown_unit = row["unit"] not in set(FigureUnit)
    broken = kind is FigureKind.COUNT and not is_count(value)
    if several or unknown_unit or broken or {row["engine"], row["quantity"]} & set(rule.besides):
        return None
    tags = parsed_tags(row["tags"])
    values: dict[str, Any] = defaultdict(lambda: LACKING, row | tags)
    values |= {name: LACKING for name, given in values.items() if isinstance(given, float) and math.isnan(given)}
    parts = [part.format_map(values) for part in rule.quantity.split(STUDY_SEPARATOR)]
    study = "" if row["study"] == COMPARISON.study else str(row["study"])  # begins the quantity's name
    quantity = STUDY_SEPARATOR.join(part for part in (study, *parts) if part)
    setting, anchor = rule.setting.format_map(values), str(tags.get(RELATIVE_TO, ""))
    unit = FigureUnit.NONE if kind in WORDED else FigureUnit(row["unit"] or "1")
    scene, engine, setting, quantity = map(brief, (row["scene"], row["engine"], setting, quantity))
    relative = brief(anchor) if kind is FigureKind.RATIO else ""
    return FigureIdentity(scene, engine, setting, quantity, kind, unit, relative)


class Lacking(float):
    """Number that a row lacks: ``nan`` where a name asks for its digits, and else empty."""

    def __format__(self, spec: str) -> str:
        """Text in a name."""
        return format(math.nan, spec) if spec else ""


LACKING = Lacking("nan")


def word(identity: FigureIdentity, row: Row, parts: Key) -> Figure:
    """Figure of a digest or an outcome; without one it is missing, for the row's reason."""
    if identity.kind is FigureKind.BITS:
        found, reason = row["text"], "" if row["text"] else row["reason"] or row["outcome"]
    elif not was_run(row["outcome"]):
        found, reason = "", reason_of(row)
    else:
        found, reason = row["outcome"], row["reason"]
    return Figure(identity, word=found, reason=brief(reason) or ("" if found else NO_NUMBER), depends=parts)


def number(identity: FigureIdentity, row: Row, rule: Followed, every: Mapping[Key, Row], parts: Key) -> Figure:
    """Figure of a number; one that is not finite, or that tells nothing, is missing for the row's reason."""
    least = LEAST_MEMORY_B if identity.kind is FigureKind.MEMORY else -math.inf
    value = real(row["value"], least)
    if value is None or row["outcome"] == NOT_COMPARED or not was_run(row["outcome"]):
        return Figure(identity, reason=brief(reason_of(row)) or NO_NUMBER, depends=parts)
    within = every.get(key_of(row, metric=rule.within)) if rule.within else None
    bits = every.get(key_of(row, tags="", quantity="", metric=BITS)) if rule.trajectory else None
    return Figure(
        identity, value, "", real(row["low"], least), real(row["high"], least),
        None if within is None else real(within["value"]), "" if bits is None else bits["text"], parts,
    )  # fmt: skip


def reason_of(row: Row) -> str:
    """Why a row has no result: its reason, else its outcome; of what was not run both."""
    if not was_run(row["outcome"]):
        return f"{NOT_RUN}: {row['reason']}"
    return str(row["reason"] or row["outcome"])


def real(value: Any, least: float = -math.inf) -> float | None:
    """Finite number, raised to the least one that counts, or None."""
    return max(float(value), least) if math.isfinite(value) else None


LARGER = frozenset({FigureKind.ERROR, FigureKind.COUNT, FigureKind.RATIO, FigureKind.MEMORY})
"""Kinds of which more is worse: the larger number stands"""


def merged(figures: Iterable[Figure]) -> tuple[Figure, ...]:
    """Figures of one night.

    Parameters
    ----------
    figures : iterable of Figure
        Of all folders, in the order of the plan's parts.

    Returns
    -------
    tuple of Figure
        One of each name.
    """
    found: dict[FigureIdentity, Figure] = {}
    for figure in figures:
        there = found.get(figure.identity)
        found[figure.identity] = figure if there is None else preferred(there, figure)
    return tuple(found.values())


def preferred(first: Figure, second: Figure) -> Figure:
    """Figure that stands for two of one name.

    One with a result stands for one without. Of two verdicts the graver one stands, of two errors, counts, ratios or
    memories the larger one, of two other numbers the first one: their plan says which part that is. Two digests of one
    trajectory contradict each other, so that the figure is missing.
    """
    if second.missing or (first.value, first.word) == (second.value, second.word):
        return first
    if first.missing:
        return second
    kind = first.identity.kind
    if kind in LARGER:
        return max(first, second, key=lambda figure: figure.value or 0.0)
    if kind is FigureKind.VALUE:
        return first
    scale = next((scale for scale in SCALES if first.word in scale and second.word in scale), None)
    if kind is FigureKind.VERDICT and scale is not None:
        return max(first, second, key=lambda figure: scale.index(figure.word))
    said = brief(f"two parts of the night differ: {first.word[:100]}, {second.word[:100]}")
    return Figure(first.identity, reason=said, depends=(*first.depends, *second.depends))


SUBJECTS = ("scenes", "engines", "bars", "faults")
STUDIES = tuple(files for files in studies.STUDIES if files.followed)
"""Kinds of results that nights follow"""


def read_figures_of(folder: Path) -> tuple[Figure, ...]:
    """Figures of all results in a folder; errors as :func:`read_night`."""
    return tuple(f for files in found_in(folder) for f in figures_of(files.rows(folder), files.followed))


def read_night(*folders: Path) -> Night:
    """Night of result folders: their figures, and what their records say of environment and parts.

    Records hold versions, and no digests of installed files: those parts are known by version only.

    Raises
    ------
    HistoryError
        If a folder holds no results.
    FileNotFoundError, DamagedResultsError, SchemaVersionError
        If a table or a record is missing, damaged, or of another version.
    """
    read = records_of(folders)
    figures = merged(figure for folder in folders for figure in read_figures_of(folder))
    first = min((record for _, record in read), key=lambda record: started(folders[0], record))
    environment = recorded_environment(first)
    return Night(
        started=started(folders[0], first),
        duration_s=sum(float(record.get("seconds") or 0.0) for _, record in read),
        plan=plan_of(read),
        barchain=str(first.get("barchain") or ""),
        environment=environment,
        parts=known_parts([record for _, record in read], environment_parts(environment), figures),
        figures=figures,
        complete=all(bool(record.get("complete")) for _, record in read),
    )


def night_here(folders: Sequence[Path], installation: Installation, *, complete: bool = True, **more: Any) -> Night:
    """Night of result folders that this installation has just written: parts have the digests of the installed files.

    Parameters
    ----------
    folders : sequence of Path
        In the order of the plan. A figure that stands in several folders is chosen by :func:`merged`.
    installation : Installation
        That the results come from.
    complete : bool
        Whether all of the plan was done; a folder whose record is incomplete makes the night incomplete too.
    **more
        Further fields of the night: ``started``, ``duration_s``, ``plan``, ``void``, ``label``.

    Raises
    ------
    HistoryError, FileNotFoundError, DamagedResultsError, SchemaVersionError
        As :func:`read_night`.
    """
    figures = merged(figure for folder in folders for figure in read_figures_of(folder))
    records = [record for _, record in records_of(folders)]
    needed = {name for figure in figures for name in figure.depends}
    return Night(
        barchain=installation.barchain,
        environment=installation.environment,
        commit=installation.commit,
        parts=known_parts(records, [part for part in installation.parts if part.name in needed], figures),
        figures=figures,
        complete=complete and all(bool(record.get("complete")) for record in records),
        **more,
    )


def records_of(folders: Iterable[Path]) -> list[tuple[StudyFiles, dict[str, Any]]]:
    """Records of all results in some folders, each with its kind of results."""
    return [(files, files.sound_record(folder)) for folder in folders for files in found_in(folder)]


def found_in(folder: Path) -> list[StudyFiles]:
    """Kinds of results that a folder holds."""
    if not folder.is_dir():
        raise HistoryError(f"{folder}: no such folder; give one that barchain wrote results into")
    found = [files for files in STUDIES if files.has_record(folder)]
    if not found:
        others = [files.study for files in studies.STUDIES if files.has_record(folder)]
        said = f"{folder}: results of {', '.join(others)}, of which nights follow no figure"
        raise HistoryError(said if others else studies.no_results(folder))
    return found


def has_results(folder: Path) -> bool:
    """Whether a study began to write results that nights follow."""
    return any(files.has_record(folder) for files in STUDIES)


def started(folder: Path, record: Mapping[str, Any]) -> datetime.datetime:
    """Start of a study, UTC."""
    said = str(record.get("created") or "")
    try:
        found = datetime.datetime.fromisoformat(said)
        return found.astimezone(datetime.UTC)
    except (ValueError, OverflowError):
        raise damaged(folder, f"its record was created {said[:40]!r}, which is no date") from None


def known_parts(
    found: Sequence[Mapping[str, Any]], below: Iterable[NightPart], figures: Sequence[Figure]
) -> tuple[NightPart, ...]:
    """Parts that figures depend on, with what the records know of each."""
    parts, registered = {part.name: part for part in below}, engines()
    own = str(next((record["barchain"] for record in found if record.get("barchain")), ""))
    versions = {name: str(version) for record in found for name, version in (record.get("packages") or {}).items()}
    for name, facts in entries_of(found, "engines"):
        if name in registered and facts.get("version"):
            versions[registered[name].distribution or registered[name].requires] = str(facts["version"])
    digests = {f"scene:{name}": str(facts.get("digest") or "") for name, facts in entries_of(found, "scenes")}
    for name in {name for figure in figures for name in figure.depends} - {MACHINE} - set(parts):
        kind, _, rest = name.partition(":")
        if kind in {"engine", "library"}:
            version = versions.get(rest, "")
        else:  # a scene, a solution, variables and a program have no version of barchain
            version = "" if kind in {"scene", "solution", "program", VARIABLES} else own
        parts[name] = NightPart(name, version, digests.get(name, ""))
    return tuple(parts.values())


def entries_of(found: Sequence[Mapping[str, Any]], entry: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Names in an entry of records, with the facts of each; a list of names alone has none."""
    for record in found:
        if isinstance(record.get(entry), dict):
            yield from ((name, facts) for name, facts in record[entry].items() if isinstance(facts, dict))


def plan_of(read: Sequence[tuple[StudyFiles, Mapping[str, Any]]]) -> str:
    """Kinds of results, and a digest of their scenes and engines: folders of the same plan have the same figures."""
    asked = []
    for files, record in read:
        entries = (record.get(entry) for entry in SUBJECTS)
        names = [sorted(map(str, entry)) if isinstance(entry, (dict, list)) else [] for entry in entries]
        asked.append([files.study, *names])
    return f"{', '.join(sorted(files.study for files, _ in read))} {content_digest(sorted(asked))[:8]}"
