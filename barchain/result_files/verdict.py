"""Verdict on a result in a file: what of it is explained, at which accuracy, and by which mistakes the rest is."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import Coordinates
from barchain.judge.checks.more_judged import until_share
from barchain.judge.compare import verdict_on
from barchain.judge.diagnosis.verdicts import diagnosis_of_verdict, needs_diagnosis, thinned
from barchain.judge.evidence import Evidence
from barchain.judge.round_off import ROUND_OFF, round_off
from barchain.judge.scales import scales
from barchain.judge.verdict import no_verdict
from barchain.judge.written import MeasuredErrors, Undeclared, WrittenErrors, WrittenResiduals
from barchain.metrics.quantities import TRACK, differences, sizes
from barchain.runs.job import RunResult
from reports.results.outcome import Outcome
from scenarios.channels import UNITS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.diagnose import Diagnosis
    from barchain.judge.error_model import ErrorModel
    from barchain.judge.verdict import Verdict
    from barchain.judge.written import Declared
    from barchain.result_files.samples import Samples
    from barchain.solutions.reference import ReferenceSolution

LEAST_SHARE = 0.1
"""Least share of the scene that a file must span: agreement over less says nothing about the scene"""
LEAST_JUDGED = 0.25
"""Least share of the samples that must be judged where a finer file alone tells the error: both have hardly a digit"""
ORDER_SLACK = 0.5
"""Difference of a measured order from the declared one from which on it is told"""
CONVERGES = 1.5
"""Least ratio of two files' errors that shows that the finer one has another error"""
FEWEST_BEFORE = 8
"""Least samples before one at which a change is held against earlier ones; and the share of the file, its reciprocal"""
SMALLEST_CHANGE = 1e-9
"""Change between files, relative to a quantity's size, that earlier changes need not foretell"""
MOST_FASTER = 1e3
"""Largest ratio of a change to what earlier ones grow to: doubled times make that of a right method up to 16 times"""
MOST_MADE = 100.0
"""Error of several steps and of what amplifies beside the attitude, over that of one step of the request"""
STATES = ("com", "com_velocity", "attitude", "rate")
"""Quantities that a start is made of"""
SAME_START = 1e-9
"""Largest difference of the row at t = 0 from the scene's start, relative to a quantity's scale"""
ROUNDED_UP = 1.1
"""Factor of a proposed noise, which is printed to two digits"""
LADDER = tuple(10.0**-k for k in range(12, 3, -1))
"""Requested errors that are tried for a file that declares none, or a coarser one: from rounding on, by decades"""
DIAGNOSED = LADDER[::2]
"""Those at which mistakes are sought, until one is found: beside it a file has errors of its own"""
UNCONTRADICTED = (Outcome.PASS, Outcome.TOO_COARSE)
"""Outcomes of a file that agrees up to the predictability limit and that no restart beyond contradicts, where a
diverged end may be; a restart that tells nothing contradicts nothing"""
COARSEST = LADDER[6]
"""Coarsest requested error, 1e-6, at which a file that declares none passes"""
FAR_APART = 50.0
"""Ratio of two requests, of decades, from which on some quantities are far less accurate than the others"""


@dataclass(frozen=True)
class FileVerdict:
    """Verdict on a file, and what is to be known about it."""

    verdict: Verdict
    mistakes: Diagnosis | None
    """None where nothing is wrong, or no mistake was sought"""
    solution: ReferenceSolution
    main: Trajectory
    finer: Trajectory | None
    engine: Declarations
    setting: Setting
    advice: list[str]
    """Sentences that come before all reasons"""
    notes: list[str]


