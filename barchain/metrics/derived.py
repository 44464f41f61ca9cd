"""Derived channels: functions of a stored trajectory and its scene, one for each entry of the table of their names.

A function takes a :class:`Motion` of n samples, and returns an array of the shape that its entry in
:mod:`scenarios.derived_channels` gives. Nothing here is stored or judged.
"""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from adapters.common.reference_model import chain_model
from adapters.trajectory import instants
from reference_impl.effects.joint_spring_damper import JointSpringDamperEffect
from reference_impl.model import invariants
from reference_impl.model.complex_vectors import as_complex, as_vectors, unit_along
from reference_impl.model.effect import EffectState
from reference_impl.model.gravity import complex_field_differences, gradient_angular_accelerations
from reference_impl.model.kinematics import consistent_state, cross, directions, relative_positions
from scenarios.channels import CHANNELS, Of
from scenarios.derived_channels import DERIVED_CHANNELS, channel_of
from scenarios.effect_types import Gravity
from scenarios.nearest import nearest
from scenarios.text import shorten

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from adapters.trajectory import Array, Trajectory
    from reference_impl.model.arrays import ComplexArray
    from reference_impl.model.chain import ChainModel
    from reference_impl.model.effect import ChainEffect
    from scenarios import Scene

GRAVITY = "gravity"
PARTS_OF_GRAVITY = ("slender", "quadrupole")
"""Effects of the reference that complete a gravity model of point masses or of gradient torques"""
TURN = 2.0 * np.pi


class DerivedError(ValueError):
    """A channel that does not exist, or can't be computed of a trajectory; one line."""


class Motion:
    """Arrays of a trajectory, n samples, and its scene; each derived quantity is computed once."""

    def __init__(self, trajectory: Trajectory) -> None:
        """Keep a trajectory."""
        self.trajectory = trajectory

    def array(self, name: str) -> Array:
        """Array of a stored channel.

        Raises
        ------
        DerivedError
            If the trajectory lacks it.
        """
        found: Array | None = getattr(self.trajectory, CHANNELS[name].array)
        if found is None:
            raise DerivedError(f"needs {CHANNELS[name].words} ({CHANNELS[name].array}), which this trajectory lacks")
        return found

    @property
    def scene(self) -> Scene:
        """Scene of the run.

        Raises
        ------
        DerivedError
            If it is not known.
        """
        if self.trajectory.run_scene is None:
            raise DerivedError("needs the scene of the run; give it by Trajectory.of_run(scene)")
        return self.trajectory.run_scene

    @cached_property
    def model(self) -> ChainModel:
        """The reference's model of the scene."""
        return chain_model(self.scene)

    @property
    def com(self) -> Array:
        """Centre of mass, (n, 2) m."""
        return self.trajectory.com_m

    @property
    def angle(self) -> Array:
        """Angles of the bars, (n, N) rad."""
        return self.array("attitude")

    @property
    def rate(self) -> Array:
        """Rates of the bars, (n, N) rad/s."""
        return self.array("rate")

    @cached_property
    def centres(self) -> Array:
        """Centres of the bars from the centre of mass, (n, N, 2) m: as the engine gives them, else by the angles."""
        stored = self.trajectory.position_m
        return relative_positions(self.model, self.angle) if stored is None else stored

    @cached_property
    def right_ends(self) -> Array:
        """Right ends of all bars from the centre of mass, (n, N, 2) m."""
        found: Array = self.centres + self.model.right_m[:, None] * directions(self.angle)[0]
        return found

    @cached_property
    def joints(self) -> Array:
        """Right ends of all bars but the last from the centre of mass, (n, N-1, 2) m."""
        return self.right_ends[:, :-1]

    @cached_property
    def ends(self) -> Array:
        """Free ends of the chain from the centre of mass, (n, 2, 2) m."""
        first = self.centres[:, 0] - self.model.left_m[0] * directions(self.angle[:, 0])[0]
        return np.stack([first, self.right_ends[:, -1]], axis=1)

    @cached_property
    def cuts(self) -> Array:
        """Force on the part before from the part behind, at both ends of each bar, (n, N+1, 2) N; 0 at free ends."""
        return np.pad(self.array("reaction"), ((0, 0), (1, 1), (0, 0)))

    @cached_property
    def wrenches(self) -> dict[str, tuple[ComplexArray, Array]]:
        """Force (n, N) N, as complex numbers, and torque (n, N) N m on each bar, by the name of the effect.

        Several effects of one name are added, and so are all parts of a gravity model. At the instant of an event an
        effect may have the value of either side.
        """
        model, scene = self.model, self.scene
        found: dict[str, tuple[ComplexArray, Array]] = {}
        if scene.effects.gravity is not Gravity.NONE:
            found[GRAVITY] = self.point_gravity()
        for effect in model.effects:
            name = GRAVITY if effect.name in PARTS_OF_GRAVITY else effect.name
            force, torque = found.get(name, (0.0, 0.0))
            added = self.wrench(effect)
            found[name] = force + added[0], torque + added[1]
        return found

    def point_gravity(self) -> tuple[ComplexArray, Array]:
        """Force and torque of point or gradient gravity on each bar, each (n, N)."""
        model, com = self.model, as_complex(self.com)[:, None]
        place = as_complex(self.centres)
        pull = complex_field_differences(model.mu_m3_s2, com, place) - model.mu_m3_s2 * com / np.abs(com) ** 3
        turned = np.zeros(place.shape)
        if model.gravity == "gradient":
            turned = gradient_angular_accelerations(model, com + place, unit_along(self.angle))
        return model.mass_kg * pull, model.inertia_kg_m2 * turned

    def wrench(self, effect: ChainEffect) -> tuple[ComplexArray, Array]:
        """Force and torque of an effect on each bar, each (n, N)."""
        model, along = self.model, unit_along(self.angle)
        force, torque = np.empty(along.shape, complex), np.empty(along.shape)
        states = zip(self.com, self.array("com_velocity"), self.angle, self.rate, strict=True)
        for k, (state, at_s) in enumerate(zip(states, self.trajectory.t_s, strict=True)):
            at = EffectState(model, float(at_s), consistent_state(model, *state), along[k])
            added = effect.accelerations(at, None)
            force[k] = model.mass_kg * (added.common + added.difference)
            torque[k] = model.inertia_kg_m2 * added.angular
        return force, torque

    @cached_property
    def mu(self) -> float:
        """Gravitational parameter, m³/s².

        Raises
        ------
        DerivedError
            If the scene has no gravity, and so no orbit.
        """
        if self.scene.effects.gravity is Gravity.NONE:
            raise DerivedError(f"needs gravity, which {self.scene.name} has not")
        return self.scene.central_body.mu_m3_s2

    @cached_property
    def eccentricity_vector(self) -> ComplexArray:
        """Eccentricity vector of the osculating orbit, (n,): v x h / mu less the unit vector of the radius."""
        place, velocity = as_complex(self.com), as_complex(self.array("com_velocity"))
        momentum = (place.conj() * velocity).imag
        found: ComplexArray = -1j * momentum * velocity / self.mu - place / np.abs(place)
        return found


