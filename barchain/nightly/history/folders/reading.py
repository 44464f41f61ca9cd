"""A night from result folders of barchain."""

from __future__ import annotations

import datetime
from typing import TYPE_CHECKING, Any

from adapters.registry import engines
from barchain.nightly.history.faults import HistoryError
from barchain.nightly.history.folders.figures import figures_of
from barchain.nightly.history.folders.merging import merged
from barchain.nightly.history.model.environment import capture, recorded_environment
from barchain.nightly.history.model.figures import MACHINE, Night, NightPart
from barchain.nightly.history.model.identity import content_digest
from barchain.nightly.history.model.installation import Installation, installation_here
from barchain.nightly.history.model.parts import VARIABLES, environment_parts, scene_part
from barchain.record.environment import package_version
from reports.tables import measured
from reports.tables.reading import damaged
from scenarios import scene_names

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from barchain.nightly.history.model.figures import Figure, FigureIdentity
    from reports.tables.files import StudyFiles
    from reports.tables.measured import Measuring

SUBJECTS = ("scenes", "engines", "bars", "faults")
STUDIES = tuple(study for study in measured.STUDIES if study.followed)
"""Kinds of results that nights follow"""


def read_figures_of(folder: Path) -> tuple[Figure, ...]:
    """Figures of all results in a folder; errors as :func:`read_night`."""
    return tuple(
        f for study in found_in(folder) for f in figures_of(measured.study_rows(study, folder), study.followed)
    )


def read_night(folder: Path) -> Night:
    """Night of a result folder: its figures, and what its records say of environment and parts.

    Records hold versions, and no digests of installed files: those parts are known by version only.

    Raises
    ------
    HistoryError
        If the folder holds no results.
    FileNotFoundError, DamagedResultsError, SchemaVersionError
        If a table or a record is missing, damaged, or of another version.
    """
    found = found_in(folder)
    read = [(study.files, study.files.sound_record(folder)) for study in found]
    figures = read_figures_of(folder)
    first = min((record for _, record in read), key=lambda record: started(folder, record))
    environment = recorded_environment(first)
    return Night(
        started=started(folder, first),
        duration_s=sum(float(record.get("seconds") or 0.0) for _, record in read),
        plan=plan_of(read),
        barchain=str(first.get("barchain") or ""),
        environment=environment,
        parts=known_parts([record for _, record in read], environment_parts(environment), figures),
        figures=figures,
        complete=all(bool(record.get("complete")) for _, record in read),
    )


def night_here(
    folders: Sequence[Path],
    *,
    started: datetime.datetime,
    duration_s: float,
    plan: str,
    complete: bool = True,
    void: str | None = None,
    installation: Installation | None = None,
    label: str = "",
) -> Night:
    """Night of result folders that this installation has just written: parts have the digests of the installed files.

    Parameters
    ----------
    folders : sequence of Path
        In the order of the plan. A figure that stands in several folders is chosen by :func:`merged`.
    started : datetime
        UTC.
    duration_s : float
    plan : str
        Digest of the plan: nights of the same plan are expected to have the same figures.
    complete : bool
        Whether all of the plan was done; a folder whose record is incomplete makes the night incomplete too.
    void : str, optional
        Why the night can't be believed.
    installation : Installation, optional
        That the results come from; the one of this process by default.
    label : str
        Ending of the night's name; the first digits of its content by default.

    Raises
    ------
    HistoryError, FileNotFoundError, DamagedResultsError, SchemaVersionError
        As :func:`read_night`.
    """
    figures = merged(figure for folder in folders for figure in read_figures_of(folder))
    records = [record for _, record in records_of(folders)]
    own = installation or installation_behind([figure.identity for figure in figures])
    needed = {name for figure in figures for name in figure.depends}
    parts = known_parts(records, [part for part in own.parts if part.name in needed], figures)
    done = complete and all(bool(record.get("complete")) for record in records)
    return Night(
        started, duration_s, plan, own.barchain, own.environment, parts, figures, own.commit, done, void, label
    )


def records_of(folders: Iterable[Path]) -> list[tuple[StudyFiles, dict[str, Any]]]:
    """Records of all results in some folders, each with its kind of results."""
    return [(study.files, study.files.sound_record(folder)) for folder in folders for study in found_in(folder)]


def recorded_installation(folders: Sequence[Path]) -> Installation:
    """Installation as the records of result folders know it: versions, and no digests of installed files."""
    records = [record for _, record in records_of(folders)]
    first = min(records, key=lambda record: str(record.get("created") or ""), default=None)
    environment = capture() if first is None else recorded_environment(first)
    own = package_version("barchain") if first is None else str(first.get("barchain") or "")
    return Installation(own, environment, environment_parts(environment))


def installation_behind(found: Sequence[FigureIdentity]) -> Installation:
    """Installation of this process behind some figures."""
    named = {name for i in found for name in (i.engine, i.anchor)} & set(engines())
    return installation_here(named, {i.scene for i in found} & set(scene_names()))


def found_in(folder: Path) -> list[Measuring]:
    """Kinds of results that a folder holds."""
    if not folder.is_dir():
        raise HistoryError(f"{folder}: no such folder; give one that barchain wrote results into")
    found = [study for study in STUDIES if study.files.has_record(folder)]
    if not found:
        kinds = ", ".join(study.files.name for study in STUDIES)
        raise HistoryError(f"{folder}: no results there; a night is made from those of: {kinds}")
    return found


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
    parts = {part.name: part for part in below}
    own = str(next((record["barchain"] for record in found if record.get("barchain")), ""))
    versions = {name: str(version) for record in found for name, version in (record.get("packages") or {}).items()}
    versions |= {name: version for record in found for name, version in engine_versions(record).items()}
    digests = {name: digest for record in found for name, digest in scene_digests(record).items()}
    for name in {name for figure in figures for name in figure.depends} - {MACHINE} - set(parts):
        kind, _, rest = name.partition(":")
        version = (
            versions.get(rest, "") if kind in {"engine", "library"} else "" if kind in {"scene", VARIABLES} else own
        )
        parts[name] = NightPart(name, version, digests.get(name, ""))
    return tuple(parts.values())


def engine_versions(record: Mapping[str, Any]) -> dict[str, str]:
    """Versions of the distributions behind a record's engines, by the names of the distributions."""
    registered, found = engines(), {}
    entries = record.get("engines")
    for name, facts in entries.items() if isinstance(entries, dict) else ():
        if name in registered and isinstance(facts, dict) and facts.get("version"):
            distribution = registered[name].distribution or registered[name].requires
            if distribution:
                found[distribution] = str(facts["version"])
    return found


def plan_of(read: Sequence[tuple[StudyFiles, Mapping[str, Any]]]) -> str:
    """Kinds of results, and a digest of their scenes and engines: folders of the same plan have the same figures."""
    asked = [[files.name, *(names_in(record.get(entry)) for entry in SUBJECTS)] for files, record in read]
    return f"{', '.join(sorted(files.name for files, _ in read))} {content_digest(sorted(asked))[:8]}"


def names_in(entry: Any) -> list[str]:
    """Names of an entry of a record: of scenes or engines, by name or as a list."""
    return sorted(map(str, entry)) if isinstance(entry, (dict, list)) else []


def scene_digests(record: Mapping[str, Any]) -> dict[str, str]:
    """Digests of a record's scenes, by the names of their parts; empty texts where the record has none."""
    scenes = record.get("scenes")
    entries = scenes.items() if isinstance(scenes, dict) else ()
    return {scene_part(name): str(facts.get("digest") or "") for name, facts in entries if isinstance(facts, dict)}
