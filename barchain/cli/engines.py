"""Commands `engines` and `new-engine`: which engines there are, how to get missing ones, and a package for one more."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from barchain.cli.common.numbers import WORDS, NamedPath
from barchain.cli.common.options import json_option, programs_option
from barchain.cli.common.progress import quiet, working
from barchain.cli.common.terminal import say, show_rows

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.registry import Registration

OFFERED = ("python", "python-program", "c", "fortran", "octave")
"""Languages of a new engine"""
HEADINGS = ("engine", "version", "default set", "setting", "what")


@click.command(short_help="List the engines, and how to install missing ones.")
@click.option("--installed/--missing", default=None, help="List only engines that are installed, or only missing ones.")
@click.option("--make", "named", metavar="NAME", multiple=True, type=WORDS,
              help="First make the environment that the entry of this engine requires. May be repeated.")  # fmt: skip
@programs_option
@json_option
def engines(installed: bool | None, named: tuple[str, ...], as_json: bool) -> None:
    """List the engines with version and default setting, and how to get missing ones."""
    from adapters import registry

    for name in named:
        make_environment(name)
    wanted = {n: r for n, r in registry.engines().items() if installed is None or installed is (not r.missing)}
    if as_json:
        say(json.dumps(list(facts(wanted)), indent=2))
    else:
        show_engines(wanted)


def make_environment(name: str) -> None:
    """Make the environment of an engine that is a program."""
    from adapters.command.entries import unpacked
    from adapters.registry import find_engine
    from barchain.runs.python_environments import EnvironmentFailedError, own_environment

    entry = find_engine(name).entry
    wanted = unpacked(entry)[1].requirements if entry else []
    if not wanted:
        raise click.UsageError(f"--make {name}: its entry has no requirements")
    try:
        with working(f"making the environment of {name}: {', '.join(wanted)}"):
            own_environment(wanted)
    except EnvironmentFailedError as error:
        raise click.UsageError(f"--make {name}: {error}") from error


def show_engines(registered: Mapping[str, Registration]) -> None:
    """Print name, version, default, setting and title of each engine, or how to get it."""
    from reports.text.numerals import unpadded

    rows = []
    for known in facts(registered):
        words = known["missing"] or known.get("fault") or known["title"]
        default = "yes" if known["default"] else ""
        setting = unpadded(known.get("setting", ""))
        rows.append((known["name"], known["version"] or "missing", default, setting, words))
    show_rows(HEADINGS, rows)


def facts(registered: Mapping[str, Registration]) -> Iterable[dict[str, Any]]:
    """Facts of each engine; "fault" says why its adapter does not load."""
    from barchain.runs.asking import declarations_of, engine_fault

    for name, r in registered.items():
        known: dict[str, Any] = {
            "name": name, "installed": not r.missing, "version": None if r.missing else r.version_words,
            "default": r.by_default, "independent_physics": r.external, "missing": r.missing,
            "install": r.remedy or None,
        }  # fmt: skip
        if not r.missing:
            try:
                loaded = declarations_of(r)
                known |= {
                    "title": loaded.title,
                    "setting": str(loaded.sweep.setting()),
                    "coordinates": str(loaded.coordinates),
                    "effects": sorted(map(str, loaded.effects)),
                }
            except Exception as error:  # an adapter of a third party may raise anything
                known["fault"] = engine_fault(error)
        yield known


@click.command("new-engine", short_help="Write a package with an engine that runs.")
@click.argument("name", type=WORDS)
@click.option(
    "--out", metavar="DIR", type=NamedPath(path_type=Path),
    help="Write the package into this new folder; default: a folder of the engine's name here.",
)  # fmt: skip
@click.option(
    "--language", type=click.Choice(OFFERED), default=OFFERED[0], show_default=True,
    help="Write a package in Python, or a program and its entry: in Python with an environment of its own, or in "
         "another language.",
)  # fmt: skip
def new_engine(name: str, out: Path | None, language: str) -> None:
    """Write an engine called NAME that runs: an integrator of a chain, in a package or a program of its own.

    A package in Python installs with pip, and has an entry point and a test; docs/tutorials/your_own_engine.md leads
    from there to a comparison. A program in another language reads a request and writes samples
    (docs/howto/programs.md). Replace the integrator by calls of your library. Nothing that is there is replaced.
    """
    from barchain.engine.new_package import PackageError, package_names, write_package
    from barchain.engine.new_program import LANGUAGES, write_program

    folder = out or Path(name)
    trial = f"barchain compare paper/fig05 --engine {name} --out fig05"
    try:
        if language == OFFERED[0]:
            written = write_package(package_names(name), folder)
            trial = f"barchain compare paper/fig05 --engine reference --engine {name} --out {name}-fig05"
            steps = [f"pip install -e {shlex.quote(f'{folder}[test]')}"]
        else:
            written = write_program(name, language, folder)
            make = f"barchain engines --make {name}" if LANGUAGES[language].requirements else ""
            steps = [f"cd {shlex.quote(str(folder))}", LANGUAGES[language].build, make]
    except PackageError as error:
        raise click.UsageError(str(error)) from error
    say("\n".join(f"{folder / file}" for file in written))
    if not quiet():
        say(f"Next: {' && '.join(filter(None, [*steps, trial, f'barchain conform {name}']))}", err=True)