def in_local_frame(motion: Motion, offset: Array) -> Array:
    """Offsets from the centre of mass (n, k, 2) along the local vertical and 90° ahead of it."""
    vertical = as_complex(motion.com)
    return as_vectors(as_complex(offset) * (vertical.conj() / np.abs(vertical))[:, None])


def from_body(motion: Motion, offset: Array) -> Array:
    """Offsets from the centre of mass (n, k, 2) as positions from the body's centre."""
    found: Array = motion.com[:, None] + offset
    return found


def both(ends: Array) -> Array:
    """Vectors at both ends (n, 2, 2) as (n, 4)."""
    return ends.reshape(len(ends), 4)


def at_both_ends(motion: Motion, part: int) -> Array:
    """Component of the cut force at both ends of each bar, (n, N, 2): along the bar (0) or across it (1)."""
    axis = directions(motion.angle)[part]
    cuts = (motion.cuts[:, :-1], motion.cuts[:, 1:])
    return np.stack([np.sum(cut * axis, axis=-1) for cut in cuts], axis=-1)


def vertical_angle(motion: Motion) -> Array:
    """Angles from the longitude of the centre of mass, (n, N) rad, continuous over the samples."""
    longitude = np.unwrap(np.arctan2(motion.com[:, 1], motion.com[:, 0]))
    found: Array = motion.angle - longitude[:, None]
    return found


