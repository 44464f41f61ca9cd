"""The data set of all cases: beside their folders an index, terms, a page on citing, a changelog, and a data package.

`datapackage.json` follows Frictionless Data's Data Package and Table Schema, version 1. No file has a date: equal input
gives equal bytes.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
from collections import Counter
from functools import cache as remembered
from importlib.metadata import distribution
from typing import TYPE_CHECKING, Any

from barchain.result_files.case import MODEL, PROGRAM, plain_templates
from barchain.result_files.difficulty import GRADES
from barchain.solutions.case_versions import TABLE, current, data_set_version
from reports.results.writing import write_atomically
from scenarios.channels import COMPARED, TIME, numbered_part

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from scenarios import Scene

NAME = "barchain-cases"
CREATORS = "The barchain team"
LICENCE = {
    "name": "CC-BY-4.0",
    "title": "Creative Commons Attribution 4.0 International",
    "path": "https://creativecommons.org/licenses/by/4.0/",
}
SOURCE = {
    "title": "P. Gasbarri, A two-dimensional approach to multibody free dynamics in space environment, "
    "Acta Astronautica 51(12), 2002",
    "path": "https://doi.org/10.1016/S0094-5765(02)00032-2",
}  # fmt: skip
MEDIA = {
    "csv": "text/csv", "json": "application/json", "md": "text/markdown", "svg": "image/svg+xml", "html": "text/html",
    "xml": "application/xml", "py": "text/x-python",
}  # fmt: skip
PACKAGE, INDEX, CHANGELOG = "datapackage.json", "cases.csv", "changelog.csv"
TEXTS = {
    "identifier": "Identifier to cite, with the version of the values",
    "scene": "Folder of the case, and name of its scene in barchain",
    "title": "What moves",
    "grade": "Difficulty",
    "needed_rtol": "Coarsest requested error, of 1e-6, 1e-8, 1e-10 and 1e-12, at which the motion is predictable to "
    "the end; empty if none is",
    "digits_lost": "Decimal logarithm of the growth of a small error of the start by the end, at most 16",
    "jumps": "Instants inside the run at which a force or a law, or its slope, jumps",
    "faces": "Whether bars turn their other face to wind or Sun, where a force has a kink",
    "fastest_radians": "Duration times the fastest rate of the chain, rad: the work of an explicit method",
    "bars": "Number of bars",
    "duration_s": "Duration, s",
    "samples": "Rows of the table",
    "data_set": "Version of the data set that has this version first",
    "digest": "Beginning of the SHA-256 of the values, column by column, as little-endian doubles",
    "change": "What changed, and why",
}  # fmt: skip
"""Meanings of the columns of the index and of the changelog"""
NUMBERS = {"needed_rtol": "number", "digits_lost": "number", "jumps": "integer", "faces": "boolean",
           "fastest_radians": "integer", "bars": "integer", "duration_s": "number", "samples": "integer"}  # fmt: skip
"""Types of those that are no text"""


def folder_name() -> str:
    """Name of the data set's folder, with its version."""
    return f"{NAME}-{data_set_version()}"


def terms(*, programs: bool) -> str:
    """Text of the licence; with `programs`, also that of barchain's programs beside the data."""
    code = (distribution("barchain").read_text("licenses/LICENSE") or "") if programs else ""
    return text("terms.txt.j2", licence=LICENCE, data_set=folder_name(), names=(MODEL, PROGRAM), code=code)


def write_surroundings(folder: Path, scenes: Iterable[Scene]) -> None:
    """Write what makes the folders of cases a data set.

    Parameters
    ----------
    folder : Path
        With the folder of each case, as written by `barchain.result_files.case.write_case`.
    scenes : iterable of Scene
    """
    rows = [index_row(folder, scene) for scene in scenes]
    graded = Counter(str(row["grade"]) for row in rows)
    shown = {"data_set": folder_name(), "version": data_set_version(), "licence": LICENCE, "creators": CREATORS,
             "example": rows[0], "cases": len(rows)}  # fmt: skip
    counts = [(grade, graded[grade], meaning) for grade, meaning in GRADES.items()]
    texts = {
        "README.md": text("data_set.md.j2", **shown, grades=counts, columns=TEXTS, source=SOURCE),
        "CITING.md": text("citing.md.j2", **shown),
        "LICENSE": terms(programs=False),
        INDEX: table(rows),
        CHANGELOG: TABLE.read_text(encoding="utf-8"),
    }
    for name, content in texts.items():
        write_atomically(folder / name, content)
    write_atomically(folder / PACKAGE, json.dumps(package(folder), indent=1, ensure_ascii=False) + "\n")


