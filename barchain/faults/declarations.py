"""Wrong declarations of an engine's class: its noise, its order, its coordinates."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from adapters.engine import AccuracyParameter, Coordinates
from barchain.faults.equations import HEAVIER
from barchain.faults.fault import Fault, FaultGroup
from barchain.faults.readings import largest

if TYPE_CHECKING:
    from adapters.engine import Engine, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.faults.fault import Foreign
    from scenarios import Scene

NOISE_RAD = 1.0


def noisy(engine: type[Engine], main: Trajectory) -> dict[str, Any]:
    """A noise of one radian, and of the largest reaction."""
    del engine
    declared: dict[str, float | Array] = {"attitude": NOISE_RAD}
    if main.reaction_N is not None:
        declared["reaction"] = largest(main.reaction_N)

    def noise(cls: type[Engine], scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        del cls, scene, setting, t_s
        return declared

    return {"noise": classmethod(noise)}


def declares(name: str, value: object) -> dict[str, Any]:
    """Arguments of a fault that declares one attribute wrongly; it can't be inserted where the value is right."""

    def wrong(engine: type[Engine], main: Trajectory) -> dict[str, Any]:
        del engine, main
        return {name: value}

    def foreign(engine: type[Engine]) -> str:
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
