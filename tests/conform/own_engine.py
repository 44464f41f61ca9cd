"""An engine of own equations with all effects, and mistakes that can be switched on in it.

Coordinates are the chain's centre of mass and the bars' angles; SciPy's DOP853 integrates from event to event.
``tests.conform.own_engine:Right`` has no mistake; any other name of ``MISTAKES`` is the engine with that mistake.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from barchain.engine import (
    AccuracyParameter,
    AccuracySweep,
    Coordinates,
    Engine,
    EngineError,
    Observable,
    Trajectory,
    accuracy_scales,
    all_effect_names,
    initial_state,
    kepler_orbit,
)

if TYPE_CHECKING:
    from barchain.engine import Array, Impulse, JointTorque, Scene, Setting, Thrust

EARTH_MU = 3.986004418e14
NOISE_RAD = {
    "NoiseEndsJudgement": 1e-4,
    "NoiseHidesThrust": 9e-6,
    "NoiseHidesConstant": 9e-6,
    "HonestNoise": 3e-6,
    "FaintNoise": 3e-8,
}
"""Declared noise of the angles"""
SOURCE = Path(__file__).read_text("utf-8")
"""Where the names of the mistakes stand"""
BUFFER = 128
"""Samples that an engine of a fixed buffer keeps"""


class State(NamedTuple):
    """Motion at an instant: places and velocities of the bars' centres from the central body, angles and rates."""

    t_s: float
    com_m: Array
    position_m: Array
    velocity_m_s: Array
    angle_rad: Array
    rate_rad_s: Array
    along: Array
    across: Array


class Solved(NamedTuple):
    """Accelerations of a state, and the forces that go with them."""

    com_m_s2: Array
    angle_rad_s2: Array
    reaction_N: Array
    torque_N_m: Array


