"""A program with an engine that runs, in C, Fortran, Octave, or Python with packages of its own, and its entry."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from typing import TYPE_CHECKING

from barchain.engine.new_package import check_name, templates, write_folder

if TYPE_CHECKING:
    from pathlib import Path

STEPS = "[500, 1000, 2000, 4000, 8000]"


@dataclass(frozen=True)
class Language:
    """A language in which there is a start."""

    title: str
    source: str
    """Name of the source"""
    file: str
    """Name of the file that is started"""
    build: str = ""
    """Command that makes the file of the source; empty where nothing is built"""
    runner: str = ""
    """Program that runs the file; empty where the file is a program itself"""
    steps: str = STEPS
    """Settings that the program does in seconds"""
    requirements: tuple[str, ...] = ()
    """Packages of an environment of its own"""

    @property
    def command(self) -> str:
        """Command of the entry."""
        return f"{self.runner} {self.file} {{request}} {{samples}} {{result}}".strip()


LANGUAGES = {
    "python-program": Language(
        "Python", "engine.py", "engine.py", runner="{python}", steps="[250, 500, 1000]", requirements=("numpy",)
    ),
    "c": Language("C", "engine.c", "engine", "cc -O2 -o engine engine.c -lm"),
    "fortran": Language("Fortran", "engine.f90", "engine", "gfortran -O2 -o engine engine.f90"),
    "octave": Language("Octave", "engine.m", "engine.m", runner="octave-cli --norc", steps="[250, 500, 1000]"),
}


def write_program(name: str, language: str, out: Path) -> list[str]:
    """Write a program and its entry into a new folder, whole or not at all.

    Parameters
    ----------
    name : str
        Of the engine.
    language : str
        One of :data:`LANGUAGES`.
    out : Path
        Folder. It must not be there, and the folder above it must.

    Returns
    -------
    list of str
        Names of the files written, below `out`.

    Raises
    ------
    PackageError
        If the name has a wrong form or is taken, `out` is there, or the folder above it is not.
    OSError
        If nothing can be written beside it.
    """
    check_name(name)
    of = LANGUAGES[language]
    source = files("barchain.engine").joinpath("programs", language, of.source).read_text(encoding="utf-8")
    given = {"name": name, "language": of.title, "command": of.command}
    entry = templates("programs").get_template("engines.toml.j2")
    about = entry.render(given, build=of.build, file=of.file, steps=of.steps, requirements=list(of.requirements))
    return write_folder({of.source: source, "engines.toml": about}, out)
