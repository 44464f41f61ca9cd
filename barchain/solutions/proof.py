"""Proofs of certified solutions: balls that contain the exact motion, beside the values in the same file.

The exact motion is the solution of the scene's equations for the scene's numbers in double precision, from the state at
t = 0 that the file has: the numbers that every engine gets. Equations and arithmetic of their own enclose it
(:mod:`barchain.solutions.enclosure`). At every sample ``proven_q`` bounds the distance of the file's value from the
exact one, in the norm of ``error_q``. At the chosen instants ``low_`` columns continue the numbers: value plus low
part, of at most 32 digits, is within ``radius_q`` of the exact value.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from decimal import ROUND_CEILING, Context
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.trajectory import to_frame
from barchain.metrics.quantities import FIELDS, components, sizes
from barchain.solutions.certified_file import (
    ERROR,
    columns_of,
    head_of,
    motion_of,
    read_file,
    shipped_files,
    shipped_path,
    with_prefix,
    write_frame,
)
from barchain.solutions.reference import UNIT_ROUNDOFF

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.enclosure.run import Enclosed
    from scenarios import Scene

    Balls = NDArray[np.object_]

PROOF, PROVEN, RADIUS, LOW = "proof", "proven_", "radius_", "low_"
BITS, MORE_BITS, MOST_BITS = 160, 1.5, 2000
"""Precision of the first attempt, its growth from attempt to attempt, and its limit"""
OTHER_BITS = 1.3
"""Precision of a check over that of the proof"""
DIGITS = 1e-20
"""Radius over the value's size that an enclosure must reach"""
SHRUNK = 1e6
"""Radius at any instant over that at the end, at most: contracting motions are far below"""
KEPT = 1e-32
"""Digits of a value and its low part"""
START_ROUNDINGS = 4.0
"""Of a start in double precision, in roundings of the largest operand: an angle is a sum, a velocity a product"""
UNKNOWNS = ("com", "com_velocity", "attitude", "rate")
MISSING = "" if find_spec("flint") else "python-flint is not installed; pip install 'barchain[proof]'"
"""Reason why nothing is enclosed here; empty if it can be"""


class NotCheckedError(ArithmeticError):
    """A proof that can't be verified anew; the message gives the reason."""


class ExcludedError(ValueError):
    """An enclosure excludes a certified value; the message has the value."""


@dataclass(frozen=True)
class Proof:
    """Enclosure of a scene at the instants of a trajectory; n rows."""

    bits: int
    order: int
    steps: int
    seconds: float
    relative: float
    """Largest radius of a ball at the last sample, over the quantity's largest value"""
    proven: dict[str, Array]
    """(n,) for each quantity, as the errors: bound of the distance of the values from the exact ones"""
    radius: dict[str, Array]
    """(n,) for each quantity: radius of the ball about value plus low part"""
    low: Trajectory
    """Low parts of all values"""

    @property
    def head(self) -> dict[str, float]:
        """Attributes of a file."""
        return {name: getattr(self, name) for name in ("bits", "order", "steps", "seconds", "relative")}

    @property
    def words(self) -> str:
        """Radius and effort in one line."""
        effort = f"{self.bits} bits, order {self.order}, {self.steps} steps, {self.seconds:.0f} s"
        return f"enclosed to {at_most(self.relative)} of the largest values at the last sample ({effort})"


