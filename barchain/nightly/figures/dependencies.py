"""Parts that figures depend on: the environment, their versions and digests here, and which figure depends on which."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from adapters.command.entries import deciding_files, unpacked, version_words
from adapters.registry import PACKAGES, engines, find_engine
from barchain.nightly.figures.figure import (
    MACHINE,
    MOST_TEXT,
    REQUIREMENTS,
    Environment,
    FigureKind,
    NightPart,
    content_digest,
)
from barchain.nightly.figures.package_origins import installed_state
from barchain.record.environment import environment, machine, package_version
from barchain.record.sources import DIGITS, contents_digest, digest_of, installed_commit, required_by
from barchain.runs.processes import GitError, git

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from adapters.registry import Registration


LIBC = "-with-"
"""Stands before the C library in the platform's name"""


def capture() -> Environment:
    """Environment of this process."""
    return recorded_environment({"environment": environment(), "machine": machine()})


def recorded_environment(record: Mapping[str, Any]) -> Environment:
    """Environment of a record; earlier records know the kernel and the C library by the platform's name only."""
    own = record.get("environment") or {}
    kernel, _, libc = str(own.get("platform") or "").partition(LIBC)
    below = {"kernel": kernel, "libc": libc.replace("glibc", "glibc ")} | dict(record.get("machine") or {})
    text = {name: str(below.get(name) or "") for name in ("cpu_flags", "architecture", "kernel", "libc", "blas")}
    return Environment(
        cpu=str(own.get("cpu") or ""), cores=int(own.get("cores") or 0), python=str(own.get("python") or ""), **text
    )


PYTHON, BLAS, VARIABLES = "python", "blas", "variables"
HARNESS, REFERENCE, JUDGE, SHARED = "harness", "reference", "judge", "adapter:shared"
SOURCES = {
    HARNESS: ("barchain.record", "barchain.runs", "barchain.nightly.figures.results", "reports.results", "scenarios"),
    REFERENCE: ("reference_impl",),
    JUDGE: ("barchain.judge", "barchain.metrics", "barchain.solutions", "barchain.studies"),
    SHARED: ("adapters.common", "adapters.bar_loads", "adapters.engine", "adapters.trajectory", "adapters.registry"),
}
"""Packages of each part of barchain that figures of all engines depend on"""
DECIDING = ("BARCHAIN_KERNEL", "BARCHAIN_NO_KERNEL", "NPY_DISABLE_CPU_FEATURES", "OPENBLAS_CORETYPE")
"""Variables that choose the code which computes"""
LIBRARIES = ("numpy", "pandas", "pyarrow", "scipy")
"""Libraries that every engine's figures depend on: they read, judge, step, and keep tables"""
IMPORTED = {"adapter:ode_solvers": ("adapter:reference",)}
"""Adapters that import others"""
JUDGED = {FigureKind.ERROR, FigureKind.VERDICT, FigureKind.VALUE}
"""Kinds that depend on the judge and its solutions"""


def installed_parts(names: Iterable[str], scenes: Iterable[str], environment: Environment) -> tuple[NightPart, ...]:
    """Parts as they are installed here, with digests of the contents of their files.

    Parameters
    ----------
    names : iterable of str
        Names of engines.
    scenes : iterable of str
        Names of scenes that come with barchain, or paths of scene files.
    environment : Environment

    Raises
    ------
    UnknownEngineError, SceneError
        If a name is none.
    """
    found = {part.name: part for part in (*environment_parts(environment), variables_part())}
    own = package_version("barchain")
    found |= {name: NightPart(name, own, digest_of(*sources)) for name, sources in SOURCES.items()}
    for name in LIBRARIES:
        found[f"library:{name}"] = distribution_part(f"library:{name}", name)
    for registration in map(find_engine, names):
        for adapter in adapters_of(registration):
            found[adapter] = NightPart(adapter, own, digest_of(adapter.replace(":", "s.")))
        for part, name in distributions_of(registration).items():
            found[part] = distribution_part(part, name)
        found |= {part.name: part for part in map(requirements_part, requiring(registration))}
        if registration.entry:
            program = program_name(registration)
            state = version_words(*unpacked(registration.entry))
            found[program] = NightPart(program, state, registration.version)
    for scene in scenes:
        found |= {part.name: part for part in scene_parts(scene)}
    return tuple(found.values())


def environment_parts(environment: Environment) -> tuple[NightPart, ...]:
    """Python and the libraries of linear algebra: what they change has them as suspects.

    A library that lies in a wheel counts without its version: that is part of the wheel's own state.
    """
    libraries = [library.split(" ") for library in environment.blas.split(", ")]
    blas = ", ".join(" ".join((words[0], *words[2:]) if words[-1].startswith("(") else words) for words in libraries)
    known = {PYTHON: environment.python, BLAS: blas}
    return tuple(NightPart(name, text, content_digest(text)[:DIGITS] if text else "") for name, text in known.items())


def variables_part() -> NightPart:
    """Environment variables that choose the code which computes: other bits come from them, too."""
    text = ", ".join(f"{name}={os.environ[name]}" for name in DECIDING if os.environ.get(name))
    return NightPart(VARIABLES, text[:MOST_TEXT], content_digest(text)[:DIGITS])


