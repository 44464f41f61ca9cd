"""What each effect should do to a bar, in fifty digits, from its potential or from its elements along the bar.

Potentials are differenced numerically, elements integrated numerically: nothing here is a closed form that the
reference could share. Plane vectors are mpmath's complex numbers.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import numpy as np

from reference_impl.effects.drag import DragEffect
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.effects.joint_torque import JointTorqueEffect
from reference_impl.effects.oblateness import OblatenessEffect
from reference_impl.effects.quadrupole import QuadrupoleEffect
from reference_impl.effects.slender import SlenderBarEffect
from reference_impl.effects.solar_pressure import SolarPressureEffect
from reference_impl.effects.third_body import ThirdBodyEffect
from reference_impl.effects.thrust import ThrustEffect
from reference_impl.model.arrays import Array
from reference_impl.model.chain import ChainModel
from reference_impl.model.effect import ChainEffect
from reference_impl.model.state import State

DIGITS = 50
DEGREE = 4  # 24 nodes leave (l/4r)^48 of an integral, less than the digits kept


@dataclass(frozen=True)
class Bar:
    """One bar, its numbers exact."""

    mass: Any
    length: Any
    inertia: Any
    place: Any
    motion: Any
    angle: Any
    rate: Any
    width: Any = None

    @property
    def unit(self) -> Any:
        return mp.expj(self.angle)


@dataclass(frozen=True)
class EffectVerdict:
    """What is right for N bars, rounded to double at the very end."""

    whole: Array
    """(N,) complex, accelerations, m/s²"""
    apart: Array
    """(N,) complex, the same less their weighted mean, subtracted in fifty digits"""
    spin: Array
    """(N,) torque over moment of inertia, rad/s²"""


def judge(effect: ChainEffect, model: ChainModel, state: State, t_s: float) -> EffectVerdict:
    """Right accelerations of a state."""
    with mp.workdps(DIGITS):
        bars = bars_of(effect, model, state)
        found = [on_bar(effect, model, state, t_s, j, bar) for j, bar in enumerate(bars)]
        mass = [bar.mass for bar in bars]
        mean = sum((m * a for m, (a, _) in zip(mass, found, strict=True)), mp.mpc(0)) / sum(mass)
        return EffectVerdict(
            np.array([complex(a) for a, _ in found]),
            np.array([complex(a - mean) for a, _ in found]),
            np.array([float(s) for _, s in found]),
        )


def bars_of(effect: ChainEffect, model: ChainModel, state: State) -> list[Bar]:
    """Bars of a state, places and motions summed exactly."""
    place = [point(state.com_m) + point(d) for d in state.position_m]
    motion = [point(state.com_velocity_m_s) + point(v) for v in state.velocity_m_s]
    numbers = np.stack([model.mass_kg, model.length_m, model.inertia_kg_m2, state.angle_rad, state.rate_rad_s], axis=1)
    width = getattr(effect, "width_m", np.zeros(model.bars))
    return [
        Bar(*map(mp.mpf, row[:3]), z, v, *map(mp.mpf, row[3:]), mp.mpf(b))
        for row, z, v, b in zip(numbers.tolist(), place, motion, width.tolist(), strict=True)
    ]


def point(vector: Array) -> Any:
    return mp.mpc(float(vector[0]), float(vector[1]))


def on_bar(effect: ChainEffect, model: ChainModel, state: State, t_s: float, j: int, bar: Bar) -> tuple[Any, Any]:
    """Acceleration and angular acceleration of one bar."""
    mu = mp.mpf(model.mu_m3_s2)
    if isinstance(effect, SlenderBarEffect):
        a, s = along_bar(lambda place, _: -mu * place / abs(place) ** 3, bar)
        return a + mu * bar.place / abs(bar.place) ** 3, s
    if isinstance(effect, QuadrupoleEffect):
        a, _ = second_moment(lambda z: -mu / abs(z), bar)
        return a, mp.mpf(0)
    if isinstance(effect, (OblatenessEffect, ThirdBodyEffect)):
        return in_field(effect, potential(effect, t_s), bar)
    return pushed(effect, state, t_s, j, bar)


def pushed(effect: ChainEffect, state: State, t_s: float, j: int, bar: Bar) -> tuple[Any, Any]:
    """The same of what is no field."""
    if isinstance(effect, DragEffect):
        return dragged(effect, bar)
    if isinstance(effect, SolarPressureEffect):
        return lit(effect, point(state.com_m), bar, mp.mpf(t_s)), mp.mpf(0)
    if isinstance(effect, JointSpringDamperEffect):
        return mp.mpc(0), sprung(effect, state, j) / bar.inertia
    if isinstance(effect, JointTorqueEffect):
        sign = {effect.joint: -1, effect.joint + 1: 1}.get(j, 0)
        return mp.mpc(0), sign * size_in_table(effect, mp.mpf(t_s)) / bar.inertia
    assert isinstance(effect, ThrustEffect)
    return thrust(effect, mp.mpf(t_s), bar) if j == effect.bar else (mp.mpc(0), mp.mpf(0))


def potential(effect: OblatenessEffect | ThirdBodyEffect, t_s: float) -> Callable[[Any], Any]:
    """Potential per unit mass."""
    if isinstance(effect, OblatenessEffect):
        strength = mp.mpf(effect.strength_m5_s2)
        return lambda z: -strength / abs(z) ** 3
    mu, distance = mp.mpf(effect.mu_m3_s2), mp.mpf(effect.distance_m)
    body = distance * mp.expj(mp.mpf(effect.longitude_rad) + mp.mpf(effect.rate_rad_s) * mp.mpf(t_s))
    return lambda z: -mu / abs(z - body) + mu * (mp.conj(body) * z).real / distance**3


def in_field(effect: OblatenessEffect | ThirdBodyEffect, field: Callable[[Any], Any], bar: Bar) -> tuple[Any, Any]:
    """A field's pull on the centre, and what it does to the second moment as far as the effect goes."""
    a, s = -gradient(field, bar.place), mp.mpf(0)
    more, turn = second_moment(field, bar)
    return a + more * effect.second_moment, s + turn * effect.turns


