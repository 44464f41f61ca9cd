"""Numbers of a scene that an engine may have wrong: every one alone, all of a kind together, each fitted."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from barchain.judge.diagnosis.motion.set_points import motor_words, motors_words, moved_joints
from barchain.judge.diagnosis.motion.words import BODIES, LOADS, NICE, factor_words, near_one, nice_factor
from scenarios.toml.scene_tables import EARTH_MU_M3_S2, EARTH_RADIUS_M

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from scenarios import Scene

    Path = tuple[str | int, ...]

KNOWN = {
    "mu_m3_s2": (
        ("EGM2008, 3.986004415e14", 3.986004415e14),
        ("WGS 84, 3.986004418e14", 3.986004418e14),
        ("the first WGS 84, 3.986005e14", 3.986005e14),
        ("WGS 72, 3.986008e14", 3.986008e14),
        ("398600.44 km^3/s^2", 3.9860044e14),
        ("398600 km^3/s^2", 3.986e14),
        ("G times the Earth's mass, 6.674e-11 times 5.972e24", 6.674e-11 * 5.972e24),
        ("g = 9.81 m/s^2 at the Earth's radius", 9.81 * EARTH_RADIUS_M**2),
        ("the Earth, not of the given body", EARTH_MU_M3_S2),
    ),
    "radius_m": (
        ("the Earth's mean radius, 6371 km", 6.371e6),
        ("the Earth's equatorial radius, 6378.137 km", 6378137.0),
        ("the Earth's equatorial radius, 6378.1363 km", 6378136.3),
        ("the Earth's equatorial radius, 6378 km", 6.378e6),
    ),
    "j2": tuple((f"the Earth, {value}", value) for value in (1.08263e-3, 1.0826e-3, 1.08262668e-3)),
    "rotation_rad_s": (("the Earth, 7.2921e-5 rad/s", 7.2921159e-5),),
    "pressure_Pa": (("a black surface at 1 au, 4.56e-6 Pa", 4.56e-6),),
}  # fmt: skip
"""Values that engines take instead of a scene's, by field"""
LEAST = -2.5
"""Least change of a factor that may be negative: the opposite sign, with room for a fit that overshoots"""
MISSING, OPPOSITE, TWICE = -1.0, -2.0, 1.0
"""Changes of a factor that is missing, of one of the opposite sign, and of one that is counted twice"""
KNOWN_DIGITS = 3e-7
"""Largest relative difference of a fitted number from a known value"""
KNOWN_SHARE = 0.1
"""The same, relative to the distance of the known value from the scene's: the scene's own value is no mistake"""
FACTOR, ANGLE, TIME = "factor", "angle", "time"
"""What is fitted: a factor, an angle that is added, or a time that is added"""
CHAIN = (
    ("mass_kg", "mass", 1),
    ("length_m", "length", 2),
    ("inertia_kg_m2", "moment of inertia", 0),
)
"""Properties of bars: field, noun, and the power of each in moments of inertia, which an engine may compute from it"""
EFFECTS: dict[str, tuple[tuple[str, str, str], ...]] = {
    "oblateness": (("j2", "coefficient J2", FACTOR), ("radius_m", "reference radius of J2", FACTOR)),
    "third_body": (
        ("mu_m3_s2", "gravitational parameter", FACTOR), ("distance_m", "distance", FACTOR),
        ("longitude_rad", "longitude", ANGLE), ("rate_rad_s", "rate", FACTOR),
    ),
    "drag": (
        ("density_kg_m3", "density of the air", FACTOR), ("altitude_m", "altitude of the air's density", FACTOR),
        ("scale_height_m", "scale height of the air", FACTOR), ("rotation_rad_s", "rotation of the air", FACTOR),
        ("width_m", "width for the drag", FACTOR), ("normal_coefficient", "normal coefficient of the drag", FACTOR),
        ("tangential_coefficient", "tangential coefficient of the drag", FACTOR),
    ),
    "solar_pressure": (
        ("pressure_Pa", "pressure of sunlight", FACTOR), ("sun_longitude_rad", "direction of the Sun", ANGLE),
        ("sun_rate_rad_s", "rate of the Sun's direction", FACTOR), ("width_m", "width for the sunlight", FACTOR),
        ("reflectivity", "reflectivity", FACTOR),
    ),
    "joint_spring_damper": (
        ("stiffness_N_m_rad", "stiffness", FACTOR), ("damping_N_m_s_rad", "damping", FACTOR),
        ("rest_rad", "rest angle", FACTOR),
    ),
    "joint_torque": (("times_s", "table of instants", TIME), ("torque_N_m", "torque", FACTOR)),
    "thrust": (
        ("direction_rad", "direction", ANGLE), ("times_s", "table of instants", TIME), ("force_N", "force", FACTOR),
    ),
    "impulse": (("direction_rad", "direction", ANGLE), ("impulse_N_s", "size", FACTOR), ("at_s", "instant", TIME)),
    "prescribed_rotation": (
        ("amplitude_rad", "amplitude", FACTOR), ("duration_s", "duration", FACTOR), ("start_s", "start", TIME),
    ),
}  # fmt: skip
"""Numbers of effects: field, noun, and what is fitted"""
OWNERS = {
    "third_body": ("", "third bodies"), "prescribed_rotation": ("prescribed rotation", "prescribed rotations"),
}  # fmt: skip
"""Nouns of an effect of which a scene may have several, where they are not its name"""
GAINS = {"spring": "stiffness_N_m_rad", "damper": "damping_N_m_s_rad"}
"""Fields of springs and dampers by what they belong to"""
PLACES = {"joint_spring_damper": "joint", "drag": "bar", "solar_pressure": "bar"}
"""What the entries of an effect's tuples belong to"""