def judge_file(name: str, main: Samples, finer: Samples | None, declared: Declared) -> FileVerdict:
    """Verdict on a file, with the mistakes that explain what is wrong.

    A file of which no accuracy is declared is judged by its digits, and by error bars that are stated. Where these do
    not explain a difference, requested errors are tried from small to large, until the file agrees, or a mistake
    explains the rest. The file passes at the accuracy that it is found to have, down to :data:`COARSEST`.

    Parameters
    ----------
    name : str
    main : Samples
    finer : Samples, optional
        At the same instants, of a run with half the step or a tenth of the requested error.
    declared : Declared
    """
    own = {} if finer is None else differences(main.trajectory, finer.trajectory)
    notes, advice = list(main.notes), list[str]()
    found, engine, setting = one_verdict(name, main, finer, declared, own)
    mistakes: Diagnosis | None = None
    rounded = "" if finer is None else as_round_off(name, main, finer, declared, found)
    if finer is not None and declared.order is not None and found.outcome is not Outcome.PASS and not rounded:
        advice += other_order(found, main, finer, declared.order)
    if found.outcome is not Outcome.PASS:
        advice += [main.other_chain, main.other_time]
        advice = [*filter(None, advice)]
    if fast := too_fast(main, own):
        fast = f"the two files part {fast}"
        found = with_outcome(found, main, setting, Outcome.INCONSISTENT, fast, name)
        advice.append(fast)
    if isinstance(setting, Undeclared) and finer is None and not advice:
        if found.outcome is Outcome.PASS:
            notes.append("no accuracy is declared (--finer, --rtol): it agrees to its digits")
        else:
            known = before_the_limit(name, main, declared) or on_the_ladder(name, main, declared, found)
            found, setting, mistakes, said = known
            advice.append(said)
    elif main.enough and not advice and needs_diagnosis(found):
        mistakes = diagnosis(found, main)
        mistakes = None if mistakes.inside_tolerances else mistakes
        if mistakes is not None and not mistakes.explanations:
            noise = rounded or undeclared_noise(found, own)
            said = noise or promised_too_much(name, main, finer, declared)
            shown = mistakes if mistakes.of_one_sample and not noise else None
            mistakes, advice = (shown, [said]) if said else (mistakes, advice)
    if mistakes is not None:
        found = explained(found, mistakes)
    elif rounded and not advice:
        advice.append(rounded)
    if found.outcome is Outcome.PASS and (against := reason_against(main, finer, declared, found, setting)):
        found = with_outcome(found, main, setting, *against, name)
        advice = [] if against[0] is Outcome.INCONSISTENT else advice
    explained_so = main.other_chain or main.other_time or (mistakes and mistakes.explanations)
    start = "" if found.outcome is Outcome.PASS or explained_so else other_start(main)
    advice += [start] if start and not any(start in said for said in advice) else []
    if found.outcome is Outcome.PASS and declared.rtol is not None:
        notes += reached(name, main, declared, found)
    notes += [*limited(found, main), *looked_at(found, main)]
    second = None if finer is None else finer.trajectory
    return FileVerdict(found, mistakes, main.solution, main.trajectory, second, engine, setting, advice, notes)


def with_outcome(found: Verdict, main: Samples, setting: Setting, outcome: Outcome, reason: str, name: str) -> Verdict:
    """Verdict with an outcome of the file as a whole besides."""
    row = no_verdict(main.solution.scene.name, name, setting, outcome, reason).rows
    return dataclasses.replace(found, rows=[*found.rows, *row])


def reason_against(
    main: Samples, finer: Samples | None, declared: Declared, found: Verdict, setting: Setting
) -> tuple[Outcome, str] | None:
    """Outcome in the place of a pass, and why; None where what agrees is enough, and nothing else speaks against it."""
    if finer is None and (left := leaves_too_fast(main, 0.0 if isinstance(setting, Undeclared) else setting.value)):
        return Outcome.INCONSISTENT, left
    short = falls_short(main, finer, declared, found)
    return (Outcome.TOO_COARSE, short) if short else None


def falls_short(main: Samples, finer: Samples | None, declared: Declared, found: Verdict) -> str:
    """Why what agrees in a file is too little for a pass; empty where it is enough."""
    reasons = []
    if main.too_few_digits:
        reasons.append(f"{main.too_few_digits}; write more digits, or leave the columns out")
    if (share := spanned(main)) < LEAST_SHARE:
        reasons.append(f"the file spans {share:.1%} of the scene, required: {LEAST_SHARE:.0%}")
    judged = next((float(row["value"]) for row in found.rows if row["metric"] == "judged_share"), 1.0)
    if finer is not None and judged < LEAST_JUDGED:
        errors = error_model(main, declared, differences(main.trajectory, finer.trajectory))
        advice = until_share(errors, errors.limit_s, judged, LEAST_JUDGED)
        said = f"{judged:.0%} of the samples can be judged, required: {LEAST_JUDGED:.0%}"
        reasons.append(f"the files part early: {said}{advice}")
    return "; ".join(reasons)


