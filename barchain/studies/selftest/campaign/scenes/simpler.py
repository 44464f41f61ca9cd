"""Simpler forms of a scene: fewer effects, bars and samples, a shorter run, rounder numbers."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenarios import Gravity, SceneError, parse_scene
from scenarios.toml.writing import TABLES, scene_data, toml

if TYPE_CHECKING:
    from scenarios import Scene
    from scenarios.scene import Array

    Data = dict[str, Any]

EXACT = 17
"""Digits of a number that is left as it is"""
BAR_LISTS = {"drag": ("width_m",), "solar_pressure": ("width_m",)}
JOINT_LISTS = ("stiffness_N_m_rad", "damping_N_m_s_rad", "rest_deg")
INSTANTS = {"at_s", "start_s", "times_s", "duration_s"}


@dataclass(frozen=True)
class Form:
    """Parts of a scene that are kept."""

    effects: tuple[bool, ...]
    """For each of :func:`effects_of`, whether it is kept"""
    bars: int
    samples: int
    share: float
    """Of the run's duration; what is timed in it keeps its place"""
    digits: int
    """Significant digits of all numbers"""

    @property
    def complexity(self) -> tuple[float, ...]:
        """Less of it is simpler, the first number first."""
        return (sum(self.effects), self.bars, self.samples, self.share, self.digits)


def effects_of(scene: Scene) -> list[tuple[str, int]]:
    """Effects that may be dropped one by one: names, and which of several."""
    called = {name: value for name, value in vars(scene.effects).items() if name != "gravity" and value}
    return [(name, k) for name, value in called.items() for k in range(len(value) if name in TABLES else 1)]


def whole(scene: Scene) -> Form:
    """Form that keeps everything."""
    return Form((True,) * len(effects_of(scene)), scene.bars, scene.run.samples, 1.0, EXACT)


def simplified(scene: Scene, form: Form) -> Scene | None:
    """Scene in a simpler form; None where that is no valid one."""
    data = copy.deepcopy(scene_data(scene))
    drop_effects(data, scene, form)
    drop_bars(data, form.bars)
    on_grid = form.samples == scene.run.samples and form.share == 1.0 and form.digits == EXACT
    if form.digits < EXACT:
        data = rounded(data, form.digits)
    retime(data, scene, form, on_grid=on_grid)
    if scene.effects.gravity is Gravity.SLENDER:  # a moment of inertia of its own, whatever the rounding
        del data["chain"]["inertia_kg_m2"]
    try:
        return parse_scene("\n".join(toml(data)), name=scene.name, file=scene.name)
    except SceneError:
        return None


def drop_effects(data: Data, scene: Scene, form: Form) -> None:
    """Leave out effects."""
    effects = data["effects"]
    dropped = {pair for pair, kept in zip(effects_of(scene), form.effects, strict=True) if not kept}
    for name in {name for name, _ in dropped}:
        if name in TABLES:
            effects[name] = [one for k, one in enumerate(effects[name]) if (name, k) not in dropped]
        if name not in TABLES or not effects[name]:
            del effects[name]


def drop_bars(data: Data, bars: int) -> None:
    """Keep the first bars; what pushes a bar that is gone pushes the last one, what turns it is gone too."""
    chain, effects = data["chain"], data["effects"]
    chain["bars"] = bars
    for name, value in chain.items():
        if isinstance(value, list):
            chain[name] = value[:bars]
    for name, keys in BAR_LISTS.items():
        for key in keys if name in effects else ():
            effects[name][key] = effects[name][key][:bars]
    if "joint_spring_damper" in effects:
        springs = effects.pop("joint_spring_damper")
        if bars > 1:
            effects["joint_spring_damper"] = {key: springs[key][: bars - 1] for key in JOINT_LISTS}
    for name in ("thrust", "impulse"):
        for one in effects.get(name, ()):
            one["bar"] = min(one["bar"], bars)
    kept = [one for one in effects.pop("prescribed_rotation", ()) if one["bar"] <= bars]
    if kept:
        effects["prescribed_rotation"] = kept


def rounded(value: Any, digits: int) -> Any:
    """Value whose floats have so many significant digits; instants stay for now."""
    if isinstance(value, dict):
        return {key: one if key in INSTANTS else rounded(one, digits) for key, one in value.items()}
    if isinstance(value, list):
        return [rounded(one, digits) for one in value]
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value


def retime(data: Data, scene: Scene, form: Form, *, on_grid: bool) -> None:
    """Give the run its duration and samples, and put what is timed on the samples next to it."""
    if on_grid:
        return
    duration = rounded(form.share * scene.run.duration_s, form.digits)
    data["run"] = {"duration_s": duration, "samples": form.samples}
    factor, times = duration / scene.run.duration_s, np.linspace(0.0, duration, form.samples)
    for law in data["effects"].get("prescribed_rotation", ()):
        law["start_s"] = nearest(law["start_s"] * factor, times)
        law["duration_s"] = rounded(law["duration_s"] * factor, form.digits)
    for thrust in data["effects"].get("thrust", ()):
        thrust["times_s"] = [nearest(t * factor, times) for t in thrust["times_s"]]
    for impulse in data["effects"].get("impulse", ()):
        impulse["at_s"] = nearest(impulse["at_s"] * factor, times[1:-1])


def nearest(t_s: float, times: Array) -> float:
    """Sample next to an instant; without samples not a number, which no file may hold."""
    return float(times[np.abs(times - t_s).argmin()]) if len(times) else math.nan