def body_words(scene: Scene) -> list[str]:
    """Nouns of the third bodies; the Moon and the Sun by name, others and those of one name by number."""
    names = [body.name for body in scene.effects.third_body]
    return [n.capitalize() if n in ("moon", "sun") and names.count(n) == 1 else f"third body {k + 1}"
            for k, n in enumerate(names)]  # fmt: skip


@dataclass(frozen=True)
class Number:
    """A number of a scene, or several with a common change."""

    name: str
    subject: str
    """Noun with `the`"""
    section: str
    scene: Scene
    """Right scene"""
    paths: tuple[Path, ...]
    kind: str = FACTOR
    powers: tuple[float, ...] = (1.0,)
    """Power of the factor in each number"""
    peers: tuple[float, ...] = ()
    """Other values that may have come in its place"""

    @property
    def interval_s(self) -> float:
        """Time between the scene's samples."""
        return self.scene.run.duration_s / (self.scene.run.samples - 1)

    @property
    def probe(self) -> float:
        """Amount that is small enough for a linear effect."""
        return 1e-3 * self.interval_s if self.kind == TIME else 1e-5

    @property
    def range(self) -> tuple[float, float]:
        """Least and largest amount.

        Masses and lengths are positive, and so is what is raised to a broken power. A factor may have the opposite
        sign, and is hardly more negative: with negative damping a fit soon takes all the time there is.
        """
        most = {FACTOR: 100.0, ANGLE: math.pi, TIME: 16.0 * self.interval_s}[self.kind]
        positive = self.section == BODIES or any(power % 1.0 for power in self.powers)
        return (-most if self.kind != FACTOR else -0.95 if positive else LEAST), most

    @property
    def slips(self) -> tuple[float, ...]:
        """Changes of a load's factor that are far from a linear effect: it is missing; rest angles also turn round.

        Stiffness and damping of the opposite sign blow up; twice of them is another oscillation.
        """
        if self.section != LOADS or self.kind != FACTOR:
            return ()
        if any("rest_rad" in path for path in self.paths):
            return MISSING, OPPOSITE
        return (MISSING, TWICE) if any("joint_spring_damper" in path for path in self.paths) else (MISSING,)

    def change(self, amount: float) -> Scene:
        """Scene with an amount; 0: the right scene."""
        found = self.scene
        for k, path in enumerate(self.paths):

            def one(v: Any, power: float = self.powers[k % len(self.powers)]) -> Any:
                if isinstance(v, tuple):
                    return tuple(map(one, v))
                return v * (1.0 + amount) ** power if self.kind == FACTOR else v + amount

            found = replaced(found, path, one)
        return found

    def value(self, amount: float) -> float | None:
        """Value that an amount makes; None of several numbers, of zero, and of what is no factor."""
        found = read(self.scene, self.paths[0])
        alone = len(self.paths) == 1 and isinstance(found, float) and self.kind == FACTOR
        return found * (1.0 + amount) if alone and found else None

    def known(self, amount: float) -> str:
        """Known value that an amount makes; empty without one."""
        value = self.value(amount)
        if value is None:
            return ""
        right = read(self.scene, self.paths[0])
        near = (*KNOWN.get(str(self.paths[0][-1]), ()), ("single precision", float(np.float32(right))))
        apart, known, words = min(((abs(value / k - 1.0), k, said) for said, k in near))
        from_right = abs(known / right - 1.0)
        return words if apart < min(KNOWN_DIGITS, KNOWN_SHARE * from_right) else ""

    def as_in(self, other: Number, amount: float) -> float:
        """Amount that makes here what it makes of the number in another scene: a known value is the same everywhere."""
        right, value = self.value(0.0), other.value(amount)
        return value / right - 1.0 if other.known(amount) and right and value is not None else amount

    def peer(self, amount: float) -> bool:
        """Whether an amount makes the value of another place."""
        value, right = self.value(amount), self.value(0.0)
        return value is not None and any(abs(value - p) <= NICE * abs(p) for p in self.peers if p != right)

    def nice(self, amount: float) -> bool:
        """Whether an amount is one that a slip would give."""
        if self.kind == FACTOR:
            return bool(nice_factor(1.0 + amount) or self.known(amount) or self.peer(amount))
        unit = 0.5 * math.pi if self.kind == ANGLE else 0.5 * self.interval_s
        return abs(amount) > 0.5 * unit and abs(amount / unit - round(amount / unit)) < NICE

    def words(self, amount: float) -> str:
        """Sentence of an amount."""
        if self.kind == ANGLE:
            return f"{self.subject} is off by {math.degrees(amount):.4g} degrees"
        if self.kind == TIME:
            return f"{self.subject} is {abs(amount):.4g} s too {'late' if amount > 0.0 else 'early'}"
        if self.known(amount):
            return f"{self.subject} is {near_one(1.0 + amount)} times the scene's, that of {self.known(amount)}"
        said, value = factor_words(1.0 + amount), self.value(amount)
        if self.paths[0][-1] == "mu_m3_s2" and value is not None and not nice_factor(1.0 + amount):
            return f"{self.subject} is {value:.10g} m^3/s^2, {near_one(1.0 + amount)} times the scene's"
        place = ", that of another place" if self.peer(amount) else ""
        return f"{self.subject} is {'zero' if said == 'missing' else said}{place}"


