"""A chain of rigid bars in JaxSim: reads a request of barchain, writes samples and a result.

JaxSim's articulated-body algorithm gives the accelerations of a tree with a free base; a Runge-Kutta method of order 4
with equal steps, compiled by JAX with it, integrates them. Frame: axes of fixed direction on the Kepler orbit of the
centre of mass, so that gravity is the field at a bar less that at the origin. Coordinates q (N + 2,): place of bar 1's
left end, its angle, and the angle at each joint.

    python chain.py REQUEST.json SAMPLES.csv RESULT.json

Steps are those of the request (`step_s`), or 2000 in `step_period_s`. It needs the package jaxsim (0.9 or later), and
no part of barchain.
"""

import json
import math
import os
import sys
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

HALVINGS = 80
"""Of an interval of the anomaly: more than its digits"""
LEAST_AN_ORBIT = 2000
"""Steps in `step_period_s`, where the request has no step"""


class Chain:
    """Bars of a request, their places in the frame, and the forces on them, in NumPy or in JAX."""

    def __init__(self, request: dict[str, Any]) -> None:
        self.scene, chain = request["scene"], request["scene"]["chain"]
        self.mass, self.length, self.inertia = (
            np.array(chain[name]) for name in ("mass_kg", "length_m", "inertia_kg_m2")
        )
        share = chain.get("com_share") or 0.5
        self.lever = np.broadcast_to(share, self.mass.shape) * self.length
        """From a bar's left end to its centre of mass, m"""
        self.effects = self.scene["effects"]
        self.gravity = self.effects["gravity"]
        self.mu = 0.0 if self.gravity == "none" else self.scene["central_body"]["mu_m3_s2"]

    @property
    def sdf(self) -> str:
        """The chain as a model: the frame of each link is at the bar's left end, along the bar."""
        found = '<sdf version="1.10"><model name="chain">'
        rows = zip(self.mass.tolist(), self.inertia.tolist(), self.lever.tolist(), self.length.tolist(), strict=True)
        for j, (mass, inertia, lever, length) in enumerate(rows, 1):
            # the same inertia about all axes: about a thin rod's own axis it would be 0, and the base's matrix singular
            turned = "".join(f"<i{axes}>{inertia!r}</i{axes}>" for axes in ("xx", "yy", "zz"))
            place = f'<pose relative_to="joint{j - 1}">0 0 0 0 0 0</pose>' if j > 1 else ""
            found += f'<link name="bar{j}">{place}<inertial><pose>{lever!r} 0 0 0 0 0</pose><mass>{mass!r}</mass>'
            found += f"<inertia>{turned}<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial></link>"
            if j < len(self.mass):
                found += f'<joint name="joint{j}" type="continuous"><parent>bar{j}</parent><child>bar{j + 1}</child>'
                found += f'<pose relative_to="bar{j}">{length!r} 0 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint>'
        return found + "</model></sdf>"

    def along_bars(self, base: Any, along: Any) -> Any:
        """Centres (..., N, 2) of bars along `along` from an end at `base` (..., 2), or derivatives of both."""
        length, lever = self.length[:, None], self.lever[:, None]
        return base[..., None, :] + library(along).cumsum(length * along, axis=-2) - (length - lever) * along

    def bars(self, q: Any, q_t: Any) -> tuple[Any, Any, Any, Any]:
        """Angles and rates (..., N), directions and centres in the frame (..., N, 2)."""
        lib = library(q)
        angle, rate = lib.cumsum(q[..., 2:], axis=-1), lib.cumsum(q_t[..., 2:], axis=-1)
        along = lib.stack([lib.cos(angle), lib.sin(angle)], axis=-1)
        return angle, rate, along, self.along_bars(q[..., :2], along)

    def moved(self, q: Any, q_t: Any) -> tuple[Any, Any]:
        """Place and velocity of the chain's centre of mass in the frame, each (..., 2)."""
        _, rate, along, centre = self.bars(q, q_t)
        velocity = self.along_bars(q_t[..., :2], rate[..., None] * left_of(along))
        share = (self.mass / self.mass.sum())[:, None]
        return (share * centre).sum(-2), (share * velocity).sum(-2)

    def loads(self, t: Any, inside: Any, origin: Any, along: Any, centre: Any) -> tuple[Any, Any]:
        """Force (N, 2) and torque (N,) on the bars of all effects but those in the joints.

        `inside` is an instant in the step: of a table in time the segment that contains it counts.
        """
        lib, place, effects = library(centre), origin + centre, self.effects
        force, torque = 0.0 * centre, 0.0 * centre[:, 0]
        fields = [(self.mu, 3, place, difference(self.mu, 3, origin, centre))] if self.mu else []
        if flat := effects.get("oblateness"):
            strength = 1.5 * self.scene["central_body"]["mu_m3_s2"] * flat["j2"] * flat["radius_m"] ** 2
            fields.append((strength, 5, place, -strength * place / norm(place) ** 5))
        for body in effects.get("third_body", ()):
            longitude = body["longitude_rad"] + body["rate_rad_s"] * t
            source = body["distance_m"] * lib.stack([lib.cos(longitude), lib.sin(longitude)])
            fields.append((body["mu_m3_s2"], 3, place - source, difference(body["mu_m3_s2"], 3, -source, place)))
        for strength, power, from_source, pull in fields:
            force += self.mass[:, None] * pull
            if self.gravity in ("gradient", "quadrupole"):
                turn, beyond = extended(strength, power, from_source, along)
                torque += self.inertia * turn
                force += self.inertia[:, None] * beyond * (self.gravity == "quadrupole")
        for thrust in effects.get("thrust", ()):
            j, aim = thrust["bar"] - 1, thrust["direction_rad"]
            u = along[j] if thrust["axes"] == "body" else np.array([1.0, 0.0])
            pushed = size(lib, thrust["times_s"], thrust["force_N"], t, inside)
            pushed = pushed * (np.cos(aim) * u + np.sin(aim) * left_of(u))
            arm = self.length[j] - self.lever[j] if thrust["end"] == "right" else -self.lever[j]
            here = np.arange(len(self.mass)) == j
            force += here[:, None] * pushed
            torque += here * arm * (left_of(along[j]) * pushed).sum()
        return force, torque

    def joint_torques(self, t: Any, inside: Any, bend: Any, turning: Any) -> Any:
        """Torque of springs, dampers and motors on the later bar of each joint, (N - 1,)."""
        torque = 0.0 * bend
        if spring := self.effects.get("joint_spring_damper"):
            names = ("stiffness_N_m_rad", "damping_N_m_s_rad", "rest_rad")
            stiffness, damping, rest = (np.array(spring[name]) for name in names)
            torque += -stiffness * (bend - rest) - damping * turning
        for motor in self.effects.get("joint_torque", ()):
            now = size(library(bend), motor["times_s"], motor["torque_N_m"], t, inside)
            torque += (np.arange(len(self.mass) - 1) == motor["joint"] - 1) * now
        return torque


