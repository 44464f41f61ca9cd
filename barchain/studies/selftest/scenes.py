"""Short scenes in which the kill matrix inserts faults: parts of shipped ones, with something of everything."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from scenarios import Scene, SceneError, load_scene, nearest, scene_names
from scenarios.scene import Run

FALL, BRIEF = "selftest/fall", "selftest/everything"
SHRUNK = 0.2  # of the times of effects/everything: a run much shorter still meets all of its events
DUSK_DEG = 58.0  # longitude from which the shadow's edge, at 67.2°, is met after some 140 s


@dataclass(frozen=True)
class Stage:
    """Part of a shipped scene."""

    name: str
    duration_s: float
    samples: int
    shows: str
    """Purpose of the scene"""

    def scene(self) -> Scene:
        """The scene, cut."""
        made = {FALL: fall, BRIEF: everything}
        whole = made[self.name]() if self.name in made else load_scene(self.name)
        return replace(whole, run=Run(self.duration_s, self.samples))


def fall() -> Scene:
    """Three bars dropped from 50 km, on the surface after some two minutes."""
    chain = load_scene("basics/point_chain")
    low = replace(chain.orbit, altitude_m=50e3, speed_factor=0.3)
    return replace(chain, name=FALL, title="Three bars that fall to the surface", orbit=low)


def everything() -> Scene:
    """All effects at once, their instants closer together, injected shortly before the shadow."""
    scene = load_scene("effects/everything")
    called, k = scene.effects, SHRUNK
    effects = called.at_instants(lambda t: k * t)
    orbit = replace(scene.orbit, longitude_rad=math.radians(DUSK_DEG))
    return replace(
        scene, name=BRIEF, title="All effects at once, in less than three minutes", orbit=orbit, effects=effects
    )


STAGES = {
    s.name: s
    for s in (
        Stage("basics/libration", 1500.0, 51, "one bar, the gravity torque alone"),
        Stage("basics/two_bars_free", 400.0, 41, "no gravity: energy and angular momentum stay"),
        Stage("paper/fig15", 900.0, 46, "the paper's chain on an ellipse"),
        Stage("paper/fig17", 80.0, 41, "a slew against the local horizontal, torque from outside"),
        Stage("effects/slews", 200.0, 41, "slews against inertial axes, a motor in a joint"),
        Stage("effects/impulse", 400.0, 41, "an impulse, bars of different length"),
        Stage(BRIEF, 160.0, 41, "all effects, exact bars, an entry into the shadow"),
        Stage(FALL, 150.0, 61, "the surface ends the run"),
    )
}


def find_scene(name: str) -> Scene:
    """Stage of a name, cut; any other scene or file as it is.

    Raises
    ------
    SceneError
        If there is none.
    """
    if name in STAGES:
        return STAGES[name].scene()
    if name.startswith("selftest/"):
        raise SceneError(f"{name}: no such scene{nearest(name, [*STAGES, *scene_names()])}")
    return load_scene(name)
