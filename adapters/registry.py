"""Registry of engines by name; a class is imported on first use."""

from __future__ import annotations

import importlib
import importlib.util
import re
from dataclasses import dataclass
from importlib.metadata import EntryPoint, PackageNotFoundError, entry_points, version
from typing import TYPE_CHECKING

from reference_impl.kernel.build import why_missing
from scenarios import nearest
from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from adapters.engine import Engine

ENTRY_POINT_GROUP = "barchain.engines"  # for third parties; barchain's own engines are in the dict below


SAFE_NAME = r"[A-Za-z0-9][A-Za-z0-9_-]{0,59}"
TARGET = r"[A-Za-z_][\w.]*:[A-Za-z_]\w*"
PACKAGES = ("barchain", "adapters", "reference_impl", "scenarios", "reports")
"""Top-level packages of barchain"""
COMMAND_TARGET = "adapters.command.engine:CommandEngine"
RESERVED = frozenset({
    "solution", "solution-check", "solution-dense", "perturbed-start", "close-start", "amplification",
})  # fmt: skip
"""Names of the judging solution's own files beside those of engines"""


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
    """Whether a command without engine names selects the engine; False for engines that only studies need"""
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

    @property
    def by_default(self) -> bool:
        """Whether a command without engine names selects the engine here."""
        return self.in_default_set and not self.rejected and not (self.optional and self.missing)

    @property
    def external(self) -> bool:
        """Whether the engine has independent physics, and so checks the reference."""
        return not self.ours

    def load(self) -> type[Engine]:
        """Import the class; of a command, make it of its entry."""
        if self.entry:
            from adapters.command.engine import command_class

            made: type[Engine] = command_class(self.entry)
            return made
        module, _, name = self.target.partition(":")
        found: type[Engine] = getattr(importlib.import_module(module), name)
        return found

    @property
    def missing(self) -> str | None:
        """Missing distribution and the command that installs it; None if the engine can be used here."""
        if self.rejected:
            return self.rejected
        if self.entry:
            from adapters.command.entries import unpacked, why_not_there

            return why_not_there(*unpacked(self.entry)) or None
        if self.requires and importlib.util.find_spec(self.module or self.requires) is None:
            return f"{self.requires} is not installed; try: {self.install}"
        # a failing import of an installed distribution is reported by the worker
        return (why_missing() or None) if self.needs_kernel else None

    @property
    def remedy(self) -> str:
        """What brings an engine that is missing here: the command for its distribution, or the kernel's."""
        there = not self.requires or importlib.util.find_spec(self.module or self.requires)
        return KERNEL_REMEDY if self.needs_kernel and there and why_missing() else self.install

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


def _ours(module: str, name: str) -> Registration:
    return Registration(f"adapters.{module}:{name}", ours=True)


def _external(module: str, name: str, requires: str, *, in_default_set: bool = True) -> Registration:
    install = f"pip install {requires}"
    return Registration(f"adapters.{module}:{name}", requires, install=install, in_default_set=in_default_set)


def _more(module: str, name: str, requires: str, imported: str = "") -> Registration:
    """Registration of an engine that only studies select."""
    install = "pip install '.[more-engines]'"
    return Registration(f"adapters.{module}:{name}", requires, imported, install, in_default_set=False, optional=True)


def _robotics(name: str, requires: str, imported: str) -> Registration:
    """Registration of a robotics library with an extra and an adapter of its own name."""
    target, install = f"adapters.{name.lower()}.adapter:{name}", f"pip install '.[{name.lower()}]'"
    return Registration(target, requires, imported, install, in_default_set=False, optional=True)


def _solver(module: str, name: str, requires: str, imported: str = "") -> Registration:
    """Registration of a library's integrator on the compiled reference's equations."""
    install = "pip install scipy" if requires == "scipy" else "pip install '.[more-engines]'"
    return Registration(
        f"adapters.{module}:{name}",
        requires,
        imported,
        install,
        ours=True,
        in_default_set=False,
        optional=True,
        needs_kernel=True,
    )


def _certified(name: str, *, in_default_set: bool = True) -> Registration:
    install = "pip install '.[certified]'"
    return Registration(
        f"adapters.heyoka.adapter:{name}",
        "heyoka",
        "",
        install,
        in_default_set=in_default_set,
        optional=True,
        compiles=True,
    )


KERNEL_REMEDY = "a C compiler, then `pip install --force-reinstall --no-deps .`"
COMPILED, WIDE = "reference-fast", "reference-wide"
"""Names of the compiled reference, in double and in extended precision"""

ENGINES: dict[str, Registration] = {
    "reference": _ours("reference.numpy_engines", "Reference"),
    "reference-fast": Registration(
        "adapters.reference.compiled_engine:ReferenceFast",
        ours=True,
        optional=True,
        needs_kernel=True,
    ),
    "reference-wide": Registration(
        "adapters.reference.compiled_engine:ReferenceWide",
        ours=True,
        in_default_set=False,
        optional=True,
        needs_kernel=True,
    ),
    "reference-absolute": _ours("reference.numpy_engines", "ReferenceAbsolute"),
    "exudyn": _external("exudyn.adapter", "Exudyn", "exudyn"),
    "exudyn-index3": _external("exudyn.adapter", "ExudynIndex3", "exudyn"),
    "exudyn-absolute": _external("exudyn.adapter", "ExudynAbsolute", "exudyn"),
    "exudyn-absolute-index3": _external("exudyn.adapter", "ExudynAbsoluteIndex3", "exudyn", in_default_set=False),
    "exudyn-tree": _external("exudyn.adapter", "ExudynTree", "exudyn"),
    "rebound": _external("rebound.adapter", "Rebound", "rebound"),
    "pymunk": _external("pymunk.adapter", "Pymunk", "pymunk"),
    "pymunk-absolute": _external("pymunk.adapter", "PymunkAbsolute", "pymunk"),
    "heyoka": _certified("Heyoka"),
    "heyoka-long": _certified("HeyokaLong", in_default_set=False),
    "heyoka-quad": _certified("HeyokaQuad", in_default_set=False),
    "scipy-dop853": _solver("ode_solvers.scipy_engines", "ScipyDop853", "scipy"),
    "scipy-radau": _solver("ode_solvers.scipy_engines", "ScipyRadau", "scipy"),
    "cvode-adams": _solver("ode_solvers.cvode_engines", "CvodeAdams", "scikit-sundae", "sksundae"),
    "cvode-bdf": _solver("ode_solvers.cvode_engines", "CvodeBdf", "scikit-sundae", "sksundae"),
    "mujoco": _more("mujoco.adapter", "Mujoco", "mujoco"),
    "pinocchio": _more("pinocchio.adapter", "Pinocchio", "pin", "pinocchio"),
    "drake": _robotics("Drake", "drake", "pydrake"),
    "dart": _robotics("Dart", "dartpy", "dartpy"),
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
    """Registrations of engines that are commands; a name that is taken is rejected, with the reason."""
    from adapters.command.entries import entry_files, found_entries, packed

    if not entry_files():
        return {}
    made = {}
    for folder, entry in found_entries():
        used = entry.name in taken or entry.name.lower() in RESERVED
        name = f"{entry.name} ({folder.name})" if used else entry.name
        reason = f"the name {entry.name} of an engine in {folder} is taken; give it another" if used else ""
        made[name] = Registration(COMMAND_TARGET, rejected=reason, entry=packed(folder, entry))
    return made


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
        raise UnknownEngineError(f"{name}: no such engine{near}; {there}{said}")
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
