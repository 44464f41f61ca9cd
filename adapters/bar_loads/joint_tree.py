"""Engines whose library gives the accelerations of a tree of joints: barchain adds loads, frame, events and samples.

The frame's origin is integrated with the chain and falls as a particle, so that the loads on bars are differences only.
State (4 + 2 (N + 2),): the origin and its velocity, the joint coordinates and their rates.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from itertools import accumulate
from math import cos, sin
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from adapters.bar_loads.chain_loads import SUPPORTED, ChainLoads
from adapters.bar_loads.falling_frame import fall_rate
from adapters.bar_loads.forces import impulse_jumps
from adapters.bar_loads.gravity import MovingLoads
from adapters.bar_loads.interface import FrameState, bars_of
from adapters.common.accuracy_scales import accuracy_scales
from adapters.common.initial_state import initial_state
from adapters.common.joint_coordinates import (
    angles,
    from_joint_coordinates,
    positions,
    reaction_from_wrench,
    to_joint_coordinates,
)
from adapters.common.landing import landing_text, least_height_m
from adapters.common.solver_driver import RTOL_FLOOR, Problem, ScipySolver, drive
from adapters.engine import (
    PRESCRIBED_ROTATIONS,
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Engine,
    EngineError,
    Setting,
)
from adapters.trajectory import Observable, Trajectory
from reference_impl.integrate.stepper import TIME_EVENT_TOLERANCE, smooth_segments
from reference_impl.model.effect import EDGE_ON
from scenarios.effect_types import COM_SHARE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from adapters.bar_loads.gravity import Loads
    from adapters.bar_loads.interface import BarPosition, BarProperties, BarRate, Load
    from adapters.common.solver_driver import Solver
    from adapters.trajectory import Array
    from scenarios import Impulse, Scene

NO_SHADOW = (
    "solar_pressure.shadow is not supported: the solver restarts at instants known beforehand, "
    "and the shadow's edges depend on the motion"
)
TOGETHER = 1e-9
"""Sines up to which bars turn at one instant, as those of a straight chain: turned so much early, a force is wrong by
a part in 1e9 for a moment"""


def tree_positions(q: Sequence[float], bars: Sequence[BarProperties]) -> Iterator[BarPosition]:
    """Each bar's position in the frame from joint coordinates (N + 2), in plain floats."""
    x, y = q[:2]
    for angle, bar in zip(accumulate(q[2:]), bars, strict=True):
        c, s, length = cos(angle), sin(angle), 2.0 * bar.half_length_m
        yield x + bar.left_m * c, y + bar.left_m * s, angle
        x, y = x + length * c, y + length * s


def tree_rates(q: Sequence[float], q_t: Sequence[float], bars: Sequence[BarProperties]) -> Iterator[BarRate]:
    """Each bar's rates in the frame from joint coordinates and their rates, each (N + 2), in plain floats."""
    vx, vy = q_t[:2]
    for angle, rate, bar in zip(accumulate(q[2:]), accumulate(q_t[2:]), bars, strict=True):
        c, s, left, length = cos(angle), sin(angle), bar.left_m * rate, 2.0 * bar.half_length_m * rate
        yield vx - left * s, vy + left * c, rate
        vx, vy = vx - length * s, vy + length * c


