"""Compiled integrator with its events: the surface, and changes of discrete modes.

Discrete modes are constant over a segment: exposed faces of the bars, and light or shadow. An event of heyoka stops the
run where a mode changes, its callback changes the mode, and the run continues from there. heyoka's cooldown prevents a
second detection of the event at the start of the next segment.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

from adapters.heyoka.compiled import KEPT, Precision, bound_memory, function, symbols, value

if TYPE_CHECKING:
    from adapters.heyoka.structure import Numbers, Structure

MOMENT = 2.0**-10  # time units: long enough for a second derivative of order one to show in double precision


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
    if structure.modes:
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


class Modes:
    """Discrete modes of a run, determined from its state."""

    def __init__(self, structure: Structure, precision: Precision) -> None:
        """Compile the event functions."""
        self.structure, self.precision = structure, precision
        self.names = structure.modes
        self.slots = [structure.slots[name] for name in self.names]
        if self.names:
            function(structure, precision, "event_functions")

    def event_values(self, state: Numbers, at: Any, parameters: Numbers) -> Any:
        """Values of the event functions, and Z0·s last."""
        return value(function(self.structure, self.precision, "event_functions"), state, at, parameters)

    def set(self, state: Numbers, at: Any, parameters: Numbers) -> None:
        """Set the modes in `parameters` by the signs of the event functions at a state.

        Where an event function is exactly zero, the sign a moment later decides, of a motion without that mode's force.
        """
        if not self.names:
            return
        number = self.precision.number
        for slot in self.slots:
            parameters[slot] = number(0.0)
        *now, sunward = self.event_values(state, at, parameters)
        if 0.0 in now:
            step = number(MOMENT)
            later = self.event_values(self.advanced(state, at, step, parameters), at + step, parameters)
            now = [x or y for x, y in zip(now, later, strict=False)]
        for name, slot, sign in zip(self.names, self.slots, now, strict=True):
            lit = sign > 0.0 or sunward > 0.0
            parameters[slot] = number(float(lit) if name == "lit" else (1.0 if sign >= 0.0 else -1.0))

    def advanced(self, state: Numbers, at: Any, step: Any, parameters: Numbers) -> Numbers:
        """State a short step later, by the midpoint rule."""
        rates, half = function(self.structure, self.precision, "rates"), self.precision.number(0.5) * step
        middle = state + half * value(rates, state, at, parameters)
        return state + step * value(rates, middle, at + half, parameters)


class FaceReversal:
    """Callback that stops heyoka where a bar turns its other face, and sets the new face."""

    def __init__(self, slot: int, precision: Precision) -> None:
        """Store the parameter's index and precision."""
        self.slot, self.precision = slot, precision

    def __call__(self, run: Any, slope: int) -> bool:
        """Set the sign to that of the slope."""
        if slope:
            run.pars[self.slot] = self.precision.number(float(slope))
        return False


class ShadowEdge:
    """Callback that stops heyoka at an edge of the shadow, and continues on the sunward side, which has no shadow."""

    def __init__(self, structure: Structure, precision: Precision) -> None:
        """Store the event function's structure and the parameter's index."""
        self.structure, self.precision, self.slot = structure, precision, structure.slots["lit"]

    def __call__(self, run: Any, slope: int) -> bool:
        """Set light if the chain moves outwards."""
        asked = function(self.structure, self.precision, "event_functions")
        if value(asked, run.state, run.time, run.pars)[-1] >= 0.0:
            return True
        run.pars[self.slot] = self.precision.number(1.0 if slope > 0 else 0.0)
        return False


def mode_events(structure: Structure, precision: Precision) -> list[Any]:
    """Events that stop a run where a mode changes, in the order of the modes."""
    import heyoka as hy

    found = []
    for name, passes in zip(structure.modes, symbols(structure).event_functions, strict=True):
        told = ShadowEdge(structure, precision) if name == "lit" else FaceReversal(structure.slots[name], precision)
        found.append(hy.t_event(passes, fp_type=precision.type, callback=told))
    return found
