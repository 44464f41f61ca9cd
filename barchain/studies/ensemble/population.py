"""The perturbed copies of a scene as arrays, one row a run."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.common.reference_model import POINT_PART, chain_model
from barchain.studies.distributions import VariationError
from barchain.studies.ensemble.variation import DrawStream
from reference_impl.integrate.simulate import contact_free_perigee_m, contact_free_radius_m, largest_pull_m_s2
from reference_impl.integrate.stepper import smooth_segments
from reference_impl.kernel import layout
from reference_impl.kernel.batch import Batch
from scenarios import Gravity

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array
    from barchain.runs.executors import Executor
    from barchain.studies.ensemble.variation import Variation
    from reference_impl.kernel.effects import Effects
    from reference_impl.model.chain import ChainModel
    from scenarios import Scene


@dataclass(frozen=True)
class Ensemble:
    """Copies to be drawn and run."""

    scene: Scene
    """As it is run, unperturbed"""
    variations: tuple[Variation, ...]
    runs: int
    seed: int
    rtol: float
    quantiles: tuple[float, ...]
    executor: Executor


@dataclass(frozen=True)
class Population:
    """Copies of a scene, a row each; N bars."""

    scene: Scene
    mass_kg: Array
    """(runs, N)"""
    length_m: Array
    """(runs, N)"""
    inertia_kg_m2: Array
    """(runs, N)"""
    angle_rad: Array
    """(runs, N) from the horizontal that the scene names"""
    rate_factor: Array
    """(runs, N)"""
    altitude_m: Array
    """(runs,)"""
    speed_factor: Array
    """(runs,)"""
    longitude_rad: Array
    """(runs,)"""

    @property
    def runs(self) -> int:
        """Number of copies."""
        return len(self.altitude_m)

    def part(self, first: int, last: int) -> Population:
        """Copies `first` to `last`, the last left out."""
        names = [f.name for f in dataclasses.fields(self) if f.name != "scene"]
        return dataclasses.replace(self, **{name: getattr(self, name)[first:last] for name in names})

    def copy(self, run: int) -> Scene:
        """Scene of one copy."""
        per_bar = ("mass_kg", "length_m", "inertia_kg_m2", "angle_rad", "rate_factor")
        columns: dict[str, Any] = {name: tuple(map(float, getattr(self, name)[run])) for name in per_bar}
        chain = dataclasses.replace(self.scene.chain, **columns)
        single = ("altitude_m", "speed_factor", "longitude_rad")
        orbit = dataclasses.replace(self.scene.orbit, **{name: float(getattr(self, name)[run]) for name in single})
        return dataclasses.replace(self.scene, chain=chain, orbit=orbit)


IN_RADIANS = {"angle_deg": "angle_rad", "longitude_deg": "longitude_rad"}


def populations(
    scene: Scene, variations: tuple[Variation, ...], runs: int, seed: int, size: int
) -> Iterator[Population]:
    """Copies of `scene` in parts of `size`, each drawn when it is asked for.

    Raises
    ------
    VariationError
        If a copy is one that a scene file could not describe.
    """
    streams = [DrawStream(v, scene.bars, seed) for v in variations]
    for first in range(0, runs, size):
        part = drawn(scene, streams, min(size, runs - first))
        check(part, first)
        yield part


def populate(scene: Scene, variations: tuple[Variation, ...], runs: int, seed: int) -> Population:
    """Draw `runs` copies of `scene` at once, as :func:`populations`."""
    return next(populations(scene, variations, runs, seed, runs))


def drawn(scene: Scene, streams: list[DrawStream], runs: int) -> Population:
    """Draw the next copies of `scene`.

    A slender bar whose mass or length varies stays one: its inertia goes with m l², unless it varies itself. Another
    inertia, which the scene states, stays.
    """
    names = [f.name for f in dataclasses.fields(Population) if f.name != "scene"]
    whole: dict[str, Any] = vars(scene.orbit) | vars(scene.chain)
    given = {name: np.atleast_1d(np.array(whole[name], dtype=float)) for name in names}
    copies = {name: np.tile(value, (runs, 1)) for name, value in given.items()}
    slender = given["mass_kg"] * given["length_m"] ** 2 / 12.0
    shapes = np.tile(np.isclose(given["inertia_kg_m2"], slender, rtol=SLENDER), (runs, 1))
    for stream in streams:
        v, values = stream.variation, stream.take(runs)
        where = slice(v.bar - 1, v.bar) if v.bar else slice(None)
        name = IN_RADIANS.get(v.key, v.key)
        copies[name][:, where] = values if name == v.key else np.radians(values)
        if v.key == "inertia_kg_m2":
            shapes[:, where] = False
    scaled = copies["mass_kg"] / given["mass_kg"] * (copies["length_m"] / given["length_m"]) ** 2
    copies["inertia_kg_m2"] *= np.where(shapes, scaled, 1.0)
    return Population(scene, **{name: d if hasattr(scene.chain, name) else d[:, 0] for name, d in copies.items()})


SLENDER = 1e-9
"""Relative difference of inertias that are those of slender bars: rounding"""
LOCATED = ("drag", "solar_pressure", "impulse")
"""Effects whose events are settled between compiled segments, run by run"""


def check_effects(scene: Scene, variations: tuple[Variation, ...]) -> None:
    """Reject effects that the compiled loop over many chains does not support, and bars with no room for an effect.

    The loop sets the modes of effects once: a table in time passes where the run is inside one segment of it.

    Raises
    ------
    VariationError
        If an effect has instants inside the run, or an exact slender bar would be none.
    """
    found = [name for name in LOCATED if getattr(scene.effects, name)]
    knots = {
        "thrust": [t for table in scene.effects.thrust for t in table.times_s],
        "joint_torque": [t for table in scene.effects.joint_torque for t in table.times_s],
    }
    found += [name for name, times_s in knots.items() if len(smooth_segments(scene.times_s, tuple(times_s))) > 1]
    if found:
        raise VariationError(
            f"ensembles do not support {', '.join(found)} with events inside the run, which are located run by run; "
            "allowed: effects that are smooth at all times; `barchain sweep` draws and runs each copy by itself"
        )
    if scene.effects.gravity is Gravity.SLENDER and any(v.key == "inertia_kg_m2" for v in variations):
        raise VariationError(
            '--vary inertia_kg_m2: a bar in gravity = "slender" is uniform; allowed: mass_kg, length_m'
        )


def check(population: Population, first: int) -> None:
    """Reject copies that a scene file could not describe; the first of them is run `first`, counted from 0.

    Raises
    ------
    VariationError
        If a chain could reach the surface from where it starts.
    """
    low = population.altitude_m <= population.length_m.sum(axis=1)
    if low.any():
        run = int(np.argmax(low))
        raise VariationError(
            f"run {first + run + 1} starts {population.altitude_m[run]:g} m up with a chain of "
            f"{population.length_m[run].sum():g} m, allowed: higher than the chain is long"
        )


def batch(population: Population, rtol: float) -> Batch:
    """Arrays for the compiled loop, at the accuracy `rtol` of a step, as a single run counts it."""
    scene, runs = population.scene, population.runs
    mu, surface = scene.central_body.mu_m3_s2, scene.central_body.radius_m
    radius = surface + population.altitude_m
    com, velocity, angle, rate = starts(population, radius)
    fastest = np.maximum(np.sqrt(mu / radius**3), np.abs(rate).max(axis=1))[:, None]
    turn, place = np.ones((runs, scene.bars)), np.repeat(radius[:, None], 2, axis=1)
    length, model = population.length_m.sum(axis=1), chain_model(scene)
    floor = contact_free_radius_m(surface, length)
    safe = np.full(runs, np.inf) if model.effects else contact_free_perigee_m(floor, length)
    return Batch(
        np.full(runs, mu),
        layout.GRAVITY_CODES[POINT_PART[scene.effects.gravity]],
        layout.bar_rows(population.mass_kg, population.length_m, population.inertia_kg_m2, model.com_share),
        laws(population),
        effects_in_one_segment(scene, model),
        layout.pack(com, velocity, angle, rate),
        layout.padded([rtol * turn, rtol * place, rtol * turn * fastest, rtol * place * fastest], 1.0),
        floor,
        safe,
        np.array([largest_pull_m_s2(model, height) for height in floor]),
    )


def effects_in_one_segment(scene: Scene, model: ChainModel) -> Effects:
    """Effects in compiled code, those with tables in time in their segment of the run."""
    compiled = layout.compiled_chain(model).effects
    for effect, own in zip(model.effects, compiled, strict=True):
        mode = effect.segment_mode(0.0, scene.run.duration_s)
        if mode is not None:
            own.mode[:] = mode
    return compiled


def laws(population: Population) -> Array:
    """Prescribed rotations, shape (runs, P, 7); each bar's inertia is its copy's own."""
    model = chain_model(population.scene)
    table = np.tile(layout.compiled_chain(model).laws, (population.runs, 1, 1))
    bars = [p.bar for p in model.prescriptions]
    table[:, :, layout.UNIT] = np.sqrt(population.inertia_kg_m2[:, bars])
    return table


def starts(population: Population, radius_m: Array) -> tuple[Array, Array, Array, Array]:
    """Place and velocity of the centre of mass (runs, 2), angles and rates (runs, N), as `initial_state` has them."""
    scene = population.scene
    if scene.effects.prescribed_rotation or scene.chain.angle_from != "chain":  # each start must be solved for
        each = [initial_state(population.copy(r)) for r in range(population.runs)]
        return (
            np.array([s.com_m for s in each]), np.array([s.com_velocity_m_s for s in each]),
            np.array([s.angle_rad for s in each]), np.array([s.rate_rad_s for s in each]),
        )  # fmt: skip
    longitude = population.longitude_rad
    speed = population.speed_factor * np.sqrt(scene.central_body.mu_m3_s2 / radius_m)
    radial = np.stack([np.cos(longitude), np.sin(longitude)], axis=1)
    level = np.stack([-radial[:, 1], radial[:, 0]], axis=1)
    angle = population.angle_rad + longitude[:, None] - 0.5 * math.pi
    climb = scene.orbit.flight_path_rad
    onward = speed * math.cos(climb)
    velocity = onward[:, None] * level
    return (
        radius_m[:, None] * radial,
        velocity + (speed * math.sin(climb))[:, None] * radial if climb else velocity,
        angle,
        population.rate_factor * (onward / radius_m)[:, None],
    )
