"""Registry of engines by name; a class is imported on first use."""

from __future__ import annotations

import importlib
import importlib.util
import re
from dataclasses import dataclass, replace
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from reference_impl.kernel.build import why_missing
from scenarios import nearest
from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from adapters.command.entries import Entry
    from adapters.engine import Declarations, Engine

ENTRY_POINT_GROUP = "barchain.engines"  # for third parties; barchain's own engines are in the dict below


SAFE_NAME = r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}"
TARGET = r"[A-Za-z_][\w.]*:[A-Za-z_]\w*"
PACKAGES = ("barchain", "adapters", "reference_impl", "scenarios", "reports")
"""Top-level packages of barchain"""
COMMAND_TARGET = "adapters.command.engine:CommandEngine"
ALL = "all"
"""Stands for all engines of the default set, and the programs of the working folder"""
RESERVED = frozenset({
    ALL, "solution", "solution-check", "solution-dense", "perturbed-start", "close-start", "amplification",
})  # fmt: skip
"""Names that no engine has: those of the judging solution's own files, and the one that stands for all"""


class UnknownEngineError(KeyError):
    """No engine of that name is registered."""

    def __str__(self) -> str:
        """Message without the quotes that KeyError adds."""
        return str(self.args[0])


@dataclass(frozen=True)
class Registration:
    """Import path and requirements of an engine's class."""

    target: str
    """``module:Class``"""
    requires: str = ""
    """Distribution that provides the third-party engine; empty if there is none."""
    module: str = ""
    """Module to import from the distribution, where its name differs."""
    install: str = ""
    """Command that installs a missing distribution."""
    ours: bool = False
    """Whether the engine steps barchain's own equations, and so is no independent check of them"""
    in_default_set: bool = True
    """Whether a command without engine names selects the engine; False for engines that only studies need, and for
    programs of a file that lies in the working folder
    """
    optional: bool = False
    """Whether an extra provides the distribution, or a compiler the kernel; while either is missing, only a command
    that names the engine selects it
    """
    compiles: bool = False
    """Whether `build` compiles code for the scene's effects, which may take longer than the run"""
    distribution: str = ""
    """Distribution that registers the engine, of another package; its version and files decide a stored result"""
    needs_kernel: bool = False
    """Whether the engine needs the compiled kernel of the reference"""
    rejected: str = ""
    """Reason why the engine can't be selected: its name is taken, or is none"""
    entry: str = ""
    """Entry of an engine that is a command, see :mod:`adapters.command.entries`; empty of every other"""
    python: str = ""
    """Python of another environment, whose workers run the engine and answer for it; empty: the one that asks"""

    @property
    def by_default(self) -> bool:
        """Whether a command without engine names selects the engine here."""
        return self.in_default_set and not self.rejected and not (self.optional and self.missing)

    @property
    def external(self) -> bool:
        """Whether the engine has independent physics, and so checks the reference."""
        return not self.ours

    def load(self) -> type[Engine]:
        """Import the class."""
        path, _, name = self.target.partition(":")
        found: type[Engine] = getattr(importlib.import_module(path), name)
        return found

    def engine(self, options: Iterable[str] = ()) -> Engine:
        """Engine for one run, made in this process."""
        kind: Any = self.load()
        if self.entry:
            from adapters.command.entries import unpacked

            return cast("Engine", kind(*unpacked(self.entry)))
        return cast("Engine", kind(**dict.fromkeys(options, True)))

    def declarations(self) -> Declarations:
        """Declarations of the class, which is imported into this process, or of a command's entry."""
        if self.entry:
            from adapters.command.entries import unpacked

            return unpacked(self.entry)[1].declarations
        return self.load().declarations()

    @property
    def missing(self) -> str | None:
        """Missing distribution and the command that installs it; None if the engine can be used here."""
        if self.rejected:
            return self.rejected
        if self.entry:
            from adapters.command.entries import unpacked, why_not_there

            return why_not_there(*unpacked(self.entry)) or None
        if self.python and not Path(self.python).is_file():
            return f"{self.python} is not there, the Python that runs it"
        if self.requires and importlib.util.find_spec(self.module or self.requires) is None:
            return f"{self.requires} is not installed; try: {self.install}"
        # a failing import of an installed distribution is reported by the worker
        return (why_missing() or None) if self.needs_kernel else None

    @property
    def remedy(self) -> str:
        """What brings an engine that is missing here: the command for its distribution, or the kernel's."""
        if self.entry:
            from adapters.command.entries import remedy, unpacked

            return remedy(unpacked(self.entry)[1])
        there = not self.requires or importlib.util.find_spec(self.module or self.requires)
        return KERNEL_REMEDY if self.needs_kernel and there and why_missing() else self.install

    @property
    def version_words(self) -> str:
        """Version for readers: of a program what its entry states, if it states one."""
        if self.entry:
            from adapters.command.entries import unpacked, version_words

            return version_words(*unpacked(self.entry)) or self.version
        return self.version

    @property
    def version(self) -> str:
        """Installed version of the engine's distribution; barchain's own version for the reference.

        An engine of another package without a distribution (a module on the path) has no version; a command has the
        digest of its entry and the files that it declares.
        """
        if self.entry:
            from adapters.command.entries import content_digest, unpacked

            return content_digest(*unpacked(self.entry))
        own = "" if self in ENGINES.values() else self.distribution
        if not own and self not in ENGINES.values():
            return "none"
        try:
            return version(own or self.requires or "barchain")
        except PackageNotFoundError:
            return "not installed"


