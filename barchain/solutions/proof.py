"""Proofs of certified solutions: balls that contain the exact motion, beside the values in the same file.

The exact motion is the solution of the scene's equations for the scene's numbers in double precision, from the state at
t = 0 that the file has: the numbers that every engine gets. Equations and arithmetic of their own enclose it
(:mod:`barchain.solutions.enclosure`). At every sample ``proven_q`` bounds the distance of the file's value from the
exact one, in the norm of ``error_q``. At the chosen instants ``low_`` columns continue the numbers: value plus low
part, to 32 digits, is within ``radius_q`` of the exact value.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
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

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.enclosure.run import Enclosed
    from scenarios import Scene

    Balls = Mapping[str, list[list[Any]]]
    """Of each quantity, by bar or joint and component"""

PROOF, PROVEN, RADIUS, LOW = "proof", "proven_", "radius_", "low_"
BITS, MORE_BITS, MOST_BITS = 200, 1.5, 2000
"""Precision of the first attempt, its growth from attempt to attempt, and its limit"""
OTHER_BITS = 1.3
"""Precision of a check over that of the proof"""
DIGITS = 1e-25
"""Radius over the value's size that an enclosure must reach"""
START_ROUNDINGS = 4.0
"""Of a start in double precision, in roundings of the largest operand: an angle is a sum, a velocity a product"""
UNKNOWNS = ("com", "com_velocity", "attitude", "rate")
MISSING = "" if find_spec("flint") else "python-flint is not installed; pip install 'barchain[proof]'"
"""Reason why nothing is enclosed here; empty if it can be"""


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
        return f"enclosed to {self.relative:.1e} of the values at the last sample ({effort})"


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
    from barchain.solutions.enclosure.run import Effort, TooWideError, enclose, order_for  # noqa: PLC0415  # flint

    while True:
        effort, begun = Effort(bits, order_for(bits)), time.perf_counter()
        try:
            found = list(enclose(scene, trajectory.t_s.tolist(), start_of(trajectory), effort, **options))
            last = by_quantity(found[-1], scene.bars)
            widths = {q: norm_of([[x.rad() for x in part] for part in last[q]]) for q in last}
            relative = max(widths[q] / float(size.max()) for q, size in sizes(trajectory).items() if size.any())
            if relative <= DIGITS:
                need_start(scene, trajectory)
                taken = round(time.perf_counter() - begun, 1)
                return Proof(bits, effort.order, effort.steps, taken, relative, *compared(scene, trajectory, found))
            reason = f"the radius at the end is {relative:.1e} of the value"
        except TooWideError as error:
            reason = str(error)
        bits = round(bits * MORE_BITS)
        if bits > MOST_BITS:
            raise TooWideError(reason)


def start_of(trajectory: Trajectory) -> list[Any]:
    """State in the first row of a trajectory, exact numbers."""
    from barchain.solutions.enclosure.forces import number  # noqa: PLC0415  # flint

    return [number(x) for q in UNKNOWNS for x in getattr(trajectory, FIELDS[q])[0]]


def need_start(scene: Scene, trajectory: Trajectory) -> None:
    """Check that the first row is the scene's start but for roundings.

    Raises
    ------
    ExcludedError
        If it is another.
    """
    from barchain.solutions.enclosure.start import start_balls  # noqa: PLC0415  # flint

    n, row = scene.bars, start_balls(scene)
    operand = {"com": scene.radius0_m, "com_velocity": scene.speed0_m_s, "attitude": 2.0 * math.pi}
    off = [x - y for x, y in zip(row, start_of(trajectory), strict=True)]
    for quantity, part in zip(UNKNOWNS, (off[:2], off[2:4], off[4 : 4 + n], off[4 + n :]), strict=True):
        largest = float(np.abs(getattr(trajectory, FIELDS[quantity])[0]).max())
        allowed = START_ROUNDINGS * 2.0**-53 * max(largest, operand.get(quantity, scene.fastest_rate_rad_s))
        if norm_of([[x] for x in part]) > allowed:
            raise ExcludedError(f"{scene.name}: the {quantity} at the start is not the scene's")


