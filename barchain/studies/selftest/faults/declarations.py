"""Wrong declarations of an engine: its noise, its order, its coordinates."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from adapters.engine import AccuracyParameter, Coordinates, StatedAnswers
from barchain.studies.selftest.faults.equations import HEAVIER
from barchain.studies.selftest.faults.fault import Fault, FaultGroup
from barchain.studies.selftest.faults.samples import largest

if TYPE_CHECKING:
    from adapters.engine import Declarations
    from adapters.trajectory import Array, Trajectory
    from barchain.studies.selftest.faults.fault import Foreign

NOISE_RAD = 1.0


def noisy(engine: Declarations, main: Trajectory) -> Declarations:
    """A noise of one radian, and of the largest reaction."""
    errors: dict[str, float | Array] = {"attitude": NOISE_RAD}
    if main.reaction_N is not None:
        errors["reaction"] = largest(main.reaction_N)
    return replace(engine, questions=("noise",), answers=StatedAnswers(errors))


def declares(name: str, value: object) -> dict[str, Any]:
    """Arguments of a fault that declares one thing wrongly; it can't be inserted where the value is right."""

    def wrong(engine: Declarations, main: Trajectory) -> Declarations:
        del main
        changed: dict[str, Any] = {name: value}
        return replace(engine, **changed)

    def foreign(engine: Declarations) -> str:
        return f"it declares {name} = {value} rightly" if getattr(engine, name) == value else ""

    return {"declares": wrong, "foreign": foreign}


def equal_steps_only(foreign: Foreign) -> Foreign:
    """Engines of equal steps, and not all of them."""
    return lambda engine: (
        "it chooses its steps" if engine.sweep.parameter is AccuracyParameter.RTOL else foreign(engine)
    )


FIRST = declares("order", 1.0)
DECLARED = FaultGroup.DECLARED
FAULTS = (
    Fault("declares-noise", "declares a noise of a radian and of its largest reaction", "a bound of no use", DECLARED,
          declares=noisy),
    replace(HEAVIER, name="declares-noise-mass", group=DECLARED, declares=noisy,
            words="the last bar too heavy; declares a noise of a radian and of its largest reaction"),
    Fault("declares-order", "declares order 1", "a table of methods read wrongly", DECLARED, declares=FIRST["declares"],
          foreign=equal_steps_only(FIRST["foreign"])),
    Fault("declares-absolute", "declares absolute coordinates", "a copied declaration", DECLARED,
          **declares("coordinates", Coordinates.ABSOLUTE)),
    Fault("declares-track", "declares that its track is not held by length", "a copied declaration", DECLARED,
          **declares("track_by_length", False)),
)  # fmt: skip
