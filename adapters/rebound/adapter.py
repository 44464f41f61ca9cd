"""REBOUND adapter: the orbit of the centre of mass, as one particle about a point mass.

A chain's centre of mass moves like a particle only up to O((L/r)²) of gravity, with L the chain's length: a comparison
has to allow for it (12 pi r (l/r)² in an orbit for five bars of length l along the horizontal). Torques, joint motors,
springs in the joints and the bars' second moments move the centre of mass through that term only.

The accuracy parameter is `rtol`. Up to LOOSEST_IAS15 it sets IAS15's epsilon; above that value WHFast runs at a fixed
step, at less cost. For a single particle WHFast's drift along Kepler's orbit is the whole motion. WHFast is therefore
exact to round-off at any step, and its step matters only for the instant at the surface. Where other forces act, IAS15
runs at every `rtol`.

Stops of IAS15 at every sample would cost accuracy, so that it keeps its own steps. A second, short simulation of the
same engine gives a sample from the step before it, and is then discarded. Events in time (a thrust's end, an impulse)
divide the run into segments. The engine's steps continue beyond the end of a segment with its own smooth forces, and
the next segment restarts from the end of the previous one.

A single third body is a massive particle: it and the central body move about their centre of mass, and the particle's
position is relative to the central body. Several third bodies are on their circles, in the callback of oblateness and
thrusts.
"""

from __future__ import annotations

import cmath
import itertools
import math
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, final

import numpy as np
from scipy.optimize import brentq

from adapters.common.initial_state import initial_state
from adapters.engine import (
    GRAVITY_MODELS,
    PRESCRIBED_ROTATIONS,
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Engine,
    EngineError,
    Setting,
)
from adapters.rebound.forces import attach, companion, forces
from adapters.trajectory import Observable, Trajectory
from reference_impl.model.gravity import perigee_m
from scenarios import Axes, Gravity
from scenarios.effect_types import COM_SHARE

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenarios import Scene

    PlaneState = tuple[float, float, float, float]

LOOSEST_IAS15 = 3e-7  # rtol above which WHFast runs
EPSILON_AT = (1e-12, 1e-9)  # an rtol and its epsilon, IAS15's default, sufficient at eccentricity 0.8 too
EPSILON_POWER = 7.0 / 15.0  # steps vary as epsilon^(1/7), the error of an orbit as their 15th power
WHFAST_STEPS_PER_ORBIT = 64
FIRST_STEP = 1e-3  # relative to the period; IAS15 adapts it immediately
LANDING_SLACK_S = 1e-9  # accuracy of the instant at which the surface is reached

GRAZING = (
    "REBOUND moves a particle, which passes {:.4g} m above the surface: "
    "the bars' attitude decides whether the chain touches it"
)
ATTITUDE_DEPENDENT = "REBOUND moves a particle without attitude and does not support {}"
ATTITUDE_EFFECTS = {
    "drag": "drag",
    "solar_pressure": "sunlight",
    "solar_pressure.shadow": "sunlight",
    "thrust.body": "a thrust that turns with its bar",
}
BODY_IMPULSE = "an impulse along a bar's own axes"


def perigee_height_m(scene: Scene) -> float:
    """Height of the orbit's lowest point, m; infinite without gravity."""
    if scene.effects.gravity is Gravity.NONE:
        return math.inf
    start, body = initial_state(scene), scene.central_body
    return perigee_m(body.mu_m3_s2, start.com_m, start.com_velocity_m_s) - body.radius_m


def attitude_dependence(effects: list[str]) -> str:
    """Reason why a particle does not support these effects."""
    *most, last = effects
    return ATTITUDE_DEPENDENT.format(f"{', '.join(most)} or {last}" if most else last)


class ParticleState(NamedTuple):
    """A particle at an instant, relative to the central body, s, m and m/s."""

    t: float
    x: float
    y: float
    vx: float
    vy: float
    companion: PlaneState | None = None
    """The third body's position and velocity, if it is a particle"""

    @property
    def radius(self) -> float:
        """Distance from the centre of the body, m."""
        return math.hypot(self.x, self.y)

    @property
    def radial_motion(self) -> float:
        """Radius times its rate, m²/s: negative on the way down."""
        return self.x * self.vx + self.y * self.vy

    @property
    def finite(self) -> bool:
        """Whether every component is finite."""
        return math.isfinite(sum(self[:5])) and math.isfinite(sum(self.companion or (0.0,)))


class TrackSegment(NamedTuple):
    """A part of the run without events."""

    start_s: float
    end_s: float
    velocity_jump_m_s: complex
    """Jump of the velocity at its start"""


