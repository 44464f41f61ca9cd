"""Libraries behind the engines: one page each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.command.entries import unpacked
from adapters.registry import built_in

if TYPE_CHECKING:
    from adapters.registry import Registration


@dataclass(frozen=True)
class EngineLibrary:
    """Library with one or more engines."""

    page: str
    title: str
    package: str
    """Adapter package whose docstring describes the engines"""
    distributions: tuple[str, ...]
    """Distributions that the registrations require; empty for barchain itself, and for a program"""
    home: str
    licence: str

    @property
    def engines(self) -> dict[str, Registration]:
        """Registered engines of the library, by name."""
        return {name: r for name, r in built_in().items() if self.has(r)}

    def has(self, registration: Registration) -> bool:
        """Whether a registration is one of this library's."""
        if registration.entry:
            return unpacked(registration.entry)[0].name == self.package.rpartition(".")[2]
        inside = registration.target.startswith(f"{self.package}.")
        return inside and (not self.distributions or registration.requires in self.distributions)


LIBRARIES = (
    EngineLibrary("reference", "barchain's own engines", "adapters.reference", (), "", "MIT"),
    EngineLibrary("exudyn", "Exudyn", "adapters.exudyn", ("exudyn",), "https://github.com/jgerstmayr/EXUDYN",
                  "EXUDYN General License"),
    EngineLibrary("rebound", "REBOUND", "adapters.rebound", ("rebound",), "https://github.com/hannorein/rebound",
                  "GPL-3.0"),
    EngineLibrary("pymunk", "pymunk", "adapters.pymunk", ("pymunk",), "https://www.pymunk.org", "MIT"),
    EngineLibrary("heyoka", "heyoka", "adapters.heyoka", ("heyoka",), "https://bluescarni.github.io/heyoka.py",
                  "MPL-2.0"),
    EngineLibrary("mujoco", "MuJoCo", "adapters.mujoco", ("mujoco",), "https://mujoco.org", "Apache-2.0"),
    EngineLibrary("pinocchio", "Pinocchio", "adapters.pinocchio", ("pin",), "https://github.com/stack-of-tasks/pinocchio",
                  "BSD-2-Clause; the metadata of its wheel says BSD-3-Clause"),
    EngineLibrary("drake", "Drake", "adapters.drake", ("drake",), "https://drake.mit.edu",
                  "BSD-3-Clause; its wheel requires Mosek's, which is proprietary"),
    EngineLibrary("dart", "DART", "adapters.dart", ("dartpy",), "https://dartsim.github.io", "BSD-2-Clause"),
    EngineLibrary("basilisk", "Basilisk", "adapters.basilisk", (), "https://avslab.github.io/basilisk", "ISC"),
    EngineLibrary("jaxsim", "JaxSim", "adapters.jaxsim", (), "https://jaxsim.readthedocs.io", "BSD-3-Clause"),
    EngineLibrary("scipy", "SciPy's solvers", "adapters.ode_solvers", ("scipy",), "https://scipy.org", "BSD-3-Clause"),
    EngineLibrary("ida", "IDA (SUNDIALS)", "adapters.ida", ("scikit-sundae",),
                  "https://github.com/NREL/scikit-sundae", "BSD-3-Clause"),
    EngineLibrary("cvode", "CVODE (SUNDIALS)", "adapters.ode_solvers", ("scikit-sundae",),
                  "https://github.com/NREL/scikit-sundae", "BSD-3-Clause"),
)  # fmt: skip
"""Libraries in the order of their pages; licences as their distributions declare them"""


def library_of(engine: str) -> EngineLibrary:
    """Library of a registered engine.

    Raises
    ------
    LookupError
        If the engine has no page; add its library to :data:`LIBRARIES`.
    """
    found = next((library for library in LIBRARIES if engine in library.engines), None)
    if found is None:
        raise LookupError(f"{engine}: no library in pictures/pages/libraries.py has this engine; add one")
    return found
