"""The basics/ scenes against their closed forms, through the reference's adapter.

DOP853 may err by `rtol` in each step, in units of each block's scale; an error made at one instant then
grows by the motion's own response. A tolerance here is steps x rtol x that growth (`budget`): in units of
what was asked for, and of nothing else. Round-off of the answer itself is added where it could matter.
"""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipj, ellipk

from adapters.common.kepler import propagate
from adapters.reference.compiled_engine import ReferenceFast
from adapters.reference.numpy_engines import Reference
from adapters.trajectory import Trajectory
from scenarios import Scene, load_scene
from tests.support.radial_chain import first_moments, radial_tension
from tests.support.slow import one_in

RTOL = 1e-11
EPS = np.finfo(float).eps


@pytest.fixture(scope="module", params=[Reference, ReferenceFast], ids=["numpy", "compiled"], autouse=True)
def implementation(request: pytest.FixtureRequest) -> None:
    """Both forms of the reference are held to them."""
    global engine  # noqa: PLW0603  # read by `run`, once for each form
    engine = request.param


def run(scene: Scene, rtol: float = RTOL) -> Trajectory:
    return engine().run(scene, engine.sweep.setting(rtol))


def budget(trajectory: Trajectory, rate_rad_s: float, rtol: float = RTOL) -> float:
    """Steps x rtol x (1 + rate t): a rate's error shifts the angle by itself times the time."""
    return float(trajectory.info["steps"]) * rtol * (1.0 + rate_rad_s * trajectory.t_s[-1])


def with_chain(scene: Scene, **changes: tuple[float, ...]) -> Scene:
    return replace(scene, chain=replace(scene.chain, **changes))


def longer(scene: Scene, factor: float) -> Scene:
    """The same scene with bars `factor` times as long, slender."""
    chain = scene.chain
    return with_chain(
        scene,
        length_m=tuple(factor * x for x in chain.length_m),
        inertia_kg_m2=tuple(factor**2 * x for x in chain.inertia_kg_m2),
    )


# one bar about the radial


@pytest.mark.parametrize("amplitude_deg", one_in(3, [0.1, 5.0, 45.0, 80.0, 89.0]))
def test_a_bar_librates_as_jacobis_elliptic_function(amplitude_deg: float) -> None:
    """psi'' = -3 n² sin psi cos psi from rest: sin psi = k cd(sqrt(3) n t | k²), k = sin psi(0)."""
    scene = with_chain(load_scene("basics/libration"), angle_rad=(math.radians(90.0 + amplitude_deg),))
    seen, n, start = run(scene), scene.mean_motion_rad_s, math.radians(amplitude_deg)
    k = math.sin(start)
    _, cn, dn, _ = ellipj(math.sqrt(3.0) * n * seen.t_s, k * k)
    psi = seen.angle_rad[:, 0] - n * seen.t_s - scene.orbit.longitude_rad
    # near the unstable horizontal an error grows like cosh(sqrt(3) n t) over the first quarter swing
    amplification = math.cosh(ellipk(k * k))
    error = np.abs(np.sin(psi) - k * cn / dn)
    assert error.max() <= amplification * (budget(seen, n) + 8.0 * EPS * n * seen.t_s[-1])


# the radial chain


def tensions(trajectory: Trajectory) -> np.ndarray:
    """Reaction along the bar (n, N-1)."""
    along = np.stack([np.cos(trajectory.angle_rad[:, :-1]), np.sin(trajectory.angle_rad[:, :-1])], axis=-1)
    return np.sum(trajectory.reaction_N * along, axis=-1)


def test_radial_tension_at_the_start_is_the_exact_sum_over_the_bars() -> None:
    scene = load_scene("basics/radial_equilibrium")
    found = tensions(run(scene))[0]
    # 90 degrees is off by an ulp and the chain is 1e-16 bent: forces of their own size
    assert np.abs(found - radial_tension(scene)).max() <= 32.0 * EPS * radial_tension(scene).max()


