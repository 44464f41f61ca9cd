"""Mistakes in the terms of a small engine of own equations, and whether the diagnosis of its own motion names them.

    python benchmarks/planted_terms.py                # all mistakes: three minutes
    python benchmarks/planted_terms.py --only thrust  # those whose names match

Each mistake stands with the words that a right diagnosis contains; no word comes from the diagnosis. A mistake runs in
the scenes in which it shows, each judged alone, and then in agreement.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import re
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import solve_ivp

from adapters.common.initial_state import initial_state
from adapters.trajectory import Trajectory
from barchain.judge.diagnosis.across_scenes import agreed
from barchain.judge.diagnosis.diagnose import Diagnosis
from barchain.judge.diagnosis.mistake import indistinguishable
from barchain.judge.diagnosis.own_motion import OwnMotion
from barchain.solutions.reference import closely_sampled
from scenarios import Axes, End, load_scene

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array
    from scenarios import Scene

FREE, GRADIENT, ECCENTRIC = ("two_bars_free", "three_bars_free"), ("three_bars_gradient", "eccentric"), ("eccentric",)
SPRINGS, BODY, INERTIAL, J2 = ("joint_springs_alone",), ("thrust_body",), ("thrust_inertial",), ("oblateness_alone",)


@dataclass(frozen=True)
class Terms:
    """Numbers of the engine's equations; the defaults are right."""

    own_gravity: tuple[float, float] = (0.0, 0.0)
    centre_without: str = ""
    """Load without which the centre of mass moves"""
    first_order_tide: bool = False
    gradient: float = 1.0
    gradient_of_start: bool = False
    joint: float = 0.5
    """Distance of a joint from the bar's centre, in lengths"""
    armature: float = 0.0
    root_damping: float = 0.0
    damper: float = 1.0
    inertial_damper: bool = False
    stray_damping: float = 0.0
    rest: tuple[float, ...] = ()
    """Factors of the rest angles"""
    arm: tuple[float, ...] = ()
    """Factors of the arms of thrusts"""
    thrust_turned: tuple[float, ...] = ()
    """Angles added to the directions of thrusts, rad"""
    centrifugal: float = 1.0
    reactions_without_thrust: bool = False
    reversed_reactions: bool = False
    """Masses in reversed order in the reactions"""
    j2_radius_m: float = 0.0
    j2_at_centre: bool = False
    """Whether the force of J2 is the same for all bars"""
    centre_by_length: bool = False
    """Whether places count from the bars' mean place by their lengths"""
    straight_matrix: bool = False
    """Whether the mass matrix is that of a straight chain"""
    relative_rates: bool = False
    """Whether the centrifugal torque takes rates relative to the bar before"""
    rtol: float = 1.0


@dataclass(frozen=True)
class Planted:
    """One mistake."""

    name: str
    words: str
    """Regular expression of the right words"""
    scenes: tuple[str, ...]
    terms: Terms = field(default_factory=Terms)
    read: Callable[[Trajectory], Trajectory] = lambda t: t


