"""The ladder: scenes from one free bar to each effect alone, in stages that presuppose each other."""

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
class Stage:
    """Scenes that presuppose those of the stages before."""

    name: str
    scenes: tuple[str, ...]


STAGES = (
    Stage("without forces", ("rungs/one_bar_free", "rungs/two_bars_free", "rungs/three_bars_free")),
    Stage("in gravity", (
        "rungs/one_bar_point", "rungs/one_bar_gradient", "rungs/three_bars_point", "rungs/three_bars_gradient",
        "rungs/eccentric", "rungs/bar_angles",
    )),
    Stage("with one effect", (
        "rungs/slender", "rungs/quadrupole", "rungs/oblateness", "rungs/third_body", "rungs/drag",
        "rungs/solar_pressure", "rungs/solar_shadow", "rungs/joint_springs", "rungs/thrust_body",
        "rungs/thrust_inertial", "rungs/impulse", "rungs/prescribed_orbital", "rungs/prescribed_inertial",
    )),
)  # fmt: skip
FIRST = ("rungs/two_bars_free", "rungs/three_bars_gradient", "rungs/one_bar_free", "rungs/one_bar_point")
"""Scenes of the conventions: the first that the engine supports"""
REPEATED = ("rungs/three_bars_gradient", "rungs/three_bars_point", "rungs/three_bars_free", "rungs/one_bar_point")
"""Scenes of accuracy and behaviour: the first that the engine supports"""


PARTICLE = ("rungs/one_bar_point", "rungs/one_bar_free")
"""The same for an engine without attitude: on one bar in point gravity it has no difference of model"""


@cache
def rung(name: str) -> Scene:
    """Scene of a rung."""
    return closely_sampled(load_scene(name))


@cache
def solved(name: str) -> ReferenceSolution:
    """Certified solution of a rung.

    Raises
    ------
    FileNotFoundError
        If barchain comes without the solution.
    """
    found = shipped_solution(rung(name))
    if found is None:
        raise FileNotFoundError(f"{name}: this installation lacks the certified solution; install barchain again")
    return found