def joint_torque(motion: Motion) -> Array:
    """Torque of spring, damper and motor on the bar before each joint, (n, N-1) N m; at a jump, just before it.

    Raises
    ------
    DerivedError
        If the scene has neither.
    """
    called = motion.scene.effects
    if not (called.joint_spring_damper or called.joint_torque):
        raise DerivedError(f"needs the effect joint_spring_damper or joint_torque, which {motion.scene.name} has not")
    found = np.zeros_like(motion.angle[:, :-1])
    for springs in (e for e in motion.model.effects if isinstance(e, JointSpringDamperEffect)):
        found += springs.torque(motion.angle, motion.rate)
    begin, *_ = instants_s = motion.trajectory.t_s.tolist()
    for motor in called.joint_torque:
        on = motor.times_s[0]  # where it jumps to its first size, unless the run begins there
        found[:, motor.joint - 1] -= [0.0 if t == on > begin else motor.size_N_m(t) for t in instants_s]
    return found


def torque_power(m: Motion) -> Array:
    """Power of the torque of each prescribed rotation, (n, P) W."""
    torque, laws = m.array("torque"), m.model.prescriptions
    if not laws or torque.shape[1] != len(laws):
        raise DerivedError(
            f"needs a law for each torque, which {m.scene.name} lacks; joined runs have it by themselves"
        )
    turned = [m.rate[:, law.bar] - (0.0 if law.reacts_on is None else m.rate[:, law.reacts_on]) for law in laws]
    found: Array = torque * np.stack(turned, axis=1)
    return found


def gravity_energy(motion: Motion) -> Array:
    """Potential energy of gravity about the centre of mass, (n,) J."""
    if motion.scene.effects.gravity is Gravity.NONE:
        return np.zeros(len(motion.com))
    found = invariants.tidal_energy(motion.model, motion.com, motion.angle)
    for effect in (e for e in motion.model.effects if e.name in PARTS_OF_GRAVITY):
        found = found + effect.energy(motion.model, motion.com, motion.angle)
    return found


def kinetic_energy(motion: Motion) -> Array:
    """Kinetic energy about the centre of mass, (n,) J."""
    return invariants.relative_kinetic_energy(motion.model, motion.angle, motion.rate)


def total_energy(motion: Motion) -> Array:
    """Kinetic and potential energy about the centre of mass, with that of the springs, (n,) J."""
    found = kinetic_energy(motion) + gravity_energy(motion)
    for effect in (e for e in motion.model.effects if e.internal):
        found = found + effect.energy(motion.model, motion.com, motion.angle)
    return found


def semi_major_axis(motion: Motion) -> Array:
    """Semi-major axis by the energy, (n,) m; infinite of a parabola."""
    distance = np.linalg.norm(motion.com, axis=-1)
    speed2 = np.sum(motion.array("com_velocity") ** 2, axis=-1)
    with np.errstate(divide="ignore"):
        found: Array = 1.0 / (2.0 / distance - speed2 / motion.mu)
    return found


def true_anomaly(motion: Motion) -> Array:
    """Angle from the periapsis in the direction of the motion, (n,) rad, from 0 to 2π."""
    from_periapsis = np.angle(as_complex(motion.com) * motion.eccentricity_vector.conj())
    sense = np.sign(cross(motion.com, motion.array("com_velocity")))
    return np.mod(np.where(sense < 0.0, -from_periapsis, from_periapsis), TURN)


FUNCTIONS: Mapping[str, Callable[[Motion], Array]] = {
    "joint_angle": lambda m: np.diff(m.angle, axis=1),
    "joint_rate": lambda m: np.diff(m.rate, axis=1),
    "vertical_angle": vertical_angle,
    "bar_position": lambda m: from_body(m, m.centres),
    "joint_position": lambda m: from_body(m, m.joints),
    "end_position": lambda m: both(from_body(m, m.ends)),
    "bar_from_com": lambda m: m.centres,
    "joint_from_com": lambda m: m.joints,
    "end_from_com": lambda m: both(m.ends),
    "bar_local": lambda m: in_local_frame(m, m.centres),
    "joint_local": lambda m: in_local_frame(m, m.joints),
    "end_local": lambda m: both(in_local_frame(m, m.ends)),
    "tension": lambda m: at_both_ends(m, 0),
    "shear": lambda m: at_both_ends(m, 1),
    "joint_torque": joint_torque,
    "joint_power": lambda m: -joint_torque(m) * np.diff(m.rate, axis=1),
    "torque_power": torque_power,
    "spin_momentum": lambda m: invariants.relative_angular_momentum(m.model, m.angle, m.rate),
    "kinetic_energy": kinetic_energy,
    "gravity_energy": gravity_energy,
    "total_energy": total_energy,
    "altitude": lambda m: np.linalg.norm(m.com, axis=-1) - m.scene.central_body.radius_m,
    "semi_major_axis": semi_major_axis,
    "eccentricity": lambda m: np.abs(m.eccentricity_vector),
    "periapsis": lambda m: np.angle(m.eccentricity_vector),
    "true_anomaly": true_anomaly,
}
"""Function of each derived channel that is one array"""
BY_EFFECT: Mapping[str, Callable[[ComplexArray, Array], Array]] = {
    "effect_force": lambda force, _: as_vectors(force),
    "effect_torque": lambda _, torque: torque,
}
"""Part of force and torque of an effect, of the channels that have an array for each effect"""