def replaced(whole: Any, path: Path, value: Callable[[Any], Any]) -> Any:
    """Copy of nested dataclasses and tuples with one value changed."""
    if not path:
        return value(whole)
    first, rest = path[0], path[1:]
    if isinstance(first, int):
        return (*whole[:first], replaced(whole[first], rest, value), *whole[first + 1 :])
    return dataclasses.replace(whole, **{first: replaced(getattr(whole, first), rest, value)})


def read(whole: Any, path: Path) -> Any:
    """Value at a path."""
    for step in path:
        whole = whole[step] if isinstance(step, int) else getattr(whole, step)
    return whole


def numbers(scene: Scene) -> Iterator[Number]:
    """All numbers of a scene that the motion shows."""
    if scene.effects.gravity != "none":
        mu = ("central_body", "mu_m3_s2")
        yield Number("gravitational-parameter", "the gravitational parameter", "orbit", scene, (mu,))
    yield from of_chain(scene)
    for effect, fields in EFFECTS.items():
        given = getattr(scene.effects, effect)
        if given is None or given == ():
            continue
        one, every = OWNERS.get(effect, (effect, f"{effect}s"))
        paths: tuple[Path, ...]
        if not isinstance(given, tuple):
            yield from of_effect(scene, ("effects", effect), "")
            yield from of_gains(scene) if effect == "joint_spring_damper" else ()
            continue
        owners = [f"{one} {k + 1}" if len(given) > 1 else one for k in range(len(given))]
        if effect == "third_body":
            owners = body_words(scene)
        elif effect == "joint_torque":
            owners, every = motor_words(scene), motors_words(scene)
        for k, owner in enumerate(owners):
            yield from of_effect(scene, ("effects", effect, k), f" of the {owner}")
            if effect == "third_body" and turns_freely(scene, k):
                paths = tuple(("effects", effect, k, field) for field in ("distance_m", "rate_rad_s"))
                yield Number(f"{effect}-{k + 1}-distance_m-with-rate", f"the distance of the {owner}, in its rate too,",
                             LOADS, scene, paths, powers=(1.0, -1.5))  # fmt: skip
        for field, noun, kind in fields if len(given) > 1 else ():
            paths = tuple(("effects", effect, k, field) for k in range(len(given)))
            yield Number(f"{effect}s-{field}", f"the {noun} of all {every}", LOADS, scene, paths, kind)


