"""Stages of the command, in order: each writes pictures, a part of the record, or pages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from adapters.registry import COMPILED, built_in
from pictures.paths import GENERATED, ROOT
from pictures.record.certified import certified_rows
from pictures.record.comparison import comparison_rows, version_rows
from pictures.record.cost import APART, CostRun, cost_rows
from pictures.record.files import note_run, write_table
from pictures.record.releases import STUDIED, releases_rows
from pictures.record.stability import stability_rows
from pictures.report import report_pictures
from pictures.runs import engine_options, run_barchain
from pictures.write import gallery_scenes, top_pictures, write_all, write_site_files, write_tables

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

COMPARED = ("paper/", "basics/", "effects/")
NAMED_IN_STABILITY = ("drake", "dart", "ida-index1", "ida-index2", "ida-ggl", "ida-index3", "basilisk", "jaxsim")
"""Engines that the stability study takes only if they are named"""
COST_MINUTES = 15
"""Time in which the cost study comes to the finer settings of its engines in all its scenes"""
REPORT = "report"
"""Result folder whose pages the README shows"""


@dataclass(frozen=True)
class Options:
    """Folder of a stage, and its way to tell its progress."""

    work: Path
    """Folder of the runs' results; a stage goes on from results that are there"""
    tell: Callable[[str], None]


@dataclass(frozen=True)
class PictureStage:
    """One stage."""

    name: str
    task: str
    run: Callable[[Options], None]


def draw_top(options: Options) -> None:
    """Draw the picture at the top of the README."""
    options.tell(f"{write_all(top_pictures())} pictures changed")


def record_certified(options: Options) -> None:
    """Record the certified solutions that come with barchain."""
    write_table("certified", certified_rows(gallery_scenes()))
    options.tell("docs/record/certified.csv")


def run_comparison(options: Options) -> None:
    """Compare all installed engines in all scenes that have a certified solution that judges."""
    scenes = [s.name for s in gallery_scenes() if s.name.startswith(COMPARED)]
    installed = [name for name, r in built_in().items() if not r.missing]
    run_barchain(options.work, "compare", *scenes, *engine_options(installed), "--out", "comparison")
    rows, record = comparison_rows(options.work / "comparison")
    write_table("comparison", rows)
    write_table("versions", version_rows(record))
    note_run("comparison", record)


def run_stability(options: Options) -> None:
    """Run the stability study by default, and again for engines that it takes only if they are named."""
    run_barchain(options.work, "stability", "--out", "stability")
    rows, scenes, record = stability_rows(options.work / "stability")
    known = built_in()
    named = [name for name in NAMED_IN_STABILITY if not known[name].missing]
    if named:
        run_barchain(options.work, "stability", *engine_options(named), "--out", "stability-named")
        rows += stability_rows(options.work / "stability-named")[0]
    write_table("stability", rows)
    write_table("hard", scenes)
    note_run("stability", record)


def run_cost(options: Options) -> None:
    """Measure cost and accuracy; a quiet machine is needed."""
    installed = [name for name, r in built_in().items() if not r.missing]
    apart = {stage: run for stage, run in APART.items() if set(run.engines) <= set(installed)}
    others = [name for name in installed if not any(name in run.engines for run in APART.values())]
    tables: dict[str, list[dict[str, Any]]] = {}
    for stage, run in {"cost": CostRun(tuple(others), COST_MINUTES), **apart}.items():
        out = REPORT if stage == "cost" else stage
        engines = engine_options(list(dict.fromkeys([COMPILED, *run.engines])))
        run_barchain(options.work, "cost", *engines, "--minutes", str(run.minutes), "--out", out)
        found, record = cost_rows(options.work / out)
        for name, rows in found.items():
            tables.setdefault(name, []).extend(row for row in rows if row["engine"] in run.engines)
        note_run(stage, record)
    for name, rows in tables.items():
        write_table(name, rows)


def run_releases(options: Options) -> None:
    """Measure all releases of six engines; a quiet machine is needed for the times."""
    rows: list[dict[str, object]] = []
    for engine, first in STUDIED.items():
        options.tell(engine)
        run_barchain(options.work, "releases", engine, "--from", first, "--out", f"releases-{engine}")
        own, record = releases_rows(options.work / f"releases-{engine}")
        rows += own
        note_run(f"releases-{engine}", record)
    write_table("releases", rows)


def draw_report(options: Options) -> None:
    """Run the studies that the README shows, and take pictures of their pages."""
    run_barchain(options.work, "crossval", "--out", REPORT)
    run_barchain(options.work, "effects", "paper/fig13", "--width", "1", "--out", REPORT)
    run_barchain(options.work, "roundoff", "--out", REPORT)
    for path in report_pictures(options.work):
        options.tell(path.name)


def fill_tables(options: Options) -> None:
    """Write the generated tables of committed pages; after every change of what they are made of."""
    options.tell(f"{write_tables()} pages with tables changed")


def write_pages(options: Options) -> None:
    """Write what a build of the site generates."""
    options.tell(f"{write_site_files()} files below {GENERATED.relative_to(ROOT)} changed")


STAGES = (
    PictureStage("top", "picture at the top of the README", draw_top),
    PictureStage("certified", "record of the certified solutions", record_certified),
    PictureStage(
        "comparison", "record of all engines in all scenes with a certified solution that judges", run_comparison
    ),
    PictureStage("stability", "record of the stability study", run_stability),
    PictureStage("cost", "record of accuracy and cost; needs a quiet machine", run_cost),
    PictureStage("releases", "record of the releases of six engines; needs a quiet machine", run_releases),
    PictureStage("report", "pictures of the report for the README", draw_report),
    PictureStage("tables", "generated tables of committed pages; takes seconds", fill_tables),
    PictureStage("pages", "gallery and pages of engines, as a build of the site writes them", write_pages),
)
