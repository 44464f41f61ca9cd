"""Diagnosis of a result: whether it is wrong, where, and which mistakes explain it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.common.initial_state import initial_state
from adapters.engine import AccuracyParameter, EngineError, Setting
from barchain.judge.diagnosis.chance import foretells
from barchain.judge.diagnosis.mistake import (
    Explanation,
    Mistake,
    WrongQuantity,
    addressed,
    explained_words,
    indistinguishable,
    nearest_words,
    part_words,
)
from barchain.judge.diagnosis.own_motion import LIKELY, OwnMotion, with_right_reactions
from barchain.judge.diagnosis.reading_search import ReadingSearch, given_result
from barchain.judge.diagnosis.readings import READINGS
from barchain.judge.diagnosis.starts import off_start
from barchain.judge.diagnosis.trial_search import TrialSearch
from barchain.metrics.quantities import arrays, differences, sizes
from barchain.solutions.at_times import solution_at
from barchain.solutions.reference_run import reference_run
from scenarios.channels import WORDS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from adapters.trajectory import Trajectory
    from barchain.judge.diagnosis.own_motion import OwnRuns
    from barchain.judge.diagnosis.reading_search import GivenResult, Tolerance
    from barchain.solutions.reference import ReferenceSolution
    from scenarios import Scene

HALVES = Setting(AccuracyParameter.RTOL, 1e-13)
"""Accuracy of the right motion between its samples"""
NEARLY = 1e-6
"""Relative difference from a motion that is made consistent from the engine's own"""
REACTION_FACTORS = ("reactions-times-a-factor",)
"""Fitted readings that other masses in the equations of the reactions make, too"""
FEW_SAMPLES = 3
"""Compared samples up to which one wrong sample is nothing special"""
STANDS_OUT = 3.0
"""Least difference of a sample that is off alone, over the largest of all others"""
AFTER_JUMPS = "samples-after-jumps"
JUST_AFTER = 1e-10
"""Time after an event, relative to the duration, at which the motion is the one after it"""
CONTINUOUS = ("com_m", "angle_rad")
"""Arrays that no event changes"""
MOST_TOGETHER = 2
"""Mistakes that explain a result together"""
START_TOLERANCES = 10.0
"""Tolerances of the first sample within which a result starts as a scene does"""
ROUNDINGS = 1e-13
"""Rounding of a start, relative to the scale of its quantity"""


@dataclass(frozen=True)
class Diagnosis:
    """Mistakes that explain a wrong result."""

    wrong: tuple[WrongQuantity, ...]
    """Quantities outside their tolerances; empty for a result inside all tolerances"""
    explanations: tuple[Explanation, ...] = ()
    """Explanations with equal residuals, best first: indistinguishable on this scene"""
    next_best: Explanation | None = None
    """Best of the other mistakes that were tried"""
    parts: tuple[Explanation, ...] = ()
    """Mistakes that each explain some quantities alone, where nothing explains all"""
    nearest: str = ""
    """Where the residual of the motion sits and what comes nearest, in sentences; empty without a residual"""
    incomplete: bool = False
    """Whether not all other mistakes were tried, as runs of the scene take long"""
    own: OwnMotion | None = field(default=None, repr=False, compare=False)
    """The engine's own motion, for a comparison with other scenes"""

    @property
    def inside_tolerances(self) -> bool:
        """Whether no quantity is wrong."""
        return not self.wrong

    @property
    def names(self) -> frozenset[tuple[str, ...]]:
        """Names of the mistakes of each explanation."""
        return frozenset(e.names for e in self.explanations)

    def __str__(self) -> str:
        """The diagnosis in one sentence, or a sentence for each explanation."""
        if self.inside_tolerances:
            return "The result is inside the tolerances."
        if self.explanations:
            others = " Others may explain it too: runs of this scene take long, and not all are tried."
            said = addressed(explained_words(self.explanations, self.next_best))
            return f"{said}.{others if self.incomplete else ''}"
        left = "" if self.next_best is None else nearest_words(self.wrong, self.next_best)
        parts = "".join(f" {part_words(part)}." for part in self.parts)
        tried = " that was tried" if self.incomplete else ""
        opening = f"No known mistake{tried} explains {'all of the' if LIKELY in self.nearest else 'the'} result."
        opening += " Runs of this scene take long, and not all are tried." if self.incomplete else ""
        said = self.departed if self.of_one_sample else self.nearest or left or self.departed
        return f"{opening}{said}{parts}"

    @property
    def of_one_sample(self) -> bool:
        """Whether each wrong quantity is so at one sample alone: what writes results is wrong, and not the motion."""
        return all(w.alone for w in self.wrong)

    @property
    def departed(self) -> str:
        """When the result first leaves its tolerances, and in which quantities."""
        if self.of_one_sample:
            return f" One sample is off: {', '.join(f'{WORDS[w.quantity]} {w.words}' for w in self.wrong)}."
        first = min(w.first for w in self.wrong)
        where = " and ".join(WORDS[w.quantity] for w in self.wrong if w.first == first)
        when = next(w.first_s for w in self.wrong if w.first == first)
        instant = "at the first sample already" if first == 0 else f"at t = {when:.4g} s"
        return f" It departs {instant}, in the {where}."


