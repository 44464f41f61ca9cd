"""Page of one library: how its engines work, and their measured record."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from pictures.pages.docstrings import paragraphs
from pictures.pages.libraries import LIBRARIES, EngineLibrary
from pictures.pages.record import rows
from pictures.pages.releases import is_studied, library_releases
from pictures.pages.scene_page import link, page_of
from pictures.pages.words import errors, outcome_text, short, stability_text, table
from pictures.paths import DOCS, ENGINE_PAGES
from pictures.templating import render
from reports.text.numerals import as_given

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import pandas as pd

    from pictures.pages.record import MeasuredRecord, Row

COST_SCENE = "paper/fig05"
MOST_COLUMNS = 5
"""Engines side by side in a page's column of text; more have further tables"""


def page_file(library: EngineLibrary) -> Path:
    """File of a library's page."""
    return ENGINE_PAGES / f"{library.page}.md"


def engine_page(library: EngineLibrary, measured: MeasuredRecord) -> str:
    """Markdown of a library's page."""
    page = page_file(library)
    return render(
        "engine.md.j2",
        library=library,
        facts=table(("fact", "value"), facts(library, measured)),
        paragraphs=paragraphs(library.package),
        variants=variants(library),
        lacking=lacking(library),
        effects_page=link(page, DOCS / "effects" / "README.md"),
        compared=compared(library, measured),
        sweep=sweep(library, measured),
        orders=orders(library, measured),
        reach=reach(library, measured),
        chart=f"{library.page}-cost.svg" if charted(library, measured) else "",
        stability=stability(library, measured),
        runs=measured.runs,
        cost_scene=COST_SCENE,
        releases=library_releases(library, measured),
        studied=is_studied(library),
        releases_page=link(page, DOCS / "engines" / "releases.md"),
        stability_page=link(page, DOCS / "studies" / "stability.md"),
    )


def facts(library: EngineLibrary, measured: MeasuredRecord) -> list[tuple[str, str]]:
    """Facts of a library in two columns."""
    registrations = list(library.engines.values())
    first = registrations[0]
    version = measured.versions.get(next(iter(library.engines)), "")
    name = f"[{library.title}]({library.home})" if library.home else library.title
    physics = "independent physics" if first.external else "integrator on barchain's equations, no check of the physics"
    installs = dict.fromkeys(r.install for r in registrations if r.install)
    return [
        ("library", f"{name} {version}".strip()),
        ("physics", physics),
        ("licence", library.licence),
        ("installation", ", ".join(f"`{command}`" for command in installs) or "comes with barchain"),
    ]


def variants(library: EngineLibrary) -> str:
    """Table of the library's engines."""
    head = (
        "engine",
        "description",
        "coordinates",
        "order",
        "accuracy parameter",
        "default",
        "sweep",
        "in a comparison",
    )
    lines = []
    for name, registration in library.engines.items():
        engine = registration.declarations()
        values = engine.sweep.values
        order = "step control" if engine.order is None else as_given(engine.order)
        sweep = f"{as_given(values[0])} to {as_given(values[-1])}"
        taken = "by default" if registration.in_default_set else "if named"
        parameter = engine.sweep.parameter.value.replace("_", " ")
        default = as_given(engine.sweep.default)
        lines.append([f"`{name}`", engine.title, engine.coordinates.value, order, parameter, default, sweep, taken])
    return table(head, lines)


def lacking(library: EngineLibrary) -> str:
    """Table of effects that engines of the library do not support, with the reason; empty if there are none."""
    every = LIBRARIES[0].engines["reference"].declarations().effects
    found: dict[tuple[str, str], list[str]] = {}
    for name, registration in library.engines.items():
        engine = registration.declarations()
        for effect in sorted(set(every).difference(engine.effects)):
            reason = engine.unsupported_reasons.get(effect, "not in its equations")
            found.setdefault((name, reason), []).append(effect.replace(".", ": ").replace("_", " "))
    same: dict[tuple[str, str], list[str]] = {}
    for (name, reason), effects in found.items():
        same.setdefault((", ".join(effects), reason), []).append(name)
    many = len(library.engines) > 1
    lines = [[effects, *([", ".join(names)] if many else []), reason] for (effects, reason), names in same.items()]
    head = ("effects", *(["engines"] if many else []), "reason")
    return table(head, lines) if lines else ""