def of_gains(scene: Scene) -> Iterator[Number]:
    """Common factor of stiffness and damping: of all joints, and of each that follows a set point, which it moves.

    Without set points, the factor of the one that there is alone is a number already.
    """
    moved, springs = moved_joints(scene), ("effects", "joint_spring_damper")
    for joint in (None, *moved) if scene.bars > 2 or not moved else moved:
        of_joint: Path = () if joint is None else (joint - 1,)
        gains: dict[str, Path] = {noun: (*springs, field, *of_joint) for noun, field in GAINS.items()}
        gains = {noun: path for noun, path in gains.items() if np.any(read(scene, path))}
        if not gains or (len(gains) == 1 and not moved):
            continue
        motors = [point.motor for own, point in moved.items() if joint in (None, own) and point.motor is not None]
        paths = (*gains.values(), *(("effects", "joint_torque", k, "torque_N_m") for k in motors))
        whose, ending = ("all joints", "") if joint is None else (f"the control in joint {joint}", f"-{joint}")
        which = f"of {'' if len(gains) > 1 else 'the '}{' and '.join(gains)}"
        yield Number(f"joint-gains{ending}", f"the gain of {whose}, {which},", LOADS, scene, paths)


def turns_freely(scene: Scene, k: int) -> bool:
    """Whether a third body turns as fast as gravity has it turn: an engine may compute its rate from its distance."""
    body = scene.effects.third_body[k]
    free_rad_s = math.sqrt((scene.central_body.mu_m3_s2 + body.mu_m3_s2) / body.distance_m**3)
    return abs(body.rate_rad_s - free_rad_s) <= NICE * free_rad_s


def of_chain(scene: Scene) -> Iterator[Number]:
    """Masses, lengths and moments of inertia of one bar or all, alone or with the moments of inertia that follow."""
    for bar in (*(range(scene.bars) if scene.bars > 1 else ()), None):
        of, ending = (" of all bars", "") if bar is None else (f" of bar {bar + 1}", f"-{bar + 1}")
        inertias = "moments" if bar is None else "moment"
        for field, noun, power in CHAIN:
            paths: tuple[Path, ...] = tuple(
                ("chain", f) if bar is None else ("chain", f, bar) for f in (field, "inertia_kg_m2")
            )
            peers = getattr(scene.chain, field)
            yield Number(f"{field}{ending}", f"the {noun}{of}", BODIES, scene, paths[:1], peers=peers)
            if power:
                subject = f"the {noun}{of}, in the {inertias} of inertia too,"
                yield Number(f"{field}-with-inertia{ending}", subject, BODIES, scene, paths, powers=(1.0, power))


def of_effect(scene: Scene, at: Path, of: str) -> Iterator[Number]:
    """Numbers of one effect; of a tuple, each value and all together."""
    effect = str(at[1])
    for field, noun, kind in EFFECTS[effect]:
        value = read(scene, (*at, field))
        name = "-".join([effect, *(str(k + 1) for k in at if isinstance(k, int)), field])
        for j in range(len(value)) if isinstance(value, tuple) and len(value) > 1 else ():
            subject = f"the {noun} of {PLACES.get(effect, 'entry')} {j + 1}{of}"
            yield Number(f"{name}-{j + 1}", subject, LOADS, scene, ((*at, field, j),), kind, peers=value)
        all_joints = " of all joints" if effect == "joint_spring_damper" else ""
        yield Number(name, f"the {noun}{of or all_joints}", LOADS, scene, ((*at, field),), kind)
