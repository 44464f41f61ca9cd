"""REBOUND behind the engines' contract: the centre of mass' track, as one particle about a point mass.

REBOUND knows particles, not bars, so it shows the centre of mass and nothing else. A chain's centre of
mass is a particle only up to O((L/r)²) of gravity, L the chain's length: a difference of models, not an
error of either, that grows as L² and is to be allowed for in a comparison (12 pi r (l/r)² in an orbit
for five bars of length l along the horizontal). Torques and joint motors move the centre of mass
through that term only, so scenes with a prescribed rotation have a track here as well.

The knob is `rtol`. From LOOSEST_IAS15 on down it sets IAS15's epsilon; above it the cheap WHFast runs,
at a fixed step. For a single particle WHFast's drift along Kepler's orbit is the whole motion, so it is
exact to round-off at any step, and its step matters for finding the surface only.

Stopping IAS15 at every sample would cost it accuracy, so it keeps its own steps. A sample is reached
from the step before it by a second, short simulation of the same engine, which is then thrown away.

REBOUND is GPL-3: it is imported here only, and only when a scene is built.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, final

import numpy as np
from scipy.optimize import brentq

from adapters.engine import Coordinates, Engine, EngineError, Knob, Ladder, Observable, Setting, Trajectory
from adapters.initial_state import initial_state
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenarios import Scene

LOOSEST_IAS15 = 3e-7  # rtol above which WHFast runs
EPSILON_AT = (1e-12, 1e-9)  # an rtol, and its epsilon: IAS15's default, good for it at eccentricity 0.8 too
EPSILON_POWER = 7.0 / 15.0  # steps go as epsilon^(1/7), the error of an orbit as their 15th power
WHFAST_STEPS_PER_ORBIT = 64
FIRST_STEP = 1e-3  # of the period; IAS15 finds its own at once
LANDING_SLACK_S = 1e-9  # accuracy of the instant at which the surface is reached


class State(NamedTuple):
    """A particle at an instant, s, m and m/s."""

    t: float
    x: float
    y: float
    vx: float
    vy: float

    @property
    def radius(self) -> float:
        """Distance from the centre of the body, m."""
        return math.hypot(self.x, self.y)

    @property
    def climb(self) -> float:
        """Radius times its rate, m²/s: negative on the way down."""
        return self.x * self.vx + self.y * self.vy


def epsilon(rtol: float) -> float:
    """IAS15's epsilon for an accuracy of `rtol` of the radius."""
    known, its = EPSILON_AT
    return its * math.pow(rtol / known, EPSILON_POWER)


@final
class Rebound(Engine):
    """A particle for the chain."""

    title = "REBOUND, one particle for the chain (IAS15; WHFast where coarse)"
    coordinates = Coordinates.ABSOLUTE
    order = None
    ladder = Ladder(Knob.RTOL, (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12), default=1e-12)
    effects = frozenset(
        {"gravity.none", "gravity.point", "gravity.gradient"}
        | {f"prescribed_rotation.{what}" for what in ("inertial", "local_horizontal", "external", "joint")}
    )
    observables = frozenset({Observable.COM})

    def build(self, scene: Scene, setting: Setting) -> None:
        """Set the particle up."""
        start = initial_state(scene)
        self.scene, self.rtol = scene, setting.value
        self.start = State(0.0, *start.com_m.tolist(), *start.com_velocity_m_s.tolist())
        self.whfast = setting.value > LOOSEST_IAS15 and scene.effects.gravity is not Gravity.NONE
        self.times_s = scene.times_s.tolist()
        self.seen: list[State] = []
        self.ended = ""
        dt = scene.step_period_s / WHFAST_STEPS_PER_ORBIT if self.whfast else scene.step_period_s * FIRST_STEP
        self.track = self.simulation(self.start, dt)

    def simulation(self, state: State, dt_s: float) -> Any:
        """REBOUND's simulation of the particle from `state` on."""
        import rebound

        free = self.scene.effects.gravity is Gravity.NONE
        sim = rebound.Simulation()
        sim.G = 1.0
        sim.add(m=0.0 if free else self.scene.central_body.mu_m3_s2)
        sim.add(m=0.0, x=state.x, y=state.y, vx=state.vx, vy=state.vy)
        sim.N_active = 1
        sim.t, sim.dt = state.t, dt_s
        sim.integrator = "whfast" if self.whfast else "ias15"
        if free:
            sim.gravity = "none"
        elif not self.whfast:
            sim.integrator.epsilon = epsilon(self.rtol)
        return sim

    def simulate(self) -> None:
        """Walk the engine's own steps, and look at the samples on the way."""
        self.seen = [self.start]
        before = self.start
        while len(self.seen) < len(self.times_s):
            self.track.steps(1)
            after = self.state(self.track)
            if not math.isfinite(sum(after)) or after.t <= before.t:
                raise EngineError(f"REBOUND lost the particle after t = {before.t:.6g} s")
            landing = self.landing(before, after)
            until = after.t if landing is None else landing
            while len(self.seen) < len(self.times_s) and self.times_s[len(self.seen)] <= until:
                self.seen.append(self.reach(before, after, self.times_s[len(self.seen)]))
            if landing is not None:
                if len(self.seen) < len(self.times_s):
                    self.ended = f"the centre of mass reached the surface at t = {landing:.6f} s"
                return
            before = after

    def read(self) -> Trajectory:
        """Bring out the centre of mass at the samples."""
        values = np.array(self.seen)
        return Trajectory(
            np.array(self.times_s[: len(values)]),
            values[:, 1:3],
            values[:, 3:5],
            ended=self.ended,
            info={
                "steps": float(self.track.steps_done),
                "integrator": str(self.track.integrator),
            },
        )

    def state(self, sim: Any) -> State:
        """Where a simulation's particle is."""
        p = sim.particles[1]
        return State(sim.t, p.x, p.y, p.vx, p.vy)

    def reach(self, before: State, after: State, t_s: float) -> State:
        """State at an instant between two steps, by a simulation of its own from the first."""
        for step in (before, after):
            if t_s == step.t:
                return step
        probe = self.simulation(before, t_s - before.t)
        probe.integrate(t_s)
        return self.state(probe)

    def landing(self, before: State, after: State) -> float | None:
        """Instant within a step at which the particle reaches the surface, s; None if it does not."""
        surface = self.scene.central_body.radius_m
        lowest = after.t
        if after.radius > surface:
            if not before.climb < 0.0 < after.climb:
                return None
            lowest = root(lambda t: self.reach(before, after, t).climb, before.t, after.t)
            if self.reach(before, after, lowest).radius > surface:
                return None
        return root(lambda t: self.reach(before, after, t).radius - surface, before.t, lowest)


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Zero of `function` between two instants, s."""
    found: float = brentq(function, low, high, xtol=LANDING_SLACK_S)
    return found