def prove(scene: Scene, trajectory: Trajectory, *, bits: int = BITS, **options: Any) -> Proof:
    """Enclose a scene at the instants of a trajectory whose first row is the start.

    Parameters
    ----------
    scene : Scene
    trajectory : Trajectory
        Values to be proven.
    bits : int
        Precision of the first attempt; more are taken until the relative radius at the end is below `DIGITS`.
    **options : Any
        As for :func:`barchain.solutions.enclosure.run.enclose`.

    Raises
    ------
    NotEnclosedError, TooWideError
        If the motion is none that is enclosed, or takes more than `MOST_BITS`.
    ExcludedError
        If the first row is not the scene's start.
    """
    from barchain.solutions.enclosure.run import Effort, enclose, order_for  # noqa: PLC0415  # flint
    from barchain.solutions.enclosure.series import TooWideError  # noqa: PLC0415  # flint

    start = state_of(exactly(components(trajectory, UNKNOWNS)), 0)
    while True:
        effort, begun = Effort(bits, order_for(bits)), time.perf_counter()
        try:
            found = list(enclose(scene, trajectory.t_s.tolist(), start, effort, **options))
            last, largest = by_quantity(found[-1], scene.bars), sizes(trajectory)
            relative = max(norm_of(RADII(last[q])) / float(x.max()) for q, x in largest.items() if x.any())
            if relative <= DIGITS:
                need_start(scene, trajectory)
                taken = round(time.perf_counter() - begun, 1)
                return Proof(
                    bits, effort.order, effort.steps, taken, relative, *compared(trajectory, found, scene.bars)
                )
            reason = f"the radius at the end is {relative:.1e} of the value"
        except TooWideError as error:
            reason = str(error)
        bits = round(bits * MORE_BITS)
        if bits > MOST_BITS:
            raise TooWideError(reason)


def exactly(values: Mapping[str, Array]) -> dict[str, Balls]:
    """Numbers in double precision as exact balls."""
    from barchain.solutions.enclosure.forces import number  # noqa: PLC0415  # flint

    return {name: np.vectorize(number, otypes=[object])(x) for name, x in values.items()}


def state_of(values: Mapping[str, Balls], row: int) -> list[Any]:
    """State of an enclosure in one row."""
    return [x for name in UNKNOWNS for x in values[name][row].ravel()]


RADII = np.vectorize(lambda x: x.rad(), otypes=[object])
MIDDLES = np.vectorize(lambda x: float(x.mid()), otypes=[float])
BOUNDS = np.vectorize(lambda x: float(x.abs_upper()), otypes=[float])


def norm_of(parts: Balls) -> float:
    """Upper bound of the largest norm of some vectors of balls, (k, components)."""
    rounded = 1.0 + 2.0**-48  # of the conversions to double precision, and of the root
    return float(np.linalg.norm(BOUNDS(parts), axis=-1).max()) * rounded


def need_start(scene: Scene, trajectory: Trajectory) -> None:
    """Check that the first row is the scene's start but for roundings.

    Raises
    ------
    ExcludedError
        If it is another.
    """
    from barchain.solutions.enclosure.start import start_balls  # noqa: PLC0415  # flint

    n, values = scene.bars, components(trajectory, UNKNOWNS)
    row = np.array(start_balls(scene), dtype=object) - np.array(state_of(exactly(values), 0), dtype=object)
    operand = {"com": scene.radius0_m, "com_velocity": scene.speed0_m_s, "attitude": 2.0 * math.pi}
    for name, off in zip(UNKNOWNS, np.split(row, [2, 4, 4 + n]), strict=True):
        size = max(float(np.abs(values[name][0]).max()), operand.get(name, scene.fastest_rate_rad_s))
        if norm_of(off[:, None]) > START_ROUNDINGS * UNIT_ROUNDOFF * size:
            raise ExcludedError(f"{scene.name}: the {name} at the start is not the scene's")


def by_quantity(found: Enclosed, bars: int) -> dict[str, Balls]:
    """Balls as `barchain.metrics.quantities.components` has values, (k, components) each."""
    parts = np.split(np.array(found.state, dtype=object), [2, 4, 4 + bars])
    others = (found.reaction, found.torque, found.impulse)
    widths = {"com": 2, "com_velocity": 2, "attitude": 1, "rate": 1, "reaction": 2, "torque": 1, "impulse": 2}
    arrays = (np.array(x, dtype=object) for x in (*parts, *others))
    return {name: x.reshape(-1, width) for (name, width), x in zip(widths.items(), arrays, strict=True)}


def compared(
    trajectory: Trajectory, found: Sequence[Enclosed], bars: int
) -> tuple[dict[str, Array], dict[str, Array], Trajectory]:
    """Distances of a trajectory's values from balls, radii of the balls about value plus low part, and low parts."""
    values = components(trajectory)
    exact, low = exactly(values), {name: np.zeros_like(x) for name, x in values.items()}
    proven, radius = ({name: np.zeros(len(found)) for name in values} for _ in range(2))
    for i, seen in enumerate(found):
        now = by_quantity(seen, bars)
        for name in values:
            beyond = now[name] - exact[name][i]
            low[name][i] = MIDDLES(beyond)
            proven[name][i] = norm_of(beyond)
            radius[name][i] = norm_of(beyond - exactly({name: low[name][i]})[name])
    arrays = {FIELDS[name]: x.reshape(getattr(trajectory, FIELDS[name]).shape) for name, x in low.items()}
    return proven, radius, trajectory.replace(**arrays)