def norm_of(parts: Sequence[Sequence[Any]]) -> float:
    """Upper bound of the largest norm of some vectors of balls."""
    rounded = 1.0 + 2.0**-48  # of the conversions to double precision, and of the root
    return max((math.hypot(*(float(x.abs_upper()) for x in part)) * rounded for part in parts), default=0.0)


def by_quantity(found: Enclosed, bars: int) -> Balls:
    """Balls as `barchain.metrics.quantities.components` has values."""
    state = found.state
    reaction, impulse = ([x[k : k + 2] for k in range(0, len(x), 2)] for x in (found.reaction, found.impulse))
    angle, rate, torque = ([[x] for x in part] for part in (state[4 : 4 + bars], state[4 + bars :], found.torque))
    track = {"com": [state[:2]], "com_velocity": [state[2:4]]}
    return track | {"attitude": angle, "rate": rate, "reaction": reaction, "torque": torque, "impulse": impulse}


def compared(
    scene: Scene, trajectory: Trajectory, found: Sequence[Enclosed]
) -> tuple[dict[str, Array], dict[str, Array], Trajectory]:
    """Distances of a trajectory's values from balls, radii of the balls about value plus low part, and low parts."""
    from barchain.solutions.enclosure.forces import number  # noqa: PLC0415  # flint

    values = components(trajectory)
    low = {name: np.zeros_like(x) for name, x in values.items()}
    proven, radius = ({name: np.zeros(len(found)) for name in values} for _ in range(2))
    for i, balls in enumerate(found):
        for name, parts in by_quantity(balls, scene.bars).items():
            if name in values:
                beyond = [
                    [x - number(y) for x, y in zip(*pair, strict=True)]
                    for pair in zip(parts, values[name][i], strict=True)
                ]
                low[name][i] = [[float(x.mid()) for x in part] for part in beyond]
                rest = [
                    [x - number(y) for x, y in zip(*pair, strict=True)]
                    for pair in zip(beyond, low[name][i], strict=True)
                ]
                proven[name][i], radius[name][i] = norm_of(beyond), norm_of(rest)
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
    proven = {q: shortened(x).astype(np.float32) for q, x in proof.proven.items()}
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
    return f"judged by a certified solution that is proven to {proof['relative']:.0e} of its values" if proof else ""


def check_proof(scene: Scene, path: Path) -> str:
    """Fault of a stored proof; empty if there is none, or no proof.

    The last interval between instants is enclosed anew, with other bits and another order, from the ball at its begin.
    """
    from flint import ctx  # noqa: PLC0415

    from barchain.solutions.enclosure.run import Effort, enclose, order_for  # noqa: PLC0415  # flint

    stored = proof_of(path)
    if stored is None:
        return ""
    values, proof = stored
    bits, (begin_s, end_s) = round(proof.bits * OTHER_BITS), values.t_s[-2:].tolist()
    ctx.prec = bits
    begin, end = (balls_at(values, proof, row) for row in (-2, -1))
    start = [x for q in UNKNOWNS for part in begin[q] for x in part]
    (last,) = enclose(scene, [end_s], start, Effort(bits, order_for(bits)), start_s=begin_s)
    again = by_quantity(last, scene.bars)
    for quantity in end.keys() - {"impulse"}:
        pairs = zip(end[quantity], again[quantity], strict=True)
        if not all(x.overlaps(y) for pair in pairs for x, y in zip(*pair, strict=True)):
            return f"the {quantity} at {end_s:.9g} s is not in the ball of {bits} bits"
    return ""


def balls_at(values: Trajectory, proof: Proof, row: int) -> Balls:
    """Balls about value plus low part, in one row."""
    from flint import arb  # noqa: PLC0415

    from barchain.solutions.enclosure.forces import number  # noqa: PLC0415  # flint

    high, low = (components(x, proof.radius) for x in (values, proof.low))
    return {
        q: [
            [number(x) + number(y) + arb(0, float(radius[row])) for x, y in zip(*pair, strict=True)]
            for pair in zip(high[q][row], low[q][row], strict=True)
        ]
        for q, radius in proof.radius.items()
    }
