"""`barchain report`: pages from stored tables."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
def report(folder: Path) -> None:
    """Render the pages of DIR again from its stored tables."""
    from barchain.cli.common.result_folder import alone  # noqa: PLC0415
    from reports.render import render_all  # noqa: PLC0415

    with alone(folder):
        pages = render_all(folder)
    click.echo(f"wrote {', '.join(map(str, pages))}")
