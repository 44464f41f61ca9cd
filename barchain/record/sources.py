"""Digests of the sources that decide a run: a stored result is reused only for the same code."""

from __future__ import annotations

import base64
import hashlib
import importlib.util
import json
import re
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

BESIDE_SOURCES = {"tests", "test", "docs", "doc", "examples", "benchmarks"}
"""Folders beside a package's sources that decide no result"""
COMPILED = {".so", ".pyd", ".dylib", ".dll"}
TEXT = {".py", ".c", ".h"}
BUILT_HERE = {"reference_impl"}
"""Packages whose compiled files are built from sources that count already"""
DIGITS = 16


def digest_of(*names: str) -> str:
    """Digest of top-level packages or modules: text of sources in Python and C, size and date of compiled files.

    A missing package has the digest of no files.
    """
    found = hashlib.sha256()
    for name in names:
        for path, inside in files_of(name):
            found.update(f"{name}/{inside}\0".encode() + fingerprint(path) + b"\0")
    return found.hexdigest()[:DIGITS]


def contents_digest(distribution: str) -> str:
    """Digest of the contents of a distribution's installed files; empty without any.

    Dates don't count, so that two installations of the same wheel agree. Files that an installation adds, and compiled
    Python, are left out. A file of the size that the installation recorded has the digest that it recorded. An editable
    distribution lists no sources: those of its modules count.
    """
    try:
        files = metadata.distribution(distribution).files or ()
    except metadata.PackageNotFoundError:
        return ""
    modules = editable_modules(distribution)
    found = hashlib.sha256(digest_of(*modules).encode() if modules else b"")
    for file in sorted(files, key=str):
        path = Path(str(file.locate()))
        if made_by_wheel(str(file)) and path.is_file():
            found.update(f"{file}\0".encode() + file_digest(file, path))
    return found.hexdigest()[:DIGITS]


def file_digest(file: metadata.PackagePath, path: Path) -> bytes:
    """Digest of an installed file: the recorded one, or of its contents where its size is another now."""
    if file.hash is not None and file.hash.mode == "sha256" and file.size == path.stat().st_size:
        return base64.urlsafe_b64decode(file.hash.value + "=")
    with path.open("rb") as content:
        return hashlib.file_digest(content, "sha256").digest()


def made_by_wheel(file: str) -> bool:
    """Whether a file comes with the wheel, not from its installation."""
    added = {"RECORD", "INSTALLER", "REQUESTED", "direct_url.json", "uv_cache.json", "uv_build.json"}
    return not (file.endswith(".pyc") or file.startswith("..") or Path(file).name in added)


@cache
def required_by(distribution: str) -> frozenset[str]:
    """Names of the installed distributions that a distribution requires, directly or through others, extras apart."""
    found: set[str] = set()
    ahead = [distribution]
    while ahead:
        lines = [line for line in requirements(ahead.pop()) if "extra ==" not in line]
        names = {re.sub(r"[-_.]+", "-", re.split(r"[^\w.-]", line)[0]).lower() for line in lines}
        more = {name for name in names - found if is_installed(name)}
        found |= more
        ahead += more
    return frozenset(found)


def requirements(distribution: str) -> list[str]:
    """Lines of an installed distribution's requirements; none if it is not installed."""
    try:
        return metadata.requires(distribution) or []
    except metadata.PackageNotFoundError:
        return []


def is_installed(distribution: str) -> bool:
    """Whether a distribution is installed."""
    return next(iter(metadata.distributions(name=distribution)), None) is not None


def direct_url(distribution: str) -> dict[str, Any]:
    """Place from which pip installed a distribution, by PEP 610; empty for one of an index, or that is not there."""
    try:
        found = json.loads(metadata.distribution(distribution).read_text("direct_url.json") or "{}")
    except (metadata.PackageNotFoundError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def installed_commit(distribution: str) -> str | None:
    """Commit from which pip installed a distribution by its repository's address; None of any other."""
    given = direct_url(distribution).get("vcs_info")
    commit = given.get("commit_id") if isinstance(given, dict) else None
    return commit if isinstance(commit, str) and re.fullmatch("[0-9a-f]{7,64}", commit) else None


def editable_modules(distribution: str) -> tuple[str, ...]:
    """Top-level modules of a distribution that runs from its sources (`pip install -e`); none of any other.

    Its list of installed files names no source. The modules are those of its entry points, those that it names as its
    own, the one with its name, and the packages in the folders that its installation adds to Python's path.
    """
    about = direct_url(distribution).get("dir_info")
    if not (isinstance(about, dict) and about.get("editable") is True):
        return ()
    found = metadata.distribution(distribution)
    entries = {point.value.partition(":")[0].partition(".")[0] for point in found.entry_points}
    named = set((found.read_text("top_level.txt") or "").split())
    return tuple(sorted(entries | named | added_packages(found) | {re.sub(r"[-.]+", "_", distribution).lower()}))


def added_packages(distribution: metadata.Distribution) -> set[str]:
    """Packages in the folders that a distribution's ``.pth`` files add to Python's path, without tests and the like."""
    files = [Path(str(file.locate())) for file in distribution.files or () if file.suffix == ".pth"]
    text = "\n".join(file.read_text(errors="replace") for file in files if file.is_file())
    folders = [Path(line.strip()) for line in text.splitlines() if line.strip() and not line.startswith("import ")]
    inside = (path for folder in folders if folder.is_dir() for path in folder.iterdir())
    return {path.name for path in inside if (path / "__init__.py").is_file() and path.name not in BESIDE_SOURCES}


def files_of(name: str) -> Iterator[tuple[Path, str]]:
    """Sources and compiled files of a top-level package or module, with their names inside; none if it is missing.

    A name without dots is found without an import.
    """
    try:
        spec = importlib.util.find_spec(name)
    except (ImportError, ValueError):  # a module made by hand has no spec
        return
    if spec is None:
        return
    for folder in map(Path, spec.submodule_search_locations or ()):
        for path in sorted(folder.rglob("*")):
            if path.suffix in TEXT or (path.suffix in COMPILED and name not in BUILT_HERE):
                yield path, path.relative_to(folder).as_posix()
    if not spec.submodule_search_locations and spec.origin and Path(spec.origin).is_file():
        yield Path(spec.origin), Path(spec.origin).name


def fingerprint(path: Path) -> bytes:
    """Text of a source, or size and date of a compiled file."""
    if path.suffix in COMPILED:
        about = path.stat()
        return f"{about.st_size} {about.st_mtime_ns}".encode()
    return path.read_bytes()
