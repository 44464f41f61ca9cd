"""Compiled integrators and functions, shared by the runs of one process."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.heyoka.system import System, jumps, system

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.heyoka.structure import Numbers, Structure

KEPT = 8  # structures whose compiled code a process keeps; heyoka keeps the code of others on disk
MEMORY = 1 << 28  # bytes of code in heyoka's own cache, which takes 2 GB by default


@dataclass(frozen=True)
class Precision:
    """A floating-point type of heyoka."""

    name: str
    """``double``, ``long double`` or ``real128``"""

    @property
    def type(self) -> Any:
        """The type itself."""
        import heyoka as hy

        return {"double": float, "long double": np.longdouble}.get(self.name) or hy.real128

    @property
    def number(self) -> Callable[[Any], Any]:
        """Constructor of a number from a float or a decimal string, without rounding through the other type."""
        return self.type  # type: ignore[no-any-return]


DOUBLE, LONG, QUAD = Precision("double"), Precision("long double"), Precision("real128")


@lru_cache(maxsize=1)
def bound_memory() -> None:
    """Limit the memory of heyoka's own cache, once in a process."""
    import heyoka as hy

    hy.llvm_state.set_memcache_limit(MEMORY)


@lru_cache(maxsize=KEPT)
def symbols(structure: Structure) -> System:
    """Equations of a structure."""
    return system(structure)


@lru_cache(maxsize=4 * KEPT)
def function(structure: Structure, precision: Precision, what: str) -> Any:
    """Function of the state; None where it has no value.

    `what` is ``rates``, ``event_functions`` (Z0·s last), ``observables`` (reactions and torques), or the ``jumps`` of
    impulses.
    """
    import heyoka as hy

    found = symbols(structure)
    wanted = jumps(structure, found) if what == "jumps" else getattr(found, what)
    if what == "event_functions":
        wanted = [*wanted, found.sunward]
    if not wanted:
        return None
    return hy.cfunc(wanted, vars=found.variables, fp_type=precision.type, compact_mode=True)


def value(function: Any, state: Numbers, at: Any, parameters: Numbers) -> Any:
    """Value of a compiled function at one state and instant."""
    given = {"pars": parameters[: function.nparams]} if function.nparams else {}
    if function.is_time_dependent:
        given["time"] = at
    return function(state, **given)


def observe(structure: Structure, precision: Precision, states: Numbers, times: Numbers, parameters: Numbers) -> Any:
    """Observables (n, k) of states (n, size) at `times` (n,), with parameters (n, m), in the working precision."""
    observables = function(structure, precision, "observables")
    if observables is None:
        return np.zeros((len(states), 0))
    given = {"pars": np.ascontiguousarray(parameters[:, : observables.nparams].T)} if observables.nparams else {}
    if observables.is_time_dependent:
        given["time"] = np.ascontiguousarray(times)
    return observables(np.ascontiguousarray(states.T), **given).T
