"""Proofs of certified solutions: balls that contain the exact motion, beside the values in the same file.

The exact motion is the solution of the scene's equations for the scene's numbers in double precision, from the state at
t = 0 that the file has: the numbers that every engine gets. It is enclosed by equations and arithmetic of their own
(:mod:`barchain.solutions.enclosure`). At every sample ``proven_q`` is an upper bound of the distance of the file's value
from the exact one, in the norm of ``error_q``. At the chosen instants ``low_`` columns continue the numbers: value plus
low part, to 32 digits, is within ``radius_q`` of the exact value.
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
    motion_of,
    read_file,
    rounded_up,
    shipped_path,
    with_prefix,
    write_frame,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from adapters.trajectory import Array, Trajectory
    from barchain.solutions.certified_file import Head
    from barchain.solutions.enclosure.run import Enclosed
    from scenarios import Scene

PROOF, PROVEN, RADIUS, LOW = "proof", "proven_", "radius_", "low_"
BITS, MORE_BITS, MOST_BITS = 160, 1.6, 2000
"""Precision of the first attempt, its growth from attempt to attempt, and its limit"""
OTHER_BITS = 1.3
"""Precision of a check over that of the proof"""
DIGITS = 1e-20
"""Radius over the value's size that an enclosure must reach"""
MISSING = "" if find_spec("flint") else "python-flint is not installed; pip install 'barchain[proof]'"
"""Reason why nothing is enclosed here; empty if it can be"""


class ExcludedError(ValueError):
    """An enclosure excludes a certified value; the message has the value."""


@dataclass(frozen=True)
class Proof:
    """Enclosure of a scene at the instants of its file; n rows."""

    bits: int
    order: int
    steps: int
    seconds: float
    relative: float
    """Largest radius at the last sample, over the quantity's largest value"""
    proven: dict[str, Array]
    """(n,) for each quantity, as the errors: bound of the distance of the file's values from the exact ones"""
    radius: dict[str, Array]
    """(n,) for each quantity: radius of the ball about value plus low part"""
    low: Trajectory
    """Low parts of all values"""

    @property
    def words(self) -> str:
        """Radius and effort in one line."""
        effort = f"{self.bits} bits, order {self.order}, {self.steps} steps, {self.seconds:.0f} s"
        return f"enclosed to {self.relative:.1e} of the values at the last sample ({effort})"

    @property
    def head(self) -> dict[str, float]:
        """Attributes of a file."""
        return {name: getattr(self, name) for name in ("bits", "order", "steps", "seconds", "relative")}


def balls_by_quantity(found: Enclosed, bars: int) -> dict[str, list[list[Any]]]:
    """Balls of each quantity by bar or joint, as `barchain.metrics.quantities.components` has values."""
    state = found.state
    paired = {name: [values[k : k + 2] for k in range(0, len(values), 2)]
              for name, values in (("reaction", found.reaction), ("impulse", found.impulse))}  # fmt: skip
    return {
        "com": [state[:2]], "com_velocity": [state[2:4]], "attitude": [[x] for x in state[4 : 4 + bars]],
        "rate": [[x] for x in state[4 + bars :]], "torque": [[x] for x in found.torque], **paired,
    }  # fmt: skip


def norm_of(parts: Sequence[Sequence[Any]]) -> float:
    """Upper bound of the largest norm of some vectors of balls."""
    rounded = 1.0 + 2.0**-48  # of the conversions to double precision, and of the root
    return max((math.hypot(*(float(x.abs_upper()) for x in part)) * rounded for part in parts), default=0.0)


