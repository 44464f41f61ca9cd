"""Digits of a scene over its time, in relative and absolute coordinates, from single to quadruple precision.

A run is compared with the run of the same equal steps in numbers of 120 digits. Both sets of coordinates are linear
images of each other, and a Runge-Kutta method commutes with linear maps. Truncation is therefore the same in all runs,
and drops out of their differences: round-off alone is left, whatever the step.

Members turn the scene about the central body, which no angle and no reaction knows of; the scene itself is the first.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import initial_state
from barchain.metrics.quantities import MODES_PER_BAR, own_rate
from barchain.runs.estimate import need_runnable
from barchain.studies.roundoff.evaluation import largest, quantiles
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT, QUADRUPLE, Arithmetic, Values
from reference_impl.precision.chain import ChainParameters
from reference_impl.precision.coordinates import ChainObservables, InitialChains
from reference_impl.precision.run import initial_vector, method_of
from scenarios import Gravity, SceneError

if TYPE_CHECKING:
    from collections.abc import Iterator

    from adapters.trajectory import Array
    from reference_impl.precision.arithmetic import Function
    from scenarios import Scene

COORDINATES = ("relative", "absolute")
PRECISIONS = {**ARITHMETICS, QUADRUPLE.name: QUADRUPLE}
CARRIED = frozenset({"gravity.none", "gravity.point", "gravity.gradient"})
"""Effects that the formulations have"""
MEMBERS, FEW = 8, 2
"""Members, and those in quadruple precision, which takes long"""
SAMPLES = 40
STEPS_PER_RADIAN = 3.0
"""Of the chain's fastest oscillation: the steps of order 8 show the scene's motion to some ten digits"""
MOST_WORK = 4e4
"""Steps times bars: a quarter of an hour in quadruple precision"""
METHOD = "dop853"


def shortened(scene: Scene, orbits: float | None) -> Scene:
    """`scene` over its first orbits, with fewer samples in proportion; all of it without a number."""
    if orbits is None or orbits * scene.period_s >= scene.run.duration_s:
        return scene
    duration_s = orbits * scene.period_s
    samples = 1 + max(1, math.ceil((scene.run.samples - 1) * duration_s / scene.run.duration_s))
    return dataclasses.replace(scene, run=dataclasses.replace(scene.run, duration_s=duration_s, samples=samples))


def need_carried(scene: Scene) -> None:
    """Check that the formulations can carry a scene.

    Raises
    ------
    SceneError
        If it has other effects, or takes too many steps in numbers of many digits; the message is one line.
    """
    lacking = sorted(scene.needs - CARRIED)
    if lacking:
        raise SceneError(
            f"{scene.name}: {', '.join(lacking)} given, allowed: {', '.join(sorted(CARRIED))}, which are there in both "
            "coordinates and all precisions; --engine NAME measures an engine in any scene"
        )
    need_runnable([scene])
    work = steps_of(scene) * SAMPLES * scene.bars
    if work > MOST_WORK:
        orbits = scene.run.duration_s / scene.period_s
        raise SceneError(
            f"{scene.name}: {work:.2g} steps of a bar given, allowed: {MOST_WORK:g} in numbers of many digits; "
            f"--orbits {0.9 * orbits * MOST_WORK / work:.2g} takes the first part"
        )


def steps_of(scene: Scene) -> int:
    """Equal steps between two samples."""
    rate = MODES_PER_BAR * scene.bars * own_rate(scene)
    return max(1, math.ceil(STEPS_PER_RADIAN * rate * scene.run.duration_s / SAMPLES))


def digit_rows(scene: Scene, arithmetic: str) -> list[dict[str, Any]]:
    """Rows of the table `digits` for both sets of coordinates in one precision.

    Errors are largest over bars and joints: of angles in rad, of reactions relative to the largest of the run, of the
    track relative to the distance from the body's centre.
    """
    a, members = PRECISIONS[arithmetic], FEW if arithmetic == QUADRUPLE.name else MEMBERS
    turns = 2.0 * np.pi * np.arange(members) / members
    truth = list(observed(EXACT, "relative", scene, turns[:1]))
    rows = []
    for name in COORDINATES:
        with np.errstate(all="ignore"):  # what overflows is found as an error
            seen = list(observed(a, name, scene, turns))
        with EXACT.numbers():
            found = errors(truth, seen, turns)
        for k in range(SAMPLES):
            orbits = (k + 1) * scene.run.duration_s / (SAMPLES * scene.period_s)
            head = {"scene": scene.name, "coordinates": name, "arithmetic": arithmetic, "orbits": orbits}
            rows += [head | {"quantity": q} | quantiles(values[k]) for q, values in found.items()]
    return rows


def observed(a: Arithmetic, name: str, scene: Scene, turns: Array) -> Iterator[ChainObservables]:
    """Observables (B,) after each interval of runs of a turned scene; a start in exact numbers is rounded."""
    with EXACT.numbers():
        coordinates, y = initial_vector(a, name, turned_start(scene, turns))
        steps = steps_of(scene)
        h = a.cast(np.full(len(turns), scene.run.duration_s)) / (SAMPLES * steps)
    step = method_of(a, METHOD)
    for _ in range(SAMPLES):
        with a.numbers():
            for _ in range(steps):
                y = step(coordinates.rates, y, h)
            found = coordinates.observables(y)
        yield found


def turned_start(scene: Scene, turns: Array) -> InitialChains:
    """Initial chains of a scene, turned by angles (B,); the doubles of its initial state are exact numbers here."""
    start, chain, ones = initial_state(scene), scene.chain, EXACT.cast(np.ones(len(turns)))
    turn = EXACT.cast(turns)

    def column(values: Any) -> Values:
        return EXACT.cast(np.array(values))[..., None] * ones

    mu = 0.0 if scene.effects.gravity is Gravity.NONE else scene.central_body.mu_m3_s2
    bars = ChainParameters(
        column(mu), column(chain.mass_kg), column(chain.length_m), column(chain.inertia_kg_m2),
        gradient=scene.effects.gravity is Gravity.GRADIENT,
    )  # fmt: skip
    com, velocity = (turned(column(values), turn) for values in (start.com_m, start.com_velocity_m_s))
    return InitialChains(EXACT, bars, com, velocity, column(start.angle_rad) + turn, column(start.rate_rad_s))


def turned(vectors: Values, turn: Values) -> Values:
    """Exact vectors (2, …, B) turned by angles (B,)."""
    c, s = EXACT.cos(turn), EXACT.sin(turn)
    return np.stack([c * vectors[0] - s * vectors[1], s * vectors[0] + c * vectors[1]])


def errors(truth: list[ChainObservables], seen: list[ChainObservables], turns: Array) -> dict[str, Array]:
    """Errors (samples, B) of each quantity; none of reactions that vanish."""
    turn = EXACT.cast(turns)
    yard = max((largest(t.reaction_N).max() for t in truth if t.reaction_N.size), default=0)
    found: dict[str, list[Values]] = {"attitude": [], "com": []} | ({"reaction": []} if yard > 0 else {})
    for right, one in zip(truth, seen, strict=True):
        found["attitude"].append(error(one.angle_rad, right.angle_rad + turn, lambda d: np.abs(d).max(axis=0)))
        com = turned(right.com_m, turn)[:, None]
        found["com"].append(error(one.com_m[:, None], com, largest) / largest(com))
        if yard > 0:
            found["reaction"].append(error(one.reaction_N, turned(right.reaction_N, turn), largest) / yard)
    return {name: np.array(values, float) for name, values in found.items()}


def error(seen: Values, right: Values, measure: Function) -> Values:
    """Measure (B,) of the exact difference of values (…, B) in any arithmetic; infinite where they are no numbers."""
    lost = ~np.isfinite(seen.astype(float))
    found = measure(EXACT.cast(np.where(lost, 0.0, seen)) - right)
    return np.where(lost.reshape(-1, lost.shape[-1]).any(axis=0), np.inf, found)
