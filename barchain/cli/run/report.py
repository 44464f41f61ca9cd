"""`barchain report`: pages from stored tables."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def report(folder: Path) -> None:
    """Render the pages of DIR again from its stored tables."""
    from reports.render import render_all  # noqa: PLC0415

    click.echo(f"wrote {', '.join(map(str, render_all(folder)))}")
