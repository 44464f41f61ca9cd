"""A chain of rigid bars in Basilisk's multibody scenes: reads a request of barchain, writes samples and a result.

The chain is a tree of MuJoCo bodies in Basilisk's MJScene: bar 1 is free, every other bar hangs by a hinge. Basilisk's
NBodyGravity, with the central body as its source, pulls each bar at its centre of mass, and Basilisk's own Runge-Kutta
method of order 4 makes equal steps. Frame: inertial, from the centre of the central body; angles from its first axis.

    python chain.py REQUEST.json SAMPLES.csv RESULT.json [TIMES]

Steps are those of the request (`step_s`). A request of an error in one step gets steps in which the method makes it,
and 2000 an orbit at least: roundings, of one step each, partly cancel in more steps. TIMES, a whole number, multiplies
the number of steps, for a second run that shows the error of the first.
It needs the package bsk (2.12 or later), and no part of barchain.
"""

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

NANO = 1e9
"""Basilisk counts time in whole nanoseconds"""
WALK = 0.1
"""Measured size of the random walk below, over that of roundings of one sign: 0.04 to 0.1"""
MOST_TURNED_RAD = 2e-6
"""Largest turn by rounding of a scene that is run"""
LEAST_AN_ORBIT = 2000
"""Steps in `step_period_s`, where the request has no step"""
ERROR_CONSTANT = 1 / 120
"""Of a step of order 4: its error is about that of the first term left out, in radians of the fastest rate"""