class SmallEngine:
    """The chain in inertial angles about its centre of mass, by its matrix of masses and SciPy's DOP853."""

    def __init__(self, scene: Scene, terms: Terms) -> None:
        """Masses, lengths, and vectors from the chain's centre to the bars'."""
        self.scene, self.terms = scene, terms
        self.m, self.l, self.j = (
            np.array(v) for v in (scene.chain.mass_kg, scene.chain.length_m, scene.chain.inertia_kg_m2)
        )
        n, near = len(self.m), self.l * (1.0 - terms.joint)
        far = self.l * terms.joint
        chain = np.tril(np.tile(near + far, (n, 1)), -1) + np.diag(near)
        weight = self.l if terms.centre_by_length else self.m
        self.a = chain - (weight / weight.sum()) @ chain
        self.g = self.a.T @ (self.m[:, None] * self.a)
        self.start = scene.radius0_m

    def loads(self, t: float, z: complex, th: Array, w: Array) -> tuple[complex, Array, Array, Array]:
        """Acceleration of the centre of mass, forces less their common part, torques, and thrusts, at a state."""
        e, p, mu = self.scene.effects, self.terms, self.scene.central_body.mu_m3_s2
        u, n = np.exp(1j * th), len(th)
        d, force, torque = self.a @ u, np.zeros(n, complex), np.zeros(n)
        centre, thrusts = complex(*p.own_gravity), np.zeros(n, complex)
        if e.gravity != "none":
            r, place = abs(z), z + d
            centre -= mu * z / r**3
            linear = -mu / r**3 * (d - 3.0 * z * (z.conjugate() * d).real / r**2)
            tide = linear if p.first_order_tide else -mu * (place / abs(place) ** 3 - z / r**3)
            force += self.m * tide
            n2 = mu / (self.start**3 if p.gradient_of_start else abs(place) ** 3)
            seen = u.conj() * place / abs(place)
            torque += p.gradient * 3.0 * n2 * self.j * seen.real * seen.imag
            if e.oblateness:
                b = 1.5 * mu * e.oblateness.j2 * (p.j2_radius_m or e.oblateness.radius_m) ** 2
                centre -= 0.0 if p.centre_without == "j2" else b * z / r**5
                force -= 0.0 if p.j2_at_centre else self.m * b * (place / abs(place) ** 5 - z / r**5)
                torque += 5.0 * b / abs(place) ** 5 * self.j * seen.real * seen.imag
        if e.joint_spring_damper:
            s = e.joint_spring_damper
            rest = np.array(s.rest_rad) * (p.rest or 1.0)
            turning = w[1:] if p.inertial_damper else np.diff(w)
            on = s.stiffness_N_m_rad * (np.diff(th) - rest) + p.damper * np.array(s.damping_N_m_s_rad) * turning
            torque[:-1] += on
            torque[1:] -= on
        for k, push in enumerate(e.thrust):
            turned = p.thrust_turned[k] if p.thrust_turned else 0.0
            bar, way = push.bar - 1, push.size_N(t) * np.exp(1j * (push.direction_rad + turned))
            way *= u[bar] if push.axes is Axes.BODY else 1.0
            arm = 0.5 * self.l[bar] * (1.0 if push.end is End.RIGHT else -1.0) * (p.arm[k] if p.arm else 1.0)
            thrusts[bar] += way
            torque[bar] += arm * (u[bar].conjugate() * way).imag
        torque[:-1] += p.stray_damping * np.diff(w)
        torque[1:] -= p.stray_damping * np.diff(w)
        torque[0] -= p.root_damping * w[0]
        return centre, force, torque, thrusts

    def accelerations(self, t: float, y: Array) -> tuple[complex, Array, Array, Array]:
        """Accelerations of the centre of mass and of the angles, with forces and thrusts."""
        n = len(self.m)
        th, w = y[4 : 4 + n], y[4 + n :]
        centre, force, torque, thrusts = self.loads(t, complex(*y[:2]), th, w)
        apart = th[:, None] - th[None, :]
        matrix = self.g * (1.0 if self.terms.straight_matrix else np.cos(apart)) + np.diag(self.j)
        turning = np.diff(w, prepend=0.0) if self.terms.relative_rates else w
        joined = np.zeros((n, n))
        for k in range(n - 1):
            joined[k : k + 2, k : k + 2] += np.array([[1.0, -1.0], [-1.0, 1.0]])
        matrix = matrix + self.terms.armature * joined
        whole = force + thrusts
        given = torque + (np.exp(-1j * th) * (self.a.T @ whole)).imag
        given -= self.terms.centrifugal * (self.g * np.sin(apart)) @ turning**2
        mean = (force.sum() + (0.0 if self.terms.centre_without == "thrust" else thrusts.sum())) / self.m.sum()
        return centre + mean, np.linalg.solve(matrix, given), force, thrusts

    def reactions(self, y: Array, turning: Array, force: Array, thrusts: Array) -> Array:
        """Force on each bar from the next one, summed from the first bar."""
        n = len(self.m)
        th, w, m = y[4 : 4 + n], y[4 + n :], self.m[::-1] if self.terms.reversed_reactions else self.m
        moved = self.a @ (np.exp(1j * th) * (1j * turning - w**2))
        known = force + (0.0 if self.terms.reactions_without_thrust else thrusts)
        apart = known / self.m - (force + thrusts).sum() / self.m.sum()
        found: Array = np.cumsum(m * (moved - apart))[:-1]
        return found

    def run(self, scene: Scene, rtol: float) -> Trajectory:
        """Result at the samples of a scene, restarted at each break."""
        s, t, n = initial_state(scene), scene.times_s, scene.bars
        y = np.concatenate([s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s])
        size = np.concatenate([np.full(2, scene.radius0_m), np.full(2, scene.speed0_m_s), np.ones(n),
                               np.full(n, scene.fastest_rate_rad_s)])  # fmt: skip
        cuts = [0.0, *(b for b in scene.effects.breaks_s if 0.0 < b < t[-1]), float(t[-1])]
        rows = [y]
        for a, b in itertools.pairwise(cuts):
            inside = 1e-9 * (b - a)
            at = np.minimum(t[(t > a + inside) & (t <= b + inside)], b)

            def slope(now: float, y: Array, a: float = a, b: float = b, inside: float = inside) -> Array:
                centre, turning, _, _ = self.accelerations(min(max(now, a + inside), b - inside), y)
                return np.concatenate([y[2:4], [centre.real, centre.imag], y[4 + n :], turning])

            made = solve_ivp(
                slope,
                (a, b),
                y,
                "DOP853",
                [*at, *([b] if at.size == 0 or at[-1] < b else [])],
                rtol=1e-13,
                atol=rtol * size,
            )
            rows += list(made.y.T[: len(at)])
            y = made.y[:, -1]
        states = np.array(rows)
        forces = [self.accelerations(x * (1.0 - 1e-12), y) for x, y in zip(t, states, strict=True)]
        reactions = np.array([self.reactions(y, *f[1:]) for y, f in zip(states, forces, strict=True)])
        return Trajectory(t, states[:, :2], states[:, 2:4], states[:, 4 : 4 + n], states[:, 4 + n :],
                          np.stack([reactions.real, reactions.imag], -1))  # fmt: skip


