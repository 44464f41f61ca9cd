"""Results of the track alone, or of few columns, are explained by another start, clock or strength, or by nothing."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from adapters.common.initial_state import initial_state
from adapters.trajectory import Trajectory
from barchain.judge.diagnosis.chance import foretells, independent_digits
from barchain.judge.diagnosis.diagnose import Diagnosis, diagnose
from barchain.judge.diagnosis.mean_elements import by_mean_elements
from barchain.judge.diagnosis.motion.numbers import numbers, read
from barchain.judge.diagnosis.trial_search import MOST_STEPS, TrialSearch, outdone
from barchain.judge.diagnosis.trials import Trial, further_trials, motion_from, start_speed
from scenarios import Axes, End, Gravity, Scene, Thrust, load_scene, make_scene
from tests.support.slow import one_in, rows
from tests.support.solutions import solution_of

ARM = {
    "title": "An arm in orbit", "source": "made up", "orbit": {"altitude_m": 500e3, "speed_factor": 1.02},
    "chain": {
        "bars": 4, "mass_kg": [30.0, 20.0, 8.0], "length_m": [2.0, 1.5, 0.8], "angle_deg": [90.0, 40.0, 10.0, -20.0],
        "rate_factor": [1.0, 3.0, -2.0, 0.5],
        "end_body": [{"at": "first", "mass_kg": 500.0, "inertia_kg_m2": 180.0, "joint_m": 0.7}],
    },
    "effects": {
        "gravity": "gradient",
        "joint_spring_damper": {
            "stiffness_N_m_rad": [0.02, 0.01, 0.005], "damping_N_m_s_rad": [0.2, 0.1, 0.05],
            "rest_deg": [-30.0, -20.0, 15.0],
        },
    },
    "run": {"duration_s": 3000.0, "samples": 51},
}  # fmt: skip
EXACT = 1e-11
"""Relative error that is granted"""


def track_of(motion: Trajectory | None) -> Trajectory:
    """The track of a motion alone."""
    return motion.replace(angle_rad=None, rate_rad_s=None, reaction_N=None, torque_N_m=None, impulse_N_s=None)


def moved(scene: Scene, **start: Any) -> Trajectory:
    """Track of a scene from a start with other values."""
    return track_of(motion_from(scene, dataclasses.replace(initial_state(scene), **start), scene.times_s))


def with_effect(scene: Scene, effect: str, **values: Any) -> Scene:
    """Scene with other numbers of an effect."""
    new = dataclasses.replace(getattr(scene.effects, effect), **values)
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **{effect: new}))


def named(scene: Scene, track: Trajectory, error: float = EXACT) -> Diagnosis:
    """Diagnosis of a track."""
    size = {"com": scene.radius0_m, "com_velocity": scene.speed0_m_s}
    tolerance = {q: np.full(len(track.t_s), error * s) for q, s in size.items()}
    return diagnose(scene, track, solution_of(scene), tolerance)


def with_mu(scene: Scene, factor: float) -> Scene:
    """Scene with another gravitational parameter, and the same velocity at the start."""
    body = dataclasses.replace(scene.central_body, mu_m3_s2=factor * scene.central_body.mu_m3_s2)
    orbit = dataclasses.replace(scene.orbit, speed_factor=scene.orbit.speed_factor * factor**-0.5)
    return dataclasses.replace(scene, central_body=body, orbit=orbit)


def test_oblateness_by_mean_elements_is_named_and_without_it_the_orbit_is_kepler_s() -> None:
    scene = with_effect(load_scene("effects/oblateness"), "oblateness", j2=1.08e-3)
    found = named(scene, track_of(by_mean_elements(scene, np.zeros(0), scene.times_s)))
    assert ("oblateness-by-mean-elements",) in found.names, str(found)
    kepler = load_scene("basics/kepler_circular")
    round_body = dataclasses.replace(scene.effects.oblateness, j2=0.0)  # type: ignore[type-var]
    eccentric = dataclasses.replace(kepler.orbit, speed_factor=1.1, longitude_rad=0.4)
    bare = dataclasses.replace(kepler, orbit=eccentric)
    flat = dataclasses.replace(bare, effects=dataclasses.replace(bare.effects, oblateness=round_body))
    made = by_mean_elements(flat, np.zeros(0), bare.times_s)
    np.testing.assert_allclose(made.com_m, solution_of(bare).trajectory.com_m, rtol=0.0, atol=1e-9 * bare.radius0_m)


def test_another_speed_at_the_start_or_any_other_start_is_named_as_the_start() -> None:
    scene = load_scene("basics/kepler_circular")
    start = initial_state(scene)
    found = named(scene, moved(scene, com_velocity_m_s=1.001 * start.com_velocity_m_s))
    assert ("initial-speed",) in found.names, str(found)
    found = named(scene, moved(scene, com_m=start.com_m + np.array([300.0, -200.0])))
    assert found.names == {("another-start",)}, str(found)


@pytest.mark.parametrize("late_s", one_in(3, [0.25, -40.0, 1000.0]))
def test_a_clock_that_is_late_or_early_is_named_with_its_seconds(late_s: float) -> None:
    circular = load_scene("basics/kepler_circular")
    scene = dataclasses.replace(circular, orbit=dataclasses.replace(circular.orbit, speed_factor=1.1))
    instants = scene.times_s + late_s
    seen = motion_from(scene, initial_state(scene), instants[instants >= 0.0])
    right = solution_of(scene).trajectory
    com, velocity = right.com_m.copy(), right.com_velocity_m_s.copy()
    com[instants >= 0.0], velocity[instants >= 0.0] = seen.com_m, seen.com_velocity_m_s
    track = track_of(right).replace(com_m=com, com_velocity_m_s=velocity)
    tolerance = {
        "com": np.where(instants >= 0.0, 1e-4, np.inf),
        "com_velocity": np.where(instants >= 0.0, 1e-7, np.inf),
    }
    found = diagnose(scene, track, solution_of(scene), tolerance)
    assert ("clock",) in found.names, str(found)
    assert f"{abs(late_s):g} s {'early' if late_s > 0.0 else 'late'}" in str(found)


def test_a_file_whose_clock_begins_later_shows_the_scene_s_start_in_its_first_row() -> None:
    circular = load_scene("basics/kepler_circular")
    scene = dataclasses.replace(circular, orbit=dataclasses.replace(circular.orbit, speed_factor=1.1))
    right, late = track_of(solution_of(scene).trajectory), 20
    at = np.maximum(np.arange(len(right.t_s)) - late, 0)
    track = right.replace(com_m=right.com_m[at], com_velocity_m_s=right.com_velocity_m_s[at])
    unknown = np.arange(len(at)) < late
    tolerance = {"com": np.where(unknown, np.inf, 1e-4), "com_velocity": np.where(unknown, np.inf, 1e-7)}
    found = diagnose(scene, track, solution_of(scene), tolerance)
    assert found.names == {("clock",)}, str(found)
    assert "shows the scene's start" in str(found)


def test_noise_and_coarse_steps_on_a_track_name_nothing() -> None:
    scene = load_scene("basics/kepler_circular")
    right, rng = track_of(solution_of(scene).trajectory), np.random.default_rng(3)
    noisy = right.replace(com_m=right.com_m + 1e-3 * rng.standard_normal(right.com_m.shape))
    assert not named(scene, noisy).explanations
    assert not named(scene, leapfrog(scene, 50)).explanations


def leapfrog(scene: Scene, steps: int) -> Trajectory:
    """Track of a particle by leapfrog, of some steps between samples."""
    mu, right = scene.central_body.mu_m3_s2, track_of(solution_of(scene).trajectory)
    com, velocity = right.com_m.copy(), right.com_velocity_m_s.copy()
    x, v = com[0].copy(), velocity[0].copy()
    for k, span_s in enumerate(np.diff(right.t_s)):
        h = span_s / steps
        for _ in range(steps):
            v = v - 0.5 * h * mu * x / np.linalg.norm(x) ** 3
            x = x + h * v
            v = v - 0.5 * h * mu * x / np.linalg.norm(x) ** 3
        com[k + 1], velocity[k + 1] = x, v
    return right.replace(com_m=com, com_velocity_m_s=velocity)


def test_a_few_rows_of_few_digits_hold_too_little_for_an_explanation() -> None:
    alone = np.zeros((17, 1))
    alone[0] = 4000.0
    assert not foretells(independent_digits(alone), fitted=0, tried=200)
    rows = 1e3 * np.random.default_rng(1).standard_normal((17, 1))
    assert foretells(independent_digits(rows), fitted=1, tried=200)
    assert not foretells(independent_digits(np.full((17, 1), 1e3)), fitted=1, tried=1)


def test_a_trial_that_spins_a_bar_up_ends() -> None:
    """Newtons as kilonewtons: the bars' faces turn millions of times, and the run would not end."""
    scene = load_scene("conform/together_10")
    trials = {trial.name: trial for trial in further_trials(scene)}
    assert trials["thrusts-in-kilonewtons"].run(np.zeros(0), scene.times_s) is None
    assert trials["thrusts-clockwise"].run(np.zeros(0), scene.times_s) is not None


