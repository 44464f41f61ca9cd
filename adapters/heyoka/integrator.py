"""Compiled integrator with its events: the surface, and changes of discrete modes."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from adapters.heyoka.compiled import KEPT, Precision, bound_memory, symbols
from adapters.heyoka.discrete_modes import mode_events

if TYPE_CHECKING:
    from adapters.heyoka.structure import Structure


@lru_cache(maxsize=KEPT)
def integrator(structure: Structure, precision: Precision, rtol: float) -> Any:
    """Integrator of a structure, without parameters and state; only one run at a time may use it."""
    import heyoka as hy

    bound_memory()
    found, number = symbols(structure), precision.number
    watched = events(structure, precision)
    return hy.taylor_adaptive(
        list(zip(found.variables, found.rates, strict=True)),
        tol=number(rtol),
        fp_type=precision.type,
        compact_mode=True,
        **({"t_events": watched} if watched else {}),
    )


def events(structure: Structure, precision: Precision) -> list[Any]:
    """Events that stop a run: those of the surface (`Structure.surfaces` of them), then those that change a mode."""
    found = surface_events(structure, precision) if structure.lands else []
    if structure.effects.modes:
        found += mode_events(structure, precision)
    return found


def surface_events(structure: Structure, precision: Precision) -> list[Any]:
    """Events at the surface: an end of a bar, or the bar's line where its foot is on the bar."""
    import heyoka as hy

    found = symbols(structure)
    falling = hy.event_direction.negative
    ends = [hy.t_event(e, direction=falling, fp_type=precision.type) for e in found.ends]
    lines = [
        hy.t_event(e, direction=falling, fp_type=precision.type, callback=BeyondBarEnds(structure, precision, j))
        for j, e in enumerate(found.middles)
    ]
    return ends + lines


class BeyondBarEnds:
    """Callback that continues the run where a bar's line, but not the bar itself, touches the surface."""

    def __init__(self, structure: Structure, precision: Precision, bar: int) -> None:
        """Store the bar; its function is compiled on first use."""
        self.structure, self.precision, self.bar = structure, precision, bar

    def __call__(self, run: Any, falling: int) -> bool:
        """Whether the nearest point of the line is beyond the bar's ends."""
        del falling
        import heyoka as hy

        found = symbols(self.structure)
        foot = hy.cfunc([found.feet[self.bar]], vars=found.variables, fp_type=self.precision.type)
        return bool(foot(run.state, pars=run.pars[: foot.nparams])[0] > 0.0)
