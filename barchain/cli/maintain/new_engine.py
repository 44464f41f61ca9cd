"""`barchain new-engine`: a package with an engine that runs, for authors of engines."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from barchain.cli.common.numbers import WORDS, NamedPath
from barchain.cli.common.terminal import say
from barchain.cli.common.verbosity import quiet


@click.command("new-engine", short_help="Write a package with an engine that runs.")
@click.argument("name", type=WORDS)
@click.option(
    "--out", metavar="DIR", type=NamedPath(path_type=Path),
    help="Write the package into this new folder; default: a folder of the engine's name here.",
)  # fmt: skip
def new_engine(name: str, out: Path | None) -> None:
    """Write a package with an engine called NAME: entry point, an integrator that runs, a test, README.

    The package installs with pip. Replace its integrator by calls of your library; docs/tutorials/your_own_engine.md
    leads from there to a comparison. Nothing that is there is replaced.
    """
    from barchain.engine.new_package import PackageError, package_names, write_package  # noqa: PLC0415

    try:
        names = package_names(name)
        folder = out or Path(name)
        written = write_package(names, folder)
    except PackageError as error:
        raise click.UsageError(str(error)) from error
    say("\n".join(f"{folder / file}" for file in written))
    if not quiet():
        trial = f"barchain compare paper/fig05 --engine reference --engine {name} --out {name}-fig05"
        say(f"Next: pip install -e {shlex.quote(f'{folder}[test]')} && {trial}, then barchain conform {name}", err=True)