def test_late_impulses_of_several_instants_are_told_by_the_time() -> None:
    scene = load_scene("conform/impulse_alone")
    late = dataclasses.replace(scene, effects=scene.effects.at_instants(lambda t: t + 2.0))
    seen = motion_from(late, initial_state(scene), scene.times_s)
    size = {"com": scene.radius0_m, "com_velocity": scene.speed0_m_s, "attitude": 1.0, "rate": scene.fastest_rate_rad_s}
    tolerance = {q: np.full(len(seen.t_s), 1e-9 * s) for q, s in size.items()}
    found = diagnose(scene, seen, solution_of(scene), tolerance)
    assert "instant of all impulses is 2 s too late" in str(found)


def loaded(**effects: Any) -> Scene:
    """A circular orbit of one bar under other effects."""
    scene = load_scene("basics/kepler_circular")
    return dataclasses.replace(scene, effects=dataclasses.replace(scene.effects, **effects))


def pushed(**thrust: Any) -> Scene:
    """One bar without gravity, pushed for a while: nothing else moves it along x."""
    changes = {"direction_rad": 0.5, "times_s": (500.0, 1500.0), **thrust}
    return loaded(gravity=Gravity.NONE, thrust=(Thrust(1, End.LEFT, Axes.INERTIAL, force_N=(0.02, 0.02), **changes),))