def compared(library: EngineLibrary, measured: MeasuredRecord) -> str:
    """Table of scenes and engines with outcome and error; empty without a record."""

    def text(scene: str, engine: str) -> str:
        row = measured.comparison.get((scene, engine))
        return "" if row is None else f"{outcome_text(row['outcome'])} {errors(row)}".strip()

    return matrix(library, dict.fromkeys(scene for scene, _ in measured.comparison), text)


def stability(library: EngineLibrary, measured: MeasuredRecord) -> str:
    """Table of hard scenes and engines with the recorded outcome; empty without a record."""
    return matrix(
        library,
        dict.fromkeys(scene for scene, _ in measured.stability),
        lambda scene, engine: stability_text(measured.stability.get((scene, engine), "")),
    )


def matrix(library: EngineLibrary, scenes: dict[str, None], text: Callable[[str, str], str]) -> str:
    """Table of scenes and a library's engines; scenes and engines without any text are left out."""
    cells = {(s, e): text(s, e) for s in scenes for e in library.engines}
    names = [e for e in library.engines if any(cells[s, e] for s in scenes)]
    page = page_file(library)
    shown = [s for s in scenes if any(cells[s, e] for e in names)]
    first = {s: f"[{s}]({link(page, page_of(s))})" for s in shown}
    return "\n\n".join(
        table(("scene", *part), [[first[s], *(cells[s, e] for e in part)] for s in shown]) for part in portions(names)
    )


def portions(names: list[str]) -> list[list[str]]:
    """Names in portions of nearly equal size, at most :data:`MOST_COLUMNS`, in their order."""
    count = -(-len(names) // MOST_COLUMNS)
    ends = [len(names) * k // count for k in range(count + 1)] if count else []
    return [names[a:b] for a, b in itertools.pairwise(ends)]


def of_library(frame: pd.DataFrame, library: EngineLibrary) -> list[Row]:
    """Rows of a library's engines."""
    return rows(frame[frame.engine.isin(list(library.engines))])


def sweep(library: EngineLibrary, measured: MeasuredRecord) -> str:
    """Table of all settings on :data:`COST_SCENE`; empty without a record."""
    lines = [
        [
            row["engine"],
            row["setting"],
            short(row["attitude_error_rad"]),
            short(row["reaction_error_N"]),
            milliseconds(row["seconds"]),
            short(row["steps"]),
        ]
        for row in points_of(library, measured)
        if row["outcome"] == "pass"
    ]
    head = ("engine", "setting", "attitude, rad:", "reactions, N:", "time, ms:", "steps:")
    return table(head, lines) if lines else ""


def charted(library: EngineLibrary, measured: MeasuredRecord) -> bool:
    """Whether there are points for a chart."""
    return any(row["seconds"] is not None and row["outcome"] == "pass" for row in points_of(library, measured))


def points_of(library: EngineLibrary, measured: MeasuredRecord) -> list[Row]:
    """Runs of the cost study on :data:`COST_SCENE`."""
    return [row for row in of_library(measured.points, library) if row["scene"] == COST_SCENE]


def milliseconds(seconds: float | None) -> str:
    """Time in milliseconds."""
    return "" if seconds is None else short(1e3 * seconds)


def orders(library: EngineLibrary, measured: MeasuredRecord) -> str:
    """Table of measured orders; empty without a record."""
    found = [row for row in of_library(measured.orders, library) if row["order"] is not None]
    lines = [
        [
            row["scene"],
            row["engine"],
            row["against"],
            short(row["order"]),
            f"{short(row['order_low'])} to {short(row['order_high'])}",
            short(row["theory"]),
            short(row["points"]),
        ]
        for row in found
    ]
    return table(("scene", "engine", "against", "order:", "95 %:", "theory:", "points:"), lines) if lines else ""


def reach(library: EngineLibrary, measured: MeasuredRecord) -> str:
    """Table of costs at equal error relative to the compiled reference; empty without a record."""
    found = [row for row in of_library(measured.reach, library) if row["scene"] == COST_SCENE]
    targets = sorted({row["target"] for row in found}, reverse=True)
    cells = {(row["engine"], row["target"]): ratio(row) for row in found}
    lines = [[e, *(cells.get((e, t), "") for t in targets)] for e in dict.fromkeys(row["engine"] for row in found)]
    return table(("engine", *(f"{short(t)} rad:" for t in targets)), lines) if lines else ""


def ratio(row: Row) -> str:
    """Cost of an engine relative to the compiled reference at one error."""
    if row["over_baseline"] is None:
        return "–" if row["cost"] is None else ""
    sign = "≤ " if row["status"] == "at most" else ""
    return f"{sign}×{short(row['over_baseline'])}"
