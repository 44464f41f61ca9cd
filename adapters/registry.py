"""Engines by name: strings, imported only when they are used."""

from __future__ import annotations

import importlib
import importlib.util
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, entry_points, version
from typing import TYPE_CHECKING

from scenarios import nearest

if TYPE_CHECKING:
    from adapters.engine import Engine

ENTRY_POINT_GROUP = "barchain.engines"  # third parties register here; ours are in the dict below


class UnknownEngineError(KeyError):
    """No engine of that name is registered."""

    def __str__(self) -> str:
        """Give the message without KeyError's quotes."""
        return str(self.args[0])


@dataclass(frozen=True)
class Registration:
    """Where an engine's class is, and what it needs."""

    target: str
    """``module:Class``"""
    requires: str = ""
    """Distribution that brings the external engine; empty if there is none."""
    module: str = ""
    """What to import of it, where that is called otherwise."""
    install: str = ""
    """What to type where it is missing."""
    ours: bool = False
    """Whether it is the reference in some form, and so no check on it"""
    everyday: bool = True
    """Whether it takes part where no engine is named; those that only a study needs do not"""
    optional: bool = False
    """Whether an extra brings it: where that is not installed it takes part only if it is named"""
    compiles: bool = False
    """Whether it compiles code for a scene's effects while it builds, which may take longer than the run"""

    @property
    def by_default(self) -> bool:
        """Whether it takes part where no engine is named."""
        return self.everyday and not (self.optional and self.missing)

    @property
    def external(self) -> bool:
        """Whether the engine is somebody else's work, and so a check on the reference."""
        return not self.ours

    def load(self) -> type[Engine]:
        """Import the class."""
        module, _, name = self.target.partition(":")
        found: type[Engine] = getattr(importlib.import_module(module), name)
        return found

    @property
    def missing(self) -> str | None:
        """Why the engine can't be used here, and how to get it; None if it can."""
        if not self.requires:
            return None
        if importlib.util.find_spec(self.module or self.requires) is None:
            return f"{self.requires} is not installed; try: {self.install}"
        return None  # one that is there but does not import is found out in its worker

    @property
    def version(self) -> str:
        """Installed version of the external engine; our own for the reference."""
        try:
            return version(self.requires or "barchain")
        except PackageNotFoundError:
            return "not installed"


def _ours(module: str, name: str) -> Registration:
    return Registration(f"adapters.{module}:{name}", ours=True)


def _external(module: str, name: str, requires: str, *, everyday: bool = True) -> Registration:
    install = f"pip install {requires}"
    return Registration(f"adapters.{module}:{name}", requires, install=install, everyday=everyday)


def _more(module: str, name: str, requires: str, imported: str = "", *, ours: bool = False) -> Registration:
    """What a user would pick instead; for studies only."""
    install = "pip install '.[more-engines]'"
    return Registration(
        f"adapters.{module}:{name}", requires, imported, install, ours=ours, everyday=False, optional=True
    )


def _certified(name: str, *, everyday: bool = True) -> Registration:
    install = "pip install '.[certified]'"
    return Registration(
        f"adapters.heyoka.adapter:{name}", "heyoka", "", install, everyday=everyday, optional=True, compiles=True
    )


ENGINES: dict[str, Registration] = {
    "reference": _ours("reference.numpy_engines", "Reference"),
    "reference-fast": Registration(
        "adapters.reference.compiled_engine:ReferenceFast",
        "numba",
        "",
        "pip install '.[fast]'",
        ours=True,
        optional=True,
        compiles=True,
    ),
    "reference-absolute": _ours("reference.numpy_engines", "ReferenceAbsolute"),
    "exudyn": _external("exudyn.adapter", "Exudyn", "exudyn"),
    "exudyn-index3": _external("exudyn.adapter", "ExudynIndex3", "exudyn"),
    "exudyn-absolute": _external("exudyn.adapter", "ExudynAbsolute", "exudyn"),
    "exudyn-absolute-index3": _external("exudyn.adapter", "ExudynAbsoluteIndex3", "exudyn", everyday=False),
    "exudyn-tree": _external("exudyn.adapter", "ExudynTree", "exudyn"),
    "rebound": _external("rebound.adapter", "Rebound", "rebound"),
    "pymunk": _external("pymunk.adapter", "Pymunk", "pymunk"),
    "pymunk-absolute": _external("pymunk.adapter", "PymunkAbsolute", "pymunk"),
    "heyoka": _certified("Heyoka"),
    "heyoka-long": _certified("HeyokaLong", everyday=False),
    "heyoka-quad": _certified("HeyokaQuad", everyday=False),
    "scipy-rk45": _more("ode_solvers.scipy_engines", "ScipyRK45", "scipy", ours=True),
    "scipy-dop853": _more("ode_solvers.scipy_engines", "ScipyDop853", "scipy", ours=True),
    "scipy-radau": _more("ode_solvers.scipy_engines", "ScipyRadau", "scipy", ours=True),
    "scipy-lsoda": _more("ode_solvers.scipy_engines", "ScipyLsoda", "scipy", ours=True),
    "cvode-adams": _more("ode_solvers.cvode_engines", "CvodeAdams", "scikit-sundae", "sksundae", ours=True),
    "cvode-bdf": _more("ode_solvers.cvode_engines", "CvodeBdf", "scikit-sundae", "sksundae", ours=True),
    "mujoco": _more("mujoco.adapter", "Mujoco", "mujoco"),
    "pinocchio": _more("pinocchio.adapter", "Pinocchio", "pin", "pinocchio"),
}


def engines() -> dict[str, Registration]:
    """All registered engines: ours, then those of installed third parties."""
    third_party = {
        e.name: Registration(e.value, install=f"reinstall {e.dist.name if e.dist else e.value}")
        for e in entry_points(group=ENTRY_POINT_GROUP)
    }
    return ENGINES | third_party


def find_engine(name: str) -> Registration:
    """Registration of the engine called `name`.

    Raises
    ------
    UnknownEngineError
        If there is none; the message names the nearest and all there are.
    """
    known = engines()
    if name not in known:
        raise UnknownEngineError(f"{name}: no such engine{nearest(name, known)}; there are: {', '.join(known)}")
    return known[name]