PLANTED = (
    Planted("none", "", (*FREE, *GRADIENT, *SPRINGS, *BODY, *INERTIAL, *J2)),
    Planted("own gravity left on", "9\\.81.*-z2", GRADIENT, Terms(own_gravity=(0.0, -9.81))),
    Planted("centre of mass without thrust", "thrust.*missing.*centre of mass|centre of mass.*thrust", BODY,
            Terms(centre_without="thrust")),
    Planted("centre of mass without J2", "oblateness.*missing|oblateness.*zero", J2, Terms(centre_without="j2")),
    Planted("tide of first order", "first order", GRADIENT, Terms(first_order_tide=True)),
    Planted("gradient with the mean motion at the start", "gradient.*(start|mean motion)", ECCENTRIC,
            Terms(gradient_of_start=True)),
    Planted("gradient 2/3", "gradient is 0\\.6666", GRADIENT, Terms(gradient=2.0 / 3.0)),
    Planted("joints at 0.501 l", "joint|arm|reach", (*FREE, *GRADIENT), Terms(joint=0.501)),
    Planted("armature", "armature", GRADIENT, Terms(armature=500.0)),
    Planted("root damping", "root|bar 1.*inertial", GRADIENT, Terms(root_damping=30.0)),
    Planted("joint damping", "joints.*(friction|damping)", GRADIENT, Terms(stray_damping=7.0)),
    Planted("damping per degree", "damp.*(degree|57\\.29)", SPRINGS, Terms(damper=180.0 / np.pi)),
    Planted("damping by inertial rates", "damp.*inertial", SPRINGS, Terms(inertial_damper=True)),
    Planted("rest angle of joint 2 opposite", "rest angle of joint 2 is of the opposite", SPRINGS,
            Terms(rest=(1.0, -1.0))),
    Planted("torque of thrust 1 at 0.98", "torque of the thrust 1 is 0\\.98", BODY, Terms(arm=(0.98, 1.0))),
    Planted("direction of thrust 2 off by 1 degree", "direction of the thrust 2 is off by 1 deg", INERTIAL,
            Terms(thrust_turned=(0.0, np.radians(1.0)))),
    Planted("torques of thrusts halved", "torque.*thrusts is half", INERTIAL, Terms(arm=(0.5, 0.5))),
    Planted("centrifugal terms halved", "centrifugal.*half", GRADIENT, Terms(centrifugal=0.5)),
    Planted("centrifugal terms by relative rates", "centrifugal.*relative to the bar before", FREE,
            Terms(relative_rates=True)),
    Planted("mass matrix of a straight chain", "mass matrix lacks the cosine", FREE, Terms(straight_matrix=True)),
    Planted("centre of mass by lengths", "centre of mass.*lengths", FREE, Terms(centre_by_length=True)),
    Planted("J2 alike on all bars", "force of the oblateness.*centre of mass", J2, Terms(j2_at_centre=True)),
    Planted("reactions without thrust", "reactions.*lack.*thrust|thrust.*reactions alone", BODY,
            Terms(reactions_without_thrust=True)),
    Planted("masses reversed in the reactions", "masses.*revers.*reactions", FREE, Terms(reversed_reactions=True)),
    Planted("J2 with the mean radius", "(radius of J2|J2).*6371", J2, Terms(j2_radius_m=6.371e6)),
)  # fmt: skip