def epsilon(rtol: float) -> float:
    """IAS15's epsilon for a requested error of `rtol` relative to the radius."""
    known, its = EPSILON_AT
    return its * math.pow(rtol / known, EPSILON_POWER)


def segments(scene: Scene) -> list[TrackSegment]:
    """Parts of the run between thrusts' events and impulses; prescribed rotations do not act on the particle."""
    effects, end = scene.effects, scene.run.duration_s
    jumps = {t for thrust in effects.thrust for t in thrust.breaks_s} | {jump.at_s for jump in effects.impulse}
    ends = [0.0, *sorted(t for t in jumps if 0.0 < t < end), end]

    def jump(at_s: float) -> complex:
        due = [p for p in effects.impulse if p.at_s == at_s]
        return sum((cmath.rect(p.impulse_N_s, p.direction_rad) for p in due), 0j) / scene.mass_kg

    return [TrackSegment(a, b, jump(a)) for a, b in itertools.pairwise(ends)]


@final
class Rebound(Engine):
    """One particle for the chain."""

    title = "REBOUND, one particle for the chain (IAS15; WHFast where coarse)"
    coordinates = Coordinates.ABSOLUTE
    order = None
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), default=1e-12)
    effects = frozenset({
        *GRAVITY_MODELS, *PRESCRIBED_ROTATIONS, "oblateness", "third_body", "joint_spring_damper", "joint_torque",
        "thrust.inertial",
        "impulse", COM_SHARE,
    })  # fmt: skip
    observables = frozenset({Observable.COM})
    unsupported_reasons: ClassVar[dict[str, str]] = {
        name: attitude_dependence([push]) for name, push in ATTITUDE_EFFECTS.items()
    }

    @classmethod
    def unsupported(cls, scene: Scene) -> str | None:
        """Reason why the engine does not support `scene`, in one sentence; of impulses, those in a bar's axes."""
        found = [ATTITUDE_EFFECTS.get(name, name) for name in sorted(scene.needs - cls.effects)]
        found += [BODY_IMPULSE for p in scene.effects.impulse if p.axes is not Axes.INERTIAL]
        if found:
            return attitude_dependence(list(dict.fromkeys(found)))
        above = perigee_height_m(scene)
        return GRAZING.format(above) if 0.0 < above < scene.size_m else None

    def build(self, scene: Scene, setting: Setting) -> None:
        """Set up the particle."""
        start = initial_state(scene)
        self.scene, self.rtol = scene, setting.value
        self.companion, self.segments = companion(scene), segments(scene)
        self.forces = forces(scene, self.segments[0].start_s, self.segments[0].end_s)
        self.failed: list[Exception] = []
        free = scene.effects.gravity is Gravity.NONE
        kepler = not (free or self.companion or self.forces or len(self.segments) > 1)
        self.whfast = kepler and setting.value > LOOSEST_IAS15
        (x, y), (vx, vy) = start.com_m.tolist(), start.com_velocity_m_s.tolist()
        state = ParticleState(0.0, x, y, vx, vy, self.companion_start())
        self.start = after_impulse(state, self.segments[0])
        self.times_s = scene.times_s.tolist()
        self.seen: list[ParticleState] = []
        self.ended, self.steps = "", 0
        self.track = self.simulation(self.start, self.step_s)

    @property
    def step_s(self) -> float:
        """First step; WHFast's fixed step."""
        return self.scene.step_period_s * (1.0 / WHFAST_STEPS_PER_ORBIT if self.whfast else FIRST_STEP)

    def companion_start(self) -> PlaneState | None:
        """Position and velocity of the third body at t = 0, relative to the central body."""
        body = self.companion
        if body is None:
            return None
        position = cmath.rect(body.distance_m, body.longitude_rad)
        velocity = 1j * body.rate_rad_s * position
        return position.real, position.imag, velocity.real, velocity.imag

    def simulation(self, state: ParticleState, dt_s: float) -> Any:
        """REBOUND's simulation of the particle from `state`.

        The central body starts at rest at the origin. Relative to the common centre of two bodies, a position near one
        of them would be rounded like the distance of that centre.
        """
        import rebound

        free = self.scene.effects.gravity is Gravity.NONE
        sim = rebound.Simulation()
        sim.G = 1.0
        sim.add(m=0.0 if free else self.scene.central_body.mu_m3_s2)
        if self.companion and state.companion:
            x, y, vx, vy = state.companion
            sim.add(m=self.companion.mu_m3_s2, x=x, y=y, vx=vx, vy=vy)
        sim.add(m=0.0, x=state.x, y=state.y, vx=state.vx, vy=state.vy)
        sim.N_active = sim.N - 1
        sim.t, sim.dt = state.t, dt_s
        sim.integrator = "whfast" if self.whfast else "ias15"
        if free:
            sim.gravity = "none"
        elif not self.whfast:
            settings = sim.ri_ias15 if isinstance(sim.integrator, str) else sim.integrator  # of 4.x, and from 5.0 on
            settings.epsilon = epsilon(self.rtol)
        if self.forces:
            attach(sim, self.forces, self.failed)
        return sim

    def simulate(self) -> None:
        """Integrate segment by segment."""
        self.seen = [self.start]
        state: ParticleState | None = self.walk(self.start, self.segments[0])
        for segment in self.segments[1:]:
            if state is None:
                return
            self.forces = forces(self.scene, segment.start_s, segment.end_s)
            start = after_impulse(state, segment)
            self.track = self.simulation(start, self.step_s)
            state = self.walk(start, segment)

    def walk(self, before: ParticleState, segment: TrackSegment) -> ParticleState | None:
        """Take the engine's own steps through a segment, and store the samples on the way.

        Returns
        -------
        ParticleState or None
            At the end of the segment; None where the run ends.
        """
        while True:
            after = self.advanced(before)
            landing = self.landing(before, after)
            until = min(after.t if landing is None else landing, segment.end_s)
            while len(self.seen) < len(self.times_s) and self.times_s[len(self.seen)] <= until:
                self.seen.append(self.state_at(before, after, self.times_s[len(self.seen)]))
            if len(self.seen) == len(self.times_s):
                return None
            if landing is not None and landing <= segment.end_s:
                self.ended = f"the centre of mass reached the surface at t = {landing:.6f} s"
                return None
            if after.t >= segment.end_s:
                return self.state_at(before, after, segment.end_s)
            before = after

    def advanced(self, before: ParticleState) -> ParticleState:
        """State after one of the engine's own steps."""
        self.track.steps(1)
        self.steps += 1
        self.check()
        after = self.state(self.track)
        if not after.finite or after.t <= before.t:
            raise EngineError(
                f"REBOUND: the particle's state is not finite, or time stands still, after t = {before.t:.6g} s"
            )
        return after

    def check(self) -> None:
        """Raise an error where a force failed."""
        if self.failed:
            raise EngineError(f"REBOUND: a force failed: {self.failed[0]!r}") from self.failed[0]

    def read(self) -> Trajectory:
        """Return the centre of mass at the samples."""
        values = np.array([state[:5] for state in self.seen])
        return Trajectory(
            np.array(self.times_s[: len(values)]),
            values[:, 1:3],
            values[:, 3:5],
            ended=self.ended,
            info={
                "steps": float(self.steps),
                "integrator": str(self.track.integrator),
            },
        )

    def state(self, sim: Any) -> ParticleState:
        """State of a simulation's particle, relative to the central body."""
        p = sim.particles[sim.N - 1]
        if self.companion is None:  # nothing moves the central body
            return ParticleState(sim.t, p.x, p.y, p.vx, p.vy)
        centre = sim.particles[0]
        return ParticleState(sim.t, *relative_state(centre, p), relative_state(centre, sim.particles[1]))

    def state_at(self, before: ParticleState, after: ParticleState, t_s: float) -> ParticleState:
        """State at an instant between two steps, by a separate simulation from the first."""
        for step in (before, after):
            if t_s == step.t:
                return step
        probe = self.simulation(before, t_s - before.t)
        probe.integrate(t_s)
        self.check()
        return self.state(probe)

    def landing(self, before: ParticleState, after: ParticleState) -> float | None:
        """Instant within a step at which the particle reaches the surface, s; None if it does not."""
        surface = self.scene.central_body.radius_m
        lowest = after.t
        if after.radius > surface:
            if not before.radial_motion < 0.0 < after.radial_motion:
                return None
            lowest = zero_between(lambda t: self.state_at(before, after, t).radial_motion, before.t, after.t)
            if self.state_at(before, after, lowest).radius > surface:
                return None
        return zero_between(lambda t: self.state_at(before, after, t).radius - surface, before.t, lowest)


def relative_state(centre: Any, particle: Any) -> PlaneState:
    """Position and velocity of a particle relative to another."""
    return particle.x - centre.x, particle.y - centre.y, particle.vx - centre.vx, particle.vy - centre.vy


def after_impulse(state: ParticleState, segment: TrackSegment) -> ParticleState:
    """State just after the impulse at a segment's start."""
    jump = segment.velocity_jump_m_s
    return state._replace(vx=state.vx + jump.real, vy=state.vy + jump.imag) if jump else state


def zero_between(function: Callable[[float], float], low: float, high: float) -> float:
    """Zero of `function` between two instants, s."""
    found: float = brentq(function, low, high, xtol=LANDING_SLACK_S)
    return found