KERNEL_REMEDY = "a C compiler, then `pip install --force-reinstall --no-deps .`"
COMPILED, WIDE = "reference-fast", "reference-wide"
"""Names of the compiled reference, in double and in extended precision"""


def _adapter(
    module: str, name: str, requires: str = "", imported: str = "", *, extra: str = "", **flags: Any
) -> Registration:
    """Registration of one of barchain's own adapters; `extra` is the extra that installs `requires`."""
    install = f"pip install '.[{extra}]'" if extra else f"pip install {requires}" if requires else ""
    return Registration(f"adapters.{module}:{name}", requires, imported, install, optional=bool(extra), **flags)


def _kernel(module: str, name: str, **flags: Any) -> Registration:
    """Registration of a form of the reference in C."""
    return Registration(f"adapters.{module}:{name}", ours=True, optional=True, needs_kernel=True, **flags)


def _solver(name: str, requires: str, imported: str = "", install: str = "") -> Registration:
    """Registration of a library's integrator on the compiled reference's equations, which only studies select."""
    made = _kernel("ode_solvers.adapter", name, in_default_set=False)
    return replace(made, requires=requires, module=imported, install=install)


MORE = "more-engines"
ENGINES: dict[str, Registration] = {
    "reference": _adapter("reference.numpy_engines", "Reference", ours=True),
    "reference-fast": _kernel("reference.compiled_engine", "ReferenceFast"),
    "reference-wide": _kernel("reference.compiled_engine", "ReferenceWide", in_default_set=False),
    "reference-absolute": _adapter("reference.numpy_engines", "ReferenceAbsolute", ours=True),
    "exudyn": _adapter("exudyn.adapter", "Exudyn", "exudyn"),
    "exudyn-index3": _adapter("exudyn.adapter", "ExudynIndex3", "exudyn"),
    "exudyn-absolute": _adapter("exudyn.adapter", "ExudynAbsolute", "exudyn"),
    "exudyn-absolute-index3": _adapter("exudyn.adapter", "ExudynAbsoluteIndex3", "exudyn", in_default_set=False),
    "exudyn-tree": _adapter("exudyn.adapter", "ExudynTree", "exudyn"),
    "rebound": _adapter("rebound.adapter", "Rebound", "rebound"),
    "pymunk": _adapter("pymunk.adapter", "Pymunk", "pymunk"),
    "pymunk-absolute": _adapter("pymunk.adapter", "PymunkAbsolute", "pymunk"),
    "heyoka": _adapter("heyoka.adapter", "Heyoka", "heyoka", extra="certified", compiles=True),
    "heyoka-long": _adapter(
        "heyoka.adapter", "HeyokaLong", "heyoka", extra="certified", compiles=True, in_default_set=False
    ),
    "heyoka-quad": _adapter(
        "heyoka.adapter", "HeyokaQuad", "heyoka", extra="certified", compiles=True, in_default_set=False
    ),
    "scipy-dop853": _solver("ScipyDop853", "scipy", install="pip install scipy"),
    "scipy-radau": _solver("ScipyRadau", "scipy", install="pip install scipy"),
    "cvode-adams": _solver("CvodeAdams", "scikit-sundae", "sksundae", f"pip install '.[{MORE}]'"),
    "cvode-bdf": _solver("CvodeBdf", "scikit-sundae", "sksundae", f"pip install '.[{MORE}]'"),
    **{
        name: _adapter("ida.adapter", kind, "scikit-sundae", "sksundae", extra=MORE, in_default_set=False)
        for name, kind in (
            ("ida-index1", "IdaIndex1"),
            ("ida-index2", "IdaIndex2"),
            ("ida-ggl", "IdaGgl"),
            ("ida-index3", "IdaIndex3"),
        )
    },
    "mujoco": _adapter("mujoco.adapter", "Mujoco", "mujoco", extra=MORE, in_default_set=False),
    "pinocchio": _adapter("pinocchio.adapter", "Pinocchio", "pin", "pinocchio", extra=MORE, in_default_set=False),
    "drake": _adapter("drake.adapter", "Drake", "drake", "pydrake", extra="drake", in_default_set=False),
    "dart": _adapter("dart.adapter", "Dart", "dartpy", "dartpy", extra="dart", in_default_set=False),
}


