"""The certified solution's equations at a scene's initial state: of a lone bar, in SI units and many digits."""

from __future__ import annotations

import dataclasses
from typing import Any

import mpmath as mp
import numpy as np

from adapters.heyoka.compiled import QUAD, Precision, function, observe, value
from adapters.heyoka.events import Modes
from adapters.heyoka.structure import parameters_of, start_of, structure_of, units_of
from scenarios import Effects, Scene, load_scene


def scene_of(effects: Effects, **chain: tuple[float, ...]) -> Scene:
    """A scene with these effects; by default one bar of 80 m, turning, on a slightly eccentric low orbit."""
    base = load_scene("paper/fig13")
    columns = {
        "mass_kg": (60.0,),
        "length_m": (80.0,),
        "angle_rad": (0.7,),
        "rate_factor": (1.3,),
    } | chain
    slender = zip(columns["mass_kg"], columns["length_m"], strict=True)
    columns.setdefault("inertia_kg_m2", tuple(m * x * x / 12.0 for m, x in slender))
    return dataclasses.replace(
        base,
        orbit=dataclasses.replace(base.orbit, longitude_rad=0.4),
        chain=dataclasses.replace(base.chain, **columns, angle_from="chain"),
        effects=effects,
        run=dataclasses.replace(base.run, duration_s=600.0, samples=7),
    )


@dataclasses.dataclass
class Start:
    """Initial state and its accelerations."""

    scene: Scene
    precision: Precision

    def __post_init__(self) -> None:
        """Fill in the numbers; modes are told from the state."""
        number = self.precision.number
        self.structure, self.units, self.zero = structure_of(self.scene), units_of(self.scene), number(0.0)
        self.parameters = parameters_of(self.scene, self.units, number)
        self.state = start_of(self.scene, self.units, number)
        Modes(self.structure, self.precision).set(self.state, self.zero, self.parameters)

    @property
    def si(self) -> list[Any]:
        """Z0 (2), Z0' (2), angles, rates as mpmath's numbers in SI units."""
        length, time, n = self.units.length_m, self.units.time_s, self.structure.bars
        scale = [length] * 2 + [length / time] * 2 + [1.0] * n + [1.0 / time] * n
        return [mp.mpf(str(x)) * s for x, s in zip(self.state, scale, strict=True)]

    @property
    def accelerations(self) -> tuple[Any, Any, list[Any]]:
        """Z0'' (2) in m/s², angular accelerations in rad/s²."""
        rates = value(function(self.structure, self.precision, "rates"), self.state, self.zero, self.parameters)
        n, units = self.structure.bars, self.units
        x, y = (mp.mpf(str(a)) * units.length_m / units.time_s**2 for a in rates[2:4])
        return x, y, [mp.mpf(str(a)) / units.time_s**2 for a in rates[4 + n :]]

    @property
    def reactions(self) -> list[Any]:
        """Components, N."""
        now = np.array([self.zero])
        seen = observe(self.structure, self.precision, self.state[None, :], now, self.parameters[None, :])[0]
        return [mp.mpf(str(x)) * self.units.force for x in seen[: 2 * (self.structure.bars - 1)]]


def start(scene: Scene, precision: Precision = QUAD) -> Start:
    """Initial state of a scene."""
    return Start(scene, precision)