def gradient(field: Callable[[Any], Any], place: Any) -> Any:
    """Of a scalar, differenced in units of the distance."""
    r = abs(place)
    east, north = (mp.diff(lambda x, way=way: field(place + r * x * way), 0) / r for way in (1, mp.mpc(0, 1)))
    return mp.mpc(east, north)


def second_moment(field: Callable[[Any], Any], bar: Bar) -> tuple[Any, Any]:
    """-grad/m and -d/dtheta/J of (J/2) d²/ds² field(Z + s u)."""
    r = abs(bar.place)

    def stored(place: Any, angle: Any) -> Any:
        unit = mp.expj(angle)
        return mp.diff(lambda s: field(place + r * s * unit), 0, 2) / r**2 / 2

    pull = -gradient(lambda z: stored(z, bar.angle), bar.place) * bar.inertia / bar.mass
    return pull, -mp.diff(lambda angle: stored(bar.place, angle), bar.angle)


def along_bar(element: Callable[[Any, Any], Any], bar: Bar) -> tuple[Any, Any]:
    """Acceleration and angular acceleration by accelerations `element(place, s)` of elements, integrated."""
    half = bar.length / 2

    def mean(f: Callable[[Any], Any]) -> Any:
        return mp.quad(f, [-half, half], method="gauss-legendre", maxdegree=DEGREE) / bar.length

    def turning(s: Any) -> Any:
        return s * (mp.conj(bar.unit) * element(bar.place + s * bar.unit, s)).imag

    a = mean(lambda s: element(bar.place + s * bar.unit, s))
    return a, mean(turning) * bar.mass / bar.inertia


def dragged(effect: DragEffect, bar: Bar) -> tuple[Any, Any]:
    """Molecules' push element by element, as docs/effects/drag.md says before it integrates."""
    spinning, height = mp.mpf(effect.rotation_rad_s), mp.mpf(effect.scale_height_m)
    wind = mp.conj(bar.unit) * (bar.motion - mp.mpc(0, 1) * spinning * bar.place)
    r, turning = abs(bar.place), bar.rate - spinning
    density = effect.density_kg_m3 * mp.exp((mp.mpf(effect.radius_m) - r) / height)
    lapse = (mp.conj(bar.unit) * bar.place).real / (r * height)

    def element(_: Any, s: Any) -> Any:
        across = wind.imag + s * turning
        push = mp.mpc(effect.tangential_coefficient * wind.real, effect.normal_coefficient * across)
        per_length = -bar.width / 2 * density * (1 - lapse * s) * mp.sign(wind.imag) * across * push
        return per_length * bar.unit * bar.length / bar.mass

    return along_bar(element, bar)