def cross(a: Array, b: Array) -> Array:
    """Component of the vector product across the plane."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def turned(a: Array) -> Array:
    """Vectors turned by +90 degrees."""
    return np.stack([-a[..., 1], a[..., 0]], axis=-1)


class Right(Engine):
    """Right by its documents: no mistake."""

    title = "own equations, centre of mass and angles, SciPy's DOP853"
    coordinates = Coordinates.RELATIVE
    order = None
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-5, 1e-7, 1e-9, 1e-11), 1e-9)
    effects = all_effect_names()
    observables = frozenset({Observable.COM, Observable.ATTITUDE, Observable.RATE, Observable.REACTION})
    mistakes: ClassVar[frozenset[str]] = frozenset()

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        """Noise of the angles with mistakes that it hides."""
        del scene, setting, t_s
        return (
            {"attitude": max(NOISE_RAD[name] for name in hidden)} if (hidden := cls.mistakes & set(NOISE_RAD)) else {}
        )

    def build(self, scene: Scene, setting: Setting) -> None:
        self.scene, self.e, self.setting = scene, scene.effects, setting
        chain = scene.chain
        self.m, self.l, self.J = (np.array(v) for v in (chain.mass_kg, chain.length_m, chain.inertia_kg_m2))
        n = scene.bars
        ends = np.tril(np.ones((n, n)), -1) * self.l + np.diag(self.l / 2.0)  # centre j from the chain's left end
        self.arms = ends - self.m @ ends / self.m.sum()  # centre j from the centre of mass: sum of arms times u_k
        self.signs: Array = np.ones(1 + 2 * n)

    def wrong(self, mistake: str) -> bool:
        """Whether a mistake is made."""
        return mistake in self.mistakes

    # Motion from numbers that are integrated

    def state(self, t_s: float, y: Array) -> State:
        """State of a vector of the centre of mass, its velocity, angles and rates."""
        com, velocity, n = y[:2], y[2:4], self.scene.bars
        angle, rate = y[4 : 4 + n], y[4 + n :]
        u = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        normal = turned(u)
        return State(
            t_s, com, com + self.arms @ u, velocity + self.arms @ (rate[:, None] * normal), angle, rate, u, normal
        )

    def solved(self, s: State, inside_s: float) -> Solved:
        """Accelerations, reactions and torques of a state; `inside_s` lies between the same two events."""
        force, torque = self.loads(s, inside_s)
        spin = -(s.rate_rad_s**2)[:, None] * s.along  # acceleration of the ends by the rates alone
        common = force.sum(axis=0) / self.m.sum()
        own = force - self.m[:, None] * common
        left = np.einsum("jk,kc,jc->k", self.arms, s.across, own - self.m[:, None] * (self.arms @ spin)) + torque
        angle, actuators = self.with_laws(s, common, self.arms @ spin, left)
        acceleration = self.arms @ (spin + angle[:, None] * s.across)
        reaction = np.cumsum(self.m[:, None] * acceleration - own, axis=0)[:-1]
        return Solved(common, angle, reaction, actuators)

    def matrix(self, s: State) -> Array:
        """Inertia of the angles, (N, N)."""
        found: Array = (self.arms.T * self.m @ self.arms) * (s.across @ s.across.T) + np.diag(self.J)
        return found

    def with_laws(self, s: State, common: Array, spin: Array, left: Array) -> tuple[Array, Array]:
        """Angular accelerations, and the torques that keep prescribed bars to their laws."""
        laws, n = self.e.prescribed_rotation, self.scene.bars
        matrix, right = self.matrix(s), left
        if laws:
            rows, wanted, columns = [], [], []
            for law in laws:
                k, row, value = law.bar - 1, np.eye(n)[law.bar - 1], law.law(s.t_s)[2]
                if law.frame == "local_horizontal":
                    place, speed = s.position_m[k], s.velocity_m_s[k]
                    r2 = place @ place
                    row = row - self.arms[k] * cross(place, s.across) / r2
                    value += cross(place, common + spin[k]) / r2
                    value -= 2.0 * cross(place, speed) * (place @ speed) / r2**2
                rows.append(row)
                wanted.append(value)
                columns.append(self.actuator(law.bar, law.actuator))
            block = np.zeros((len(laws), len(laws)))
            matrix = np.block([[matrix, -np.array(columns).T], [np.array(rows), block]])
            right = np.concatenate([left, wanted])
        found = np.linalg.solve(matrix, right)
        return found[:n], found[n:]

    def actuator(self, bar: int, kind: str) -> Array:
        """Torques on all bars for a torque of 1 on a prescribed bar."""
        found = np.zeros(self.scene.bars)
        found[bar - 1] = 1.0
        if kind == "joint":
            found[bar - 2 if bar > 1 else 1] = -1.0
        return found

    # Loads

    def loads(self, s: State, inside_s: float) -> tuple[Array, Array]:
        """Forces (N, 2) and torques (N,) on the bars."""
        force, torque = np.zeros((self.scene.bars, 2)), np.zeros(self.scene.bars)

        def add(load: tuple[Array, Array]) -> None:
            force[:] += load[0]
            torque[:] += load[1]

        add(self.gravity(s))
        if self.e.gravity == "none" and self.wrong("LoadsNeedGravity"):
            return force, torque
        thrusting = any(t.times_s[0] < inside_s < t.times_s[-1] for t in self.e.thrust)
        if self.e.oblateness and not (self.e.third_body and self.wrong("ThirdBodyOverwritesOblateness")):
            add(self.oblateness(s))
        for body in self.e.third_body[: 2 if self.wrong("TwoThirdBodies") else None]:
            add(self.third_body(s, body))
        if self.e.drag:
            add(self.drag(s))
        if self.e.solar_pressure and self.signs[0] > 0.0 and not (self.e.drag and self.wrong("DragElseSunlight")):
            add(self.sunlight(s))
        if self.e.joint_spring_damper and not (thrusting and self.wrong("SpringsOffInThrust")):
            torque += self.springs(s)
        for thrust in self.e.thrust[: 2 if self.wrong("TwoThrusts") else None]:
            add(self.end_force(s, thrust, self.size(thrust, s.t_s, inside_s)))
        for motor in self.e.joint_torque:
            torque[motor.joint - 1 : motor.joint + 1] += self.size(motor, s.t_s, inside_s) * np.array([-1.0, 1.0])
        return force, torque

    def gravity(self, s: State) -> tuple[Array, Array]:
        """Gravity of the central body."""
        mu, model = self.scene.central_body.mu_m3_s2, self.e.gravity
        if model == "none":
            return np.zeros_like(s.position_m), np.zeros_like(self.J)
        if model == "slender":
            return self.slender(s, mu)
        force, torque = self.attraction(s.position_m, s, mu, moment=model == "quadrupole", turns=model != "point")
        if self.wrong("SixthBarWithoutTorque"):
            torque[5:] = 0.0
        if self.wrong("NoGradientInChains") and self.scene.bars > 1:
            torque[:] = 0.0
        if self.wrong("ClosedOrbitsOnly") and self.scene.orbit.speed_factor**2 >= 2.0:
            torque[:] = 0.0
        return force, torque

    def attraction(
        self, place: Array, s: State, mu: float, *, moment: bool, turns: bool, inertia: Array | None = None
    ) -> tuple[Array, Array]:
        """Force and torque on bars at places relative to a point mass."""
        inertia = self.J if inertia is None else inertia
        r = np.linalg.norm(place, axis=1)[:, None]
        p, q = (np.sum(a * place, axis=1)[:, None] for a in (s.along, s.across))
        force = -mu * self.m[:, None] * place / r**3
        if moment:
            second = 2.0 * p * s.along + place - 5.0 * (p / r) ** 2 * place
            force = force + 1.5 * mu * inertia[:, None] / r**5 * second
        torque = 3.0 * mu * inertia * (p * q / r**5)[:, 0] if turns else np.zeros(len(r))
        return force, torque

    def slender(self, s: State, mu: float) -> tuple[Array, Array]:
        """Gravity integrated along each bar."""
        half = self.l[:, None] / 2.0 * s.along
        a, b = (np.linalg.norm(s.position_m + side * half, axis=1) for side in (-1.0, 1.0))
        p, q = (np.sum(x * s.position_m, axis=1) for x in (s.along, s.across))
        total = a + b
        apart = total**2 - self.l**2
        pull = 2.0 * mu * self.m / (a * b)
        force = -pull[:, None] * ((p / total)[:, None] * s.along + (q * total / apart)[:, None] * s.across)
        return force, pull * p * q * self.l**2 / (total * apart)

    @property
    def extended(self) -> bool:
        """Whether forces include the bars' second moments."""
        return self.e.gravity in ("quadrupole", "slender")

    @property
    def turns(self) -> bool:
        """Whether fields turn bars."""
        return self.extended or self.e.gravity == "gradient"

    def uniform(self, mistake: str) -> Array:
        """Moments of inertia; those of uniform bars with a mistake."""
        return self.m * self.l**2 / 12.0 if self.wrong(mistake) else self.J

    def oblateness(self, s: State) -> tuple[Array, Array]:
        """The J2 term of the central body."""
        assert self.e.oblateness is not None
        mu = EARTH_MU if self.wrong("OblatenessOfEarth") else self.scene.central_body.mu_m3_s2
        b = mu * self.e.oblateness.j2 * self.e.oblateness.radius_m**2 / 2.0
        z, r = s.position_m, np.linalg.norm(s.position_m, axis=1)[:, None]
        p, q = (np.sum(x * z, axis=1)[:, None] for x in (s.along, s.across))
        inertia = self.uniform("OblatenessOnUniformBars")
        force = -3.0 * b * self.m[:, None] * z / r**5
        if self.extended and not self.wrong("OblatenessWithoutMoment"):
            second = z + 2.0 * p * s.along - 7.0 * (p / r) ** 2 * z
            force = force + 7.5 * b * inertia[:, None] / r**7 * second
        torque = 15.0 * b * inertia * (p * q / r**7)[:, 0] if self.turns else np.zeros(len(r))
        return force, torque

    def third_body(self, s: State, body: object) -> tuple[Array, Array]:
        """Tide of a third body."""
        mu, distance = body.mu_m3_s2, body.distance_m  # type: ignore[attr-defined]
        longitude = body.longitude_rad + body.rate_rad_s * s.t_s  # type: ignore[attr-defined]
        x = distance * np.array([math.cos(longitude), math.sin(longitude)])
        moment = self.extended and not self.wrong("ThirdBodyWithoutMoment")
        inertia = self.uniform("ThirdBodyOnUniformBars")
        force, torque = self.attraction(s.position_m - x, s, mu, moment=moment, turns=self.turns, inertia=inertia)
        if self.wrong("TideToFirstOrder"):
            z, unit = s.position_m, x / distance
            tide = mu / distance**3 * (3.0 * (z @ unit)[:, None] * unit - z)
            return self.m[:, None] * tide, torque
        return force - self.m[:, None] * mu * x / distance**3, torque

    def drag(self, s: State) -> tuple[Array, Array]:
        """Drag on flat bars, the density linear along each."""
        d = self.e.drag
        assert d is not None
        z, length, b = s.position_m, self.l, np.array(d.width_m)
        r = np.linalg.norm(z, axis=1)
        v, along = self.wind(s)
        w = s.rate_rad_s - d.rotation_rad_s
        height = r - self.scene.central_body.radius_m - d.altitude_m
        density = d.density_kg_m3 * np.exp(-height / d.scale_height_m)
        kappa = np.sum(s.along * z, axis=1) / (r * d.scale_height_m)
        i2, i4 = length**3 / 12.0, length**5 / 80.0
        scale = -0.5 * b * density * self.signs[1 : 1 + self.scene.bars]
        normal = scale * d.normal_coefficient * (length * v**2 + i2 * w**2 - 2.0 * kappa * i2 * v * w)
        tangent = scale * d.tangential_coefficient * along * (length * v - kappa * i2 * w)
        torque = scale * d.normal_coefficient * (2.0 * i2 * v * w - kappa * (i2 * v**2 + i4 * w**2))
        return normal[:, None] * s.across + tangent[:, None] * s.along, torque

    def wind(self, s: State) -> tuple[Array, Array]:
        """Speeds of the bars' centres against the air, across and along the bars."""
        assert self.e.drag is not None
        found = s.velocity_m_s - self.e.drag.rotation_rad_s * turned(s.position_m)
        return np.sum(s.across * found, axis=1), np.sum(s.along * found, axis=1)

    def sun(self, t_s: float) -> Array:
        """Unit vector to the Sun."""
        light = self.e.solar_pressure
        assert light is not None
        angle = light.sun_longitude_rad + light.sun_rate_rad_s * t_s
        return np.array([math.cos(angle), math.sin(angle)])

    def sunlight(self, s: State) -> tuple[Array, Array]:
        """Pressure of sunlight."""
        light = self.e.solar_pressure
        assert light is not None
        sun = self.sun(s.t_s)
        facing = s.across @ sun
        faces = self.signs[1 + self.scene.bars :]
        normal = faces[:, None] * s.across
        size = light.pressure_Pa * np.array(light.width_m) * self.l * facing * faces
        rho = light.reflectivity
        force = -size[:, None] * ((1.0 - rho) * sun + 2.0 * rho * (facing * faces)[:, None] * normal)
        return force, np.zeros(len(size))

    def springs(self, s: State) -> Array:
        """Torques of springs and dampers in the joints, (N,)."""
        spring = self.e.joint_spring_damper
        assert spring is not None
        if self.wrong("DampersNeedSprings") and not any(spring.stiffness_N_m_rad):
            return np.zeros(self.scene.bars)
        k, c, rest = (np.array(x) for x in (spring.stiffness_N_m_rad, spring.damping_N_m_s_rad, spring.rest_rad))
        each = k * (np.diff(s.angle_rad) - rest) + c * np.diff(s.rate_rad_s)
        if self.wrong("TwoSprings"):
            each[2:] = 0.0
        return np.append(each, 0.0) - np.append(0.0, each)

    def size(self, table: Thrust | JointTorque, t_s: float, inside_s: float) -> float:
        """Size of a thrust or a motor's torque between the events around `inside_s`."""
        for k in range(len(table.times_s) - 1):
            begin, end = table.times_s[k : k + 2]
            if begin < inside_s < end:
                one, other = table.sizes[k : k + 2]
                size = one + (other - one) * (t_s - begin) / (end - begin)
                weaker = 5e-7 * self.wrong("NoiseHidesThrust") + 5e-6 * self.wrong("NoiseEndsJudgement")
                return abs(size) if self.wrong("ThrustsArePositive") else (1.0 - weaker) * size
        return 0.0

    def end_force(self, s: State, where: Thrust | Impulse, size: float) -> tuple[Array, Array]:
        """Force of a size on the end of a bar, or impulse."""
        k = where.bar - 1
        aim = where.direction_rad + (s.angle_rad[k] if where.axes == "body" else 0.0)
        force, torque = np.zeros((self.scene.bars, 2)), np.zeros(self.scene.bars)
        force[k] = size * np.array([math.cos(aim), math.sin(aim)])
        torque[k] = where.end.sign * self.l[k] / 2.0 * float(cross(s.along[k], force[k]))
        return force, torque

    # Events

    def struck(self, t_s: float, y: Array) -> tuple[Array, Array]:
        """State after the impulses of an instant, and the impulsive reactions."""
        n, s = self.scene.bars, self.state(t_s, y)
        force, torque = np.zeros((n, 2)), np.zeros(n)
        acting = [i for i in self.e.impulse if i.at_s == t_s]
        if self.wrong("OneImpulseAtATime"):
            acting = acting[:1]
        if self.wrong("ImpulseAtEndOfThrust") and any(t_s == t.times_s[-1] for t in self.e.thrust):
            acting = []
        for impulse in acting:
            load = self.end_force(s, impulse, impulse.impulse_N_s)
            force, torque = force + load[0], torque + load[1]
        common = force.sum(axis=0) / self.m.sum()
        own = force - self.m[:, None] * common
        left = np.einsum("jk,kc,jc->k", self.arms, s.across, own) + torque
        jump = self.jump(s, common, left)
        moved = self.arms @ (jump[:, None] * s.across)
        after = y.copy()
        after[2:4] += common
        after[4 + n :] += jump
        return after, np.cumsum(self.m[:, None] * moved - own, axis=0)[:-1]

    def jump(self, s: State, common: Array, left: Array) -> Array:
        """Jump of the rates; prescribed bars keep the rates of their laws."""
        laws, n = self.e.prescribed_rotation, self.scene.bars
        size = n + len(laws)
        matrix, right = np.zeros((size, size)), np.zeros(size)
        matrix[:n, :n], right[:n] = self.matrix(s), left
        for row, law in enumerate(laws, start=n):
            k = law.bar - 1
            matrix[:n, row] = -self.actuator(law.bar, law.actuator)
            matrix[row, k] = 1.0
            if law.frame == "local_horizontal":
                place = s.position_m[k]
                matrix[row, :n] -= self.arms[k] * cross(place, s.across) / (place @ place)
                right[row] = cross(place, common) / (place @ place)
        found: Array = np.linalg.solve(matrix, right)[:n]
        return found

    def watched(self, t_s: float, y: Array) -> Array:
        """Numbers whose signs change at events: outside the shadow, faces to the wind, faces to the Sun; (1 + 2 N,)."""
        s, found = self.state(t_s, y), np.ones_like(self.signs)
        if self.e.drag:
            found[1 : 1 + self.scene.bars] = self.wind(s)[0]
        if self.e.solar_pressure:
            sun, radius = self.sun(t_s), self.scene.central_body.radius_m
            found[1 + self.scene.bars :] = s.across @ sun
            if self.e.solar_pressure.shadow:
                found[0] = max(abs(float(cross(s.com_m, sun))) - radius, float(s.com_m @ sun)) / radius
        return found

    # Phases

    def simulate(self) -> None:
        start, scales, n = initial_state(self.scene), accuracy_scales(self.scene), self.scene.bars
        y = np.concatenate([start.com_m, start.com_velocity_m_s, start.angle_rad, start.rate_rad_s])
        if self.wrong("SlowStartsClipped"):
            y[2:4] *= max(1.0, self.scene.orbit.speed_factor) / self.scene.orbit.speed_factor
        units = np.concatenate([scales.track, np.ones(n), np.full(n, scales.rate_rad_s)])
        times, end = self.scene.times_s, self.scene.run.duration_s
        near = 1e-9 * end
        breaks = [t for t in self.e.breaks_s if near < t < end - near]
        self.rows: list[tuple[float, Array, float, Array, Array]] = []
        impulse, now, k = np.zeros((n - 1, 2)), 0.0, 0
        self.signs = np.sign(self.watched(0.0, y))
        for until in [*breaks, end]:
            while now < until:
                inside = 0.5 * (now + until)
                part, changed = self.integrated(now, until, y, inside, units)
                y, now = part.y[:, -1], float(part.t[-1])
                while k < len(times) and times[k] <= now + near:
                    self.rows.append((times[k], part.sol(min(times[k], now)), inside, impulse, self.signs.copy()))
                    k += 1
                self.signs[changed] *= -1.0
            if any(i.at_s == until for i in self.e.impulse):
                y, gained = self.struck(until, y)
                impulse = impulse + gained

    def integrated(self, now: float, until: float, y: Array, inside: float, units: Array) -> tuple[Any, list[int]]:
        """Part of the motion between two events, and the signs that change at its end."""

        def rates(t: float, x: Array) -> Array:
            s = self.state(t, x)
            found = self.solved(s, inside)
            return np.concatenate([x[2:4], found.com_m_s2, x[4 + self.scene.bars :], found.angle_rad_s2])

        events: list[Any] = []
        for k in range(len(self.signs)) if self.e.drag or self.e.solar_pressure else ():

            def event(t: float, x: Array, k: int = k) -> float:
                return float(self.signs[k] * self.watched(t, x)[k]) + 1e-12

            event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
            events.append(event)
        rtol = self.setting.value
        part = solve_ivp(
            rates, (now, until), y, method="DOP853", rtol=1e-13, atol=rtol * units, dense_output=True, events=events
        )
        if part.status < 0:
            raise EngineError(part.message)
        return part, [k for k, t in enumerate(part.t_events or ()) if len(t)]

    def read(self) -> Trajectory:
        """Samples; mistakes of reading are made here."""
        n = self.scene.bars
        y = np.array([row[1] for row in self.rows])
        found = []
        for t, x, inside, _, signs in self.rows:
            self.signs = signs
            found.append(self.solved(self.state(t, x), inside))
        reaction, torque = (np.array([getattr(f, a) for f in found]) for a in ("reaction_N", "torque_N_m"))
        angle = y[:, 4 : 4 + n]
        if self.wrong("UnwrapsAtSamples"):
            angle = np.unwrap(angle, axis=0)
        if self.wrong("ReactionsInABuffer") and len(reaction) > BUFFER:
            reaction[BUFFER:] = reaction[BUFFER - 1]
        com, velocity = y[:, :2], y[:, 2:4]
        if self.wrong("TrackOfAFrame") and self.e.gravity != "none":
            start = initial_state(self.scene)
            mu, times = self.scene.central_body.mu_m3_s2, self.scene.times_s
            com, velocity = kepler_orbit(mu, start.com_m, start.com_velocity_m_s, times)
        if self.wrong("NoiseHidesConstant"):
            angle = angle + 1.5e-6 * np.minimum(1.0, self.scene.times_s / 100.0)[:, None]
        for amplitude in [1e-6] * self.wrong("HonestNoise") + [1e-8] * self.wrong("FaintNoise"):
            digits = np.random.default_rng(int(1e12 * self.setting.value) + n)
            angle = angle + amplitude * digits.uniform(-1.0, 1.0, angle.shape)
        if self.wrong("RightAtTheFinest") and self.setting.value > 5e-12:
            digits = np.random.default_rng(int(1e6 * abs(math.sin(1e9 * self.setting.value + y[-1].sum() * 1e6))))
            angle = angle * (1.0 + 1e-7 * digits.standard_normal(angle.shape))
        return Trajectory(
            t_s=self.scene.times_s,
            com_m=com,
            com_velocity_m_s=velocity,
            angle_rad=angle,
            rate_rad_s=y[:, 4 + n :],
            reaction_N=reaction,
            torque_N_m=torque if self.e.prescribed_rotation else None,
            impulse_N_s=np.array([row[3] for row in self.rows]) if self.e.impulse else None,
        )


def __getattr__(name: str) -> type[Right]:
    """Engine with the mistake of a name."""
    if name.startswith("_") or f'"{name}"' not in SOURCE:
        raise AttributeError(name)
    return type(name, (Right,), {"mistakes": frozenset({name})})