class JointTree(ABC):
    """Accelerations and reactions of a state, by a library's model of the chain."""

    def __init__(self, scene: Scene, loads: Loads | None = None) -> None:
        """Prepare the loads; `loads` of another frame put the joint coordinates into that frame."""
        self.width = scene.bars + 2
        self.length_m, self.left_m = np.array(scene.chain.length_m), np.array(scene.chain.left_m)
        self.radius_m = scene.central_body.radius_m
        self.loads = ChainLoads(scene, loads or MovingLoads(scene, surface=False), falling=True)
        self.fall_rate = fall_rate(scene)
        self.bars = bars_of(scene.chain)
        self.inside_s = 0.0  # an instant within the current segment between events

    @abstractmethod
    def put(self, angle: Sequence[float], loads: Sequence[Load]) -> None:
        """Set the forces and torques on all bars at `angle` (N,) rad, for the calls that follow."""

    @abstractmethod
    def forward(self, q: Array, q_t: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,), at the forces last set."""

    @abstractmethod
    def transmitted(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force of each bar on the next along and across the next, (N-1, 2), N; called just after `forward`.

        `q` and `q_t` are the arguments of that call and `q_tt` its result.
        """

    def split(self, state: Array) -> tuple[Array, Array, Array]:
        """Origin with its velocity (4,), coordinates and their rates, (N + 2,) each."""
        return state[:4], state[4 : 4 + self.width], state[4 + self.width :]

    def rate(self, t_s: float, state: Array) -> Array:
        """Time derivative of a state."""
        return np.concatenate([self.fall_rate(t_s, state[:4]), state[4 + self.width :], self.accelerations(t_s, state)])

    def accelerations(self, t_s: float, state: Array) -> Array:
        """Second derivatives of the joint coordinates, (N + 2,), under all loads of the scene."""
        _, q, q_t = self.split(state)
        if self.loads.act:
            frame, positions, rates = self.placed(t_s, state)
            self.put([angle for *_, angle in positions], self.loads(frame, positions, rates))
        return self.forward(q, q_t)

    def placed(self, t_s: float, state: Array) -> tuple[FrameState, list[BarPosition], list[BarRate]]:
        """Frame, and places and rates of the bars, as loads take them; no rates where no load depends on them."""
        (x, y, vx, vy), q, q_t = (part.tolist() for part in self.split(state))
        rates = list(tree_rates(q, q_t, self.bars)) if self.loads.of_rates else []
        return FrameState(x, y, vx, vy, t_s, self.inside_s), list(tree_positions(q, self.bars)), rates

    def incidences(self, t_s: float, state: Array) -> list[list[float]]:
        """Sines of the angles between bars and the wind or the Sun, a list for each effect that depends on faces."""
        placed = self.placed(t_s, state) if self.loads.faced else ()
        return [effect.incidence(*placed) for effect in self.loads.faced]

    def hold_faces(self, faces: Iterable[list[float] | None]) -> None:
        """Faces, +1 or -1, of each effect that depends on them; None: those of each state."""
        for effect, held in zip(self.loads.faced, faces, strict=True):
            effect.held = held

    def reactions(self, state: Array, t_s: float = 0.0) -> Array:
        """Force on each bar from the next, (N-1, 2), N, at the state's accelerations."""
        found = self.accelerations(t_s, state)
        return self.joint_forces(*self.split(state)[1:], found)

    def joint_forces(self, q: Array, q_t: Array, q_tt: Array) -> Array:
        """Force on each bar from the next, (N-1, 2), N, just after `forward`."""
        force = self.transmitted(q, q_t, q_tt)
        return reaction_from_wrench(force, on_next_bar=True, axes_rad=angles(q[None])[0, 1:])

    def apply_impulses(self, state: Array, impulses: Sequence[Impulse]) -> tuple[Array, Array]:
        """State after impulses, and the impulsive reactions on each bar from the next, (N-1, 2), N s.

        With all rates zero, the same joint system gives jumps by impulses as accelerations by forces.
        """
        q, rest = state[4 : 4 + self.width], np.zeros(self.width)
        angle = list(accumulate(q[2:].tolist()))
        self.put(angle, impulse_jumps(self.bars, impulses, angle))
        jump = self.forward(q, rest)
        after = state.copy()
        after[4 + self.width :] += jump
        found = self.joint_forces(q, rest, jump)
        self.put(angle, [(0.0, 0.0, 0.0)] * len(self.bars))  # without a new load the impulse would act as a force
        return after, found

    def height(self, state: Array) -> float:
        """Least distance of any point of any bar from the surface, m."""
        q = state[None, 4 : 4 + self.width]
        place = state[:2] + positions(self.length_m, q, self.left_m)[0]
        return least_height_m(self.radius_m, self.length_m, place, angles(q)[0], self.left_m)