def library(array: Any) -> Any:
    """NumPy or jax.numpy, whose array this is."""
    return array.__array_namespace__()


def norm(vector: Any) -> Any:
    """Lengths (..., 1) of vectors (..., 2)."""
    return library(vector).sqrt((vector**2).sum(-1, keepdims=True))


def left_of(vector: Any) -> Any:
    """Vectors (..., 2) turned by +90 degrees."""
    return library(vector).stack([-vector[..., 1], vector[..., 0]], axis=-1)


def difference(strength: float, power: int, origin: Any, moved: Any) -> Any:
    """The field -A Z/r^n at `origin` + `moved` (N, 2) less that at `origin` (2,), by Encke's q: nothing cancels."""
    lib, r2 = library(moved), (origin**2).sum()
    change = lib.expm1(-0.5 * power * lib.log1p(((2.0 * origin + moved) * moved).sum(-1, keepdims=True) / r2))
    return -strength * r2 ** (-0.5 * power) * (moved + (origin + moved) * change)


def extended(strength: float, power: int, place: Any, along: Any) -> tuple[Any, Any]:
    """Torque (N,) of the field's gradient on a bar, and force (N, 2) beyond that on its mass, for an inertia of 1."""
    r = norm(place)
    p, q = ((each * place).sum(-1, keepdims=True) for each in (along, left_of(along)))
    k = power * strength / r ** (power + 2)
    beyond = 0.5 * k * (place + 2.0 * p * along - (power + 2) * (p / r) ** 2 * place)
    return (k * p * q)[:, 0], beyond


def size(lib: Any, times: list[float], sizes: list[float], t: Any, inside: Any) -> Any:
    """Size at `t` on the segment of a table in time that contains `inside`; 0 outside the table."""
    points = pairwise(zip(times, sizes, strict=True))
    return sum(
        lib.where((a < inside) & (inside < b), f + (g - f) * ((t - a) / (b - a)), 0.0)
        for (a, f), (b, g) in points if a < b
    )  # fmt: skip