def of_wrong(scene: Scene, wrong: Scene, error: float = EXACT, **absent: NDArray[np.bool_]) -> Diagnosis:
    """Diagnosis of the track of another scene."""
    track, right = (track_of(motion_from(s, initial_state(s), scene.times_s)) for s in (wrong, scene))
    track = track.replace(**{f: np.where(a, getattr(right, f), getattr(track, f)) for f, a in absent.items()})
    size = {"com": scene.radius0_m, "com_velocity": start_speed(scene)}
    tolerance = {q: np.full(len(track.t_s), error * s) for q, s in size.items()}
    return diagnose(scene, track, solution_of(scene), tolerance, absent=absent)


def test_a_distance_of_a_third_body_is_no_pull_of_it() -> None:
    """The pull would leave thousand times more, which a coarse tolerance allows."""
    scene = loaded(third_body=load_scene("conform/third_body_alone").effects.third_body[:1])
    body = scene.effects.third_body[0]
    nearer = dataclasses.replace(body, distance_m=0.9 * body.distance_m, rate_rad_s=0.9**-1.5 * body.rate_rad_s)
    wrong = loaded(third_body=(nearer,))
    for error in (1e-12, 1e-8):
        found = of_wrong(scene, wrong, error)
        assert found.names == {("third_body-1-distance_m-with-rate",)}, str(found)
        assert "in its rate too, is 0.9 times the right value" in str(found)


def turned(scene: Scene) -> Scene:
    """Scene whose orbit begins a degree later."""
    longitude_rad = scene.orbit.longitude_rad + np.radians(1.0)
    return dataclasses.replace(scene, orbit=dataclasses.replace(scene.orbit, longitude_rad=longitude_rad))


def lighter(scene: Scene) -> Scene:
    """Scene with bars of less mass."""
    mass_kg = tuple(m / 1.02 for m in scene.chain.mass_kg)
    return dataclasses.replace(scene, chain=dataclasses.replace(scene.chain, mass_kg=mass_kg))


KEPLER, OBLATE = load_scene("basics/kepler_circular"), load_scene("effects/oblateness")
WIDER = with_effect(OBLATE, "oblateness", radius_m=1.01 * OBLATE.effects.oblateness.radius_m)
TRACKS = [
    (KEPLER, with_mu(KEPLER, 1.0 + 3e-6), {"gravitational-parameter"}, "1.000003 times the scene's"),
    (KEPLER, turned(KEPLER), {"clock", "initial-longitude"}, "longitude at t = 0 is off by 1 degrees"),
    (pushed(), lighter(pushed()), {"mass_kg", "thrust-1-force_N"}, "0.980392 times"),
    (OBLATE, WIDER, {"oblateness-radius_m", "oblateness-j2"}, "reference radius of J2 is 1.01 times"),
]


