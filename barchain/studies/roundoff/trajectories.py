"""One chain integrated in several coordinates and arithmetics, from tolerance or step to where round-off rules.

The chain is a scene's, its bars' lengths scaled from tethers to hinges: the motion of the angles is nearly the same at
every size, so what differs is the arithmetic's. Members start at different longitudes, which no angle knows of.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import gmpy2
import numpy as np

from barchain.runs.message import message_bytes, read_message
from barchain.studies.roundoff.evaluation import quantiles
from barchain.studies.roundoff.formulations import EQUATOR_M
from reference_impl.precision.arithmetic import ARITHMETICS, EXACT, LONG, Values, exact_numbers
from reference_impl.precision.chain import ChainParameters
from reference_impl.precision.coordinates import ChainObservables, InitialChains
from reference_impl.precision.run import adaptive_steps, equal_steps

if TYPE_CHECKING:
    from collections.abc import Iterable

    from adapters.trajectory import Array
    from scenarios import Scene

SOLUTION_STEPS = 64, 48  # an orbit, of order 14: the high-precision solution's, and those that tell its error
GROWS_FROM = 1.0  # orbits: the motion's own oscillation is averaged out
REDRAWN = 400  # times that members are drawn again
OBSERVABLES = tuple(f.name for f in fields(ChainObservables))
MARGIN = 10.0  # a high-precision solution tells errors this many times its own


@dataclass(frozen=True)
class ScaledScene:
    """A scene at several sizes, sampled `samples` times in a number of orbits."""

    scene: Scene
    ratios: tuple[float, ...]
    members: int
    orbits: float = 1.0
    samples: int = 8

    @property
    def sample_s(self) -> float:
        """Time between samples."""
        return self.orbits * self.scene.period_s / self.samples

    def start(self, longitudes: Array, ratios: Array) -> InitialChains:
        """Runs from `longitudes` at size `ratios`, each (B,); where exact numbers are in force."""
        scene, chain, runs = self.scene, self.scene.chain, len(ratios)

        def column(values: tuple[float, ...]) -> Values:
            return EXACT.cast(np.array(values))[:, None] * EXACT.cast(np.ones(runs))

        scale = EXACT.cast(ratios) * EQUATOR_M / max(chain.length_m)
        mass, length = column(chain.mass_kg), column(chain.length_m) * scale
        mu, radius = EXACT.cast(np.full(runs, scene.central_body.mu_m3_s2)), EXACT.cast(np.full(runs, scene.radius0_m))
        circular, at = EXACT.sqrt(mu / radius), EXACT.cast(longitudes)
        speed, climb = scene.orbit.onward * circular, scene.orbit.upward * circular
        outward, onward = np.stack([EXACT.cos(at), EXACT.sin(at)]), np.stack([-EXACT.sin(at), EXACT.cos(at)])
        bars = ChainParameters(mu, mass, length, column(chain.inertia_kg_m2) * scale * scale)
        angle = column(chain.angle_rad) + (at - gmpy2.const_pi() / 2)
        return InitialChains(
            EXACT,
            bars,
            radius * outward,
            speed * onward + climb * outward,
            angle,
            column(chain.rate_factor) * (speed / radius),
        )


@dataclass(frozen=True)
class HighPrecisionSolution:
    """Motion at each size from longitude 0, and how well it is known."""

    family: ScaledScene
    seen: tuple[ChainObservables, ...]
    error: dict[str, Array]
    """(sizes,) of each quantity over the whole run, by another step size"""


def solution_of(family: ScaledScene) -> HighPrecisionSolution:
    """Integrate in long double, by a method that nothing else here uses, at two steps."""
    ratios = np.array(family.ratios)
    with exact_numbers():
        start, sample_s = family.start(np.zeros(len(ratios)), ratios), np.full(len(ratios), family.sample_s)
        fine, coarse = (
            tuple(equal_steps(LONG, "minimal", start, "extrapolated", sample_s, family.samples, steps))
            for steps in (math.ceil(n * family.orbits / family.samples) for n in SOLUTION_STEPS)
        )
    found = HighPrecisionSolution(family, fine, {})
    apart = judged(found, coarse, np.zeros(len(ratios)), np.arange(len(ratios)))
    return HighPrecisionSolution(family, fine, {quantity: values.max(axis=0) for quantity, values in apart.items()})


def solution_bytes(family: ScaledScene) -> bytes:
    """Message with a high-precision solution, made here; arrays of long doubles."""
    found = solution_of(family)
    seen = {f"{k} {name}": getattr(one, name) for k, one in enumerate(found.seen) for name in OBSERVABLES}
    return message_bytes({}, seen | {f"error {k}": v.astype(np.longdouble) for k, v in found.error.items()})


def solution_from(family: ScaledScene, content: bytes) -> HighPrecisionSolution:
    """High-precision solution of a message.

    Raises
    ------
    MessageError, KeyError
        If a part is missing, or of another type.
    """
    _, arrays = read_message(content, np.longdouble)
    count = sum(name.endswith(OBSERVABLES[0]) for name in arrays)
    seen = tuple(ChainObservables(*(arrays[f"{k} {name}"] for name in OBSERVABLES)) for k in range(count))
    error = {k.removeprefix("error "): v.astype(float) for k, v in arrays.items() if k.startswith("error ")}
    return HighPrecisionSolution(family, seen, error)


def judged(
    solution: HighPrecisionSolution, seen: Iterable[ChainObservables], longitudes: Array, sizes: Values
) -> dict[str, Array]:
    """Errors (samples, B) of runs from `longitudes` at the solution's `sizes`-th sizes, largest over bars and joints.

    Attitude in rad; reactions over the largest of the run; gaps and the centre of mass over a bar's length.
    """
    turn = LONG.cast(longitudes)
    yard = np.max([length_of(t.reaction_N).max(axis=0) for t in solution.seen], axis=0)[sizes]
    bar_m = LONG.cast(np.array(solution.family.ratios) * EQUATOR_M)[sizes]
    rows: dict[str, list[Values]] = {"attitude": [], "reaction": [], "gap": [], "com": []}
    for right, one in zip(solution.seen, seen, strict=True):
        rows["attitude"].append(np.abs(LONG.cast(one.angle_rad) - (right.angle_rad[:, sizes] + turn)).max(axis=0))
        missed = LONG.cast(one.reaction_N) - rotated(right.reaction_N[..., sizes], turn)
        rows["reaction"].append(length_of(missed).max(axis=0) / yard)
        rows["gap"].append(LONG.cast(one.gap_m) / bar_m)
        rows["com"].append(length_of(LONG.cast(one.com_m) - rotated(right.com_m[..., sizes], turn)) / bar_m)
    return {name: np.array(values, float) for name, values in rows.items()}


def length_of(vectors: Values) -> Values:
    """Lengths of vectors (2, …)."""
    return np.sqrt(vectors[0] * vectors[0] + vectors[1] * vectors[1])


def rotated(vectors: Values, turn: Values) -> Values:
    """Vectors (2, …, B) turned by angles (B,)."""
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([c * vectors[0] - s * vectors[1], s * vectors[0] + c * vectors[1]])


def columns(family: ScaledScene) -> tuple[Values, Array]:
    """Sizes (their place in the family's) and longitudes of all runs, (B,)."""
    random = np.random.default_rng(family.members)
    longitudes = random.uniform(0.0, 2.0 * np.pi, family.members)
    pairs = list(itertools.product(range(len(family.ratios)), longitudes))
    return np.array([k for k, _ in pairs]), np.array([x for _, x in pairs])


def at_equal_steps(
    solution: HighPrecisionSolution, arithmetic: str, name: str, method: str, steps: int
) -> tuple[dict[str, Array], Values]:
    """Errors (samples, B) of runs in one set of coordinates at equal steps between samples, and their sizes (B,)."""
    family = solution.family
    sizes, longitudes = columns(family)
    with exact_numbers(), np.errstate(all="ignore"):
        start = family.start(longitudes, np.array(family.ratios)[sizes])
        sample_s = np.full(len(sizes), family.sample_s)
        seen = equal_steps(ARITHMETICS[arithmetic], name, start, method, sample_s, family.samples, steps)
        return judged(solution, seen, longitudes, sizes), sizes


def equal_step_rows(
    solution: HighPrecisionSolution, arithmetic: str, name: str, method: str, steps: int
) -> list[dict[str, Any]]:
    """Rows of the table `trajectories` for one set of coordinates at `steps` equal steps between samples."""
    found, sizes = at_equal_steps(solution, arithmetic, name, method, steps)
    per_orbit = steps * solution.family.samples / solution.family.orbits
    head = {"coordinates": name, "arithmetic": arithmetic, "method": method, "steps_per_orbit": per_orbit}
    return summed_up(solution, head, worst(found), sizes)


def chosen_step_rows(
    solution: HighPrecisionSolution, arithmetic: str, name: str, rtols: tuple[float, ...]
) -> list[dict[str, Any]]:
    """Rows for DOP853 with its own steps, at several tolerances side by side."""
    family = solution.family
    sizes, longitudes = (np.tile(v, len(rtols)) for v in columns(family))
    rtol = np.repeat(rtols, len(sizes) // len(rtols))
    with exact_numbers(), np.errstate(all="ignore"):
        start = family.start(longitudes, np.array(family.ratios)[sizes])
        walked = list(
            adaptive_steps(
                ARITHMETICS[arithmetic], name, start, np.full(len(sizes), family.sample_s), family.samples, rtol
            )
        )
        found = judged(solution, [seen for seen, _ in walked], longitudes, sizes)
    evaluations = walked[-1][1].evaluations / family.orbits
    rows = []
    for tolerance in rtols:
        own = rtol == tolerance
        head = {"coordinates": name, "arithmetic": arithmetic, "method": "dop853, chosen steps", "rtol": tolerance}
        values = {quantity: v[own] for quantity, v in worst(found).items()}
        rows += summed_up(solution, head, values, sizes[own], evaluations[own])
    return rows


def growth_rows(
    solution: HighPrecisionSolution, arithmetic: str, name: str, method: str, steps: int
) -> list[dict[str, Any]]:
    """Rows of `growth`: the largest errors so far, at each sample of a long run; so the motion's swing is out."""
    family = solution.family
    found, sizes = at_equal_steps(solution, arithmetic, name, method, steps)
    found = {quantity: np.maximum.accumulate(values) for quantity, values in found.items()}
    time = np.arange(1, family.samples + 1) * family.orbits / family.samples
    drawn = {
        (ratio, quantity): drawn_exponents(time, values[:, sizes == k])
        for k, ratio in enumerate(family.ratios)
        for quantity, values in found.items()
    }
    rows = []
    for k in range(family.samples):
        orbits = (k + 1) * family.orbits / family.samples
        head = {"coordinates": name, "arithmetic": arithmetic, "method": method, "orbits": orbits}
        own = summed_up(solution, head, {quantity: values[k] for quantity, values in found.items()}, sizes)
        rows += [row | drawn[row["ratio"], row["quantity"]] for row in own]
    return rows


def drawn_exponents(time: Array, errors: Array) -> dict[str, float]:
    """Interval of the exponent of errors (samples, members) in time, by drawing members again.

    The largest errors so far of one run depend on each other, so that least squares alone would tell too narrow a one.
    """
    used = time >= GROWS_FROM
    random, x = np.random.default_rng(REDRAWN), np.log(time[used])
    members = random.integers(0, errors.shape[1], (REDRAWN, errors.shape[1]))
    y = np.log(np.maximum(np.median(errors[used][:, members], axis=2), np.finfo(float).tiny))
    slopes = np.polyfit(x, y, 1)[0]
    low, high = np.quantile(slopes, [0.025, 0.975])
    return {"exponent_low": float(low), "exponent_high": float(high)}


def worst(found: dict[str, Array]) -> dict[str, Array]:
    """Largest errors of a run, (B,)."""
    return {quantity: values.max(axis=0) for quantity, values in found.items()}


def summed_up(
    solution: HighPrecisionSolution,
    head: dict[str, Any],
    found: dict[str, Array],
    sizes: Values,
    evaluations: Array | None = None,
) -> list[dict[str, Any]]:
    """One row for each size and quantity; errors that the high-precision solution does not resolve are marked."""
    rows = []
    for k, ratio in enumerate(solution.family.ratios):
        count = {} if evaluations is None else {"evaluations": float(np.median(evaluations[sizes == k]))}
        for quantity, values in found.items():
            own = np.where(np.isfinite(values[sizes == k]), values[sizes == k], np.inf)
            spread = quantiles(own)
            known = quantity == "gap" or spread["median"] >= MARGIN * solution.error[quantity][k]
            rows.append({"ratio": ratio, "quantity": quantity} | head | count | spread | {"known": bool(known)})
    return rows
