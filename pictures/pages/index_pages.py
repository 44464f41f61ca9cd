"""Index of the gallery, and index of the engines."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.registry import ENGINES
from pictures.pages.engine_page import page_file
from pictures.pages.libraries import LIBRARIES
from pictures.pages.scene_page import link
from pictures.pages.words import table
from pictures.paths import DOCS, ENGINE_PAGES
from pictures.templating import render
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from pictures.pages.record import MeasuredRecord
    from scenarios import Scene

ENGINES_INDEX = ENGINE_PAGES / "index.md"


@dataclass(frozen=True)
class Family:
    """Folder of scenes."""

    folder: str
    title: str
    sentence: str


FAMILIES = (
    Family("paper", "The paper's figures", "Initial states and manoeuvres of the paper, with its parameters."),
    Family("basics", "Closed forms", "Motions whose solution is known on paper, in whole or in part."),
    Family("effects", "Effects", "One effect each, or all of them at once."),
    Family("published", "Published problems", "Problems of other people, with the numbers that they published."),
    Family("hard", "Hard scenes", "Scenes at which integrators fail: sizes, spins, mass ratios, chaos, long runs."),
)
"""Families in the order of the index"""


def gallery_index(scenes: list[Scene], measured: MeasuredRecord) -> str:
    """Markdown of the gallery's index."""
    groups = [(family, [s for s in scenes if s.name.startswith(f"{family.folder}/")]) for family in FAMILIES]
    engines = len({engine for _, engine in measured.comparison if engine in independent_engines()})
    return render("gallery.md.j2", groups=groups, count=len(scenes), engines=engines, totals=totals(measured))


def independent_engines() -> frozenset[str]:
    """Names of the engines that have physics of their own."""
    return frozenset(name for name, registration in ENGINES.items() if registration.external)


def totals(measured: MeasuredRecord) -> str:
    """Table of the outcomes of independent engines, a row for each family that was compared."""
    independent = independent_engines()
    counted = {
        family: Counter(
            row["outcome"] for (scene, engine), row in measured.comparison.items()
            if scene.startswith(f"{family.folder}/") and engine in independent
        )
        for family in FAMILIES
    }  # fmt: skip
    outcomes = [outcome for outcome in Outcome if any(words[outcome] for words in counted.values())]
    rows = []
    for family, words in counted.items():
        scenes = {s for s, _ in measured.comparison if s.startswith(f"{family.folder}/")}
        if words:
            rows.append([family.title, len(scenes), words.total(), *(words[outcome] for outcome in outcomes)])
    both = [sum(column) for column in zip(*(row[1:] for row in rows), strict=True)]
    head = ("scenes", "number:", "pairs:", *(f"{outcome.replace('_', ' ')}:" for outcome in outcomes))
    return table(head, [*rows, ["all", *both]])


def engines_index() -> str:
    """Markdown of the index of engines."""
    head = ("library", "engines", "physics", "formulation and integrator", "licence", "installation")
    lines = []
    for library in LIBRARIES:
        for name, registration in library.engines.items():
            physics = "independent" if registration.external else "barchain's equations"
            install = f"`{registration.install}`" if registration.install else "comes with barchain"
            page = f"[{library.title}]({page_file(library).name})"
            lines.append([page, f"`{name}`", physics, registration.declarations().title, library.licence, install])
    effects = link(ENGINES_INDEX, DOCS / "effects" / "README.md")
    return render("engines.md.j2", rows=table(head, lines), libraries=LIBRARIES, count=len(lines), effects=effects)
