"""Scenes from one free bar to each effect alone, in stages that presuppose each other."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from barchain.solutions.sampling import closely_sampled
from barchain.solutions.shipped import shipped_solution
from scenarios import load_scene

if TYPE_CHECKING:
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene


@dataclass(frozen=True)
class SceneStage:
    """Scenes that presuppose those of the stages before."""

    name: str
    scenes: tuple[str, ...]


STAGES = (
    SceneStage("without forces", ("conform/one_bar_free", "conform/two_bars_free", "conform/three_bars_free")),
    SceneStage(
        "in gravity",
        (
            "conform/one_bar_point",
            "conform/one_bar_gradient",
            "conform/three_bars_point",
            "conform/three_bars_gradient",
            "conform/eccentric",
            "conform/bar_angles",
            "conform/one_bar_eccentric",
        ),
    ),
    SceneStage(
        "with one effect",
        (
            "conform/slender_alone",
            "conform/quadrupole_alone",
            "conform/oblateness_alone",
            "conform/third_body_alone",
            "conform/drag_alone",
            "conform/solar_pressure_alone",
            "conform/solar_shadow_alone",
            "conform/joint_springs_alone",
            "conform/thrust_body",
            "conform/thrust_inertial",
            "conform/impulse_alone",
            "conform/prescribed_orbital",
            "conform/prescribed_inertial",
            "conform/prescribed_orbital_joint",
            "conform/prescribed_inertial_external",
        ),
    ),
)
FIRST = ("conform/two_bars_free", "conform/three_bars_gradient", "conform/one_bar_free", "conform/one_bar_point")
"""Scenes of the conventions: the first that the engine supports"""
REPEATED = (
    "conform/three_bars_gradient",
    "conform/three_bars_point",
    "conform/three_bars_free",
    "conform/one_bar_point",
)
"""Scenes of accuracy and behaviour: the first that the engine supports"""


PARTICLE = ("conform/one_bar_point", "conform/one_bar_free")
"""The same for an engine without attitude: on one bar in point gravity it has no difference of model"""


@cache
def scene_of(name: str) -> Scene:
    """Scene of a name, at the samples of a comparison."""
    return closely_sampled(load_scene(name))


@cache
def solved(name: str) -> ReferenceSolution:
    """Certified solution of a scene.

    Raises
    ------
    FileNotFoundError
        If barchain comes without the solution.
    """
    found = shipped_solution(scene_of(name))
    if found is None:
        raise FileNotFoundError(f"{name}: this installation lacks the certified solution; install barchain again")
    return found