def engines() -> dict[str, Registration]:
    """All registered engines: barchain's, those of installed third parties, then commands.

    A third party can't take a name of barchain's, nor one that another distribution registers too, nor one that is no
    file name. Such an engine is listed as missing, with the reason; its class is not imported.

    Raises
    ------
    EntryError
        If a file of commands can't be read, or has a fault.
    """
    found = ENGINES | third_party(entry_points(group=ENTRY_POINT_GROUP))
    return found | commands(found)


def commands(taken: Collection[str]) -> dict[str, Registration]:
    """Registrations of engines that are commands; a name that is taken is rejected, with the reason.

    A file that only lies in the working folder starts no program by that: its engines are in no default set.
    """
    from adapters.command.entries import found_entries

    made = {}
    for path, entry in found_entries():
        folder = path.resolve().parent
        used = entry.name in taken or entry.name.lower() in RESERVED
        name = f"{entry.name} ({folder.name})" if used else entry.name
        reason = f"the name {entry.name} of an engine in {folder} is taken; give it another" if used else ""
        made[name] = program_of(path, entry, reason)
    return made


def program_of(path: Path, entry: Entry, rejected: str = "") -> Registration:
    """Registration of an entry of a file; barchain's own programs run where they are named."""
    from adapters.command.entries import OURS, lies_here, packed, remedy

    ours = path in OURS
    return Registration(
        COMMAND_TARGET, install=remedy(entry), in_default_set=not (ours or lies_here(path)), optional=ours,
        rejected=rejected, entry=packed(path.resolve().parent, entry),
    )  # fmt: skip


def built_in() -> dict[str, Registration]:
    """Engines of barchain's: :data:`ENGINES`, and those that have an environment of their own."""
    from adapters.command.entries import OURS, read_entries

    return ENGINES | {entry.name: program_of(path, entry) for path in OURS for entry in read_entries(path)}


def third_party(found: Iterable[EntryPoint]) -> dict[str, Registration]:
    """Registrations of other packages' engines, by names that are all different and safe as file names."""
    points = sorted(found, key=lambda e: (e.name, origin(e)))
    origins: dict[str, set[str]] = {}
    for e in points:
        origins.setdefault(e.name.lower(), set()).add(origin(e))
    made = {}
    for e in points:
        reason, name = name_fault(e, origins[e.name.lower()]), printable(e.name)
        if reason:
            name = f"{name} ({origin(e)})"
        distribution = e.dist.name if e.dist else ""
        install = f"pip install --force-reinstall {distribution}" if distribution else ""
        made[name] = Registration(e.value, install=install, distribution=distribution, rejected=reason)
    return made


def name_fault(point: EntryPoint, origins: set[str]) -> str:
    """Reason against an engine's name; empty if it is safe and its own."""
    if point.name.lower() in ENGINES or point.name.lower() in RESERVED:
        return f"the name {printable(point.name)} is barchain's own; {origin(point)} must register another"
    if len(origins) > 1:
        return f"the name {printable(point.name)} is registered by {' and by '.join(sorted(origins))}"
    if not re.fullmatch(SAFE_NAME, point.name):
        return f"the name {printable(point.name)!r} is not made of 1 to 60 letters, digits, _ and -"
    if not re.fullmatch(TARGET, point.value):
        return f"its entry point {printable(point.value)!r} is not module:Class"
    return ""


def origin(point: EntryPoint) -> str:
    """Distribution that an entry point belongs to, or its module."""
    return point.dist.name if point.dist else printable(point.value.partition(":")[0])


def printable(text: str) -> str:
    """One line of at most 60 printable characters."""
    return "".join(c if c.isprintable() else "?" for c in text[:60])


def find_engine(name: str) -> Registration:
    """Registration of the engine called `name`.

    Raises
    ------
    UnknownEngineError
        If there is none; the message gives the nearest name, or all names.
    """
    if isinstance(name, str) and name in ENGINES:  # a name that no package can take: none is looked through
        return ENGINES[name]
    known = engines()
    if not isinstance(name, str):
        raise UnknownEngineError(
            f"{shorten(name)} given as an engine{nearest(str(name), known)}; allowed: a name, one of {', '.join(known)}"
        )
    if name not in known:
        allowed = [n for n, r in known.items() if not r.rejected]
        reasons = [r.rejected for n, r in known.items() if r.rejected and n.partition(" (")[0] == name]
        said = f"; {'; '.join(reasons)}" if reasons else ""
        near = nearest(name, allowed)
        there = f"`barchain engines` lists all {len(allowed)}" if near else f"allowed: {', '.join(allowed)}"
        programs = "" if near or said else "; engines that are programs: engines.toml in this folder, or --engines FILE"
        raise UnknownEngineError(f"{name}: no such engine{near}; {there}{said}{programs}")
    return known[name]


def find_own_engine(name: str) -> Registration:
    """Registration of one of barchain's own adapters, whose class may be loaded in this process.

    Raises
    ------
    UnknownEngineError
        If there is none, or the engine is another package's.
    """
    found = find_engine(name)
    if name not in ENGINES:
        raise UnknownEngineError(
            f"{name}: an engine of another package; faults are inserted into barchain's own: {', '.join(ENGINES)}"
        )
    return found