def index_row(folder: Path, scene: Scene) -> dict[str, object]:
    """Row of a case in the index, from its own files."""
    facts = json.loads((folder / scene.name / "settings.json").read_text(encoding="utf-8"))
    return {
        "identifier": facts["identifier"], "scene": scene.name, "title": scene.title, **facts["difficulty"],
        "bars": scene.bars, "duration_s": facts["duration_s"], "samples": facts["samples"],
        "digest": current()[scene.name].digest,
    }  # fmt: skip


def table(rows: list[dict[str, object]]) -> str:
    """CSV table of rows with the same keys."""
    made = io.StringIO()
    writer = csv.DictWriter(made, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: str(v).lower() if isinstance(v, bool) else v for k, v in row.items()} for row in rows)
    return made.getvalue()


def package(folder: Path) -> dict[str, Any]:
    """Data package of a folder: every file with its size and hash, every table with its columns."""
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != PACKAGE)
    return {
        "profile": "data-package",
        "name": NAME,
        "version": data_set_version(),
        "title": "Chains of rigid bars in orbit: reference motions with error bars",
        "description": "Motions in quadruple precision to compare programs with. SI units; units end names of columns.",
        "licenses": [LICENCE],
        "contributors": [{"title": CREATORS, "role": "author"}],
        "sources": [SOURCE],
        "keywords": ["multibody dynamics", "space dynamics", "benchmark", "reference solution"],
        "resources": [resource(folder, path) for path in files],
    }


def resource(folder: Path, path: Path) -> dict[str, Any]:
    """One file of the package."""
    place, content = path.relative_to(folder), path.read_bytes()
    ending = path.suffix.lstrip(".")
    found: dict[str, Any] = {
        "name": "-".join(place.with_suffix("").parts).lower() + (f"-{ending}" if ending and ending != "csv" else ""),
        "path": place.as_posix(),
        "format": ending or "txt",
        "mediatype": MEDIA.get(ending, "text/plain"),
        "encoding": "utf-8",
        "bytes": len(content),
        "hash": f"sha256:{hashlib.sha256(content).hexdigest()}",
    }
    if ending == "csv":
        names = next(csv.reader(io.StringIO(content.decode("utf-8").partition("\n")[0])))
        key = TIME if TIME in names else "identifier"
        fields = [field(name) for name in names]
        found |= {"profile": "tabular-data-resource"}
        found["schema"] = {"fields": fields, "primaryKey": key, "missingValues": [""]}
    return found


def field(column: str) -> dict[str, str]:
    """Column of a table: name, type and description with its unit."""
    if column in TEXTS:
        return {"name": column, "type": NUMBERS.get(column, "string"), "description": TEXTS[column]}
    return {"name": column, "type": "number", "description": meanings()[(numbered_part(column) or (column,))[0]]}


@remembered
def meanings() -> dict[str, str]:
    """Descriptions of the columns of a case by pattern, ``{}`` for the number of a bar or joint, with their units."""
    found = {TIME: "Instant of the sample; s"}
    for channel in COMPARED:
        found |= {pattern: f"{channel.meaning.rstrip('.')}; {channel.unit}" for pattern in channel.columns}
        bar = "of the largest difference over bars or joints" if channel.of.numbered else "of the vector's length"
        found[f"error_{channel.column_of()}"] = f"Error bar of the {channel.words}, {bar}; {channel.unit}"
    return found


def text(template: str, **shown: Any) -> str:
    """Text of a template of plain text."""
    made = plain_templates(trim_blocks=True, keep_trailing_newline=True)
    return made.get_template(template).render(shown)