class HeldFaces:
    """Faces that bars turn to the wind and the Sun, held until one turns: the solver stops there."""

    def __init__(self, chain: JointTree) -> None:
        """Hold none yet."""
        self.chain = chain
        self.faces: list[list[float]] = []

    def hold(self, t_s: float, y: Array) -> None:
        """Hold the faces of a state."""
        self.faces = [[math.copysign(1.0, x) for x in found] for found in self.chain.incidences(t_s, y)]
        self.chain.hold_faces(self.faces)

    def release(self) -> None:
        """Take the faces of each state from here on."""
        self.chain.hold_faces([None] * len(self.faces))

    def sines(self, t_s: float, y: Array) -> list[list[float]]:
        """Sines of the angles to the source, positive where the held face is right."""
        found = self.chain.incidences(t_s, y)
        return [[f * x for f, x in zip(*both, strict=True)] for both in zip(self.faces, found, strict=True)]

    def margin(self, t_s: float, y: Array) -> float:
        """Least of the sines, positive while the faces are right; a bar that stays edge-on turns none."""
        return min(min(each) for each in self.sines(t_s, y)) + EDGE_ON

    def change(self, t_s: float, y: Array) -> None:
        """Turn the bars whose sines vanish at this instant."""
        sines = self.sines(t_s, y)
        least = min(map(min, sines)) + TOGETHER
        self.faces = [
            [-f if x <= least else f for f, x in zip(*both, strict=True)]
            for both in zip(self.faces, sines, strict=True)
        ]
        self.chain.hold_faces(self.faces)


class StruckChain(Protocol):
    """A chain that impulses strike, and whose loads know the segment between two events."""

    inside_s: float
    """An instant within the current segment"""

    def apply_impulses(self, state: Array, impulses: Sequence[Impulse]) -> tuple[Array, Array]:
        """State after impulses, and the impulsive reactions on each bar from the next, (N-1, 2), N s."""


class Jumps:
    """State changes at the events of a run: starts and ends of thrusts, impulses, and faces that turn."""

    def __init__(self, scene: Scene, chain: StruckChain) -> None:
        """Events of `scene`."""
        self.chain, self.scheduled = chain, scene.effects.impulse
        self.faces: HeldFaces | None = None
        self.slack_s = TIME_EVENT_TOLERANCE * scene.run.duration_s
        self.segments = smooth_segments(scene.times_s, scene.effects.breaks_s)
        self.sums: list[tuple[float, Array]] = [(-np.inf, np.zeros((scene.bars - 1, 2)))]

    def begin_segment(self, start_s: float, end_s: float, y: Array) -> Array:
        """State from which the next segment starts."""
        self.chain.inside_s = 0.5 * (start_s + end_s)
        applied = [impulse for impulse in self.scheduled if abs(impulse.at_s - start_s) <= self.slack_s]
        begun = self.apply_impulses(start_s, applied, y) if applied and start_s > 0.0 else y
        if self.faces:
            self.faces.hold(start_s, begun)
        return begun

    def begin(self, y: Array) -> Array:
        """State just after impulses at t = 0."""
        self.chain.inside_s = 0.5 * sum(self.segments[0])
        applied = [impulse for impulse in self.scheduled if impulse.at_s <= self.slack_s]
        return self.apply_impulses(-np.inf, applied, y) if applied else y

    def apply_impulses(self, at_s: float, applied: list[Impulse], y: Array) -> Array:
        """State after impulses; the impulsive reactions are stored."""
        after, found = self.chain.apply_impulses(y, applied)
        self.sums.append((at_s, self.sums[-1][1] + found))
        return after

    def before(self, t_s: float) -> float:
        """An instant within the segment that ends at `t_s` or contains it."""
        start, end = next((part for part in self.segments if t_s <= part[1] + self.slack_s), self.segments[-1])
        return 0.5 * (start + end)

    def impulses(self, t_s: Array) -> Array:
        """Sum of the impulsive reactions before each sample, (n, N-1, 2) N s."""
        return np.array([[found for at, found in self.sums if at < t - self.slack_s][-1] for t in t_s])