def scene_parts(scene: str) -> tuple[NightPart, ...]:
    """Scene, and the solution that judges it; where none comes with barchain, the digest of no file on every night."""
    from barchain.solutions.certified_file import shipped_path  # noqa: PLC0415
    from scenarios import load_scene  # noqa: PLC0415

    loaded = load_scene(scene)
    file = shipped_path(loaded.name)
    digest = hashlib.sha256(file.read_bytes() if file.is_file() else b"").hexdigest()[:DIGITS]
    return (
        NightPart(f"scene:{loaded.name}", "", loaded.digest),
        NightPart(f"solution:{loaded.name}", "", digest),
    )


@cache
def distribution_part(part: str, name: str) -> NightPart:
    """Installed distribution as a part."""
    return NightPart(part, installed_state(name), contents_digest(name))


def depends_on(scene: str, engine: str, kind: FigureKind, anchor: str = "") -> tuple[str, ...]:
    """Names of the parts that a figure depends on.

    Parameters
    ----------
    scene, engine : str
        Names; empty, or in parentheses, where a figure belongs to none.
    kind : FigureKind
    anchor : str
        Engine whose time is 1, of a ratio.
    """
    found = {MACHINE, PYTHON, BLAS, VARIABLES, HARNESS, REFERENCE, *(f"library:{name}" for name in LIBRARIES)}
    for name in (engine, anchor):
        registration = engines().get(name)
        if registration is not None:
            found |= {SHARED, *adapters_of(registration), *distributions_of(registration)}
            found |= {f"{REQUIREMENTS}{name}" for name in requiring(registration)}
            if registration.entry:
                found.add(program_name(registration))
    if scene:
        found.add(f"scene:{scene}")
    if kind in JUDGED:
        found |= {JUDGE, f"solution:{scene}"} if scene else {JUDGE}
    return tuple(sorted(found))


def adapters_of(registration: Registration) -> tuple[str, ...]:
    """Parts of an engine's adapter: the package of its module, and those that it imports."""
    package, _, rest = registration.target.partition(":")[0].partition(".")
    if package != "adapters":
        return ()
    own = f"adapter:{rest.partition('.')[0]}"
    return (own, *IMPORTED.get(own, ()))


def distributions_of(registration: Registration) -> dict[str, str]:
    """Distributions behind an engine, by the name of the part."""
    names = {registration.requires, registration.distribution} - {"", *LIBRARIES}
    return {f"engine:{name}": name for name in names}


def program_name(registration: Registration) -> str:
    """Part of an engine that is a program; the name tells what counts: its entry, and the contents of files."""
    folder, entry = unpacked(registration.entry)
    files = ", ".join(deciding_files(folder, entry)) or "files unknown"
    return f"program:{entry.name} (its entry, {files})"[:MOST_TEXT]


def requiring(registration: Registration) -> tuple[str, ...]:
    """Distributions of an engine that require others, which are a part of their own."""
    return tuple(name for name in distributions_of(registration).values() if required_by(name) - set(LIBRARIES))


@cache
def requirements_part(name: str) -> NightPart:
    """All distributions that an engine's distribution requires, as one part: pip exchanges them with the engine.

    Libraries that are parts by themselves are not among them.
    """
    names = sorted(required_by(name) - set(LIBRARIES))
    found = {each: f"{package_version(each)} {contents_digest(each)}" for each in names}
    versions = ", ".join(f"{each} {package_version(each)}" for each in found)
    return NightPart(f"{REQUIREMENTS}{name}", versions[:MOST_TEXT], content_digest(found)[:DIGITS])


def commit() -> str | None:
    """Commit of barchain's sources, with a plus where a file of any package differs; None outside its repository.

    An installation that lies inside a repository, but is no part of it, has no commit of that: it may be older. Of one
    from a repository's address, pip notes the commit.
    """
    folder = Path(__file__).parent
    try:
        git(folder, "ls-files", "--error-unmatch", Path(__file__).name)
        found = git(folder, "rev-parse", "HEAD").decode().strip()
        paths = (f":/{name}" for name in PACKAGES)
        changed = git(folder, "status", "--porcelain", "--untracked-files=no", "--", *paths)
    except GitError:
        return installed_commit("barchain")
    return f"{found}+" if changed else found


@dataclass(frozen=True)
class Installation:
    """Installation at one moment."""

    barchain: str
    """Version"""
    environment: Environment
    parts: tuple[NightPart, ...] = ()
    commit: str | None = None


def installation_here(engines: Iterable[str], scenes: Iterable[str]) -> Installation:
    """Installation of this process, with the digests of the installed files of some engines.

    Parameters
    ----------
    engines : iterable of str
        Names.
    scenes : iterable of str
        Names of scenes that come with barchain.

    Raises
    ------
    UnknownEngineError, SceneError
        If a name is none.
    """
    environment = capture()
    parts = installed_parts(sorted(set(engines)), sorted(set(scenes)), environment)
    return Installation(package_version("barchain"), environment, parts, commit())


def code_of(installation: Installation, engines: Iterable[str]) -> str:
    """Digest of all sources, engines and libraries, and of the environment.

    Parameters
    ----------
    installation : Installation
    engines : iterable of str
        Names: sources of engines outside barchain count too, wherever they lie.
    """
    tops = {find_engine(name).target.partition(":")[0].partition(".")[0] for name in engines} - set(PACKAGES)
    sources = digest_of(*PACKAGES, *sorted(tops))
    return content_digest([sources, installation.environment, list(installation.parts)])[:DIGITS]
