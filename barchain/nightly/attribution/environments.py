"""Fresh environments: other versions of engines and libraries, other sources of barchain, beside the installation."""

from __future__ import annotations

import contextlib
import io
import shutil
import sys
import tarfile
from dataclasses import dataclass
from datetime import date, timedelta
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from adapters.command.own_python import READY, environments_folder, python_in, without_own
from adapters.registry import PACKAGES
from barchain.nightly.errors import HistoryError, PinnedEnvironmentError
from barchain.nightly.figures.figure import content_digest
from barchain.nightly.figures.package_origins import AT, installed_state, requirement_of, wheel_folders
from barchain.nightly.figures.results import read_figures_of
from barchain.record.sources import direct_url
from barchain.runs.environment import marked, scratch_folder
from barchain.runs.processes import GitError, git, run
from barchain.runs.python_environments import INSTALL_S, UV, brief, install, put_in_place

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from barchain.nightly.figures.figure import Figure
    from barchain.runs.processes import Finished


RESOLVE_S = 120.0
MONTH = timedelta(days=30)
"""Time after a release within which its dependencies were found to be wrong, if they were"""
LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.pyc", ".git")


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
        return python_in(self.folder)


def run_in(
    python: Path, tree: Path, arguments: Sequence[str], *, limit_s: float, folder: Path,
    variables: Mapping[str, str] = MappingProxyType({}),
) -> Finished:  # fmt: skip
    """Run the Python of an environment with a tree of barchain's sources.

    Parameters
    ----------
    python : Path
        Interpreter of the environment.
    tree : Path
        Folder of barchain's packages.
    arguments : sequence of str
        Of Python, e.g. ``("-m", "barchain", "compare", ...)``.
    limit_s : float
        Wall time after which all processes of the command are killed, s.
    folder : Path
        Working folder.
    variables : mapping
        Further variables of its environment.
    """
    with scratch_folder() as scratch:
        own = without_own(marked(scratch)) | {"PYTHONPATH": str(tree)} | dict(variables)
        return run([python, "-P", *arguments], limit_s=limit_s, folder=folder, variables=own)


def measured_figures(
    environment: PinnedEnvironment, tree: Path, line: Sequence[str], *, limit_s: float, out: Path
) -> tuple[Figure, ...] | str:
    """Figures of a command of barchain, whose results come into `out`, or why there are none.

    Other parameters are those of :func:`run_in`, with an environment in the place of its interpreter.
    """
    arguments = ("-m", "barchain", "-q", *line, "--out", str(out))
    done = run_in(environment.python, tree, arguments, limit_s=limit_s, folder=out.parent)
    try:
        return read_figures_of(out)
    except (HistoryError, FileNotFoundError, ValueError):
        return done.reason or f"ended with exit code {done.code}"


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
    folder = environments_folder() / key
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
    for one in map(Requirement, declared):
        if one.marker is None or one.marker.evaluate({"extra": ""}):
            yield as_installed(one.name)


def as_installed(name: str) -> str:
    """Requirement of the installed version; of any version without one."""
    place = direct_url(name)
    if "dir_info" in place:
        return f"{canonicalize_name(name)}{AT}{place['url']}"
    try:
        return requirement_of(canonicalize_name(name), installed_state(name) if place else metadata.version(name))
    except metadata.PackageNotFoundError:
        return str(canonicalize_name(name))


def constraints(pins: Sequence[str]) -> list[str]:
    """Versions of this installation, of all distributions but those pinned, barchain, local and private ones."""
    pinned = {name_of(pin) for pin in pins} | {"barchain"}
    names = {str(canonicalize_name(d.metadata["Name"])): d.version for d in metadata.distributions()}
    found = {name: version for name, version in names.items() if not direct_url(name)}
    return [
        f"{name}=={version}" for name, version in sorted(found.items()) if name not in pinned and "+" not in version
    ]


def name_of(requirement: str) -> str:
    """Name of a requirement's distribution."""
    return str(canonicalize_name(Requirement(requirement).name))


def make(folder: Path, wanted: Sequence[str], others: Sequence[str]) -> None:
    """Make an environment, first with this installation's versions of everything else, then with any.

    Raises
    ------
    PinnedEnvironmentError
        If neither can be installed.
    """
    named = {name_of(one) for one in wanted if "==" in one or AT in one}
    held = [one for one in others if name_of(one) not in named]

    def fill(new: Path) -> None:
        failed = installed(new, wanted, held)
        if failed:
            shutil.rmtree(new, ignore_errors=True)
            failed = installed(new, loosened(wanted), ())
        if failed:
            raise PinnedEnvironmentError(failed)
        (new / READY).write_text("".join(f"{line}\n" for line in moved_in(new)), "utf-8")

    put_in_place(folder, fill)


