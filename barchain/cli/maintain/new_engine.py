"""`barchain new-engine`: a package with an engine that runs, for authors of engines."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from barchain.cli.common.numbers import WORDS, NamedPath
from barchain.cli.common.terminal import say
from barchain.cli.common.verbosity import quiet
from barchain.engine.new_program import LANGUAGES


@click.command("new-engine", short_help="Write a package with an engine that runs.")
@click.argument("name", type=WORDS)
@click.option(
    "--out", metavar="DIR", type=NamedPath(path_type=Path),
    help="Write the package into this new folder; default: a folder of the engine's name here.",
)  # fmt: skip
@click.option(
    "--language", type=click.Choice(["python", *LANGUAGES]), default="python", show_default=True,
    help="Write a package in Python, or a program in another language and its entry.",
)  # fmt: skip
def new_engine(name: str, out: Path | None, language: str) -> None:
    """Write an engine called NAME that runs: an integrator of a chain, in a package or a program of its own.

    A package in Python installs with pip, and has an entry point and a test; docs/tutorials/your_own_engine.md leads
    from there to a comparison. A program in another language reads a request and writes samples
    (docs/howto/programs.md). Replace the integrator by calls of your library. Nothing that is there is replaced.
    """
    if language != "python":
        write_in(language, name, out or Path(name))
        return
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


def write_in(language: str, name: str, folder: Path) -> None:
    """Write a program in another language."""
    from barchain.engine.new_package import PackageError  # noqa: PLC0415
    from barchain.engine.new_program import write_program  # noqa: PLC0415

    try:
        written = write_program(name, language, folder)
    except PackageError as error:
        raise click.UsageError(str(error)) from error
    say("\n".join(f"{folder / file}" for file in written))
    if not quiet():
        steps = [f"cd {shlex.quote(str(folder))}", LANGUAGES[language].build]
        steps += [f"barchain compare paper/fig05 --engine {name} --out fig05", f"barchain conform {name}"]
        say(f"Next: {' && '.join(filter(None, steps))}", err=True)