def orbit(mu: float, place: Any, velocity: Any, t: Any) -> tuple[Any, Any]:
    """Place and velocity (n, 2) of a particle at t (n,), s, on any conic, or without a force.

    With the anomaly s, ds = dt/r, and G_k = s^k c_k(beta s²), beta = 2 mu/r0 - v0²:
    t = r0 G1 + eta G2 + mu G3 rises with s, as its derivative is r.
    """
    if not mu:
        return place + t[:, None] * velocity, np.tile(velocity, (len(t), 1))
    r0, eta = np.hypot(*place), place @ velocity
    beta = 2.0 * mu / r0 - velocity @ velocity

    def functions(s: Any) -> tuple[Any, Any, Any, Any]:
        if not beta:
            return np.ones_like(s), s, s**2 / 2.0, s**3 / 6.0
        w, x = np.sqrt(complex(beta)), beta * s**2
        g1 = (np.sin(w * s) / w).real
        near = s**3 * sum((-x) ** k / math.factorial(2 * k + 3) for k in range(9))  # on a parabola s - G1 cancels
        g3 = np.where(np.abs(x) < 1.0, near, (s - g1) / beta)
        return np.cos(w * s).real, g1, (2.0 * (np.sin(0.5 * w * s) / w) ** 2).real, g3

    def late(s: Any) -> Any:
        _, g1, g2, g3 = functions(s)
        return r0 * g1 + eta * g2 + mu * g3 > t

    high = np.full(len(t), 1e-3 * t[-1] / r0)
    while not late(high)[-1]:
        high = 2.0 * high
    low = 0.0 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        beyond = late(middle)
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    g0, g1, g2, _ = (each[:, None] for each in functions(low))
    r = r0 * g0 + eta * g1 + mu * g2
    return (
        place + (r0 * g1 + eta * g2) * velocity - mu / r0 * g2 * place,
        velocity - mu * g2 / r * velocity - mu / (r * r0) * g1 * place,
    )


