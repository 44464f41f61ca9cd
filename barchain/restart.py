"""The reference restarted from an engine's own state: what can be compared beyond the predictability limit.

Two correct runs of a chaotic scene part. But an engine's samples still have to follow the equations of motion: from one
sample to the next, and for as long as errors do not grow too large. So beyond the limit the reference starts anew from
the engine's last sample that was found right, and the next stretch of the engine's run is compared with that, as far as
*its* predictability limit; then from there again. Nonsense shows in the stretch in which it begins.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np

from adapters.engine import Knob, Setting
from adapters.initial_state import InitialState, chain_model
from adapters.reference_adapter import Reference
from adapters.registry import ENGINES
from barchain.compiling import COMPILED, mark
from barchain.declared import MOST_ATTITUDE_NOISE_RAD
from barchain.error_model import ErrorModel
from barchain.quantities import differences
from barchain.tolerances import NORM_SLACK
from barchain.truth import TRACK, Truth, answers, densely_sampled, moves_aside, own_rate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from adapters.engine import Array, Trajectory
    from adapters.reference_adapter import ReferenceEngine
    from scenarios import Scene

RTOL = 1e-7  # its own error is counted too; engines that lose a chaotic scene's attitude within it are far coarser
TIGHTER = 0.1  # than what an engine that chooses its steps is asked for
ASIDE_RTOL = 1e-6  # of the perturbed run, whose distance is asked for, to some per cent
ASIDE_RAD = 3e-5  # of the perturbed run: thirty times what its steps leave, yet linear until 3e3 times larger
FIRST_TRY = 1.2  # times the length of the stretch before: how far the reference walks before it is known how far to
SHORTER = 0.2  # of what is predictable from exact initial values: an engine's own samples have errors of reading
IN_A_ROW = 7
"""Stretches one after the other from the predictability limit on"""
SPREAD_OUT = 15
"""Stretches spread over the rest of the run, where those in a row do not reach its end"""
JUDGED = ("attitude", "rate", "reaction", "torque", "impulse")


@dataclass(frozen=True)
class Stretch:
    """Part of an engine's run, compared with the reference started from the engine's own state; m samples."""

    first: int
    """Sample that the reference starts from"""
    found: dict[str, Array]
    """(m,) difference for each quantity, from sample `first` on"""
    allowed: dict[str, Array]
    """(m,) bound of what two correct runs differ by. An engine's samples need not be the state that it goes on from:
    rates are read off half a step aside, or off impulses that are noise"""

    @property
    def last(self) -> int:
        """Last sample compared; `first` where not even the next one can be predicted."""
        return self.first + len(next(iter(self.found.values()))) - 1

    @property
    def empty(self) -> bool:
        """Whether nothing after its start could be predicted."""
        return self.last == self.first

    @property
    def everywhere(self) -> NDArray[np.bool_]:
        """All of its samples, (m,)."""
        return np.ones(self.last - self.first + 1, bool)

    @property
    def right(self) -> bool:
        """Whether all differences are inside their bounds."""
        return all(np.all(self.found[name] <= self.allowed[name]) for name in self.found)


def can_restart(seen: Trajectory) -> bool:
    """Whether a run shows the whole state."""
    return seen.angle_rad is not None and seen.rate_rad_s is not None


def stretches(errors: ErrorModel, seen: Trajectory, first: int) -> list[Stretch]:
    """Stretches of a run from sample `first` on, until one of them is wrong or the run ends.

    Each starts from the engine's own state, so that they need not follow on each other: where the run is longer than
    :data:`IN_A_ROW` of them, some more are spread over the rest. What goes on being wrong is met by one of them,
    wherever it began; a single sample that is wrong may fall in between.

    Parameters
    ----------
    errors : ErrorModel
        Of the engine at its setting in the scene.
    seen : Trajectory
        Run of the engine.
    first : int
        Last sample that is known to be right.

    Raises
    ------
    EngineError
        If the reference can't go on from one of the engine's states.
    """
    found = in_a_row(errors, seen, first)
    reached, end = found[-1].last if found else first, len(seen.t_s) - 1
    if reached >= end or not all(s.right for s in found):
        return found
    length = max(1, round(np.mean([s.last - s.first for s in found])))
    latest = max(end - length, reached)
    for planned in scattered(errors.scene, reached, latest):
        start = max(planned, found[-1].last)
        if start >= end or not found[-1].right:
            break
        if planned in (start, latest):  # what an earlier one covers needs no other, but for the run's end
            found.append(compared(errors, seen, start, min(end, start + tried(length))))
    return found


def scattered(scene: Scene, reached: int, latest: int) -> list[int]:
    """Samples that stretches start from: one at random in each equal part of the rest, the last at its end.

    The scene seeds them, so that they are the same in every run, and no fault that recurs can fall between them.
    """
    edges = np.linspace(reached, latest, SPREAD_OUT)
    shift = np.random.default_rng(list(scene.digest.encode())).uniform(0.0, 1.0, SPREAD_OUT - 1)
    starts = edges[:-1] + shift * np.diff(edges)
    return [*starts.astype(int).tolist(), latest]


def in_a_row(errors: ErrorModel, seen: Trajectory, first: int) -> list[Stretch]:
    """Stretches of a run from sample `first` on, each from the end of the one before, at most :data:`IN_A_ROW`."""
    end = len(seen.t_s) - 1
    found: list[Stretch] = []
    ahead = max(SHORTER * first, 1.0)
    while first < end and len(found) < IN_A_ROW:
        stretch = compared(errors, seen, first, min(end, first + tried(ahead)))
        found.append(stretch)
        if not stretch.right:
            break
        ahead = max(stretch.last - first, 1.0)
        first = max(stretch.last, first + 1)
    return found


def tried(samples: float) -> int:
    """Samples that the reference walks where about so many are expected to be predictable."""
    return max(2, math.ceil(FIRST_TRY * samples))


def compared(errors: ErrorModel, seen: Trajectory, first: int, last: int) -> Stretch:
    """Compare samples `first` to `last` of a run, as far as they can be predicted from the first.

    What is read off a step may belong to what was before the first sample, such as the end of a manoeuvre, and its
    ringing lasts where the method damps nothing: where there are such instants, the errors of reading that the scene
    has shown until then are allowed besides. In a manoeuvre and just after it they are errors of the state, too.
    """
    engine, setting = errors.engine, errors.setting
    rtol = min(RTOL, TIGHTER * setting.value) if setting.knob is Knob.RTOL else RTOL
    restarted = restarted_truth(errors.truth, seen, first, last, rtol)
    shown = errors.local.immediate if errors.scene.effects.breaks_s else {}
    before = {name: float(values[min(first, errors.n - 1)]) for name, values in shown.items()}
    model = ErrorModel(engine, setting, restarted, seen)
    read_off = float(model.local.immediate["rate"][0])
    if in_a_manoeuvre(errors.scene, seen.t_s, first):
        read_off = max(read_off, before.get("rate", 0.0))
    model.start_rad = read_off / own_rate(errors.scene) + declared_rad(errors, first)
    n = int(np.count_nonzero(model.t_s <= model.limit_s))
    rows = seen.samples(slice(first, last + 1))
    if rows.impulse_N_s is not None:  # the restarted reference counts its blows from its own start
        rows = rows.replace(impulse_N_s=rows.impulse_N_s - rows.impulse_N_s[0])
    apart = differences(rows, restarted.trajectory)
    quantities = [name for name in JUDGED if name in apart]
    return Stretch(
        first,
        {name: apart[name][:n] for name in quantities},
        {
            name: (model.band[name] + restarted.error[name])[:n] + NORM_SLACK * before.get(name, 0.0)
            for name in quantities
        },
    )


def in_a_manoeuvre(scene: Scene, t_s: Array, first: int) -> bool:
    """Whether a bar is being turned at a sample, or equations of motion changed within two sample intervals before."""
    earliest, now = t_s[max(first - 2, 0)], t_s[first]
    turned = any(p.breaks_s[0] <= now and earliest <= p.breaks_s[1] for p in scene.effects.prescribed_rotation)
    return turned or any(earliest <= at <= now for at in scene.effects.breaks_s)


def declared_rad(errors: ErrorModel, first: int) -> float:
    """Declared noise of the rates of a sample, as an angle, rad: as far as noise of the attitude would be believed.

    The floor of the run counts for nothing here: what round-off has grown to since the start is part of the state that
    the engine goes on from.
    """
    noise = errors.noise.get("rate")
    said = 0.0 if noise is None else float(noise[min(first, errors.n - 1)]) / own_rate(errors.scene)
    return min(said, MOST_ATTITUDE_NOISE_RAD)


def restarted_truth(truth: Truth, seen: Trajectory, first: int, last: int, rtol: float) -> Truth:
    """Reference solution from a sample of a run on: growth, derivatives and its own error as the scene's truth has."""
    scene = truth.scene
    between = max(1, (densely_sampled(scene).run.samples - 1) // (scene.run.samples - 1))
    times = seen.t_s[first : last + 1]
    closely = np.interp(np.arange((len(times) - 1) * between + 1) / between, np.arange(len(times)), times)
    closely[::between] = times
    fine = walked(scene, seen, first, closely, rtol, 0.0)
    aside = walked(scene, seen, first, times, max(rtol, ASIDE_RTOL), ASIDE_RAD)
    main = fine.samples(slice(None, None, between))
    parted = differences(main, aside)
    n = min(len(main.t_s), len(aside.t_s))
    attitude = np.maximum.accumulate(parted["attitude"])[:n]
    response = answers(parted, n, 0.0) | {name: np.zeros(n) for name in TRACK}
    made = Truth(scene, main, fine, {}, attitude / attitude[0], response, float(main.t_s[n - 1]))
    own = ErrorModel(Reference, Setting(Knob.RTOL, rtol), made, main)
    return dataclasses.replace(made, error=own.band)


def walked(scene: Scene, seen: Trajectory, first: int, t_s: Array, rtol: float, aside_rad: float) -> Trajectory:
    """Run of the reference from sample `first` of `seen`, at instants (m,) s; its start moved aside by an angle.

    Raises
    ------
    EngineError
        If the reference can't go on from there.
    """
    assert seen.angle_rad is not None
    assert seen.rate_rad_s is not None
    unit, moved = own_rate(scene), aside_rad * moves_aside(scene.bars)
    nothing = np.zeros((scene.bars, 2))
    start = InitialState(
        seen.com_m[first], seen.com_velocity_m_s[first], seen.angle_rad[first] + moved[0],
        seen.rate_rad_s[first] + unit * moved[1], nothing, nothing,
    )  # fmt: skip
    model = chain_model(scene)
    model = dataclasses.replace(model, impulses=tuple(b for b in model.impulses if b.at_s >= t_s[0]))
    run = form(scene)
    run.times_s, run.prepared = t_s, run.prepare(model, start, rtol)
    run.simulate()
    seen_again = run.read()
    if seen.impulse_N_s is not None and seen_again.impulse_N_s is None:  # no blow is left: what it adds up stays
        return seen_again.replace(impulse_N_s=np.zeros((len(t_s), scene.bars - 1, 2)))
    return seen_again


def form(scene: Scene) -> ReferenceEngine:
    """Return the compiled reference where its code for the scene's effects is there, else NumPy's.

    Compiling takes longer than any stretch does in NumPy.
    """
    compiled = ENGINES[COMPILED]
    if compiled.missing or not mark(scene).is_file():
        return Reference()
    return cast("ReferenceEngine", compiled.load()())