def diagnose(
    scene: Scene,
    trajectory: Trajectory,
    judging: ReferenceSolution,
    tolerance: Tolerance,
    runs: OwnRuns | None = None,
    absent: Mapping[str, NDArray[np.bool_]] = MappingProxyType({}),
    kept: dict[str, TrialSearch] | None = None,
) -> Diagnosis:
    """Find the mistakes that explain a wrong result.

    A mistake of reading alters the right motion, and explains the result if the altered motion agrees with it within
    the tolerances in every quantity, far better than the right motion does. Other mistakes are found in the engine's
    own motion: its start, and what its momenta gain between samples that the right equations at its own states lack.

    Parameters
    ----------
    scene : Scene
        Scene that the engine was to run, with the samples of `judging`.
    trajectory : Trajectory
        Result of the engine, n samples.
    judging : ReferenceSolution
        Judging solution of the scene.
    tolerance : mapping of str to ndarray, shape (n,)
        Explained error of each quantity (``com`` m, ``com_velocity`` m/s, ``attitude`` rad, ``rate`` rad/s,
        ``reaction`` N, ``torque`` N m, ``impulse`` N s); infinite where a quantity is not compared.
    runs : callable, optional
        Runs of the engine in two given scenes, which are the same with more samples and with twice as many: at the
        judged and at the next finer setting. Each may be None. Without it, the samples of the result have to do.
    absent : mapping, optional
        Parts of arrays that the trajectory lacks, of the shape of a sample; it holds the judging solution's there.
    kept : dict, optional
        What one diagnosis keeps for the next one of the same result with other tolerances.

    Returns
    -------
    Diagnosis
        Without mistakes if the result is inside the tolerances.

    Raises
    ------
    ValueError
        If `judging` is the solution of another scene.
    """
    if scene.digest != judging.scene.digest:
        raise ValueError(f"the judging solution is that of {judging.scene.name}, not of {scene.name}")
    result = given_result(trajectory, judging, tolerance, absent)
    wrong = wrong_quantities(result)
    if not wrong or not result.finite:
        return Diagnosis(wrong)
    if at_jumps := only_at_jumps(result, judging):
        return Diagnosis(wrong, (at_jumps,))
    search = ReadingSearch(result, lambda: half_way(judging))
    given = result.given.replace(**dict.fromkeys(absent))
    lacks_start = all(np.isinf(t[0]) for t in tolerance.values())
    starts_right = starts_in(result, judging.scene, tolerances=1.0)
    own = OwnMotion(judging.scene, given, runs, first=int(lacks_start), starts_right=starts_right)
    found = searched(search, own, wrong)
    # a file's own errors may be larger than the noise of its balance, which then tells no number to its last digits
    untold = own.residual is None or not own.residual.wrong or runs is None
    if not found.explanations and untold:
        kept = {} if kept is None else kept
        trials = kept.setdefault("trials", TrialSearch(result))
        explained = tuple(trials.explaining(result))
        found = dataclasses.replace(found, explanations=explained, incomplete=trials.incomplete)
    return dataclasses.replace(found, own=own)


def only_at_jumps(result: GivenResult, judging: ReferenceSolution) -> Explanation | None:
    """Explanation of differences at instants of events alone by the motion just after these; None of other ones."""
    t_s = result.right.t_s
    jumps = np.isin(t_s, result.scene.effects.breaks_s) & (t_s < judging.fine.t_s[-1])
    if not jumps.any() or jumps.all() or result.at(np.flatnonzero(~jumps)).fit(result.right.samples(~jumps)).outside:
        return None
    after = solution_at(judging, t_s[jumps] + JUST_AFTER * float(judging.fine.t_s[-1])).trajectory
    changed: dict[str, Any] = {}
    for name, values in arrays(result.right).items():
        changed[name] = values.copy()
        if name not in CONTINUOUS:
            changed[name][jumps] = getattr(after, name)
    fit = result.fit(result.right.replace(**changed))
    scene = result.scene.effects
    kinds = (["impulses"] if scene.impulse else []) + (["jumps of a force"] if scene.thrust else [])
    said = f"the samples at instants of {' and '.join(kinds) or 'events'} show the motion after these"
    found = Explanation((Mistake(AFTER_JUMPS, said, "samples"),), fit)
    return found if found.explains(result.fit(result.right).own_error) and foretold(result, found) else None


