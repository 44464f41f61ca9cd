"""Right motions under another start, another clock or other numbers, each made by a run of the reference.

A result without angles and rates, or of few samples, has no balance of momenta. It is compared with whole motions.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import chain_model
from adapters.engine import AccuracyParameter, EngineError, Setting
from adapters.trajectory import Trajectory
from barchain.judge.diagnosis.mean_elements import by_mean_elements
from barchain.judge.diagnosis.motion.numbers import ANGLE, FACTOR, Number, body_words, numbers
from barchain.judge.diagnosis.motion.others import others
from barchain.judge.diagnosis.motion.quadrature import SAME_INSTANT
from barchain.judge.diagnosis.motion.set_points import motor_words, motors_words
from barchain.judge.diagnosis.motion.words import GRAVITY, LOADS
from barchain.judge.diagnosis.starts import ORBIT, RATES, STARTS
from barchain.metrics.quantities import FIELDS
from barchain.solutions.reference_run import reference_run

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.common.initial_state import InitialState
    from adapters.trajectory import Array
    from scenarios import Scene

    Run = Callable[[Array, Array], Trajectory | None]
    """Motion at instants (n,) s, of amounts (m,); None where there is none"""

SETTING = Setting(AccuracyParameter.RTOL, 1e-13)
"""Accuracy of the motions"""
PROBE = 1e-6
"""Relative change of a number, or an angle in rad, that is small enough for a linear effect"""
SURFACE_LENGTHS = 10.0
"""Radius of a surface that no motion reaches, in lengths of the chain: of a smaller one each step would be examined"""
STRENGTHS = {
    "solar_pressure": (("pressure_Pa", "sunlight"),),
    "drag": (("density_kg_m3", "drag"),),
    "oblateness": (("j2", "coefficient J2"),),
    "joint_spring_damper": (("stiffness_N_m_rad", "stiffness of all joints"),
                            ("damping_N_m_s_rad", "damping of all joints")),
}  # fmt: skip
"""Strength of each effect that a scene has once: field, and noun"""
EACH_STRENGTH = {
    "third_body": ("mu_m3_s2", "pull of the {}"), "thrust": ("force_N", "thrust{}"),
    "joint_torque": ("torque_N_m", "torque of the {}"),
    "impulse": ("impulse_N_s", "impulse{}"),
}  # fmt: skip
"""The same of effects that it may have several times"""
ALL_STRENGTHS = {"third_body": "the pull of all third bodies"}
"""Nouns of the strengths of all effects of a kind, where these are no forces"""
SAME = 1e-13
"""Relative difference of two starts that rounding leaves"""
MOST_RATE = 100.0
"""Largest error of a rate at the start, relative to the fastest one: degrees for radians make 56"""
MOST_EVENTS = 1000
"""Turned faces and edges of the shadow in a motion, some seconds: a bar that a trial's forces or start spin up turns
its face millions of times"""


@dataclass(frozen=True)
class Trial:
    """A motion that may have made a result."""

    name: str
    section: str
    """Anchor of the convention"""
    words: Callable[[Array], str]
    """Sentence of the amounts (m,), without a full stop; begins with `the`"""
    run: Run
    probes: tuple[float, ...] = ()
    """Changes of the fitted amounts with a linear effect; none of a fixed motion"""
    begin: tuple[float, ...] = ()
    """Amounts to begin with"""
    slips: tuple[float, ...] = ()
    """Other amounts to begin with, where one comes nearer: what is missing is far from a linear effect"""
    within: tuple[float, float] = (-math.inf, math.inf)
    """Range of the fitted amounts"""
    nice: Callable[[Array], bool] = lambda _: False
    """Whether the amounts are ones that a slip would give"""


def motion_from(scene: Scene, start: InitialState, t_s: Array, setting: Setting = SETTING) -> Trajectory | None:
    """Motion of a scene from a start, at rising instants (n,) s from 0 on; None where there is none.

    It goes on below the surface of the body, as a wrong result may.
    """
    model = dataclasses.replace(chain_model(scene), body_radius_m=SURFACE_LENGTHS * scene.size_m)
    instants = t_s if t_s[0] == 0.0 else np.append(0.0, t_s)
    try:
        with np.errstate(all="ignore"):
            seen = reference_run(scene, setting, t_s=instants, start=start, model=model, most_events=MOST_EVENTS)
    except (EngineError, ValueError, ArithmeticError, np.linalg.LinAlgError):
        return None
    if len(seen.t_s) < len(instants):
        return None
    return seen if len(instants) == len(t_s) else seen.samples(slice(1, None))


def right_motion(scene: Scene, t_s: Array, setting: Setting = SETTING) -> Trajectory | None:
    """The right motion at rising instants (n,) s."""
    return motion_from(scene, initial_state(scene), t_s, setting)


def of_scene(
    change: Callable[[float], Scene], start: InitialState | None, amounts: Array, t_s: Array
) -> Trajectory | None:
    """Motion of a changed scene; from a given start, or from its own."""
    try:
        scene = change(float(amounts[0]) if len(amounts) else 0.0)
        return motion_from(scene, start or initial_state(scene), t_s)
    except (ValueError, ArithmeticError):
        return None


def shifted(scene: Scene, started: bool, amounts: Array, t_s: Array) -> Trajectory | None:
    """The right motion at instants (n,) plus an amount, s; NaN before its start. If `started`, t = 0 is no other."""
    instants = np.where(started & (t_s == 0.0), 0.0, t_s + float(amounts[0]))
    instants[np.abs(instants) <= SAME_INSTANT * float(np.diff(t_s).min(initial=math.inf))] = 0.0
    inside = instants >= 0.0
    if not inside.any() or (np.diff(instants[inside]) <= 0.0).any():
        return None
    seen = motion_from(scene, initial_state(scene), instants[inside])
    if seen is None:
        return None
    found: dict[str, Any] = {}
    for field in FIELDS.values():
        values = getattr(seen, field)
        if values is not None:
            found[field] = np.full((len(t_s), *values.shape[1:]), np.nan)
            found[field][inside] = values
    return Trajectory(t_s, **found)


def clock_words(first_s: float, started: bool, amounts: Array) -> str:
    """Sentence on a clock whose instants are late by an amount."""
    late_s = float(amounts[0])
    shown = first_s + late_s
    of = "the instants after the first row" if started else "the instants"
    said = f"{of} are {abs(late_s):.4g} s {'early' if late_s > 0.0 else 'late'}"
    if started:
        return f"{said}: the first row shows the scene's start, as it should"
    if abs(shown) <= 1e-6 * abs(late_s):
        return f"{said}: the first row, at t = {first_s:.6g} s, shows the scene's start"
    return f"{said}: the first row, at t = {first_s:.6g} s, shows the motion at t = {shown:.6g} s"


def moved_start(scene: Scene, state: bool, amounts: Array, t_s: Array) -> Trajectory | None:
    """Motion from a start whose place and velocity, and angles and rates, are off by relative amounts.

    None where a rate is off by more than :data:`MOST_RATE`: a diverged result asks for any, and its run would not end.
    """
    if state and not np.all(np.abs(amounts[4 + scene.bars :]) <= MOST_RATE):
        return None
    right = initial_state(scene)
    r0, v0 = scene.radius0_m, start_speed(scene)
    changes = {"com_m": right.com_m + r0 * amounts[:2], "com_velocity_m_s": right.com_velocity_m_s + v0 * amounts[2:4]}
    if state:
        n = scene.bars
        changes["angle_rad"] = right.angle_rad + amounts[4 : 4 + n]
        changes["rate_rad_s"] = right.rate_rad_s + scene.fastest_rate_rad_s * amounts[4 + n :]
    return motion_from(scene, dataclasses.replace(right, **changes), t_s)


def start_speed(scene: Scene) -> float:
    """Speed by which departures of a velocity count, m/s: that of the start, or of a circular orbit."""
    return abs(scene.speed0_m_s) or math.sqrt(scene.central_body.mu_m3_s2 / scene.radius0_m)


def start_words(scene: Scene, state: bool, amounts: Array) -> str:
    """Sentence on a start that is off."""
    place, speed = scene.radius0_m * amounts[:2], start_speed(scene) * amounts[2:4]
    found = [
        f"{noun} by ({vector[0]:.3g}, {vector[1]:.3g}) {unit}"
        for noun, vector, unit in (("position", place, "m"), ("velocity", speed, "m/s"))
    ]
    if state:
        n = scene.bars
        turned, rates = np.degrees(amounts[4 : 4 + n]), scene.fastest_rate_rad_s * amounts[4 + n :]
        found += [f"angles by ({', '.join(f'{v:.3g}' for v in turned)}) degrees",
                  f"rates by ({', '.join(f'{v:.3g}' for v in rates)}) rad/s"]  # fmt: skip
    return f"the start is off: {', '.join(found)}; from there on the motion is right"


def start_trials(scene: Scene, *, track: bool, state: bool) -> Iterator[Trial]:
    """Other starts: known ones, one whose speed, distance, longitude or rates are off, and any."""
    right = initial_state(scene)
    for known in STARTS:
        if not other_start(partial(known.change, scene), right):
            continue
        yield Trial(known.name, known.section, lambda _, w=known.sentence: w,  # type: ignore[misc]
                    partial(from_start, scene, lambda _, c=known.change: c(scene)))  # type: ignore[misc] # fmt: skip
    fitted = (
        ("initial-speed", "the speed at t = 0", ("orbit", "speed_factor")),
        ("initial-distance", "the altitude at t = 0", ("orbit", "altitude_m")),
        ("initial-longitude", "the longitude at t = 0", ("orbit", "longitude_rad")),
        ("initial-rates-times-a-factor", "the factor of the rates at t = 0", ("chain", "rate_factor")),
    )
    for name, subject, (part, field) in fitted:
        kind = ANGLE if field == "longitude_rad" else FACTOR
        number = Number(name, subject, RATES if part == "chain" else ORBIT, scene, ((part, field),), kind)
        if number.value(0.0) or field in ("longitude_rad", "rate_factor"):
            yield number_trial(number, partial(from_start, scene, number.change), within=number.range)
    if track or state:
        count = 4 + (2 * scene.bars if state else 0)
        yield Trial("another-start", ORBIT, partial(start_words, scene, state), partial(moved_start, scene, state),
                    (PROBE,) * count, (0.0,) * count)  # fmt: skip


def other_start(change: Callable[[], Scene], right: InitialState) -> bool:
    """Whether a changed scene has a start, and another one."""
    try:
        start = initial_state(change())
    except (ValueError, ArithmeticError):
        return False
    pairs = [(getattr(start, f.name), getattr(right, f.name)) for f in dataclasses.fields(start)]
    return any(np.abs(a - b).max(initial=0.0) > SAME * np.abs(b).max(initial=0.0) for a, b in pairs)


def from_start(scene: Scene, change: Callable[[float], Scene], amounts: Array, t_s: Array) -> Trajectory | None:
    """Motion of a scene from the start of another one."""
    try:
        start = initial_state(change(float(amounts[0]) if len(amounts) else 0.0))
    except (ValueError, ArithmeticError):
        return None
    return motion_from(scene, start, t_s)


def number_trial(
    number: Number, run: Run, more: str = "", within: tuple[float, float] = (-math.inf, math.inf)
) -> Trial:
    """Trial of a number that is fitted within a range of amounts."""

    def words(amounts: Array) -> str:
        return f"{number.words(float(amounts[0]))}{more}"

    probe = 1e-3 * number.probe if number.kind == "time" else PROBE
    name = f"{number.name}-and-start" if more else number.name
    return Trial(name, number.section, words, run, (probe,), (0.0,), number.slips, within,
                 lambda a: number.nice(float(a[0])))  # fmt: skip


def clock_trials(scene: Scene, first_s: float, late_s: float) -> Iterator[Trial]:
    """A clock that is late or early, and one that is so from the start on; `late_s` is where the fit begins."""
    interval_s = scene.run.duration_s / max(scene.run.samples - 1, 1)
    for started in (False, True) if first_s == 0.0 else (False,):
        words, run = partial(clock_words, first_s, started), partial(shifted, scene, started)
        name = "clock-from-the-start" if started else "clock"
        yield Trial(name, "samples", words, run, (1e-4 * interval_s,), (late_s,))


def strength_trials(scene: Scene) -> Iterator[Trial]:
    """Strengths of gravity and of each effect."""
    right = initial_state(scene)
    mu = Number(
        "gravitational-parameter", "the gravitational parameter", "orbit", scene, (("central_body", "mu_m3_s2"),)
    )
    if scene.effects.gravity != "none":
        yield number_trial(mu, partial(of_scene, mu.change, right))
        yield number_trial(mu, partial(of_scene, mu.change, None), ", at the start too")
    for number in strengths(scene):
        within = number.range[0], math.inf  # other units may make it millions of times too large
        yield number_trial(number, partial(of_scene, number.change, right), within=within)
    if scene.effects.oblateness is not None:
        words = "the oblateness drifts mean elements, and the start's osculating ones are taken as these"
        yield Trial("oblateness-by-mean-elements", ORBIT, lambda _: words, partial(by_mean_elements, scene),
                    nice=lambda _: True)  # fmt: skip
    for other in others(scene):
        if other.section == GRAVITY or other.name.endswith("missing") or other.name.startswith("sunlight"):
            yield fixed_trial(other.name, other.words, other.section, other.scene, right)


def strengths(scene: Scene) -> Iterator[Number]:
    """Strengths of effects as numbers."""
    for effect, fields in STRENGTHS.items():
        for field, noun in fields if getattr(scene.effects, effect) is not None else ():
            yield Number(f"{effect}-{field}", f"the {noun}", LOADS, scene, (("effects", effect, field),))
    for effect, (field, noun) in EACH_STRENGTH.items():
        given = getattr(scene.effects, effect)
        which = [f" {k + 1}" if len(given) > 1 else "" for k in range(len(given))]
        if effect == "third_body":
            which = body_words(scene)
        elif effect == "joint_torque":
            which = motor_words(scene)
        for k in range(len(given)):
            name, path = f"{effect}-{k + 1}-{field}", ("effects", effect, k, field)
            yield Number(name, f"the {noun.format(which[k])}", LOADS, scene, (path,))
        if len(given) > 1:
            every = tuple(("effects", effect, k, field) for k in range(len(given)))
            subject = ALL_STRENGTHS.get(effect, f"the force of all {effect}s")
            subject = f"the torque of all {motors_words(scene)}" if effect == "joint_torque" else subject
            yield Number(f"{effect}s-{field}", subject, LOADS, scene, every)


def fixed_trial(name: str, words: str, section: str, scene: Scene, start: InitialState) -> Trial:
    """Trial of another scene from the right start."""
    return Trial(name, section, lambda _: words, partial(of_scene, lambda _: scene, start), nice=lambda _: True)


def further_trials(scene: Scene) -> Iterator[Trial]:
    """All other numbers of a scene, those of single bars last, and all other scenes, from the right start."""
    right, tried = initial_state(scene), {n.name for n in strengths(scene)} | {"gravitational-parameter"}
    for number in sorted(numbers(scene), key=lambda n: n.name[-1].isdigit()):
        if number.name not in tried:
            yield number_trial(number, partial(of_scene, number.change, right), within=number.range)
    for other in others(scene):
        if not (other.section == GRAVITY or other.name.endswith("missing") or other.name.startswith("sunlight")):
            yield fixed_trial(other.name, other.words, other.section, other.scene, right)