class Chain:
    """Bars of a request, their joints and their motion in the plane."""

    def __init__(self, request: dict[str, Any]) -> None:
        chain, self.start = request["scene"]["chain"], request["start"]
        self.mass, self.length, self.inertia = (
            np.array(chain[name]) for name in ("mass_kg", "length_m", "inertia_kg_m2")
        )
        share = chain.get("com_share") or 0.5
        self.lever = np.broadcast_to(share, self.mass.shape) * self.length
        """From a bar's left end to its centre of mass, m"""

    @property
    def mjcf(self) -> str:
        """The chain as a model of MuJoCo: the frame of each body is at the bar's centre of mass, along the bar."""
        found = '<mujoco><option gravity="0 0 0"><flag contact="disable"/></option><worldbody>'
        left, right = self.lever.tolist(), (self.length - self.lever).tolist()
        for j, (mass, inertia) in enumerate(zip(self.mass.tolist(), self.inertia.tolist(), strict=True)):
            place = f'pos="{right[j - 1] + left[j]!r} 0 0"' if j else ""
            found += f'<body name="bar{j + 1}" {place}>'
            joint = f'<joint name="joint{j}" type="hinge" axis="0 0 1" pos="{-left[j]!r} 0 0"/>'
            found += joint if j else "<freejoint/>"
            sizes = " ".join([repr(inertia)] * 3)  # about the axes in the plane, nothing turns
            found += f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="{sizes}"/>'
        return found + "</body>" * len(self.mass) + "</worldbody></mujoco>"

    def from_first_bar(self, angle: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Centre of mass from that of the first bar, and its velocity, at angles (..., N): complex numbers."""
        u = np.exp(1j * angle)
        v = 1j * rate * u
        found = []
        for each in (u, v):
            left = np.cumsum(self.length * each, axis=-1) - self.length * each
            centres = left + self.lever * each
            found.append((centres - centres[..., :1]) @ self.mass / self.mass.sum())
        return found[0], found[1]


def steps_of_sample(request: dict[str, Any]) -> int:
    """Steps from one sample to the next."""
    setting, t = request["setting"], request["sample_times_s"]
    between = float(t[1] - t[0])
    if setting["step_s"] is not None:
        return round(between / float(setting["step_s"]))
    step = (setting["value"] / ERROR_CONSTANT) ** (1 / 5) / setting["rate_rad_s"]
    return int(np.ceil(between / min(step, setting["step_period_s"] / LEAST_AN_ORBIT)))


def why_left_out(request: dict[str, Any]) -> str:
    """Reason why a request of these effects is not run; empty where it is."""
    turned_rad = turned_by_rounding(request, Chain(request))
    if turned_rad <= MOST_TURNED_RAD:
        return ""
    return f"rounding of places from the centre of the central body turns a bar by about {turned_rad:.1g} rad here"


def turned_by_rounding(request: dict[str, Any], chain: Chain) -> float:
    """Turn of a bar by roundings of its place, rad.

    MuJoCo takes moments about a point whose place, as all places here, counts from the centre of the central body. The
    arm of gravity is off by half a unit in the last place of that distance, other in each step, and turns a bar.
    """
    scene, place = request["scene"], np.hypot(*chain.start["com_m"])
    if scene["effects"]["gravity"] == "none":
        return 0.0
    pull = scene["central_body"]["mu_m3_s2"] / place**2
    turning = float(np.max(chain.mass / chain.inertia)) * pull * 0.5 * np.finfo(float).eps * place
    steps = steps_of_sample(request) * (len(request["sample_times_s"]) - 1)
    return float(WALK * turning * scene["run"]["duration_s"] ** 2 / np.sqrt(3.0 * steps))


def simulate(request: dict[str, Any]) -> tuple[Chain, np.ndarray, np.ndarray, float, int]:
    """Chain, positions and velocities of MuJoCo's joints at all samples, time of the integration, and steps.

    In the place of the first bar's quaternion's first number stands its angle, with all turns.
    A unit of time that differs from the second by half a nanosecond in a step, or less, makes the step a whole number.
    """
    from Basilisk.simulation import NBodyGravity, mujoco, pointMassGravityModel, svIntegrators
    from Basilisk.utilities import SimulationBaseClass

    chain, scene, t = Chain(request), request["scene"], np.array(request["sample_times_s"])
    every = steps_of_sample(request)
    step = (t[1] - t[0]) / every
    nanos = round(step * NANO)
    unit = step * NANO / nanos
    """Second, as the simulation counts it, s"""
    sim = SimulationBaseClass.SimBaseClass()
    sim.CreateNewProcess("process").addTask(sim.CreateNewTask("task", nanos))
    multibody = mujoco.MJScene(chain.mjcf)
    multibody.setIntegrator(svIntegrators.svIntegratorRK4(multibody))
    sim.AddModelToTask("task", multibody)
    gravity = NBodyGravity.NBodyGravity()
    if scene["effects"]["gravity"] != "none":
        source = pointMassGravityModel.PointMassGravityModel()
        source.muBody = scene["central_body"]["mu_m3_s2"] * unit**2
        gravity.addGravitySource("centre", source, True)
        for j in range(len(chain.mass)):
            gravity.addGravityTarget(f"bar{j + 1}", multibody.getBody(f"bar{j + 1}"))
        multibody.AddModelToDynamicsTask(gravity)
    seen = multibody.stateOutMsg.recorder()  # at every step: between samples, a bar may turn round
    sim.AddModelToTask("task", seen)
    sim.InitializeSimulation()

    start, angle, rate = chain.start, np.array(chain.start["angle_rad"]), np.array(chain.start["rate_rad_s"])
    offset, drift = chain.from_first_bar(angle, rate)
    first = multibody.getBody("bar1")
    first.setPosition([start["com_m"][0] - offset.real, start["com_m"][1] - offset.imag, 0.0])
    speed = start["com_velocity_m_s"]
    first.setVelocity([(speed[0] - drift.real) * unit, (speed[1] - drift.imag) * unit, 0.0])
    first.setAttitude([0.0, 0.0, np.tan(np.remainder(angle[0] + np.pi, 2 * np.pi) / 4 - np.pi / 4)])
    first.setAttitudeRate([0.0, 0.0, rate[0] * unit])
    for j in range(1, len(angle)):
        joint = multibody.getBody(f"bar{j + 1}").getScalarJoint(f"joint{j}")
        joint.setPosition(angle[j] - angle[j - 1])
        joint.setVelocity((rate[j] - rate[j - 1]) * unit)
    sim.ConfigureStopTime(nanos * every * (len(t) - 1))
    begun = time.perf_counter()
    sim.ExecuteSimulation()
    seconds = time.perf_counter() - begun
    steps = every * (len(t) - 1)
    place, motion = (np.array(values).reshape(steps + 1, -1) for values in (seen.qpos, seen.qvel))
    turned = np.unwrap(2 * np.arctan2(place[:, 6], place[:, 3]))
    place[:, 3] = turned + 2 * np.pi * np.round((angle[0] - turned[0]) / (2 * np.pi))
    return chain, place[::every], motion[::every] / unit, seconds, steps


def main() -> None:
    """Run the request."""
    request_file, samples_file, result_file, *times = sys.argv[1:]
    request = json.loads(Path(request_file).read_text(encoding="utf-8"))
    if times:
        between = request["sample_times_s"][1] - request["sample_times_s"][0]
        request["setting"]["step_s"] = between / (steps_of_sample(request) * int(times[0]))
    if said := why_left_out(request):
        left_out = {"version": 1, "outcome": "unsupported", "reason": said}
        Path(result_file).write_text(json.dumps(left_out), encoding="utf-8")
        return
    chain, place, motion, seconds, steps = simulate(request)
    t, bars = request["sample_times_s"], request["bars"]
    angle = np.cumsum(np.column_stack([place[:, 3], place[:, 7:]]), axis=1)
    rate = np.cumsum(np.column_stack([motion[:, 5], motion[:, 6:]]), axis=1)
    offset, drift = chain.from_first_bar(angle, rate)
    com = [place[:, 0] + offset.real, place[:, 1] + offset.imag, motion[:, 0] + drift.real, motion[:, 1] + drift.imag]
    result: dict[str, Any] = {"version": 1, "seconds": seconds, "steps": steps}
    if np.hypot(com[0], com[1]).min() - chain.length.sum() < request["scene"]["central_body"]["radius_m"]:
        result |= {"outcome": "unsupported", "reason": "the chain comes near the surface, and no event is located"}
    names = ["t_s", "com_x_m", "com_y_m", "com_vx_m_s", "com_vy_m_s"]
    names += [f"angle_{j}_rad" for j in range(1, bars + 1)] + [f"rate_{j}_rad_s" for j in range(1, bars + 1)]
    rows = np.column_stack([t, *com, angle, rate])
    np.savetxt(samples_file, rows, fmt="%.17g", delimiter=",", header=",".join(names), comments="")
    Path(result_file).write_text(json.dumps(result), encoding="utf-8")


if __name__ == "__main__":
    main()