def test_radial_chain_stays_at_rest_up_to_the_square_of_its_size_over_the_radius() -> None:
    """The circular speed at r0 is a particle's: a long chain's orbit is eccentric by O((L/r)²).

    The chain's mean field exceeds a particle's by e = 3 <d²>/r² = L²/4r², which is the eccentricity. The
    radius varies by 2e, so the tide's two thirds of the tension by 6e, that is 4e of it; the orbital rate
    by 4e and the swing's by at most 2e, so the centrifugal third, being quadratic, by 12e, 4e of it: 8e.
    """
    ratios = []
    for factor in (1.0, 10.0):
        scene = longer(load_scene("basics/radial_equilibrium"), factor)
        seen = run(scene)
        moved = np.abs(tensions(seen) / radial_tension(scene) - 1.0).max()
        e = (scene.size_m / scene.radius0_m) ** 2 / 4.0
        assert moved <= 8.0 * e + budget(seen, scene.mean_motion_rad_s)
        ratios.append(moved / e)
    assert ratios[0] == pytest.approx(ratios[1], rel=0.05)  # it is that order: ten times longer, a hundred times more


# no gravity


def test_free_straight_chain_carries_the_centrifugal_tension_and_turns_evenly() -> None:
    scene = load_scene("basics/free_rotation")
    seen, omega = run(scene), scene.chain.rate_factor[0] * scene.orbital_rate_rad_s
    tension = omega**2 * first_moments(scene)
    allowed = budget(seen, omega)
    turned = seen.angle_rad - seen.angle_rad[0] - omega * seen.t_s[:, None]
    assert np.abs(turned).max() <= allowed + 4.0 * EPS * omega * seen.t_s[-1]
    # a bend is neutrally stable: it swings at about omega, and tension feels it to first order in its rate
    assert np.abs(tensions(seen) / tension - 1.0).max() <= 4.0 * allowed + 32.0 * EPS


class TwoBars:
    """Two hinged bars in free space, by their two integrals: I g'² (AB - C² cos² g) = ... and a quadrature.

    With g = theta2 - theta1: T = A w1²/2 + B w2²/2 + C w1 w2 cos g, L = (A + C cos g) w1 + (B + C cos g) w2.
    """

    def __init__(self, scene: Scene, angle: np.ndarray, rate: np.ndarray) -> None:
        (m1, m2), (l1, l2) = scene.chain.mass_kg, scene.chain.length_m
        j1, j2 = scene.chain.inertia_kg_m2
        self.reduced = m1 * m2 / (m1 + m2)
        self.half = np.array([l1, l2]) / 2.0
        self.A, self.B = j1 + self.reduced * (l1 / 2) ** 2, j2 + self.reduced * (l2 / 2) ** 2
        self.C = self.reduced * l1 * l2 / 4.0
        c = math.cos(angle[1] - angle[0])
        self.E2 = self.A * rate[0] ** 2 + self.B * rate[1] ** 2 + 2 * self.C * c * rate[0] * rate[1]
        self.L = (self.A + self.C * c) * rate[0] + (self.B + self.C * c) * rate[1]
        self.sign = math.copysign(1.0, rate[1] - rate[0])

    def opening_rate(self, g: float) -> float:
        """g' at g."""
        c = self.C * math.cos(g)
        total = self.A + self.B + 2.0 * c
        return self.sign * math.sqrt((self.E2 - self.L**2 / total) * total / (self.A * self.B - c * c))

    def first_rate(self, g: float) -> float:
        """theta1' at g."""
        c = self.C * math.cos(g)
        return (self.L - (self.B + c) * self.opening_rate(g)) / (self.A + self.B + 2.0 * c)

    def time(self, start: float, end: float) -> float:
        """Time from one opening to another."""
        return float(quad(lambda g: 1.0 / self.opening_rate(g), start, end, epsabs=0.0, epsrel=1e-13)[0])

    def turned(self, start: float, end: float) -> float:
        """Angle theta1 turns by meanwhile."""
        return float(
            quad(lambda g: self.first_rate(g) / self.opening_rate(g), start, end, epsabs=1e-13, epsrel=1e-13)[0]
        )

    def reaction(self, angle: np.ndarray) -> np.ndarray:
        """Force (2,) on bar 1: minus the reduced mass times the acceleration of centre 2 from centre 1."""
        g = angle[1] - angle[0]
        w1 = self.first_rate(g)
        w2, c, s = w1 + self.opening_rate(g), self.C * math.cos(g), self.C * math.sin(g)
        a1, a2 = np.linalg.solve([[self.A, c], [c, self.B]], [s * w2**2, -s * w1**2])
        u = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        n = np.stack([-u[:, 1], u[:, 0]], axis=-1)
        parts = self.half[:, None] * (np.array([a1, a2])[:, None] * n - np.array([w1**2, w2**2])[:, None] * u)
        force: np.ndarray = -self.reduced * parts.sum(axis=0)
        return force


