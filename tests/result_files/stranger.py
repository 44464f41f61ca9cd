"""Program of a stranger, who has read the README of an exported folder and nothing else: folder, table, rtol.

Point gravity with its gradient on the bars, or none; any number of bars. It knows NumPy and SciPy, and not barchain.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

folder, table, rtol = Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3])
problem = json.loads((folder / "scene.json").read_text())
chain, start = problem["scene"]["chain"], problem["start"]
m, length, J = (np.array(chain[key]) for key in ("mass_kg", "length_m", "inertia_kg_m2"))
mu, gravity = problem["scene"]["central_body"]["mu_m3_s2"], problem["scene"]["effects"]["gravity"]
N, h = len(m), length / 2


def geometry(angle):
    """Vectors along and across the bars, and their centres from the centre of mass."""
    u = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    n = np.stack([-u[:, 1], u[:, 0]], axis=1)
    d = np.cumsum(length[:, None] * u, axis=0) - h[:, None] * u
    return u, n, d - m @ d / m.sum()


def forces(Z0, u, n, d):
    """Acceleration of each bar less that of a particle at the centre of mass, that acceleration, and the torques."""
    if gravity == "none":
        return np.zeros((N, 2)), np.zeros(2), np.zeros(N)
    R, Z = np.linalg.norm(Z0), Z0 + d
    q = ((2 * Z0 + d) * d).sum(axis=1) / R**2  # |Z|^2 = R^2 (1 + q)
    r = R * np.sqrt(1 + q)
    tide = -mu / R**3 * (d + np.expm1(-1.5 * np.log1p(q))[:, None] * Z)
    K = 3 * mu * J * (u * Z).sum(axis=1) * (n * Z).sum(axis=1) / r**5 if gravity == "gradient" else np.zeros(N)
    return tide, -mu / R**3 * Z0, K


def reactions(rate, u, n, tide, K):
    """Force on each bar from the next, (N-1, 2)."""
    if N == 1:
        return np.zeros((0, 2))
    A, b, one = np.zeros((N - 1, 2, N - 1, 2)), np.zeros((N - 1, 2)), np.eye(2)
    for j in range(N - 1):
        b[j] = tide[j + 1] - tide[j]
        for bar, other in ((j, j - 1), (j + 1, j + 1)):
            turned = h[bar] ** 2 / J[bar] * np.outer(n[bar], n[bar])
            A[j, :, j] += one / m[bar] + turned
            if 0 <= other < N - 1:
                A[j, :, other] += turned - one / m[bar]
            b[j] -= h[bar] * (K[bar] / J[bar] * n[bar] - rate[bar] ** 2 * u[bar])
    return np.linalg.solve(A.reshape(2 * N - 2, -1), b.ravel()).reshape(-1, 2)


def motion(y):
    """Derivative of (Z0, V0, angles, rates), and the reactions."""
    Z0, V0, angle, rate = y[:2], y[2:4], y[4 : 4 + N], y[4 + N :]
    u, n, d = geometry(angle)
    tide, centre, K = forces(Z0, u, n, d)
    R = np.zeros((N + 1, 2))
    R[1:N] = reactions(rate, u, n, tide, K)
    spin = (K + h * (n * (R[1:] + R[:-1])).sum(axis=1)) / J
    return np.concatenate([V0, centre + m @ tide / m.sum(), rate, spin]), R[1:N]


y0 = np.concatenate([start[key] for key in ("com_m", "com_velocity_m_s", "angle_rad", "rate_rad_s")])
times = problem["sample_times_s"]
size = np.concatenate([np.full(2, 7e6), np.full(2, 7e3), np.ones(N), np.full(N, 1e-3)])
found = solve_ivp(
    lambda t, y: motion(y)[0], (0, times[-1]), y0, method="DOP853", t_eval=times, rtol=rtol, atol=rtol * size * 1e-3
)
header = ["t_s", "com_x_m", "com_y_m", "com_vx_m_s", "com_vy_m_s"]
header += [f"angle_{j}_rad" for j in range(1, N + 1)] + [f"rate_{j}_rad_s" for j in range(1, N + 1)]
header += [f"reaction_{j}_{axis}_N" for j in range(1, N) for axis in "xy"]
with table.open("w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(header)
    writer.writerows([t, *y, *motion(y)[1].ravel()] for t, y in zip(found.t, found.y.T, strict=True))