def leaves_too_fast(main: Samples, rtol: float) -> str:
    """Where a file that agrees leaves the solution beyond its own predictability limit, as a sentence; empty if not.

    A file of low accuracy has an early limit. The solution is known until a later one. At any time before, a step may
    have made an error of the request at which the file agrees, which the scene amplifies.

    Parameters
    ----------
    main : Samples
    rtol : float
        The request; 0 of a file that agrees to its digits.
    """
    known = main.solution.trajectory.t_s <= main.solution.limit_s
    own = differences(main.trajectory, main.solution.trajectory)
    seen = {quantity: off[known[: len(off)]] for quantity, off in own.items() if quantity in main.judged}
    where = too_fast(main, seen, rtol)
    return f"the file leaves the solution {where}" if where else ""


def too_fast(main: Samples, own: Mapping[str, Array], rtol: float = 0.0) -> str:
    """Where an error begins that grows faster than the scene lets errors grow, in words; empty where none does.

    What a change between files is taken for, an error, grows with the amplification, and slowly besides. Garbage
    begins at once. Scenes in which forces jump are left out: an error may begin at a jump.

    Parameters
    ----------
    main : Samples
    own : mapping
        Difference of the file from its finer one, or from the solution, by quantity, (n,).
    rtol : float
        Error that a step in between may have made, relative to a quantity's scale.
    """
    effects, amplification = main.solution.scene.effects, main.solution.amplification
    if effects.breaks_s or effects.drag or effects.solar_pressure:
        return ""
    size, unit = sizes(main.solution.trajectory), scales(main.solution)
    for quantity, change in own.items():
        n = min(len(change), len(amplification))
        if quantity in TRACK or quantity not in size:
            continue
        least = SMALLEST_CHANGE * float(size[quantity].max()) + 2.0 * main.written[quantity]
        between = MOST_MADE * rtol * amplification * unit[quantity]
        for k in range(max(FEWEST_BEFORE, n // FEWEST_BEFORE), n):
            grown = float(change[: k // 2 + 1].max()) * amplification[k] / amplification[k // 2]
            if change[k] > max(MOST_FASTER * max(grown, float(least[k])), float(between[k])):
                when = main.trajectory.t_s[k]
                return f"at t = {when:.4g} s, in the {quantity}, far faster than errors grow in the scene"
    return ""


def other_order(verdict: Verdict, main: Samples, finer: Samples, declared: float) -> list[str]:
    """What a file and its finer one show of the order, where that alone is what fails; empty else."""
    errors = [differences(each.trajectory, main.solution.trajectory) for each in (main, finer)]
    orders = set()
    for quantity in {row["quantity"] for row in verdict.rows if not Outcome(row["outcome"]).ok}:
        coarse, fine = (float(each[quantity].max()) if quantity in each else 0.0 for each in errors)
        if not coarse or not fine or 1.0 / CONVERGES < coarse / fine < CONVERGES:
            return []  # an error that stays is no matter of the order
        orders.add(round(math.log2(coarse / fine), 1))
    if all(abs(order - declared) <= ORDER_SLACK for order in orders):  # also where nothing fails: too coarse
        return []
    if all(order < 0.0 for order in orders):
        return ["the errors of the finer file are larger: are the two files exchanged?"]
    shown = " and ".join(f"{order:g}" for order in sorted(orders))
    return [f"the two files show errors of order {shown}; order {declared:g} is declared"]


def as_round_off(name: str, main: Samples, finer: Samples, declared: Declared, found: Verdict) -> str:
    """Sentence on errors of two files that are round-off, with the declarations with which the file passes; else empty.

    The coordinates are the declared ones, or else those counted from the centre of the central body.
    """
    own = differences(main.trajectory, finer.trajectory)
    for absolute in [True] if declared.absolute else [False, True]:
        coordinates = Coordinates.ABSOLUTE if absolute else Coordinates.RELATIVE
        noise = round_off(found, coordinates, main.trajectory, finer.trajectory, main.solution)
        new = ["--absolute"] if absolute and not declared.absolute else []
        for more in ({}, noise) if noise and new else (noise,) if noise else ():
            at = dataclasses.replace(declared, absolute=absolute, noise={**declared.noise, **more})
            if one_verdict(name, main, finer, at, own, restarts=False)[0].outcome is Outcome.PASS:
                options = [*new, *(f"--noise {quantity}={size:.1e}" for quantity, size in more.items())]
                return f"{ROUND_OFF}; declare it: {' '.join(options)}"
    return ""


def undeclared_noise(verdict: Verdict, own: Mapping[str, Array]) -> str:
    """Noise that would explain all that fails; empty where some of it is larger than the file's own error.

    Parameters
    ----------
    verdict : Verdict
    own : mapping
        Difference of the file from its finer one by quantity, (n,).
    """
    options = []
    for quantity in sorted({row["quantity"] for row in verdict.rows if not Outcome(row["outcome"]).ok}):
        if quantity not in own or verdict.series is None or f"{quantity}_tolerance" not in verdict.series:
            return ""
        beyond = float((verdict.series[f"{quantity}_difference"] - verdict.series[f"{quantity}_tolerance"]).max())
        if not 0.0 < beyond < own[quantity].max():
            return ""
        options.append(f"--noise {quantity}={ROUNDED_UP * beyond:.2g}")
    said = f"if iterations or round-off leave that much at every step, declare it: {' '.join(options)}"
    return said if options else ""


def promised_too_much(name: str, main: Samples, finer: Samples | None, declared: Declared) -> str:
    """Sentence on the larger requested error with which a file passes; empty if there is none."""
    promised = declared.rtol
    if finer is None and promised is not None:
        for rtol in LADDER:
            if rtol > promised and passes(name, main, declared, rtol):
                return f"it agrees at rtol={rtol:g}"
    return ""


def reached(name: str, main: Samples, declared: Declared, found: Verdict) -> list[str]:
    """Sentences on the accuracy that a file that passes has, beside the requested one.

    An error above that of a method that keeps its request passes by the width of the bound alone.
    """
    assert declared.rtol is not None
    best = next((r for r in LADDER if r < declared.rtol and passes(name, main, declared, r)), declared.rtol)
    notes = [f"requested: rtol={declared.rtol:g}; reached: rtol={best:g}"]
    finer = {r: dataclasses.replace(declared, rtol=r) for r in LADDER if r < best}
    verdicts = {r: one_verdict(name, main, None, at, {}, restarts=False)[0] for r, at in finer.items()}
    notes += filter(None, [less_accurate(verdicts, best)])
    if start := other_start(main):
        notes.append(f"warning: {start}, which the bound at this request allows")
    model = error_model(main, declared, {})
    if found.series is not None and "attitude_difference" in found.series:
        until = model.t_s <= model.limit_s
        error = found.series["attitude_difference"].to_numpy()[: model.n][until]
        ratio = float((error / model.kept_request_rad[until]).max())
        if ratio > 1.0:
            notes.append(
                f"warning: the attitude's error is {ratio:.2g} times that of a method that keeps a request of "
                f"{declared.rtol:g} in each step, as the scene amplifies it"
            )
    return notes


def passes(name: str, main: Samples, declared: Declared, rtol: float) -> bool:
    """Whether a file agrees at another requested error, as far as it can be judged."""
    at = dataclasses.replace(declared, rtol=rtol)
    found, *_ = one_verdict(name, main, None, at, {}, restarts=False)
    return found.outcome is Outcome.PASS and one_verdict(name, main, None, at, {})[0].outcome in UNCONTRADICTED


def less_accurate(finer: Mapping[float, Verdict], reached: float) -> str:
    """Sentence on quantities that are far less accurate than the others; empty where all are alike.

    Errors of a method reach all quantities of a motion. What one has alone is of its output, or of a few rows.

    Parameters
    ----------
    finer : mapping
        Verdicts at requests, in decades, that a file does not keep.
    reached : float
        Request that it keeps.
    """
    outside = {rtol: {row["quantity"] for row in v.rows if not Outcome(row["outcome"]).ok} for rtol, v in finer.items()}
    if not outside:
        return ""
    last = outside[max(outside)]
    if not last or not {row["quantity"] for v in finer.values() for row in v.rows if row["metric"] == "max"} - last:
        return ""  # there are no others
    best = min(rtol for rtol, names in outside.items() if names <= last)
    if best * FAR_APART > reached:
        return ""
    return f"{', '.join(sorted(last))}: no better than rtol={reached:g}, while all else agrees at rtol={best:g}"


def before_the_limit(
    name: str, main: Samples, declared: Declared
) -> tuple[Verdict, Setting, Diagnosis | None, str] | None:
    """Verdict on a file of which even the finest request leaves too little before its limit; None of any other one.

    Coarser requests have earlier limits still. What follows the limit is compared from the file's own states.
    """
    at = dataclasses.replace(declared, rtol=LADDER[0])
    early = one_verdict(name, main, None, at, {}, restarts=False)[0]
    some = any(row["metric"] == "judged_share" and row["value"] > 0.0 for row in early.rows)
    if early.outcome is not Outcome.TOO_COARSE or not some:
        return None
    whole, *_ = one_verdict(name, main, None, at, {})
    if whole.outcome is Outcome.PASS:
        said = f"agrees at rtol={at.rtol:g}; declare it (--rtol {at.rtol:g}) to demand it"
        return whole, at.setting, None, said
    return early, at.setting, None, f"it agrees at rtol={at.rtol:g} as far as it can be judged"


def on_the_ladder(
    name: str, main: Samples, declared: Declared, found: Verdict
) -> tuple[Verdict, Setting, Diagnosis | None, str]:
    """Verdict on a file that declares no accuracy, its setting, a diagnosis, and the accuracy that the file has.

    Parameters
    ----------
    name : str
    main : Samples
    declared : Declared
        Without a requested error; stated error bars count.
    found : Verdict
        By digits and error bars alone, no pass. It stays where the file is outside of a stated error bar. Of what fails
        else, the verdict at the coarsest request that is allowed tells what is wrong: digits alone allow no error.
    """
    finer: dict[float, Verdict] = {}
    mistakes, unexplained = None, None
    by_digits, setting, held = found, declared.setting, ""
    for rtol in LADDER:
        at = dataclasses.replace(declared, rtol=rtol)
        finer[rtol] = verdict = one_verdict(name, main, None, at, {}, restarts=False)[0]
        if verdict.outcome is Outcome.PASS:
            whole, *_ = one_verdict(name, main, None, at, {})
            if whole.outcome in UNCONTRADICTED:
                break
        sought = mistakes is None and rtol in DIAGNOSED and main.enough and needs_diagnosis(verdict)
        if sought:
            seen = diagnosis(verdict, main)
            if seen.explanations:
                mistakes = seen
            elif seen.wrong and (rtol <= COARSEST or unexplained is None):  # of the request whose ratios are told
                unexplained = seen
        if rtol <= COARSEST and needs_diagnosis(verdict):
            found, setting, held = verdict, at.setting, f"; the ratios below are those at rtol={rtol:g}"
    else:
        said = f"it does not agree at rtol={LADDER[-1]:g} either{held}"
        return found, setting, mistakes or unexplained, said
    if mistakes is not None:
        return found, setting, mistakes, f"but for that it agrees at rtol={rtol:g}"
    outside = {row["quantity"] for row in by_digits.rows if not Outcome(row["outcome"]).ok} & declared.noise.keys()
    if outside:
        return by_digits, declared.setting, None, f"outside of the stated error bar; it agrees at rtol={rtol:g}"
    if start := other_start(main):
        return found, setting, unexplained, f"{start}; but for that it agrees at rtol={rtol:g}"
    del finer[rtol]
    apart = "".join(f"; {said}" for said in [less_accurate(finer, rtol)] if said)
    if rtol > COARSEST:
        said = f"it agrees at rtol={rtol:g}; a file that declares nothing has to at {COARSEST:g}: declare it (--rtol)"
        said += apart
        return found, setting, None, said
    limits = [row["limit_s"] for row in whole.rows if row["metric"] == "max"]
    end_s = min(limits, default=float(main.trajectory.t_s[-1]))
    said = f"agrees at rtol={rtol:g} up to t = {end_s:.6g} s; declare it (--rtol {rtol:g}) to demand it{apart}"
    return whole, at.setting, None, said


def other_start(main: Samples) -> str:
    """Sentence on a row at t = 0 that is not the scene's start; empty where it is, or where there is none.

    No method has an error there. What digits and the conversion of a start's elements may leave is allowed.
    """
    if main.starts_late:
        return ""
    size = scales(main.solution)
    for quantity, apart in differences(main.trajectory, main.solution.trajectory).items():
        allowed = main.written[quantity][0] + SAME_START * size[quantity] if quantity in main.judged else math.inf
        if quantity in STATES and apart[0] > allowed:
            return f"at t = 0 the {quantity} is {apart[0]:.3g} {UNITS[quantity]} off the scene's start"
    return ""


def one_verdict(
    name: str, main: Samples, finer: Samples | None, declared: Declared, own: dict[str, Array], *, restarts: bool = True
) -> tuple[Verdict, Declarations, Setting]:
    """Verdict without a diagnosis, the program's declarations and its setting."""
    errors = error_model(main, declared, own)
    result = RunResult(Outcome.PASS, trajectory=main.trajectory)
    second = result if finer is None else RunResult(Outcome.PASS, trajectory=finer.trajectory)
    run = WrittenResiduals(errors, Evidence(result, second), main.judged, whole=main.complete, restarted=restarts)
    return dataclasses.replace(verdict_on(name, run), further_runs=()), errors.engine, errors.setting


def error_model(main: Samples, declared: Declared, own: Mapping[str, Array]) -> ErrorModel:
    """Error model of a file; `own` is its difference from the finer one by quantity, (n,)."""
    kind = MeasuredErrors if declared.rtol is None else WrittenErrors
    errors = kind(declared.engine, declared.setting, main.solution, main.trajectory)
    errors.written, errors.absent = main.written, main.absent
    if isinstance(errors, MeasuredErrors):
        errors.own = own
    return errors


def diagnosis(verdict: Verdict, main: Samples) -> Diagnosis:
    """Mistakes that explain what is wrong."""
    assert verdict.series is not None
    series = verdict.series
    if main.starts_late:
        series = series.copy()
        series.loc[0, series.columns != "t_s"] = np.nan
    seen = dataclasses.replace(verdict, series=series)
    return diagnosis_of_verdict(seen, main.trajectory, main.solution, absent=main.absent, kept=main.kept)


def explained(verdict: Verdict, found: Diagnosis) -> Verdict:
    """Verdict whose first inconsistent row tells the diagnosis."""
    at = next(k for k, row in enumerate(verdict.rows) if not Outcome(row["outcome"]).ok)
    row = verdict.rows[at]
    reason = "; ".join(filter(None, [row["reason"], str(found)]))
    return dataclasses.replace(verdict, rows=[*verdict.rows[:at], row | {"reason": reason}, *verdict.rows[at + 1 :]])


def limited(verdict: Verdict, main: Samples) -> list[str]:
    """Sentence on the predictability limit, where it ends the comparison before the file."""
    ends = [row["limit_s"] for row in verdict.rows if row["metric"] == "max" and row["quantity"] not in TRACK]
    if not ends or min(ends) >= main.trajectory.t_s[-1]:
        return []
    share = next((row["value"] for row in verdict.rows if row["metric"] == "judged_share"), 0.0)
    restarted = any(row["metric"] == "restart_ratio" for row in verdict.rows)
    how = "from the file's own states alone" if restarted else "no more, as errors may have grown too large"
    when = f"after t = {min(ends):.6g} s, the predictability limit"
    return [f"{when}, compared {how}; {share:.0%} of the samples are judged"]


def looked_at(found: Verdict, main: Samples) -> list[str]:
    """Sentence on the rows of a long file in which mistakes are sought; none where it is all of them."""
    rows = len(main.trajectory.t_s)
    every = thinned(rows) if needs_diagnosis(found) else 1
    return [f"mistakes are sought in one of {every} rows, {-(-rows // every)} in all"] if every > 1 else []


def spanned(main: Samples) -> float:
    """Share of the scene up to the last row of a file."""
    return float(main.trajectory.t_s[-1] / main.solution.fine.t_s[-1])
