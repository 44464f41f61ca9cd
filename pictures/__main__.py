"""Command line: `python -m pictures`."""

from __future__ import annotations

from pathlib import Path

import click

from pictures.stages import STAGES, Options

NAMES = [stage.name for stage in STAGES]


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--only", "chosen", type=click.Choice(NAMES), multiple=True, help="Run this stage; may be repeated.")
@click.option("--from", "first", type=click.Choice(NAMES), help="Begin with this stage.")
@click.option(
    "--work",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("build/pictures"),
    show_default=True,
    help="Keep results of runs in this folder; an interrupted stage goes on from there.",
)
def main(chosen: tuple[str, ...], first: str | None, work: Path) -> None:
    """Make the pictures of README and documents, the measured record, and the pages of the site made of it."""
    stages = STAGES[NAMES.index(first) if first else 0 :]
    for stage in stages:
        if not chosen or stage.name in chosen:
            click.secho(f"{stage.name}: {stage.task}", bold=True)
            stage.run(Options(work.resolve(), lambda text: click.echo(f"  {text}")))


if __name__ == "__main__":
    main()