def accelerations_of(chain: Chain) -> Callable[..., tuple[Any, Any]]:
    """Function of an instant, the origin and a state: second derivatives of q (N + 2,), and joint forces (N - 1, 2)."""
    import jax.numpy as jnp
    import jaxsim.api as js
    from jaxsim.rbda import aba

    build = js.model.JaxSimModel.build_from_model_description
    model = build(chain.sdf, is_urdf=False, parametrized_links=())
    parameters = model.kin_dyn_parameters

    def accelerations(t: Any, inside: Any, origin: Any, q: Any, q_t: Any) -> tuple[Any, Any]:
        angle, rate, along, centre = chain.bars(q, q_t)
        force, torque = chain.loads(t, inside, origin, along, centre)
        c, s, w = jnp.cos(angle[0]), jnp.sin(angle[0]), rate[0]
        (x, y), (vx, vy) = q[:2], q_t[:2]
        base = jnp.array([[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
        half = 0.5 * angle[0]
        # velocities, accelerations and moments are those of the body's point at the frame's origin
        moment = torque + centre[:, 0] * force[:, 1] - centre[:, 1] * force[:, 0]
        at_origin, bend_tt = aba(
            model,
            base_position=jnp.array([x, y, 0.0]),
            base_quaternion=jnp.array([jnp.cos(half), 0.0, 0.0, jnp.sin(half)]),
            joint_positions=q[3:],
            base_linear_velocity=jnp.array([vx + w * y, vy - w * x, 0.0]),
            base_angular_velocity=jnp.array([0.0, 0.0, w]),
            joint_velocities=q_t[3:],
            joint_transforms=parameters.joint_transforms(joint_positions=q[3:], base_transform=base),
            joint_forces=chain.joint_torques(t, inside, q[3:], q_t[3:]),
            link_forces=jnp.concatenate([force, np.zeros((len(force), 3)), moment[:, None]], axis=1),
            standard_gravity=0.0,  # 9.8 m/s² by default
        )
        ax, ay, w_t = at_origin[0], at_origin[1], at_origin[5]
        end_tt = jnp.array([ax - w_t * y - w * vy, ay + w_t * x + w * vx, w_t])
        q_tt = jnp.concatenate([end_tt, bend_tt])
        bar_tt = jnp.cumsum(q_tt[2:])[:, None] * left_of(along) - (rate**2)[:, None] * along
        gained = chain.mass[:, None] * chain.along_bars(q_tt[:2], bar_tt) - force
        return q_tt, jnp.cumsum(gained, axis=0)[:-1]  # Newton's law for all bars up to the joint

    return accelerations


def compiled_run(
    accelerations: Callable[..., Any], track: Any, step_s: float, every: int, start: Any
) -> Callable[..., Any]:
    """Function from the state (2, N + 2) at the start to states and joint forces at all samples.

    The classical Runge-Kutta method of order 4. Its stages are a loop, with a fifth for the joint forces at a sample,
    so that accelerations are compiled once. `track` has the origin at each half of a step, and a sample is taken after
    each `every` steps.
    """
    import jax
    import jax.numpy as jnp

    origin, samples = jnp.array(track), (len(track) - 1) // (2 * every) + 1
    ahead, half = jnp.array([0.0, 0.5, 0.5, 1.0, 0.0]), jnp.array([0, 1, 1, 2, 2])
    weight = jnp.array([1.0, 2.0, 2.0, 1.0, 0.0]) / 6.0

    def step(k: Any, carried: Any, h: Any, end: Any) -> Any:
        """State after step `k`, which takes `h` s, and the joint forces there if the next step is `end`."""
        state, force = carried

        def stage(i: Any, found: Any) -> Any:
            slope, total, _ = found
            q, q_t = state + h * (ahead[i] * slope + (i == 4) * total)
            middle, later = jnp.maximum(k, 0) + 0.5, 2 * k + half[i]  # an event at a sample is yet to come
            q_tt, force = accelerations(0.5 * step_s * later, step_s * middle, origin[later], q, q_t)
            slope = jnp.stack([q_t, q_tt])
            return slope, total + weight[i] * slope, force

        none, stages = 0.0 * state, jnp.where(k + 1 == end, 5, 4)
        _, total, force = jax.lax.fori_loop(0, stages, stage, (none, none, force))
        return state + h * total, force

    def sample(carried: Any, k: Any) -> tuple[Any, Any]:
        """State and joint forces at sample `k`; the first one is the end of a step of no length."""
        begin, end, h = jnp.where(k == 0, -1, (k - 1) * every), k * every, jnp.where(k == 0, 0.0, step_s)
        after = jax.lax.fori_loop(begin, end, lambda i, now: step(i, now, h, end), carried)
        return after, after

    def run(state: Any) -> Any:
        nothing = jnp.zeros((state.shape[1] - 3, 2))
        return jax.lax.scan(sample, (state, nothing), jnp.arange(samples))[1]

    compiled: Callable[..., Any] = jax.jit(run).lower(start).compile()
    return compiled


def simulate(request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Result, and columns of the samples."""
    os.environ |= {"JAX_PLATFORMS": "cpu", "JAX_ENABLE_X64": "1"}  # read when JAX is imported
    chain, start, t = Chain(request), request["start"], np.array(request["sample_times_s"])
    setting, begun = request["setting"], time.perf_counter()
    every = max(1, round((t[1] - t[0]) / (setting["step_s"] or setting["step_period_s"] / LEAST_AN_ORBIT)))
    h, steps = (t[1] - t[0]) / every, every * (len(t) - 1)
    halves = 0.5 * h * np.arange(2 * steps + 1)
    track, drift = orbit(chain.mu, np.array(start["com_m"]), np.array(start["com_velocity_m_s"]), halves)
    seconds = time.perf_counter() - begun

    angle, rate = np.array(start["angle_rad"]), np.array(start["rate_rad_s"])
    first = np.array([[0.0, 0.0, each[0], *np.diff(each)] for each in (angle, rate)])
    first[:, :2] = -np.array(chain.moved(*first))
    run = compiled_run(accelerations_of(chain), track, h, every, first)
    begun = time.perf_counter()
    state, force = (np.array(each) for each in run(first))
    seconds += time.perf_counter() - begun

    q, q_t = state[:, 0], state[:, 1]
    angle, rate, *_ = chain.bars(q, q_t)
    place, velocity = (a[:: 2 * every] + b for a, b in zip((track, drift), chain.moved(q, q_t), strict=True))
    columns = {"t_s": t, "com_x_m": place[:, 0], "com_y_m": place[:, 1]}
    columns |= {"com_vx_m_s": velocity[:, 0], "com_vy_m_s": velocity[:, 1]}
    for j in range(len(chain.mass)):
        columns |= {f"angle_{j + 1}_rad": angle[:, j], f"rate_{j + 1}_rad_s": rate[:, j]}
    for j in range(len(chain.mass) - 1):
        columns |= {f"reaction_{j + 1}_x_N": force[:, j, 0], f"reaction_{j + 1}_y_N": force[:, j, 1]}
    result: dict[str, Any] = {"version": 1, "seconds": seconds, "steps": steps, "evaluations": 4 * steps}
    if np.hypot(*place.T).min() < request["scene"]["central_body"]["radius_m"] + chain.length.sum():
        result |= {"outcome": "unsupported", "reason": "the chain comes near the surface, and no event is located"}
    return result, columns


def main() -> None:
    """Run the request."""
    request_file, samples_file, result_file = sys.argv[1:]
    result, columns = simulate(json.loads(Path(request_file).read_text(encoding="utf-8")))
    rows = np.column_stack(list(columns.values()))
    np.savetxt(samples_file, rows, fmt="%.17g", delimiter=",", header=",".join(columns), comments="")
    Path(result_file).write_text(json.dumps(result), encoding="utf-8")


if __name__ == "__main__":
    main()