def foretold(result: GivenResult, explanation: Explanation) -> bool:
    """Whether the quantities that an explanation names, else all, hold numbers enough for it, of all that are tried."""
    digits = result.digits_of(result.quantities & explanation.fit.keys() or result.quantities)
    return foretells(digits, 0, len(READINGS) ** len(explanation.mistakes))


def half_way(judging: ReferenceSolution) -> Trajectory | None:
    """The right motion at its samples and half way between them; None if the reference fails."""
    run = judging.scene.run
    dense = dataclasses.replace(judging.scene, run=dataclasses.replace(run, samples=2 * run.samples - 1))
    try:
        return reference_run(dense, HALVES)
    except EngineError:
        return None


def searched(search: ReadingSearch, own: OwnMotion, wrong: tuple[WrongQuantity, ...]) -> Diagnosis:
    """Diagnosis by a search: readings and starts, then the equations of motion, then both together."""
    others = [e for e in search.alone if not e.explains(search.unaltered.own_error)]
    equal = tuple(e for e in indistinguishable(causes(search, own)) if foretold(search.result, e))
    if equal:
        return Diagnosis(wrong, equal, next((e for e in others if e not in equal), None))
    next_best, together = next(iter(others), None), search.parts_together
    if together is not None and foretold(search.result, together):
        return Diagnosis(wrong, (together,), next_best)
    parts = tuple(part for t in search.in_parts if foretold(search.result, part := t.of_altered))
    return Diagnosis(wrong, (), next_best, parts, own.nearest)


def causes(search: ReadingSearch, own: OwnMotion) -> list[Explanation]:
    """Explanations of the simplest kind that there is: readings, fitted readings, both kinds, the motion."""
    if search.explaining:
        return [*search.explaining, *own.starts]
    motion = own.explaining_from(partial(starts_in, search.result))
    if search.fitted:
        of_reactions = all(e.names[0] in REACTION_FACTORS for e in search.fitted)
        return [*(motion if of_reactions else ()), *search.fitted]
    return list(combined(search, own)) or own.starts or motion


def starts_in(result: GivenResult, scene: Scene, tolerances: float = START_TOLERANCES) -> bool:
    """Whether a result starts as a scene does, as far as its tolerances at the first sample tell."""
    return not any(
        np.linalg.norm(off) > max(tolerances * result.tolerance[q][0], ROUNDINGS * result.scale.get(q, 0.0))
        for q, off in off_start(result.given, initial_state(scene)).items()
        if q in result.tolerance
    )


def combined(search: ReadingSearch, own: OwnMotion) -> Iterator[Explanation]:
    """A wrong start or wrong equations together with a mistake of reading.

    The readings are those of the engine's own motion, made consistent: with reactions that belong to its states, or
    with rates by its angles.
    """
    for found, scene in own.moves_as:
        right = with_right_reactions(scene, own.given)
        yield from both(found, readings_of(search, right))
    if own.moves_as or own.explaining or own.starts:
        return
    for inner in own.repaired():
        causes = indistinguishable(inner.explaining or inner.starts)
        for reading in readings_of(search, inner.given) if causes else ():
            yield from (e for c in causes for e in both(c, [reading]))


def both(cause: Explanation, readings: Iterable[Explanation]) -> Iterator[Explanation]:
    """A cause with each reading, of two mistakes together: three explain anything."""
    for reading in readings:
        if len(cause.mistakes) + len(reading.mistakes) <= MOST_TOGETHER:
            yield Explanation((*cause.mistakes, *reading.mistakes), reading.fit)


def readings_of(search: ReadingSearch, right: Trajectory) -> list[Explanation]:
    """Readings of another right motion that explain the result."""
    result = search.result
    size = {q: np.full(result.n, NEARLY * scale) for q, scale in result.scale.items() if q in result.tolerance}
    again = dataclasses.replace(result, right=right, tolerance=size)
    return ReadingSearch(again).explaining[:1]


def wrong_quantities(result: GivenResult) -> tuple[WrongQuantity, ...]:
    """Quantities outside their tolerances, with the size of the difference; not-a-number is outside."""
    apart = differences(result.given, result.right)
    size = sizes(result.right)
    found = []
    for name in (n for n in apart if n in result.quantities):
        inside = np.isfinite(result.tolerance[name])
        over = inside & ~(apart[name] <= result.tolerance[name])
        if over.any():
            first = int(np.argmax(over))
            others = apart[name][inside & ~over]
            alone = bool(len(others) >= FEW_SAMPLES and np.count_nonzero(over) == 1)
            alone &= not apart[name][first] <= STANDS_OUT * others.max(initial=0.0)
            counted = over if alone else inside
            largest, whole = float(apart[name][counted].max()), float(size[name][inside].max(initial=0.0))
            when, scale = float(result.right.t_s[first]), result.scale.get(name, 0.0)
            found.append(WrongQuantity(name, largest, whole, scale, first, when, alone))
    return tuple(found)
