"""The reference's runs: known values, coordinate sets, drift, events, breaks, the stepper."""

import math
from dataclasses import replace

import numpy as np
import pytest

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from reference_impl.integrate.simulate import History, Simulation
from reference_impl.integrate.stepper import Integration, integrate
from reference_impl.kernel.simulate import KernelSimulation
from reference_impl.model.chain import BarTurn, ChainModel, Prescription
from reference_impl.model.kinematics import consistent_state, relative_positions
from reference_impl.model.state import State
from scenarios import Scene, load_scene

MU, RADIUS = 3.986004418e14, 6378e3
TIGHT = 1e-13


def one_orbit(name: str, samples: int = 101) -> Scene:
    scene = load_scene(name)
    return replace(scene, run=replace(scene.run, duration_s=scene.period_s, samples=samples))


def simulate(scene: Scene, rtol: float, coordinates: str = "minimal") -> History:
    s = initial_state(scene)
    run = Simulation(
        chain_model(scene),
        s.com_m,
        s.com_velocity_m_s,
        s.angle_rad,
        s.rate_rad_s,
        rtol=rtol,
        coordinates=coordinates,
    )
    return run.history(run.integrate(scene.times_s), condition=True)


# known values, to the digits in which they are known


def test_fig05_after_one_orbit() -> None:
    h = simulate(one_orbit("paper/fig05"), TIGHT)
    turned = h.angle_rad[-1] - h.angle_rad[0] - 2.0 * math.pi
    assert turned == pytest.approx([-0.77351466, -0.28699644, 0.11854976, 0.41158638, 0.59243057], abs=0.5e-8)
    size = np.linalg.norm(h.reaction_N, axis=-1)
    assert size[-1] == pytest.approx([0.01128, 0.02417, 0.03735, 0.03434], abs=0.5e-5)
    assert size.max() == size[-1].max()
    assert size[0].max() < 1e-10  # first-order forces cancel: about 4e-11 N are left


def test_fig05_from_each_bars_own_horizontal_ends_elsewhere() -> None:
    """The convention of the start moves the chaotic scene by 0.77 rad in one orbit."""
    chain, bar = (simulate(one_orbit(name), 1e-11).angle_rad for name in ("paper/fig05", "paper/fig05_bar_horizontal"))
    assert np.abs(chain[-1] - bar[-1]).max() == pytest.approx(0.77, abs=0.01)


# coordinate sets


@pytest.fixture(scope="module")
def four_sets() -> dict[str, History]:
    scene = one_orbit("paper/fig13", 51)
    return {name: simulate(scene, 1e-11, name) for name in ("minimal", "redundant", "projected", "absolute")}


@pytest.mark.parametrize("name", ["redundant", "projected", "absolute"])
def test_coordinate_sets_agree(four_sets: dict[str, History], name: str) -> None:
    """Steps x rtol x growth of the rotating chain's errors (1 + n t), in bar lengths and radians.

    Absolute coordinates add the round-off of places, u r per step, which is u r/l in units of a bar.
    """
    minimal, other = four_sets["minimal"], four_sets[name]
    turn = 1.0 + 2.0 * math.pi
    noise = 2.0**-53 * np.linalg.norm(minimal.com_m[0]) / 100.0 if name == "absolute" else 0.0
    allowed = turn**2 * (other.steps + minimal.steps) * (1e-11 + noise)
    assert np.abs(other.angle_rad - minimal.angle_rad).max() <= allowed
    stiffest = 2.1**2 * 100.0 * 100.0 * (MU / RADIUS**3)  # N per rad: m l times the square of the fastest mode
    assert (
        np.abs(other.reaction_N - minimal.reaction_N).max()
        <= 10.0 * allowed * stiffest + 8.0 * noise * stiffest * 100.0
    )