def prove(
    scene: Scene, trajectory: Trajectory, *, bits: int = BITS, told: Callable[[float, Any], None] | None = None,
    gradient_sign: int = 1,
) -> Proof:  # fmt: skip
    """Enclose a scene at the instants of a trajectory whose first row is the start.

    Parameters
    ----------
    scene : Scene
    trajectory : Trajectory
        Values to be proven.
    bits : int
        Precision of the first attempt; more are taken until the relative radius at the end is below `DIGITS`.
    told : callable, optional
        As in :func:`barchain.solutions.enclosure.run.enclose`.
    gradient_sign : int
        -1 for a wrong sign of gravity's torque, to be detected.

    Raises
    ------
    NotEnclosedError, TooWideError
        If the motion is none that is enclosed, or takes more than `MOST_BITS`.
    """
    from barchain.solutions.enclosure.run import Effort, TooWideError, enclose, order_for  # noqa: PLC0415  # flint

    while True:
        effort, begun = Effort(bits, order_for(bits)), time.perf_counter()
        try:
            balls = list(enclose(scene, trajectory.t_s.tolist(), start_of(trajectory), effort, told=told,
                                 gradient_sign=gradient_sign))  # fmt: skip
            found = compared(scene, trajectory, balls)
            relative = relative_radius(found[1], trajectory)
            if relative <= DIGITS:
                taken = round(time.perf_counter() - begun, 1)
                return Proof(bits, effort.order, effort.steps, taken, relative, *found)
            reason = f"{scene.name}: the radius at the end is above {DIGITS:g} of the value"
        except TooWideError as error:
            reason = f"{scene.name}: {error}"
        bits = round(bits * MORE_BITS)
        if bits > MOST_BITS:
            raise TooWideError(reason)


def start_of(trajectory: Trajectory, row: int = 0) -> list[Any]:
    """State in a row of a trajectory, exact numbers."""
    from barchain.solutions.enclosure.forces import number  # noqa: PLC0415  # flint

    parts = (getattr(trajectory, FIELDS[q])[row] for q in ("com", "com_velocity", "attitude", "rate"))
    return [number(x) for x in np.concatenate(list(parts))]


def relative_radius(radius: dict[str, Array], trajectory: Trajectory) -> float:
    """Largest radius in the last row over the quantity's largest value; of quantities that are zero there is none."""
    largest = {name: float(size.max()) for name, size in sizes(trajectory).items()}
    return max(float(r[-1]) / largest[name] for name, r in radius.items() if largest[name])


def compared(
    scene: Scene, trajectory: Trajectory, balls: Sequence[Enclosed]
) -> tuple[dict[str, Array], dict[str, Array], Trajectory]:
    """Distances of a trajectory's values from balls, radii of the balls about value plus low part, and low parts."""
    from barchain.solutions.enclosure.forces import number  # noqa: PLC0415  # flint

    names = [name for name in FIELDS if getattr(trajectory, FIELDS[name]) is not None]
    names = [name for name in names if getattr(trajectory, FIELDS[name]).shape[1]]
    low = {name: np.zeros_like(getattr(trajectory, FIELDS[name])) for name in names}
    proven, radius = ({name: np.zeros(len(balls)) for name in names} for _ in range(2))
    for i, found in enumerate(balls):
        for name, parts in balls_by_quantity(found, scene.bars).items():
            if name not in low:
                continue
            values, shape = iter(getattr(trajectory, FIELDS[name])[i].ravel()), low[name][i].shape
            beyond = [[x - number(next(values)) for x in part] for part in parts]
            lows = [[float(x.mid()) for x in part] for part in beyond]
            low[name][i] = np.array(lows).reshape(shape)
            proven[name][i] = norm_of(beyond)
            rest = [[x - number(y) for x, y in zip(*both, strict=True)] for both in zip(beyond, lows, strict=True)]
            radius[name][i] = norm_of(rest)
    arrays = {FIELDS[name]: values for name, values in low.items()}
    return proven, radius, trajectory.replace(**arrays)


