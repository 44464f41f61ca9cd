"""What the command line prints and writes: lists of scenes and engines, a verdict, tables of samples."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path

    import pandas as pd

    from adapters.registry import Registration
    from barchain.crossval.run import ComparisonResult
    from scenarios import Scene

TABLE_WRITERS: dict[str, Callable[[pd.DataFrame, Path], None]] = {
    ".parquet": lambda frame, path: frame.to_parquet(path, index=False),
    ".csv": lambda frame, path: frame.to_csv(path, index=False),  # repr of floats: every digit comes back
}


def show(table: Table) -> None:
    """Print a table; without a terminal, wide enough never to break a line."""
    console = Console()
    if not console.is_terminal:
        console = Console(width=240)
    console.print(table)


def show_scenes(scenes: Iterable[Scene]) -> None:
    """Name, tags, size and title of each scene."""
    table = Table(box=None, header_style="bold")
    for column in ("scene", "bars", "orbits", "tags", "title"):
        table.add_column(column, justify="right" if column in {"bars", "orbits"} else "left")
    for s in scenes:
        orbits = f"{s.run.duration_s / s.period_s:.3g}"
        table.add_row(s.name, str(s.bars), orbits, ", ".join(s.tags), escape(s.title))
    show(table)


def show_engines(registered: Mapping[str, Registration]) -> None:
    """Name, version, knob and what it is for each engine; how to get those that are missing."""
    table = Table(box=None, header_style="bold")
    for column in ("engine", "version", "setting", "what"):
        table.add_column(column)
    for name, registration in registered.items():
        if registration.missing:
            table.add_row(name, "missing", "", escape(registration.missing))
            continue
        try:
            loaded = registration.load()
        except Exception as error:
            table.add_row(name, registration.version, "", escape(f"its adapter does not load: {error}"))
            continue
        table.add_row(name, registration.version, str(loaded.sweep.setting()), loaded.title)
    show(table)


def show_verdict(result: ComparisonResult, html: Path) -> None:
    """How many comparisons ended how, those that failed, and where the report is."""
    counts = Counter(str(o) for o in result.outcomes.values())
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.most_common()))
    for (scene, engine), outcome in result.outcomes.items():
        if not outcome.ok:
            rows = result.metrics.query("scene == @scene and engine == @engine and outcome == @outcome.value")
            print(
                f"  {scene}  {engine}  {outcome}: {'; '.join(f'{r.quantity}: {r.reason}' for r in rows.itertuples())}"
            )
    print(f"report: {html}")