def test_minimal_coordinates_have_no_drift_and_redundant_ones_do(four_sets: dict[str, History]) -> None:
    round_off = 64.0 * 2.0**-53 * 500.0  # of a 500 m chain rebuilt from its angles
    assert four_sets["minimal"].gap_m.max() <= round_off
    assert four_sets["minimal"].com_residual_m.max() <= round_off
    assert four_sets["redundant"].gap_m[-1].max() > 100.0 * round_off
    assert (
        four_sets["redundant"].gap_m[-1].max()
        > 3.0 * four_sets["redundant"].gap_m[len(four_sets["redundant"].t_s) // 4].max()
    )
    # what is left of a projected run is the step under way: one step's error in a bar's length
    assert four_sets["projected"].gap_m.max() <= 10.0 * 1e-11 * 100.0
    # absolute places are rounded to u r each
    assert four_sets["absolute"].gap_m.max() >= 2.0**-53 * RADIUS


# surface


BOTH = pytest.mark.parametrize("kind", [Simulation, KernelSimulation])


def falling(kind: type, angle_rad: float, length_m: float = 100.0) -> tuple[Simulation, float]:
    """One bar released at rest from 350 km, and its fall's closed form to a centre's radius of R + reach."""
    mass, length = np.array([100.0]), np.array([length_m])
    model = ChainModel(MU, mass, length, mass * length**2 / 12.0, "point", RADIUS)
    start = RADIUS + 350e3
    run = kind(model, np.array([start, 0.0]), np.zeros(2), np.array([angle_rad]), np.zeros(1), rtol=1e-11)
    x = (RADIUS + 0.5 * length_m * abs(math.cos(angle_rad))) / start
    return run, math.sqrt(start**3 / (2.0 * MU)) * (math.acos(math.sqrt(x)) + math.sqrt(x * (1.0 - x)))


@BOTH
@pytest.mark.parametrize("angle_deg", [0.0, 60.0, 90.0])
def test_a_falling_bar_lands_at_the_closed_forms_instant(angle_deg: float, kind: type) -> None:
    run, instant = falling(kind, math.radians(angle_deg))
    times = np.linspace(0.0, 400.0, 401)
    seen = run.integrate(times)
    speed = 2500.0  # m/s at the surface, about: an error of rtol x radius per step is rtol r/v in time
    sideways = 100.0**2 / RADIUS / speed  # a slanted bar's end is nearest to the centre's own vertical, within l²/r
    slant = sideways if angle_deg == 60.0 else 0.0
    assert abs(seen.stopped_s - instant) <= seen.steps * 1e-11 * RADIUS / speed + 1e-9 * 100.0 + slant
    assert len(seen.t_s) == np.count_nonzero(times <= seen.stopped_s)
    assert run.history(seen).landed_s == seen.stopped_s


@BOTH
def test_an_orbit_that_an_effect_bends_lands_where_it_dips_and_is_not_searched_far_above(
    kind: type, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A surface 3 m above the lowest height of a whole run ends it, one 3 m below does not."""
    scene = one_orbit("effects/oblateness", 1001)
    model, s = chain_model(scene), initial_state(scene)
    start = s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s
    heights: list[float] = []
    height = Simulation.height

    def counted(run: Simulation, y: np.ndarray) -> float:
        heights.append(height(run, y))
        return heights[-1]

    monkeypatch.setattr(Simulation, "height", counted)
    free = kind(model, *start, rtol=1e-10)
    seen = free.integrate(scene.times_s)
    assert not heights, "hundreds of kilometres up, no step can reach the surface"
    look = Simulation(model, *start, rtol=1e-10)
    lowest = min(height(look, look.coordinates.pack(state)) for state in states_of(free, seen))
    for above, lands in ((3.0, True), (-3.0, False)):
        low = replace(model, body_radius_m=model.body_radius_m + lowest + above)
        assert (kind(low, *start, rtol=1e-10).integrate(scene.times_s).stopped_s is not None) == lands
    assert heights


def states_of(run: Simulation, seen: Integration) -> list[State]:
    """Complete states of a run at its samples."""
    h = run.history(seen)
    columns = zip(h.com_m, h.com_velocity_m_s, h.angle_rad, h.rate_rad_s, strict=True)
    return [consistent_state(run.model, *each) for each in columns]


# manoeuvres


@pytest.mark.parametrize("frame", ["local", "inertial"])
@pytest.mark.parametrize("actuator", ["external", "joint"])
@BOTH
def test_the_prescribed_bar_follows_its_law(kind: type, frame: str, actuator: str) -> None:
    """Through both ends of the slew, to steps x rtol; a step across an end would leave far more."""
    scene = load_scene("paper/fig17" if frame == "local" else "paper/fig17_inertial")
    model, s, rtol = chain_model(scene), initial_state(scene), 1e-11
    law = model.prescriptions[0]
    turn = replace(law.turns[0], start_s=37.0)
    law = replace(law, turns=(turn,), reacts_on=3 if actuator == "joint" else None)
    model = replace(model, prescriptions=(law,))
    run = kind(model, s.com_m, s.com_velocity_m_s, s.angle_rad, s.rate_rad_s, rtol=rtol)
    h = run.history(run.integrate(np.linspace(0.0, 300.0, 61)))
    angle = h.angle_rad[:, law.bar]
    if frame == "local":
        place = np.array([relative_positions(model, a)[law.bar] for a in h.angle_rad]) + h.com_m
        angle = angle - np.unwrap(np.arctan2(place[:, 1], place[:, 0]))
    wanted = np.array([law.angle_rad(t) for t in h.t_s])
    rate = float(np.abs(h.rate_rad_s).max())
    # an error of a rate, in units of the rates at the start, shifts the angle by itself times the time
    initial = float(np.abs(s.rate_rad_s).max())
    assert (
        np.abs(angle - angle[0] - wanted).max()
        <= h.steps * rtol * (1.0 + initial * 300.0) + 64 * 2.0**-53 * rate * 300.0
    )
    assert np.abs(h.torque_N_m).max() > 0.1


@pytest.mark.parametrize("quintic", [False, True])
def test_the_acceleration_of_a_law_is_the_second_derivative_of_its_angle(quintic: bool) -> None:
    """Differences of second order: h²/12 times the fourth derivative, at most 4e-5 rad/s⁴ of both courses."""
    law, h = Prescription(0, (BarTurn(0.8, 60.0, 10.0, quintic),), frame="inertial", reacts_on=None), 0.1
    assert [law.angle_rad(t) for t in (0.0, 10.0, 70.0, 99.0)] == pytest.approx([0.0, 0.0, 0.8, 0.8], abs=1e-15)
    for t in (15.0, 40.0, 66.0):
        bend = (law.angle_rad(t + h) - 2.0 * law.angle_rad(t) + law.angle_rad(t - h)) / h**2
        assert law.acceleration_rad_s2(t) == pytest.approx(bend, abs=4e-5 * h**2 / 12.0)


# the stepper


def decay(t: float, y: np.ndarray) -> np.ndarray:
    return -y


TIMES = np.linspace(0.0, 1.0, 11)


@pytest.mark.parametrize("at", [0.3, 0.3 + 1e-14, 1e-13, 1.0 - 1e-13, 0.0, 1.0, -3.0, 7.0])
def test_every_sample_is_taken_once_wherever_a_break_falls(at: float) -> None:
    seen = integrate(decay, np.ones(2), TIMES, np.full(2, 1e-10), breaks_s=(at,))
    assert np.array_equal(seen.t_s, TIMES)
    assert np.abs(seen.y[:, 0] - np.exp(-TIMES)).max() < 10.0 * 1e-10
    assert seen.stopped_s is None


def test_projection_acts_after_every_step() -> None:
    def turn(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([-y[1], y[0]])

    free, held = (
        integrate(turn, np.array([1.0, 0.0]), np.array([0.0, 20.0]), np.full(2, 1e-5), project=project)
        for project in (None, lambda y: y / np.linalg.norm(y))
    )
    assert held.evaluations > free.evaluations + held.steps // 2
    assert abs(np.linalg.norm(held.y[-1]) - 1.0) < abs(np.linalg.norm(free.y[-1]) - 1.0)


class FlatSurface:
    """A surface at zero that is always looked at."""

    def height(self, y):
        return y[0]

    def clears_surface(self, before, after, step_s):
        return False


def test_a_dip_within_one_step_is_found_and_a_near_miss_is_not() -> None:
    def parabola(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([y[1], 1.0])

    for depth in (1e-2, 1e-4):
        lowest = integrate(parabola, np.array([0.125 - depth, -0.5]), TIMES, np.full(2, 1e-10), surface=FlatSurface())
        assert lowest.stopped_s == pytest.approx(0.5 - math.sqrt(2.0 * depth), abs=1e-8)
    miss = integrate(parabola, np.array([0.125 + 1e-4, -0.5]), TIMES, np.full(2, 1e-10), surface=FlatSurface())
    assert miss.stopped_s is None


def test_a_start_below_the_surface_stops_at_once() -> None:
    seen = integrate(decay, np.array([-1.0]), TIMES, np.full(1, 1e-10), surface=FlatSurface())
    assert seen.stopped_s == 0.0
    assert len(seen.t_s) == 1


@pytest.mark.parametrize("where", ["state", "rate", "later"])
def test_what_is_not_finite_raises_and_does_not_hang(where: str) -> None:
    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        return -y * (np.nan if where == "rate" or (where == "later" and t > 0.5) else 1.0)

    start = np.array([np.nan if where == "state" else 1.0])
    with pytest.raises(ArithmeticError, match=r"not finite|failed at"):
        integrate(rhs, start, TIMES, np.full(1, 1e-10))
