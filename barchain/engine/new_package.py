"""A package with an engine that runs: written from templates, for an author to put another library in."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader, StrictUndefined

from adapters.registry import PACKAGES, RESERVED, engines, printable

if TYPE_CHECKING:
    from collections.abc import Mapping

NAME = r"[A-Za-z0-9](?:[A-Za-z0-9_-]{0,38}[A-Za-z0-9])?"
"""Form of an engine's name: that of the registry, shortened by what distribution and module add to it"""
OPEN_FOLDER = 0o755  # a temporary folder is closed to others, a package is not


class PackageError(ValueError):
    """Raised where no package can be written; the message is one line."""


@dataclass(frozen=True)
class PackageNames:
    """Names in a package of one engine."""

    engine: str

    @property
    def distribution(self) -> str:
        """Name that pip knows; its prefix keeps it apart from the library that the engine wraps."""
        return f"barchain-{self.engine}"

    @property
    def module(self) -> str:
        """Name that Python imports; its prefix makes it an identifier and no keyword."""
        return self.distribution.replace("-", "_").lower()

    @property
    def class_name(self) -> str:
        """Name of the engine's class."""
        words = "".join(word[0].upper() + word[1:] for word in re.split(r"[-_]+", self.engine))
        return f"{'N' if words[0].isdigit() else ''}{words}Engine"

    @property
    def files(self) -> dict[str, str]:
        """Files of the package by their templates."""
        source = f"src/{self.module}"
        modules = ("__init__.py", "adapter.py", "chain.py", "py.typed")
        outside = ("pyproject.toml", "README.md", "tests/test_conformity.py")
        return {f"{name}.j2": name for name in outside} | {f"source/{name}.j2": f"{source}/{name}" for name in modules}


def check_name(name: str) -> None:
    """Check the name of a new engine.

    Raises
    ------
    PackageError
        If it has a wrong form, or an engine here has it.
    """
    if not re.fullmatch(NAME, name):
        raise PackageError(
            f"{printable(name)!r} given, allowed: 1 to 40 letters, digits, _ and -, with a letter or digit at both ends"
        )
    for known, registered in engines().items():
        if known.lower() == name.lower():
            owner = registered.distribution or "barchain"
            raise PackageError(f"{name} given, and {owner} registers an engine of that name; choose another")
    if name.lower() in RESERVED:
        raise PackageError(f"{name} given, which names barchain's own files; choose another")


def package_names(name: str) -> PackageNames:
    """Names of a package for the engine `name`.

    Raises
    ------
    PackageError
        If the name has a wrong form, an engine here has it, or it is that of a package.
    """
    check_name(name)
    plain = name.lower().replace("-", "_")
    if plain in PACKAGES or plain in {m.lower() for m in sys.stdlib_module_names}:
        owner = "barchain" if plain in PACKAGES else "Python's library"
        raise PackageError(
            f"{name} given, which names a package of {owner}; allowed: any name but those of engines, of Python's "
            f"library and {', '.join(sorted(PACKAGES))}"
        )
    return PackageNames(name)


def write_package(names: PackageNames, out: Path) -> list[str]:
    """Write a package into a new folder, whole or not at all.

    Parameters
    ----------
    names : PackageNames
    out : Path
        Folder of the package. It must not be there, and the folder above it must.

    Returns
    -------
    list of str
        Names of the files written, below `out`.

    Raises
    ------
    PackageError
        If `out` is there, or the folder above it is not.
    OSError
        If nothing can be written beside it.
    """
    return write_folder(package_files(names), out)


def write_folder(texts: Mapping[str, str], out: Path) -> list[str]:
    """Write files, text by name, into a new folder, whole or not at all; errors as of :func:`write_package`."""
    if os.path.lexists(out):
        raise PackageError(f"{out} is there already, and nothing in it is replaced; --out DIR gives another folder")
    if not out.parent.is_dir():
        raise PackageError(f"{out}: there is no folder {out.parent}")
    made = Path(tempfile.mkdtemp(prefix=".new-engine-", dir=out.parent))
    try:
        for name, text in texts.items():
            (made / name).parent.mkdir(parents=True, exist_ok=True)
            (made / name).write_text(text, encoding="utf-8", newline="\n")
        made.chmod(OPEN_FOLDER)
        made.rename(out)
    except BaseException:
        shutil.rmtree(made, ignore_errors=True)
        raise
    return sorted(texts)


def package_files(names: PackageNames) -> dict[str, str]:
    """Files of a package, text by name."""
    given = {what: getattr(names, what) for what in ("engine", "distribution", "module", "class_name")}
    found = templates("template")
    return {name: found.get_template(template).render(given) for template, name in names.files.items()}


def templates(folder: str) -> Environment:
    """Templates of a folder beside this module."""
    return Environment(
        loader=PackageLoader("barchain.engine", folder),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,  # sources and TOML, from names of letters and digits
    )