def need_contained(name: str, t_s: Array, proven: dict[str, Array], error: dict[str, Array]) -> None:
    """Check that the ball of each value and its error bar contains the exact value.

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


def attach(path: Path, scene: Scene, out: Path, **options: Any) -> Proof:
    """Enclose the certified solution of a file, and write it with the proof into a folder.

    Parameters
    ----------
    path : Path
    scene : Scene
    out : Path
    **options : Any
        As for :func:`prove`.

    Raises
    ------
    ExcludedError
        If the enclosure excludes a certified value.
    """
    head, frame = read_file(path)
    head.pop(PROOF, None)
    frame = frame[[c for c in frame if not str(c).startswith((PROVEN, RADIUS, LOW))]]
    instants = np.arange(len(frame)) >= head.get("dense", 0)
    used = np.flatnonzero(instants | frame[f"{ERROR}attitude"].notna())
    used = used[np.argsort(frame["t_s"].to_numpy()[used], kind="stable")]
    rows, chosen = frame.iloc[used], instants[used]
    proof = prove(scene, motion_of(rows, head), **options)
    need_contained(scene.name, rows["t_s"].to_numpy(), proof.proven, columns_of(rows, ERROR))
    proven = {q: rounded_up(x) for q, x in proof.proven.items()}
    radius = {q: np.where(chosen, x, np.nan) for q, x in proof.radius.items()}
    low = to_frame(proof.low).drop(columns="t_s").add_prefix(LOW)
    low[~chosen] = np.nan
    added = low.assign(**with_prefix(PROVEN, proven), **with_prefix(RADIUS, radius)).set_index(used)
    head[PROOF] = proof.head
    write_frame(shipped_path(scene.name, out), head, frame.join(added))
    return proof


def proof_of(path: Path) -> Proof | None:
    """Proof at the chosen instants of a file; None without one. Errors as in :func:`read_file`."""
    head, frame = read_file(path)
    if PROOF not in head:
        return None
    rows = frame[head.get("dense", 0) :]
    low = motion_of(
        rows[["t_s"]].join(rows.filter(regex=f"^{LOW}").rename(columns=lambda c: c.removeprefix(LOW))), head
    )
    return Proof(**head[PROOF], proven=columns_of(rows, PROVEN), radius=columns_of(rows, RADIUS), low=low)


def proven_words(head: Head) -> str:
    """Sentence on the proof of a file; empty without one."""
    if PROOF not in head:
        return ""
    return f"the certified solution is proven to {head[PROOF]['relative']:.0e} of its values"


def check_proof(scene: Scene, path: Path) -> str:
    """Fault of a stored proof; empty if there is none, or no proof.

    The values at the chosen instants and their low parts are enclosed anew over the last interval, with other bits and
    another order, and all distances are compared with the error bars.
    """
    from flint import ctx  # noqa: PLC0415

    from barchain.solutions.enclosure.run import Effort, enclose, order_for  # noqa: PLC0415  # flint

    head, frame = read_file(path)
    stored = proof_of(path)
    if stored is None:
        return ""
    rows = frame[head.get("dense", 0) :]
    try:
        need_contained(scene.name, rows["t_s"].to_numpy(), stored.proven, columns_of(rows, ERROR))
    except ExcludedError as error:
        return str(error)
    values, bits = motion_of(rows, head), round(stored.bits * OTHER_BITS)
    ctx.prec = bits
    begin, end = (balls_at(values, stored, row) for row in (-2, -1))
    effort, t_s = Effort(bits, order_for(bits)), values.t_s
    start = [x for q in ("com", "com_velocity", "attitude", "rate") for part in begin[q] for x in part]
    (last,) = enclose(scene, [float(t_s[-1])], start, effort, start_s=float(t_s[-2]))
    again = balls_by_quantity(last, scene.bars)
    for quantity, parts in end.items():
        if quantity != "impulse" and not all(
            x.overlaps(y)
            for part, other in zip(parts, again[quantity], strict=True)
            for x, y in zip(part, other, strict=True)
        ):
            return f"{scene.name}: the stored {quantity} at {t_s[-1]:.9g} s is not in the ball of {bits} bits"
    return ""


def balls_at(values: Trajectory, stored: Proof, row: int) -> dict[str, list[list[Any]]]:
    """Balls of a stored proof about value plus low part, in one row."""
    from flint import arb  # noqa: PLC0415

    from barchain.solutions.enclosure.forces import number  # noqa: PLC0415  # flint

    found = {}
    highs, lows = (components(x, stored.radius) for x in (values, stored.low))
    for quantity, radius in stored.radius.items():
        found[quantity] = [
            [number(x) + number(y) + arb(0, float(radius[row])) for x, y in zip(*both, strict=True)]
            for both in zip(highs[quantity][row], lows[quantity][row], strict=True)
        ]
    return found
