"""Environments with pinned versions, made once and kept: with uv where it is installed, else with venv and pip."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from filelock import FileLock
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from platformdirs import user_cache_path

from barchain.nightly.environments.faults import PinnedEnvironmentError
from barchain.nightly.history.model.identity import content_digest

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

VARIABLE = "BARCHAIN_ENVIRONMENTS"
LIMIT_S = 900.0
"""Longest installation"""
READY = "ready.txt"
LONGEST_REASON = 300
ADDRESS = re.compile(r"https?://\S+")


@dataclass(frozen=True)
class PinnedEnvironment:
    """Environment with some versions given, and all others as they are in this installation where that is possible."""

    folder: Path
    pins: tuple[str, ...]
    moved: tuple[str, ...] = ()
    """Other distributions whose versions differ from this installation's: the pins ask for it"""

    @property
    def python(self) -> Path:
        """Its interpreter."""
        return self.folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def environments_folder() -> Path:
    """Folder of all environments: by the variable, else in the user's cache."""
    given = os.environ.get(VARIABLE)
    return Path(given) if given else user_cache_path("barchain") / "environments"


def pinned_environment(pins: Sequence[str], *, also: Sequence[str] = ()) -> PinnedEnvironment:
    """Environment with what barchain needs, and with some versions given.

    Parameters
    ----------
    pins : sequence of str
        Requirements, e.g. ``mujoco==3.2.7``; their own dependencies are resolved, not forced.
    also : sequence of str
        Further distributions that are needed, as they are in this installation.

    Returns
    -------
    PinnedEnvironment
        Made now, or earlier by the same request.

    Raises
    ------
    PinnedEnvironmentError
        If the versions can't be installed together; the message is the resolver's reason in one line.
    """
    wanted, others = requirements(pins, also), constraints(pins)
    key = content_digest([sys.version, sys.platform, sorted(wanted), sorted(others)])[:20]
    root = environments_folder()
    root.mkdir(parents=True, exist_ok=True)
    folder = root / key
    with FileLock(root / f"{key}.lock"):
        if not (folder / READY).is_file():
            make(folder, wanted, others)
    return PinnedEnvironment(folder, tuple(pins), tuple((folder / READY).read_text("utf-8").splitlines()))


def requirements(pins: Sequence[str], also: Sequence[str]) -> list[str]:
    """Requirements of barchain itself, of `also`, and the pins in the place of what they name."""
    pinned = {name_of(pin) for pin in pins}
    found = {name_of(text): text for text in (*needed(), *map(as_installed, also))}
    return [*(text for name, text in found.items() if name not in pinned), *pins]


def needed() -> Iterator[str]:
    """Distributions that barchain needs at all."""
    try:
        declared = metadata.requires("barchain") or []
    except metadata.PackageNotFoundError:
        raise PinnedEnvironmentError("barchain is not installed here, so that its requirements are not known") from None
    for text in declared:
        one = Requirement(text)
        if one.marker is None or one.marker.evaluate({"extra": ""}):
            yield as_installed(one.name)


def as_installed(name: str) -> str:
    """Requirement of the installed version; of any version without one."""
    try:
        return f"{canonicalize_name(name)}=={metadata.version(name)}"
    except metadata.PackageNotFoundError:
        return str(canonicalize_name(name))


def constraints(pins: Sequence[str]) -> list[str]:
    """Versions of this installation, of all distributions but those pinned, barchain, and local builds."""
    pinned = {name_of(pin) for pin in pins} | {"barchain"}
    found = {str(canonicalize_name(d.metadata["Name"])): d.version for d in metadata.distributions()}
    return [
        f"{name}=={version}" for name, version in sorted(found.items()) if name not in pinned and "+" not in version
    ]


def name_of(requirement: str) -> str:
    """Name of a requirement's distribution."""
    return str(canonicalize_name(Requirement(requirement).name))


def make(folder: Path, wanted: Sequence[str], others: Sequence[str]) -> None:
    """Make an environment, first with this installation's versions of everything else, then with any."""
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix="new-") as scratch:
        failed = ""
        for limits in (others, ()):
            new = Path(scratch) / f"{'held' if limits else 'free'}"
            names = {name_of(one) for one in wanted if "==" in one} if limits else set()
            asked = wanted if limits else loosened(wanted)
            failed = install(new, asked, [one for one in limits if name_of(one) not in names])
            if not failed:
                write_ready(new)
                shutil.rmtree(folder, ignore_errors=True)
                relocate(new, folder)
                return
    raise PinnedEnvironmentError(failed)


def loosened(wanted: Sequence[str]) -> list[str]:
    """Requirements without the versions of this installation; the pins, which come last, stay."""
    installed = {as_installed(name_of(one)) for one in wanted}
    return [name_of(one) if one in installed else one for one in wanted]


def install(folder: Path, wanted: Sequence[str], limits: Sequence[str]) -> str:
    """Make an environment in a folder; the reason of a failure, or an empty text."""
    held = folder.parent / "constraints.txt"
    held.write_text("\n".join(limits), "utf-8")
    base = str(getattr(sys, "_base_executable", sys.executable))
    python = str(PinnedEnvironment(folder, ()).python)
    if find_spec("uv") is not None:
        uv = [sys.executable, "-m", "uv", "--quiet", "--no-progress"]
        steps = [
            [*uv, "venv", "--python", base, str(folder)],
            [*uv, "pip", "install", "--python", python, "--constraint", str(held), *wanted],
        ]
    else:
        pip = [python, "-m", "pip", "--disable-pip-version-check", "--quiet", "install"]
        steps = [
            [base, "-m", "venv", str(folder)],
            [*pip, "--only-binary", ":all:", "--constraint", str(held), *wanted],
        ]
    for step in steps:
        try:
            done = subprocess.run(step, capture_output=True, text=True, timeout=LIMIT_S, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            return brief(str(error))
        if done.returncode:
            return brief(done.stderr or done.stdout)
    return ""


def relocate(new: Path, folder: Path) -> None:
    """Put an environment in its place; interpreters of virtual environments find their packages by their own place."""
    with contextlib.suppress(FileNotFoundError):
        shutil.rmtree(new / "__pycache__")
    new.rename(folder)


def write_ready(folder: Path) -> None:
    """Mark an environment as whole; the file lists versions that differ from this installation's."""
    script = "from importlib import metadata\nfor d in metadata.distributions(): print(d.metadata['Name'], d.version)\n"
    python = str(PinnedEnvironment(folder, ()).python)
    said = subprocess.run([python, "-I", "-c", script], capture_output=True, text=True, check=True, timeout=60).stdout
    moved = []
    for line in sorted(said.splitlines()):
        name, _, version = line.partition(" ")
        with contextlib.suppress(metadata.PackageNotFoundError):
            if metadata.version(name) != version:
                moved.append(f"{canonicalize_name(name)} {version} (here {metadata.version(name)})")
    (folder / READY).write_text("\n".join(moved) + "\n" if moved else "", "utf-8")


def brief(said: str) -> str:
    """Reason of an installer in one line, without addresses."""
    lines = [line.strip(" ╰─▶│×") for line in said.splitlines() if line.strip()]
    text = ADDRESS.sub("(address)", " ".join(lines))
    text = "".join(c for c in text if c.isprintable())
    return text if len(text) <= LONGEST_REASON else f"{text[: LONGEST_REASON - 3]}..."


def prune_environments() -> int:
    """Remove all environments, and return their number."""
    root, count = environments_folder(), 0
    for folder in root.iterdir() if root.is_dir() else ():
        if folder.is_dir():
            shutil.rmtree(folder, ignore_errors=True)
            count += 1
    return count
