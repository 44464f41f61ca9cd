"""JaxSim, an engine of barchain's in an environment of its own: its program's forces and orbit, and its agreement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import barchain
from adapters.bar_loads.chain_loads import ChainForces
from adapters.bar_loads.interface import FrameState
from adapters.common.kepler import propagate
from adapters.engine import AccuracyParameter, Setting
from adapters.jaxsim.chain import Chain, left_of, orbit
from adapters.registry import built_in
from adapters.request import run_request
from barchain.conform.scenes import candidates
from tests.support.solutions import run

if TYPE_CHECKING:
    from pathlib import Path

    from scenarios import Scene

JAXSIM = built_in()["jaxsim"]
MISSING = JAXSIM.missing
in_jaxsim = pytest.mark.skipif(bool(MISSING), reason=MISSING or "it is there")


def chain_of(scene: Scene) -> Chain:
    return Chain(run_request(scene, Setting(AccuracyParameter.STEPS_PER_ORBIT, 1000)))


def carried(name: str) -> Scene:
    """A scene without the effects that the program does not carry."""
    return candidates(JAXSIM.declarations(), name)[-1]


@pytest.mark.parametrize(
    "name", ["quadrupole_alone", "oblateness_alone", "third_body_alone", "thrust_body", "joint_torque_alone",
             "eleven_bars_loads", "com_share_loads", "together_4", "together_8"],
)  # fmt: skip
def test_the_forces_are_those_that_other_engines_apply(name: str) -> None:
    """Forces in the falling frame, and the pull of the frame's origin: those of a frame at rest, to rounding."""
    scene = carried(f"conform/{name}")
    chain, forces, seen = chain_of(scene), ChainForces(scene, falling=False), run(scene, 1e-8)
    rest = np.zeros(2)
    for k in (1, len(seen.t_s) // 3, -1):
        t, origin = float(seen.t_s[k]), seen.com_m[k]
        bend, turning = np.diff(seen.angle_rad[k]), np.diff(seen.rate_rad_s[k])
        q = np.concatenate([rest, seen.angle_rad[k][:1], bend])
        q_t = np.concatenate([rest, seen.rate_rad_s[k][:1], turning])
        q[:2], q_t[:2] = (-each for each in chain.moved(q, q_t))
        _, rate, along, centre = chain.bars(q, q_t)
        inside = t - 1e-6 * scene.run.duration_s
        force, torque = chain.loads(t, inside, origin, along, centre)
        bent = chain.joint_torques(t, inside, bend, turning)
        torque = torque + np.concatenate([[0.0], bent]) - np.concatenate([bent, [0.0]])
        pull = chain.mass[:, None] * (-chain.mu * origin / np.hypot(*origin) ** 3)

        velocity = seen.com_velocity_m_s[k] + chain.along_bars(q_t[:2], rate[:, None] * left_of(along))
        frame = FrameState(0.0, 0.0, t_s=t, inside_s=inside)
        there, turned = forces(frame, origin + centre, seen.angle_rad[k], velocity, rate)
        assert force + pull == pytest.approx(there, abs=1e-14 * np.abs(there).max())
        assert torque == pytest.approx(turned, abs=1e-12 * np.abs(turned).max())


@pytest.mark.parametrize("speed", [0.4, 1.0, np.sqrt(2.0 / 0.89), np.nextafter(np.sqrt(2.0 / 0.89), 2.0), 1.6])
def test_the_frame_follows_keplers_orbit_on_every_conic(speed: float) -> None:
    """Against the adapters' own solution of Kepler's equation, over three periods of the circular orbit."""
    mu, place = 4e14, np.array([5e6, 4e6])
    r = np.hypot(*place)
    velocity = speed * np.sqrt(mu / r) * np.array([-0.5, 0.8])
    t = np.linspace(0.0, 6.0 * np.pi * np.sqrt(r**3 / mu), 61)
    found, expected = orbit(mu, place, velocity, t), propagate(mu, place, velocity, t)
    turned = 1.0 + t[:, None] / t[1]
    for a, b in zip(found, expected, strict=True):
        assert np.all(np.abs(a - b) <= 1e-14 * turned * np.abs(b).max())
    assert orbit(0.0, place, velocity, t)[0] == pytest.approx(place + t[:, None] * velocity, rel=1e-15)


@in_jaxsim
@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["conform/one_bar_gradient", "conform/three_bars_gradient", "conform/together_8"])
def test_it_agrees_with_the_certified_solution(tmp_path: Path, name: str) -> None:
    found = barchain.compare([carried(name)], ["jaxsim"], tmp_path / "out")
    assert found.passed, found.metrics[found.metrics.reason.notna()][["quantity", "reason"]]
    assert set(found.metrics.quantity) >= {"com", "attitude", "rate"}