def need_contained(name: str, t_s: Array, proven: Mapping[str, Array], error: Mapping[str, Array]) -> None:
    """Check that each value's error bar contains the exact value.

    Raises
    ------
    ExcludedError
        If one does not.
    """
    for quantity, allowed in error.items():
        outside = np.flatnonzero(proven[quantity] > allowed)
        if len(outside):
            i = outside[0]
            raise ExcludedError(
                f"{name}: the {quantity} at {t_s[i]:.9g} s may be {proven[quantity][i]:.3g} from the exact one; its "
                f"error bar is {allowed[i]:.3g} (SI units; {len(outside)} samples)"
            )


def shortened(values: Array) -> Any:
    """Values of 8 bits, none smaller than before: a file then takes a fifth of their room."""
    mantissa, exponent = np.frexp(values)
    return np.ldexp(np.ceil(256.0 * mantissa) / 256.0, exponent)


def attach(path: Path, scene: Scene, out: Path, **options: Any) -> Proof:
    """Enclose the certified solution of a file, and write it with the proof into a folder.

    Parameters
    ----------
    path : Path
    scene : Scene
    out : Path
    **options : Any
        As for :func:`prove`, whose errors are raised.

    Raises
    ------
    ExcludedError
        If the enclosure excludes a certified value.
    """
    head, frame = read_file(path)
    frame = frame[[c for c in frame if not str(c).startswith((PROVEN, RADIUS, LOW))]]
    instants = np.arange(len(frame)) >= head.get("dense", 0)
    used = np.flatnonzero(instants | frame[f"{ERROR}attitude"].notna())
    used = used[np.argsort(frame["t_s"].to_numpy()[used], kind="stable")]
    rows, chosen = frame.iloc[used], instants[used]
    proof = prove(scene, motion_of(rows, head), **options)
    need_contained(scene.name, rows["t_s"].to_numpy(), proof.proven, columns_of(rows, ERROR))
    low = to_frame(proof.low).drop(columns="t_s").add_prefix(LOW)
    low[~chosen] = np.nan
    least = float(np.finfo(np.float32).tiny)  # a smaller bound would be stored as zero
    proven = {q: np.where(x > 0.0, np.maximum(shortened(x), least), 0.0) for q, x in proof.proven.items()}
    proven = {q: x.astype(np.float32) for q, x in proven.items()}
    radius = {q: np.where(chosen, shortened(x), np.nan) for q, x in proof.radius.items()}
    added = low.assign(**with_prefix(PROVEN, proven), **with_prefix(RADIUS, radius)).set_index(used)
    write_frame(shipped_path(scene.name, out), head | {PROOF: proof.head}, frame.join(added))
    return proof


def proof_of(path: Path) -> tuple[Trajectory, Proof] | None:
    """Values at the chosen instants of a file with their proof; None without one. Errors as in :func:`read_file`."""
    head, frame = read_file(path)
    if PROOF not in head:
        return None
    rows = frame[head.get("dense", 0) :]
    low = rows.filter(regex=f"^{LOW}").rename(columns=lambda c: str(c).removeprefix(LOW)).assign(t_s=rows["t_s"])
    proven, radius = columns_of(rows, PROVEN), columns_of(rows, RADIUS)
    return motion_of(rows, head), Proof(**head[PROOF], proven=proven, radius=radius, low=motion_of(low, head))


def proven_words(scene: Scene) -> str:
    """Sentence on the proof of the solution that judges a scene; empty if none comes with barchain, or no proof."""
    path = shipped_files().get(scene.digest)
    proof = head_of(path).get(PROOF) if path is not None else None
    if not proof:
        return ""
    known = f"the exact motion is proven to {at_most(max(proof['relative'], KEPT))} of each quantity's largest value"
    return f"{known}, and the certified solution lies within its error bars of it at its own instants"