def columns_of(motion: Motion, name: str) -> dict[str, Array]:
    """Columns of a derived channel, each (n,).

    Raises
    ------
    DerivedError
        If the trajectory lacks what the channel is computed of.
    """
    channel = DERIVED_CHANNELS[name]
    try:
        if name not in BY_EFFECT:
            numbers = channel.numbers(motion.scene) if channel.of is Of.LAWS else ()
            found = channel.split(FUNCTIONS[name](motion), numbers)
        else:
            found = {}
            for effect, wrench in motion.wrenches.items():
                stems = tuple(stem.replace("effect", effect, 1) for stem in channel.stems)
                found |= dataclasses.replace(channel, stems=stems).split(BY_EFFECT[name](*wrench))
    except DerivedError as error:
        raise DerivedError(f"{name} {error}") from None
    if not found:
        lacking = "effects" if name in BY_EFFECT else "joints"
        raise DerivedError(f"{name} needs {lacking}, which this chain has not")
    return found


def with_derived(trajectory: Trajectory, names: Sequence[str], frame: pd.DataFrame) -> pd.DataFrame:
    """Table of a trajectory with the columns of derived channels after its own.

    Raises
    ------
    DerivedError
        If there is no such channel, or the trajectory lacks what it is computed of.
    """
    if isinstance(names, str):
        raise DerivedError(f"derived is {names!r}, allowed: a list of names, e.g. [{names!r}]")
    for name in names:
        if name not in DERIVED_CHANNELS:
            near, allowed = nearest(str(name), DERIVED_CHANNELS), ", ".join(DERIVED_CHANNELS)
            raise DerivedError(f"{shorten(name)}: no derived channel{near}, allowed: {allowed}")
    motion = Motion(trajectory)
    added = {column: values for name in names for column, values in columns_of(motion, name).items()}
    return pd.concat([frame, pd.DataFrame(added, index=frame.index)], axis=1)


def stored_columns(motion: Motion, name: str) -> dict[str, Array]:
    """Columns of a stored channel, each (n,).

    Raises
    ------
    DerivedError
        If the trajectory lacks it.
    """
    channel, trajectory = CHANNELS[name], motion.trajectory
    values = getattr(trajectory, channel.array)
    numbers = trajectory.torque_bars if channel.of is Of.LAWS else ()
    if values is None or not values.size or (channel.of is Of.LAWS and len(numbers) != values.shape[1]):
        raise DerivedError(f"{name}: {trajectory.engine or 'this trajectory'} gives none in this scene")
    return channel.split(values, numbers)


def channel_columns(motion: Motion, name: str) -> dict[str, Array]:
    """Columns of a channel, stored or derived, each (n,).

    Raises
    ------
    DerivedError
        If the trajectory lacks it, or what it is computed of.
    """
    return columns_of(motion, name) if name in DERIVED_CHANNELS else stored_columns(motion, name)


def chosen_columns(trajectory: Trajectory, names: Iterable[str]) -> pd.DataFrame:
    """Table of the instants and of some channels or single columns, stored or derived, in the order of their names.

    Raises
    ------
    DerivedError
        If the trajectory lacks one, or what it is computed of.
    """
    motion = Motion(trajectory)
    found = instants(trajectory)
    for name in names:
        channel = channel_of(name)
        own = channel_columns(motion, channel.name if channel else name)
        if channel and name != channel.name:
            if name not in own:
                raise DerivedError(
                    f"{name}: the run has no such column; of this channel it has {', '.join(own) or 'none'}"
                )
            own = {name: own[name]}
        found |= own
    return pd.DataFrame(found)