def test_two_free_bars_follow_their_quadrature() -> None:
    scene = load_scene("basics/two_bars_free")
    seen = run(scene)
    exact = TwoBars(scene, seen.angle_rad[0], seen.rate_rad_s[0])
    rate = float(np.abs(seen.rate_rad_s).max())
    opening = seen.angle_rad[:, 1] - seen.angle_rad[:, 0]
    time, turned = 0.0, 0.0
    allowed = 4.0 * budget(seen, rate)  # two bars, two rates each bearing on both angles
    for i, (before, after) in enumerate(pairwise(opening), start=1):
        time += exact.time(before, after)
        turned += exact.turned(before, after)
        assert abs(time - seen.t_s[i]) * rate <= allowed
        assert abs(turned - (seen.angle_rad[i, 0] - seen.angle_rad[0, 0])) <= allowed
        assert abs(exact.first_rate(after) - seen.rate_rad_s[i, 0]) <= allowed * rate
        force = np.abs(exact.reaction(seen.angle_rad[i]) - seen.reaction_N[i, 0]).max()
        assert force <= 4.0 * allowed * exact.reduced * rate**2 * exact.half.sum()


# Kepler


@pytest.mark.parametrize("kind", ["circular", "elliptic", "hyperbolic"])
def test_a_point_like_bar_follows_kepler(kind: str) -> None:
    """A speed off by rtol shifts the semi-major axis by 2 a²/r0 rtol, thus the phase by 3 n t."""
    scene = load_scene(f"basics/kepler_{kind}")
    seen, b2 = run(scene), scene.orbit.speed_factor**2
    expected, _ = propagate(scene.central_body.mu_m3_s2, seen.com_m[0], seen.com_velocity_m_s[0], seen.t_s)
    stretch = 2.0 / abs(2.0 - b2)  # of the semi-major axis by a change of speed at r0: da/a = 2 a/r0 dv/v
    amplification = (
        3.0
        * stretch
        * np.linalg.norm(seen.com_velocity_m_s, axis=1).max()
        / (scene.speed0_m_s / scene.orbit.speed_factor)
    )
    allowed = amplification * budget(seen, math.sqrt(scene.central_body.mu_m3_s2 / scene.radius0_m**3))
    assert np.linalg.norm(seen.com_m - expected, axis=1).max() <= allowed * scene.radius0_m
    even = seen.angle_rad[:, 0] - seen.angle_rad[0, 0] - scene.orbital_rate_rad_s * seen.t_s
    assert np.abs(even).max() <= budget(seen, scene.orbital_rate_rad_s)


@pytest.mark.parametrize("name", one_in(3, ["two_bars_free", "libration", "kepler_elliptic"]))
def test_the_error_shrinks_with_the_tolerance_asked_for(name: str) -> None:
    """From 1e-6 to 1e-10 the distance to a run at 1e-13 falls by at least 1e3 of the 1e4 asked for."""
    scene = load_scene(f"basics/{name}")
    solution = run(scene, 1e-13)
    coarse, fine = (
        max(
            np.abs(seen.angle_rad - solution.angle_rad).max(),
            np.abs(seen.com_m - solution.com_m).max() / scene.radius0_m,
        )
        for seen in (run(scene, 1e-6), run(scene, 1e-10))
    )
    assert fine <= 1e-3 * coarse