def examined(p: Planted) -> tuple[dict[str, Diagnosis], float]:
    """Diagnoses of the scenes of a mistake in agreement, and their processor time, s."""
    start, found, motions = time.process_time(), {}, {}
    for name in p.scenes:
        scene = closely_sampled(load_scene(f"conform/{name}"))
        engine = SmallEngine(scene, p.terms)

        def runs(one: Scene, two: Scene, engine: SmallEngine = engine) -> tuple[Trajectory, Trajectory]:
            return p.read(engine.run(one, 1e-9)), p.read(engine.run(two, 1e-10))

        own = OwnMotion(scene, p.read(engine.run(scene, 1e-9)), runs)
        equal = indistinguishable(own.explaining)
        diagnosis = Diagnosis((), equal, None, (), own.nearest)
        found[name], motions[name] = dataclasses.replace(diagnosis, own=own), own
    return agreed(found, motions), time.process_time() - start


def verdict(p: Planted, found: dict[str, Diagnosis]) -> tuple[str, str]:
    """Whether diagnoses name a mistake, and their words."""
    said = {name: "; or ".join(e.words for e in d.explanations[:3]) or d.nearest for name, d in found.items()}
    named = [d for d in found.values() if d.explanations]
    right = [d for d in named if re.search(p.words, d.explanations[0].words, re.I)]
    words = " / ".join(f"{name}: {text}" for name, text in said.items() if text)
    if not p.words:
        return ("right" if not words else "misnamed"), words
    if named:
        return ("named" if len(right) == len(named) else "one of several" if right else "misnamed"), words
    return ("nearest" if re.search(p.words, words, re.I) else "detected" if words else "conforms"), words


def main() -> None:
    """Plant the mistakes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", help="Regular expression of names.")
    only, counts = parser.parse_args().only, dict[str, int]()
    for p in (p for p in PLANTED if re.search(only, p.name)):
        found, seconds = examined(p)
        state, words = verdict(p, found)
        counts[state] = counts.get(state, 0) + 1
        print(f"| {p.name} | {state} | {words[:400]} | {seconds:.1f} s |", flush=True)
    print(counts)


if __name__ == "__main__":
    main()