@pytest.mark.parametrize(("scene", "wrong", "names", "said"), TRACKS, ids=["mu", "longitude", "mass", "radius"])
def test_a_wrong_number_is_named_from_the_track_alone_beside_what_looks_the_same(
    scene: Scene, wrong: Scene, names: set[str], said: str
) -> None:
    found = of_wrong(scene, wrong)
    assert found.names == {(name,) for name in names}, str(found)
    assert len(names) == 1 or "indistinguishable" in str(found)
    assert said in str(found)


@pytest.mark.parametrize(("wrong", "name", "said", "beside"), [
    ({"direction_rad": 0.5 + np.radians(3.0)}, "thrust-1-direction_rad", "off by 3 degrees", "thrust-1-force_N"),
    ({"times_s": (520.0, 1520.0)}, "thrust-1-times_s", "20 s too late", "clock-from-the-start"),
])  # fmt: skip
def test_of_one_axis_a_thrust_s_direction_and_instants_are_told_beside_what_looks_the_same(
    wrong: dict[str, Any], name: str, said: str, beside: str
) -> None:
    scene = dataclasses.replace(pushed(), orbit=dataclasses.replace(pushed().orbit, speed_factor=0.0))
    other = dataclasses.replace(pushed(**wrong), orbit=scene.orbit)
    lacking = np.array([False, True])
    found = of_wrong(scene, other, com_m=lacking, com_velocity_m_s=lacking)
    assert {(name,), (beside,)} <= found.names, str(found)
    assert said in str(found)


def test_a_search_that_runs_out_of_steps_says_that_others_may_explain_the_result(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = load_scene("basics/kepler_circular")
    track = track_of(motion_from(with_mu(scene, 1.001), initial_state(scene), scene.times_s))
    whole = named(scene, track)
    assert "not all are tried" not in str(whole)
    share = TrialSearch.linear_share

    def long(self: TrialSearch, trial: Trial) -> float:
        found = share(self, trial)
        self.steps += 0.6 * MOST_STEPS if trial.name == "mass_kg" else 0.0
        return found

    monkeypatch.setattr(TrialSearch, "linear_share", long)
    short = named(scene, track)
    assert short.names == whole.names
    assert "not all are tried" in str(short)


def test_of_several_fits_far_less_left_counts_more_than_fewer_numbers() -> None:
    assert outdone(1, 3e-8, [(1, 1e-12)], 10.0)
    assert not outdone(1, 5.0, [(1, 1.0)], 10.0)
    assert not outdone(0, 50.0, [(1, 1.0)], 10.0)
    assert outdone(0, 500.0, [(1, 1.0)], 10.0)


def test_no_trial_of_a_number_makes_a_scene_of_complex_ones() -> None:
    """A third body's rate goes with the power -3/2 of its distance, which is then positive."""
    for number in numbers(load_scene("effects/third_body")):
        for amount in number.range:
            changed = number.change(amount)
            assert not any(isinstance(read(changed, path), complex) for path in number.paths), number.name


@pytest.mark.parametrize(("field", "factor"), one_in(2, rows([("rest_rad", -1.0), ("damping_N_m_s_rad", 0.0)])))
def test_dampers_that_are_missing_and_springs_that_pull_the_other_way_are_named_by_a_few_angles(
    field: str, factor: float
) -> None:
    """Far from any linear effect: a swing between two samples is no longer damped, or goes elsewhere."""
    scene = make_scene(ARM)
    values = tuple(factor * x for x in getattr(scene.effects.joint_spring_damper, field))
    wrong = with_effect(scene, "joint_spring_damper", **{field: values})
    seen = motion_from(wrong, initial_state(wrong), scene.times_s)
    angles = seen.replace(rate_rad_s=None, reaction_N=None, torque_N_m=None, impulse_N_s=None)
    tolerance = {"attitude": np.full(len(seen.t_s), 1e-9)}
    found = diagnose(scene, angles, solution_of(scene), tolerance)
    assert (f"joint_spring_damper-{field}",) in found.names, str(found)
