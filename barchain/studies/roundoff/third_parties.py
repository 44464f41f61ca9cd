"""Third parties' reactions of one state as formulations: trees of bars whose root is near, or as far as the orbit.

Both libraries carry linear and angular motion in one six-vector, and what they do with it holds more than the reactions
need: a torque v x (m v), which is zero. With a root that moves at the orbital speed v = n r its rounding is u m n² r²,
over a bar u m n² r²/l: against m n² l it is u/ratio², one power more than any place costs. That it is the speed's doing
is shown by a third way, where places count from the body's centre but velocities from the centre of mass: u/ratio.

All of that is the formula's. Rounding the input costs them nothing in any frame: joint angles keep the chain's shape,
and a root that is off by a rounding shifts all bars alike.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from adapters.bar_loads.chain_loads import ChainLoads
from adapters.bar_loads.gravity import AbsoluteLoads, Loads, MovingLoads
from adapters.mujoco.chain import AppliedLoads, data_at, installed, model_of, reactions
from adapters.pinocchio.adapter import PinocchioChain
from adapters.registry import ENGINES
from barchain.studies.roundoff.formulations import Formulation, Given, circular_m_s
from reference_impl.precision.arithmetic import EXACT, FLOAT64, Arithmetic, Values
from reference_impl.precision.chain import AbsoluteState, ChainParameters, bar_centres, directions
from scenarios import Scene, load_scene

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array
    from barchain.studies.roundoff.formulations import Exact

TEMPLATE = "paper/fig15"  # a scene of the paper's gravity; chain and body are exchanged
MOVING, INERTIAL, PLACES = "moving frame", "inertial", "inertial places"
FALLS = {MOVING: 0.0, INERTIAL: -2.0, PLACES: -1.0}
"""Exponent of the size ratio in the error of each"""


@dataclass(frozen=True)
class Folded:
    """A chain as a tree: one bar's end, and each bar's angle against the one before."""

    com_m: Values
    """(2, B) origin of the frame; zero where ends count from the body's centre"""
    end_m: Values
    """(2, B) left end of bar 1 in the frame"""
    end_m_s: Values
    """(2, B)"""
    joint_rad: Values
    """(N, B) angle of bar 1, then at each joint"""
    joint_rad_s: Values
    """(N, B)"""

    def unfolded(self, bars: ChainParameters) -> AbsoluteState:
        """Bars from the body's centre, in exact numbers."""
        angle, rate = np.cumsum(self.joint_rad, axis=0), np.cumsum(self.joint_rad_s, axis=0)
        reach = bars.half_m * directions(EXACT, angle)[0]
        end = (self.com_m + self.end_m)[:, None]
        return AbsoluteState(end + 2.0 * np.cumsum(reach, axis=1) - reach, angle, rate)

    def coordinates(self, member: int) -> tuple[Array, Array]:
        """Coordinates and rates of one member, each (N + 2,)."""
        q, q_t = (self.end_m, self.joint_rad), (self.end_m_s, self.joint_rad_s)
        return np.concatenate([v[:, member] for v in q]), np.concatenate([v[:, member] for v in q_t])


@dataclass(frozen=True)
class ThirdParty(Formulation):
    """A library's tree in one frame."""

    engine: str = ""
    """Registered name, by which it is known whether the library is there"""
    frame: str = MOVING
    """Root at the centre of mass, in orbit, or as far as the orbit and at rest"""


def folded(exact: Exact, frame: str) -> Given:
    """Tree of a state."""
    bars, s = exact.bars, exact.state
    along, across = directions(EXACT, s.angle_rad)
    end = s.position_m[:, 0] - bars.half_m[0] * along[:, 0]
    moved = bar_centres(bars, bars.half_m * s.rate_rad_s * across)[:, 0]
    motion = moved - bars.half_m[0] * s.rate_rad_s[0] * across[:, 0]
    com = s.com_m
    if frame != MOVING:
        end, com = com + end, 0 * com
    if frame == INERTIAL:
        motion = motion + circular_m_s(exact)
    return Given(bars, Folded(com, end, motion, to_joint_coordinates(s.angle_rad), to_joint_coordinates(s.rate_rad_s)))


def loads_in(frame: str, scene: Scene) -> Loads:
    """Gravity in a frame."""
    return (MovingLoads if frame == MOVING else AbsoluteLoads)(scene, surface=False)


def pinocchio_reaction_N(frame: str, given: Given, member: int) -> Array:
    """Force on each bar from the next, (N-1, 2), N: articulated bodies forwards, then inverse dynamics."""
    scene = scene_of(given.bars, member)
    chain, com = PinocchioChain(scene, loads_in(frame, scene)), given.state.com_m[:, member]
    return chain.reactions(np.concatenate([com, 0.0 * com, *given.state.coordinates(member)]))


def mujoco_reaction_N(frame: str, given: Given, member: int) -> Array:
    """Force on each bar from the next, (N-1, 2), N: inner forces at the accelerations that MuJoCo finds."""
    scene = scene_of(given.bars, member)
    model = model_of(scene.chain, 1.0)
    data = data_at(model, *given.state.coordinates(member))
    com = given.state.com_m[:, member]
    loads, track = ChainLoads(scene, loads_in(frame, scene), falling=True), np.concatenate([com, 0.0 * com])[None]
    with installed(AppliedLoads(scene.chain, data, loads, track, 1.0)):
        return reactions(model, data)


def third_party(engine: str, frame: str, reaction_N: Callable[[str, Given, int], Array]) -> ThirdParty:
    """Formulation of a library in a frame, one member after the other."""

    def of_all(a: Arithmetic, given: Given) -> Values:
        assert a is FLOAT64
        members = range(given.state.com_m.shape[-1])
        return np.stack([reaction_N(frame, given, member).T for member in members], axis=-1)

    return ThirdParty(
        f"{engine} ({frame})", lambda exact, _: folded(exact, frame), of_all,
        lambda given: given.state.unfolded(given.bars), engine, frame,
    )  # fmt: skip


THIRD_PARTIES = {
    f.name: f
    for f in (
        third_party(engine, frame, reaction_N)
        for engine, reaction_N in (("pinocchio", pinocchio_reaction_N), ("mujoco", mujoco_reaction_N))
        for frame in (MOVING, INERTIAL, PLACES)
    )
}


def present() -> tuple[str, ...]:
    """Names of those whose library is installed."""
    return tuple(name for name, f in THIRD_PARTIES.items() if ENGINES[f.engine].missing is None)


def to_joint_coordinates(angle: Values) -> Values:
    """First of angles or rates (N, B), then their differences."""
    return np.concatenate([angle[:1], angle[1:] - angle[:-1]])


@cache
def template() -> Scene:
    """A scene to be filled."""
    return load_scene(TEMPLATE)


def scene_of(bars: ChainParameters, member: int) -> Scene:
    """Scene of one member's chain."""
    mass, length, inertia = (tuple(map(float, v[:, member])) for v in (bars.mass_kg, bars.length_m, bars.inertia_kg_m2))
    none, scene = (0.0,) * len(mass), template()
    chain = dataclasses.replace(
        scene.chain, mass_kg=mass, length_m=length, inertia_kg_m2=inertia, angle_rad=none, rate_factor=none
    )
    body = dataclasses.replace(scene.central_body, mu_m3_s2=float(bars.mu_m3_s2[member]))
    return dataclasses.replace(scene, chain=chain, central_body=body)
