"""Numbers of a scene that an engine may have wrong by an unknown amount, which a fit finds."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from barchain.judge.diagnosis.altered_scenes.bodies import SECTION as BODIES
from barchain.judge.diagnosis.altered_scenes.changes import part
from barchain.judge.diagnosis.altered_scenes.events import delayed, interval_s
from barchain.judge.diagnosis.altered_scenes.loads import SECTION as LOADS
from barchain.judge.diagnosis.altered_scenes.loads import each, single, times, with_effects
from barchain.judge.diagnosis.altered_scenes.start import ANGLES, ORBIT, RATES
from barchain.judge.diagnosis.mistake import SceneMistake
from barchain.judge.diagnosis.readings.fitted import factor_words
from scenarios.effect_types import JointSpringDamper

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from barchain.judge.diagnosis.mistake import ModelChange, SceneChange
    from scenarios import Scene

    Words = Callable[[float], str]

SAMPLES = "samples"
RELATIVE = (-0.9, 9.0)
"""Range of a relative departure: a tenth to ten times the right value"""


@dataclass(frozen=True)
class Amount:
    """A number of the scene or of its equations, wrong by an amount."""

    name: str
    section: str
    change: Callable[[float], SceneChange] | None
    """Altered scene of an amount; None if the equations are altered"""
    words: Words
    """Sentence of an amount, without a full stop"""
    probe: float
    """Amount that is small enough for a linear effect"""
    range: tuple[float, float]
    model: Callable[[float], ModelChange] | None = None
    """Altered equations of an amount; None if the scene is altered"""

    def mistake(self, amount: float) -> SceneMistake:
        """Mistake in the scene with an amount."""
        scene, model = self.change and self.change(amount), self.model and self.model(amount)
        return SceneMistake(self.name, self.words(amount), self.section, scene, model)


def amounts(scene: Scene) -> tuple[Amount, ...]:
    """All numbers of a scene that are fitted, and of joints that the scene has free of torques."""
    own = (*of_bodies(scene), *of_start(scene), *of_orbit(), *of_clock(), *of_effects(scene), *of_events(scene))
    return (*own, *of_free_joints(scene))


def relative(name: str, subject: str, section: str, change: Callable[[float], SceneChange]) -> Amount:
    """A number times 1 + amount; `change` takes that factor."""

    def words(amount: float) -> str:
        values = "values" if subject.endswith("are") else "value"
        return f"{subject} {factor_words(1.0 + amount)} times the right {values}"

    return Amount(name, section, lambda a: change(1.0 + a), words, 1e-5, RELATIVE)


def shifted(name: str, subject: str, section: str, change: Callable[[float], SceneChange]) -> Amount:
    """An angle plus an amount in radians."""

    def words(amount: float) -> str:
        return f"{subject} off by {math.degrees(amount):.4g} degrees"

    return Amount(name, section, change, words, 1e-5, (-math.pi, math.pi))


def at_bar(field: str, bar: int, value: Callable[[float], float]) -> SceneChange:
    """A value of one bar changed, from 0."""

    def values(scene: Scene) -> tuple[float, ...]:
        old = getattr(scene.chain, field)
        return (*old[:bar], value(old[bar]), *old[bar + 1 :])

    return part("chain", **{field: values})


def at_all_bars(field: str, value: Callable[[float], float]) -> SceneChange:
    """A value of all bars changed."""
    return part("chain", **{field: lambda scene: tuple(map(value, getattr(scene.chain, field)))})


PROPERTIES = (
    ("mass_kg", "mass", "the mass", "the masses"),
    ("length_m", "length", "the length", "the lengths"),
    ("inertia_kg_m2", "inertia", "the moment of inertia", "the moments of inertia"),
)


WITH_INERTIA = (("mass_kg", "mass", 1), ("length_m", "length", 2))
"""Properties from which an engine may compute moments of inertia, m l²/12, and the power of each"""


def of_bodies(scene: Scene) -> Iterator[Amount]:
    """Masses, lengths and moments of inertia, of one bar or of all; equal factors of all masses move nothing else."""
    for field, name, one, every in PROPERTIES:
        for bar in range(scene.bars if scene.bars > 1 else 0):
            subject = f"{one} of bar {bar + 1} is"
            yield relative(f"{name}-of-bar-{bar + 1}", subject, BODIES, times_at_bar(field, bar))
        yield relative(f"{name}-of-all-bars", f"{every} are", BODIES, times_at_all(field))
    for field, name, power in WITH_INERTIA:
        for bar in range(scene.bars if scene.bars > 1 else 0):
            words = f"the {name} of bar {bar + 1}, in the moment of inertia too, is"
            yield relative(f"{name}-with-inertia-of-bar-{bar + 1}", words, BODIES, both_at_bar(field, power, bar))


def both_at_bar(field: str, power: int, bar: int) -> Callable[[float], SceneChange]:
    """Change of a value of one bar by a factor, and of its moment of inertia by a power of the factor."""

    def of(factor: float) -> SceneChange:
        value = at_bar(field, bar, lambda v: v * factor)
        inertia = at_bar("inertia_kg_m2", bar, lambda v: v * factor**power)
        return lambda scene: inertia(value(scene))

    return of


def times_at_bar(field: str, bar: int) -> Callable[[float], SceneChange]:
    """Change of a value of one bar by a factor."""
    return lambda factor: at_bar(field, bar, lambda v: v * factor)


def times_at_all(field: str) -> Callable[[float], SceneChange]:
    """Change of a value of all bars by a factor."""
    return lambda factor: at_all_bars(field, lambda v: v * factor)


def of_start(scene: Scene) -> Iterator[Amount]:
    """Initial angles and rates, of one bar or of all."""
    for bar in range(scene.bars if scene.bars > 1 else 0):
        yield shifted(f"initial-angle-of-bar-{bar + 1}", f"the initial angle of bar {bar + 1} is", ANGLES,
                      shift_at_bar("angle_rad", bar))  # fmt: skip
        yield rate_amount(f"initial-rate-of-bar-{bar + 1}", f"the initial rate of bar {bar + 1} is",
                          shift_at_bar("rate_factor", bar))  # fmt: skip
    yield shifted("initial-angles", "the initial angles are", ANGLES, shift_at_all("angle_rad"))
    yield rate_amount("initial-rates", "the initial rates are", shift_at_all("rate_factor"))
    yield relative("initial-rates-times-a-factor", "the initial rates are", RATES, times_at_all("rate_factor"))


def shift_at_bar(field: str, bar: int) -> Callable[[float], SceneChange]:
    """Change of a value of one bar by a sum."""
    return lambda amount: at_bar(field, bar, lambda v: v + amount)


def shift_at_all(field: str) -> Callable[[float], SceneChange]:
    """Change of a value of all bars by a sum."""
    return lambda amount: at_all_bars(field, lambda v: v + amount)


def rate_amount(name: str, subject: str, change: Callable[[float], SceneChange]) -> Amount:
    """Initial rates plus an amount in units of the orbital rate."""
    return Amount(name, RATES, change, lambda a: f"{subject} off by {a:.4g} orbital rates", 1e-5, (-9.0, 9.0))


def of_orbit() -> Iterator[Amount]:
    """Gravity of the body, and the start of the orbit."""
    yield relative("gravitational-parameter", "the gravitational parameter is", ORBIT,
                   lambda f: part("central_body", mu_m3_s2=lambda s: f * s.central_body.mu_m3_s2))  # fmt: skip
    yield relative("initial-radius", "the initial distance from the body's centre is", ORBIT,
                   lambda f: part("orbit", altitude_m=lambda s: f * s.radius0_m - s.central_body.radius_m))  # fmt: skip
    yield relative("speed-factor", "the speed factor is", ORBIT,
                   lambda f: part("orbit", speed_factor=lambda s: f * s.orbit.speed_factor))  # fmt: skip
    yield shifted("initial-longitude", "the initial longitude is", ORBIT,
                  lambda a: part("orbit", longitude_rad=lambda s: a + s.orbit.longitude_rad))  # fmt: skip


SINGLE = (
    ("oblateness", "the coefficient J2 is", "j2"),
    ("drag", "the density of the air is", "density_kg_m3"),
    ("drag", "the scale height of the air is", "scale_height_m"),
    ("drag", "the rotation of the air is", "rotation_rad_s"),
    ("drag", "the normal coefficient of the drag is", "normal_coefficient"),
    ("drag", "the tangential coefficient of the drag is", "tangential_coefficient"),
    ("solar_pressure", "the pressure of sunlight is", "pressure_Pa"),
    ("solar_pressure", "the reflectivity is", "reflectivity"),
    ("joint_spring_damper", "the stiffness of the joints is", "stiffness_N_m_rad"),
    ("joint_spring_damper", "the damping of the joints is", "damping_N_m_s_rad"),
)
EACH = (
    ("third_body", "the gravitational parameters of the third bodies are", "mu_m3_s2"),
    ("thrust", "the thrusts are", "force_N"),
    ("impulse", "the impulses are", "impulse_N_s"),
    ("prescribed_rotation", "the amplitudes of the prescribed rotations are", "amplitude_rad"),
    ("prescribed_rotation", "the durations of the prescribed rotations are", "duration_s"),
)


def of_clock() -> Iterator[Amount]:
    """Instants of the samples: a step that is a little too long adds up."""

    def change(amount: float) -> SceneChange:
        return part("run", duration_s=lambda s: (1.0 + amount) * s.run.duration_s)

    def words(amount: float) -> str:
        return f"the samples are taken at {factor_words(1.0 + amount)} times their instants"

    yield Amount("clock", SAMPLES, change, words, 1e-5, (-0.1, 0.1))


def of_effects(scene: Scene) -> Iterator[Amount]:
    """Sizes of the effects that the scene has."""
    for effects, change in ((SINGLE, single), (EACH, each)):
        for effect, subject, field in effects:
            if getattr(scene.effects, effect):
                yield relative(f"{effect}-{field}".replace("_", "-").lower(), subject, LOADS,
                               times_of(change, effect, field))  # fmt: skip


def times_of(change: Callable[..., SceneChange], effect: str, field: str) -> Callable[[float], SceneChange]:
    """Change of a number, or of a tuple of numbers, of an effect by a factor."""
    return lambda factor: times(change, effect, field, factor)


def of_free_joints(scene: Scene) -> Iterator[Amount]:
    """Stiffness and damping of joints in which the scene has neither."""
    if scene.bars == 1 or scene.effects.joint_spring_damper is not None:
        return
    rate = scene.fastest_rate_rad_s
    damping = rate * min(scene.chain.inertia_kg_m2)
    for field, word, unit, size in (
        ("damping_N_m_s_rad", "friction", "N m s/rad", damping),
        ("stiffness_N_m_rad", "stiffness", "N m/rad", rate * damping),
    ):
        yield Amount(
            f"joint-{word}", LOADS, joint_torques(field, size), added_words(word, unit, size), 1e-5, (0.0, 20.0)
        )


def joint_torques(field: str, size: float) -> Callable[[float], SceneChange]:
    """Change that adds equal springs or dampers to all joints."""

    def of(amount: float) -> SceneChange:
        def change(scene: Scene) -> Scene:
            none = (0.0,) * (scene.bars - 1)
            free = JointSpringDamper(none, none, none)
            added = dataclasses.replace(free, **{field: (amount * size,) * (scene.bars - 1)})
            return with_effects(scene, joint_spring_damper=added)

        return change

    return of


def added_words(word: str, unit: str, size: float) -> Words:
    """Sentence of a torque in the joints that the scene has not."""
    return lambda amount: f"the joints have a {word} of {amount * size:.4g} {unit}, and the scene's have none"


EVENTS = (
    ("thrust", "the thrusts act"),
    ("impulse", "the impulses act"),
    ("prescribed_rotation", "the prescribed rotations begin"),
)


def of_events(scene: Scene) -> Iterator[Amount]:
    """Instants of thrusts, impulses and prescribed rotations."""
    interval = interval_s(scene)
    for effect, subject in EVENTS:
        if getattr(scene.effects, effect):
            yield Amount(
                f"{effect}-late".replace("_", "-"), LOADS, partial(delayed, effect), late_words(subject),
                0.01 * interval, (-interval, interval),
            )  # fmt: skip


def late_words(subject: str) -> Words:
    """Sentence of a delay, s."""
    return lambda late_s: f"{subject} {abs(late_s):.4g} s too {'late' if late_s > 0.0 else 'early'}"
