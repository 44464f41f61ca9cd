"""Trees of barchain's sources: those of this installation, those of a commit, and mixtures of both."""

from __future__ import annotations

import io
import shutil
import subprocess
import tarfile
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from adapters.registry import PACKAGES
from barchain.nightly.environments.faults import PinnedEnvironmentError

if TYPE_CHECKING:
    from collections.abc import Iterable

LIMIT_S = 120.0
LEFT_OUT = shutil.ignore_patterns("__pycache__", "*.pyc", ".git")


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
    information = information_folder()
    if information is not None:
        shutil.copytree(information, target / information.name, ignore=LEFT_OUT)
    return target


def information_folder() -> Path | None:
    """Folder ``barchain-VERSION.dist-info`` of this installation; None of bare sources."""
    try:
        files = metadata.distribution("barchain").files or ()
    except metadata.PackageNotFoundError:
        return None
    found = next((file for file in files if file.name == "METADATA"), None)
    return None if found is None else Path(str(found.locate())).parent


def commit_tree(commit: str, target: Path, repository: Path | None = None) -> Path:
    """Write the packages of a commit into a new folder.

    Parameters
    ----------
    commit : str
        Any name that Git knows.
    target : Path
    repository : Path, optional
        Folder inside the repository; that of this installation by default.

    Raises
    ------
    PinnedEnvironmentError
        If there is no repository, or no such commit in it.
    """
    if commit.endswith("+"):
        raise PinnedEnvironmentError(f"commit {commit}: the sources differed from the commit; they can't be made again")
    folder = repository or Path(__file__).parent
    line = ["git", "-C", str(folder), "archive", "--format=tar", commit, *PACKAGES]
    root = ["git", "-C", str(folder), "rev-parse", "--show-toplevel"]
    try:
        top = subprocess.run(root, capture_output=True, text=True, check=True, timeout=LIMIT_S).stdout.strip()
        line[2] = top
        found = subprocess.run(line, capture_output=True, check=True, timeout=LIMIT_S).stdout
    except FileNotFoundError:
        raise PinnedEnvironmentError(f"commit {commit}: Git is not installed") from None
    except subprocess.CalledProcessError as error:
        said = (error.stderr if isinstance(error.stderr, str) else error.stderr.decode("utf-8", "replace")).strip()
        raise PinnedEnvironmentError(f"commit {commit}: {said.splitlines()[-1] if said else 'Git failed'}") from None
    except subprocess.TimeoutExpired:
        raise PinnedEnvironmentError(f"commit {commit}: Git did not answer in {LIMIT_S:.0f} s") from None
    target.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=io.BytesIO(found)) as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # not in early releases of Python 3.11
        archive.extractall(target)
    information = information_folder()
    if information is not None and not (target / information.name).exists():
        shutil.copytree(information, target / information.name, ignore=LEFT_OUT)
    return target


def replace_packages(tree: Path, other: Path, packages: Iterable[str]) -> None:
    """Take some packages, or modules, of another tree into a tree: ``adapters.mujoco``, ``reference_impl``."""
    for name in packages:
        place = Path(*name.split("."))
        for path in (place, place.with_suffix(".py")):
            remove(tree / path)
            if (other / path).is_dir():
                shutil.copytree(other / path, tree / path, ignore=LEFT_OUT)
            elif (other / path).is_file():
                shutil.copy2(other / path, tree / path)


def remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
