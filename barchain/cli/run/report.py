"""`barchain report`: pages from stored tables."""

from __future__ import annotations

from pathlib import Path

import click

from barchain.cli.common.numbers import NamedPath
from barchain.cli.common.terminal import say


@click.command(short_help="Render a result folder again from its tables.")
@click.argument("folder", metavar="DIR", type=NamedPath(path_type=Path))
def report(folder: Path) -> None:
    """Render the pages of DIR again from its stored tables."""
    from barchain.api import render  # noqa: PLC0415

    pages = render(folder)
    say(f"wrote {', '.join(map(str, pages))}")