def lit(effect: SolarPressureEffect, com: Any, bar: Bar, t: Any) -> Any:
    """Light that is absorbed pushes along s, light that is reflected across the bar."""
    sun = mp.expj(mp.mpf(effect.longitude_rad) + mp.mpf(effect.rate_rad_s) * t)
    radius = mp.mpf(effect.shadow_radius_m)
    seen = mp.conj(sun) * com
    if seen.real < 0 and abs(seen.imag) < radius:
        return mp.mpc(0)
    normal = mp.mpc(0, 1) * bar.unit
    facing = (mp.conj(normal) * sun).real
    normal, facing = (normal, facing) if facing > 0 else (-normal, -facing)
    share = mp.mpf(effect.reflectivity)
    area = bar.width * bar.length
    return -effect.pressure_Pa * area * facing / bar.mass * ((1 - share) * sun + 2 * share * facing * normal)


def sprung(effect: JointSpringDamperEffect, state: State, j: int) -> Any:
    """Torque on bar j: -dU/dtheta_j of the springs, and the dampers'."""
    total = mp.mpf(0)
    for joint, sign in ((j - 1, -1), (j, 1)):
        if 0 <= joint < len(effect.rest_rad):
            bent = mp.mpf(state.angle_rad[joint + 1]) - mp.mpf(state.angle_rad[joint]) - mp.mpf(effect.rest_rad[joint])
            opening = mp.mpf(state.rate_rad_s[joint + 1]) - mp.mpf(state.rate_rad_s[joint])
            pull = mp.mpf(effect.stiffness_N_m_rad[joint]) * bent + mp.mpf(effect.damping_N_m_s_rad[joint]) * opening
            total += sign * pull
    return total


def thrust(effect: ThrustEffect, t: Any, bar: Bar) -> tuple[Any, Any]:
    """Force at an end."""
    force = size_in_table(effect, t) * mp.expj(mp.mpf(effect.direction_rad)) * (1 if effect.inertial else bar.unit)
    arm = mp.mpf(effect.side) * bar.length / 2 * bar.unit
    return force / bar.mass, (mp.conj(arm) * force).imag / bar.inertia


def size_in_table(effect: ThrustEffect | JointTorqueEffect, t: Any) -> Any:
    """Size at an instant, by the table read anew."""
    table = list(zip(map(mp.mpf, effect.times_s.tolist()), map(mp.mpf, effect.sizes.tolist()), strict=True))
    size = mp.mpf(0)
    for (t0, f0), (t1, f1) in itertools.pairwise(table):
        if t0 < t <= t1:
            size = (f0 * (t1 - t) + f1 * (t - t0)) / (t1 - t0)
    return size


def energy(effect: ChainEffect, model: ChainModel, state: State) -> float:
    """Potential energy of an effect, J: of the same potentials; of springs, the work to wind them up."""
    with mp.workdps(DIGITS):
        bars, mu = bars_of(effect, model, state), mp.mpf(model.mu_m3_s2)
        if isinstance(effect, SlenderBarEffect):
            return float(sum(bar.mass * (potential_of(mu, bar) + mu / abs(bar.place)) for bar in bars))
        if isinstance(effect, QuadrupoleEffect):
            return float(sum(stretched(lambda z: -mu / abs(z), bar) for bar in bars))
        assert isinstance(effect, OblatenessEffect)
        field = potential(effect, 0.0)
        both = [bar.mass * field(bar.place) + effect.second_moment * stretched(field, bar) for bar in bars]
        return float(sum(both))


def potential_of(mu: Any, bar: Bar) -> Any:
    """Of a uniform bar, per unit mass."""
    half = bar.length / 2
    total = mp.quad(
        lambda s: -mu / abs(bar.place + s * bar.unit), [-half, half], method="gauss-legendre", maxdegree=DEGREE
    )
    return total / bar.length


def stretched(field: Callable[[Any], Any], bar: Bar) -> Any:
    """(J/2) d²/ds² field(Z + s u)."""
    r = abs(bar.place)
    return bar.inertia * mp.diff(lambda s: field(bar.place + r * s * bar.unit), 0, 2) / r**2 / 2