class JointTreeEngine(Engine):
    """Joint coordinates in a freely falling frame, with error control.

    An engine sets `tree`, and its reason against prescribed rotations; with a solver of its own it overrides `solver`.
    """

    coordinates = Coordinates.JOINT
    order = None
    sweep = AccuracySweep(
        AccuracyParameter.RTOL, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13), default=1e-10
    )
    effects = SUPPORTED | {COM_SHARE}
    observables: ClassVar[frozenset[Observable]] = frozenset(
        {Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION, Observable.IMPULSE}
    )
    tree: ClassVar[type[JointTree]]
    """The library's model of the chain"""

    def solver(self, rtol: float, units: Array) -> Solver:
        """SciPy's DOP853; `units` has the unit of each component of the state."""
        return ScipySolver("DOP853", RTOL_FLOOR, rtol * units)

    def build(self, scene: Scene, setting: Setting) -> None:
        """Make the model and the initial value problem."""
        start, self.times_s = initial_state(scene), scene.times_s
        self.mass_kg = np.array(scene.chain.mass_kg)
        self.chain = self.tree(scene)
        q, q_t = to_joint_coordinates(self.chain.length_m, start, self.chain.left_m)
        self.jumps, self.breaks_s = Jumps(scene, self.chain), scene.effects.breaks_s
        self.struck = bool(scene.effects.impulse)
        y0 = self.jumps.begin(np.concatenate([start.com_m, start.com_velocity_m_s, q, q_t]))
        unit = accuracy_scales(scene)
        self.problem = Problem(self.chain.rate, y0, self.chain.height)
        self.integrator = self.solver(setting.value, np.concatenate([unit.track, unit.joint_coordinates(scene.bars)]))
        if self.integrator.locates_events and self.chain.incidences(0.0, y0):
            self.jumps.faces = self.problem.mode_events = HeldFaces(self.chain)

    def simulate(self) -> None:
        """Integrate."""
        try:
            self.walk = drive(self.integrator, self.problem, self.times_s, self.breaks_s, self.jumps).walk
        except ArithmeticError as error:
            raise EngineError(str(error)) from error

    def read(self) -> Trajectory:
        """Observables at the samples; reactions just before an event."""
        if self.jumps.faces:
            self.jumps.faces.release()
        y, width, reactions = self.walk.y, self.chain.width, []
        for t_s, state in zip(self.walk.t_s, y, strict=True):
            self.chain.inside_s = self.jumps.before(t_s)
            reactions.append(self.chain.reactions(state, t_s))
        chain = self.chain
        bars = from_joint_coordinates(chain.length_m, y[:, 4 : 4 + width], y[:, 4 + width :], chain.left_m)
        return Trajectory(
            self.walk.t_s,
            *bars.track(self.mass_kg, y[:, :2], y[:, 2:4]),
            bars.angle_rad,
            bars.rate_rad_s,
            np.array(reactions),
            impulse_N_s=self.jumps.impulses(self.walk.t_s) if self.struck else None,
            ended=landing_text(self.walk.stopped_s),
            info={"steps": self.walk.steps, "evaluations": self.walk.evaluations},
        )


def reasons(no_prescribed_rotation: str) -> dict[str, str]:
    """Reasons for the unsupported effects; the library's own reason against prescribed rotations."""
    return dict.fromkeys(PRESCRIBED_ROTATIONS, no_prescribed_rotation) | {"solar_pressure.shadow": NO_SHADOW}
