"""A chain of rigid bars in orbit: reads a request of barchain, writes samples and a result. It needs NumPy alone.

Unknowns are the place and velocity of the centre of mass, and each bar's angle and rate, so joints stay closed. The
reactions solve a linear system. Runge-Kutta of order 4, equal steps. Vectors are complex numbers.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np


class Chain:
    """Bars under the gravity of a scene."""

    def __init__(self, scene: dict[str, Any]) -> None:
        self.mu = scene["central_body"]["mu_m3_s2"]
        self.mass, self.length, self.inertia = (
            np.array(scene["chain"][name]) for name in ("mass_kg", "length_m", "inertia_kg_m2")
        )
        gravity = scene["effects"]["gravity"]
        self.attracted, self.gradient = gravity != "none", gravity == "gradient"

    def derivative(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivative of the state [centre of mass, its velocity, angles, rates], and reactions from the next bar."""
        n, h, mass = len(self.mass), self.length / 2, self.mass
        com, u, rate = y[0] + 1j * y[1], np.exp(1j * y[4 : 4 + n]), y[4 + n :]
        d = np.cumsum(h * u) + np.append(0, np.cumsum(h[:-1] * u[:-1]))  # from the first bar's left end on
        d -= (mass @ d) / mass.sum()
        r0 = abs(com)
        pull = self.mu / r0**3 if self.attracted else 0.0
        z = com + d
        q = ((com + z) * d.conj()).real / r0**2
        g = -pull * (
            d + np.expm1(-1.5 * np.log1p(q)) * z
        )  # less that at the centre of mass: no large numbers subtracted
        moment = (u * z.conj()).real * (1j * u * z.conj()).real / r0**2
        torque = self.gradient * 3 * pull * (1 + q) ** -2.5 * self.inertia * moment
        # Accelerations of both ends of each bar without reactions, and what a force at an end adds at either end.
        turn = h * (1j * torque / self.inertia - rate**2) * u
        right = g[1:] - turn[1:] - (g[:-1] + turn[:-1])
        a = np.zeros((2 * n - 2, 2 * n - 2))
        for bar in range(n):
            across = h[bar] * np.array([-u[bar].imag, u[bar].real])
            near = np.eye(2) / mass[bar] + np.outer(across, across) / self.inertia[bar]
            far = -np.eye(2) / mass[bar] + np.outer(across, across) / self.inertia[bar]
            left_joint, right_joint = slice(2 * bar - 2, 2 * bar), slice(2 * bar, 2 * bar + 2)
            if bar > 0:
                a[left_joint, left_joint] += near
            if bar < n - 1:
                a[right_joint, right_joint] += near
            if 0 < bar < n - 1:
                a[left_joint, right_joint] = a[right_joint, left_joint] = far
        force = np.linalg.solve(a, np.column_stack([right.real, right.imag]).ravel())
        reaction = force[::2] + 1j * force[1::2]
        both = np.append(reaction, 0) + np.append(0, reaction)
        acceleration = (mass @ g) / mass.sum() - pull * com
        turned = (torque + h * (1j * u * both.conj()).real) / self.inertia
        return np.concatenate([y[2:4], [acceleration.real, acceleration.imag], rate, turned]), reaction

    def step(self, y: np.ndarray, h: float) -> np.ndarray:
        """State a step later."""
        k1 = self.derivative(y)[0]
        k2 = self.derivative(y + h / 2 * k1)[0]
        k3 = self.derivative(y + h / 2 * k2)[0]
        k4 = self.derivative(y + h * k3)[0]
        after: np.ndarray = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return after


request_file, samples_file, result_file = sys.argv[1:]
request = json.loads(Path(request_file).read_text(encoding="utf-8"))
chain, start = Chain(request["scene"]), request["start"]
y = np.concatenate([start[name] for name in ("com_m", "com_velocity_m_s", "angle_rad", "rate_rad_s")])
t, h = request["sample_times_s"], request["setting"]["step_s"]

rows, steps, begun = [], 0, time.perf_counter()
for k in range(len(t)):
    for _ in range(round((t[k] - t[k - 1]) / h) if k else 0):
        y = chain.step(y, h)
        steps += 1
    reaction = chain.derivative(y)[1]
    rows.append([t[k], *y, *np.column_stack([reaction.real, reaction.imag]).ravel()])
seconds = time.perf_counter() - begun

bars = range(1, request["bars"] + 1)
names = ["t_s", "com_x_m", "com_y_m", "com_vx_m_s", "com_vy_m_s"]
names += [f"angle_{j}_rad" for j in bars] + [f"rate_{j}_rad_s" for j in bars]
names += [f"reaction_{j}_{axis}_N" for j in bars[:-1] for axis in "xy"]
np.savetxt(samples_file, rows, fmt="%.17g", delimiter=",", header=",".join(names), comments="")
Path(result_file).write_text(json.dumps({"version": 1, "seconds": seconds, "steps": steps}), encoding="utf-8")