def at_most(bound: float) -> str:
    """A bound in one digit, rounded up: ``2e-28``."""
    return f"{float(Context(prec=1, rounding=ROUND_CEILING).create_decimal_from_float(bound)):.0e}"


def bounds_fault(values: Trajectory, proof: Proof) -> str:
    """Fault of the bounds of a proof beside its own values and low parts; empty if there is none.

    A radius is that of a ball and of the low part's rounding. At the last instant the largest of those of balls, over
    the quantity's largest value, is the relative radius; no earlier one is far larger.
    """
    low, largest = components(proof.low), sizes(values)
    ends = []
    for name, radius in proof.radius.items():
        beyond = np.linalg.norm(low[name], axis=-1).max(axis=1, initial=0.0)
        proven, rounding, size = proof.proven[name], beyond * 2.0**-52, float(largest[name].max(initial=0.0))
        widened = (beyond + radius) * (1.0 + 2.0**-6) + float(np.finfo(np.float32).tiny)
        if not ((beyond - radius <= proven) & (proven <= widened)).all():
            return f"{PROVEN}{name} is none of a value, its low part and {RADIUS}{name}"
        if not (radius <= SHRUNK * proof.relative * size + 2.0 * rounding).all():
            return f"{RADIUS}{name} is larger than that of the proof"
        if size:
            ends.append((radius[-1] - rounding[-1]) / size)
    if max(ends, default=0.0) > 2.0 * proof.relative:  # the largest values may lie between these instants
        return "the relative radius is smaller than those at the last instant"
    return ""


def check_proof(scene: Scene, path: Path) -> str:
    """Fault of a stored proof; empty if there is none, or no proof.

    Its bounds are held against values, low parts and error bars. The last interval between instants is enclosed anew,
    with other bits and another order, from the ball at its begin; earlier ones are not.

    Raises
    ------
    NotCheckedError
        If the stored ball, which has the rounding of the low parts, is too wide for that.
    """
    stored = proof_of(path)
    if stored is None:
        return ""
    values, proof = stored
    fault = bounds_fault(values, proof) or error_bars_fault(scene, path)
    if fault or MISSING:
        return fault
    from flint import ctx  # noqa: PLC0415

    from barchain.solutions.enclosure.run import Effort, enclose, order_for  # noqa: PLC0415  # flint
    from barchain.solutions.enclosure.series import TooWideError  # noqa: PLC0415  # flint

    bits, (begin_s, end_s) = round(proof.bits * OTHER_BITS), values.t_s[-2:].tolist()
    ctx.prec = bits
    stored_balls = balls_of(values, proof)
    begin, effort = state_of(stored_balls, -2), Effort(bits, order_for(bits))
    try:
        (last,) = enclose(scene, [end_s], begin, effort, start_s=begin_s)
    except TooWideError as error:
        raise NotCheckedError(f"its last interval is not enclosed again: {error}") from None
    again = by_quantity(last, scene.bars)
    for quantity in stored_balls.keys() - {"impulse"}:
        pairs = zip(stored_balls[quantity][-1].ravel(), again[quantity].ravel(), strict=True)
        if not all(x.overlaps(y) for x, y in pairs):
            return f"the {quantity} at {end_s:.9g} s is not in the ball of {bits} bits"
    return ""


def error_bars_fault(scene: Scene, path: Path) -> str:
    """Fault of a file with a proven distance above its error bar; empty if there is none."""
    _, frame = read_file(path)
    rows = frame[frame[f"{PROVEN}attitude"].notna()]
    try:
        need_contained(scene.name, rows["t_s"].to_numpy(), columns_of(rows, PROVEN), columns_of(rows, ERROR))
    except ExcludedError as error:
        return str(error).removeprefix(f"{scene.name}: ")
    return ""


def balls_of(values: Trajectory, proof: Proof) -> dict[str, Balls]:
    """Balls about value plus low part, (n, k, components) each."""
    from flint import arb  # noqa: PLC0415

    high, low = (exactly(components(x, proof.radius)) for x in (values, proof.low))
    radii = {
        q: np.array([arb(0, float(r)) for r in radius], dtype=object)[:, None, None]
        for q, radius in proof.radius.items()
    }
    return {q: high[q] + low[q] + radii[q] for q in radii}