def loosened(wanted: Sequence[str]) -> list[str]:
    """Requirements without the versions of this installation; the pins, which come last, stay."""
    installed = {as_installed(name_of(one)) for one in wanted}
    return [name_of(one) if one in installed and AT not in one else one for one in wanted]


def installed(folder: Path, wanted: Sequence[str], limits: Sequence[str]) -> str:
    """Make an environment under constraints, with wheels beside; the reason of a failure, or an empty text."""
    held = folder.parent / "constraints.txt"
    held.write_text("\n".join(limits), "utf-8")
    beside = (word for each in wheel_folders() for word in ("--find-links", str(each)))
    return install(folder, wanted, "--constraint", str(held), *beside)


def moved_in(folder: Path) -> list[str]:
    """Distributions of an environment whose versions differ from this installation's."""
    script = "from importlib import metadata\nfor d in metadata.distributions(): print(d.metadata['Name'], d.version)\n"
    done = run([PinnedEnvironment(folder, ()).python, "-I", "-c", script], limit_s=INSTALL_S)
    if done.reason:
        raise PinnedEnvironmentError(done.reason)
    moved = []
    for line in sorted(done.output.splitlines()):
        name, _, version = line.partition(" ")
        with contextlib.suppress(metadata.PackageNotFoundError):
            if metadata.version(name) != version:
                moved.append(f"{canonicalize_name(name)} {version} (here {metadata.version(name)})")
    return moved


def dependencies_at(pin: str, released: str) -> list[str]:
    """Versions of all dependencies of a release, as the package index had them a month after the release.

    Parameters
    ----------
    pin : str
        Requirement of the release: ``pin==3.4.0``.
    released : str
        Day of the release, e.g. ``2025-02-13``.

    Returns
    -------
    list of str
        Requirements, without that of the release itself.

    Raises
    ------
    PinnedEnvironmentError
        If the day is missing, or there are no such versions; the message is one line.
    """
    if not released:
        raise PinnedEnvironmentError(f"the package index gives no day for {pin}")
    day = date.fromisoformat(released) + MONTH
    line = ("pip", "compile", "--no-header", "--no-annotate", "--only-binary", ":all:")
    done = run([*UV, *line, "--exclude-newer", day.isoformat(), "-"], limit_s=RESOLVE_S, given=pin)
    if done.reason:
        raise PinnedEnvironmentError(brief(done.said or done.reason))
    found = [line.strip() for line in done.output.splitlines() if "==" in line]
    return [one for one in found if name_of(one) != name_of(pin)]


def installed_tree(target: Path) -> Path:
    """Copy the packages of this installation, with the metadata that holds their version, into a new folder.

    Raises
    ------
    OSError
        If a file can't be written.
    """
    for name in PACKAGES:
        spec = find_spec(name)
        assert spec is not None
        assert spec.submodule_search_locations
        shutil.copytree(spec.submodule_search_locations[0], target / name, ignore=LEFT_OUT)
    copy_information(target)
    return target


def copy_information(target: Path) -> None:
    """Copy the folder ``barchain-VERSION.dist-info`` of this installation; bare sources have none."""
    with contextlib.suppress(metadata.PackageNotFoundError):
        for file in metadata.distribution("barchain").files or ():
            if file.name == "METADATA":
                folder = Path(str(file.locate())).parent
                shutil.copytree(folder, target / folder.name, ignore=LEFT_OUT, dirs_exist_ok=True)


def commit_tree(commit: str, target: Path) -> Path:
    """Write the packages of a commit into a new folder.

    Parameters
    ----------
    commit : str
        Any name that Git knows.
    target : Path

    Raises
    ------
    PinnedEnvironmentError
        If there is no repository, or no such commit in it.
    """
    if commit.endswith("+"):
        raise PinnedEnvironmentError(f"commit {commit}: the sources differed from the commit; they can't be made again")
    try:
        top = Path(git(Path(__file__).parent, "rev-parse", "--show-toplevel").decode().strip())
        found = git(top, "archive", "--format=tar", commit, *PACKAGES)
    except GitError as error:
        raise PinnedEnvironmentError(f"commit {commit}: {error}") from None
    target.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=io.BytesIO(found)) as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # not in early releases of Python 3.11
        archive.extractall(target)
    copy_information(target)
    return target


def replace_packages(tree: Path, other: Path, packages: Iterable[str]) -> None:
    """Take some packages, or modules, of another tree into a tree: ``adapters.mujoco``, ``reference_impl``."""
    for name in packages:
        place = Path(*name.split("."))
        for path in (place, place.with_suffix(".py")):
            shutil.rmtree(tree / path, ignore_errors=True)
            (tree / path).unlink(missing_ok=True)
            if (other / path).is_dir():
                shutil.copytree(other / path, tree / path, ignore=LEFT_OUT)
            elif (other / path).is_file():
                shutil.copy2(other / path, tree / path)
