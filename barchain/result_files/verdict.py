"""Verdict on a result in a file: what of it is explained, at which accuracy, and by which mistakes the rest is."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from adapters.engine import Coordinates
from barchain.judge.checks.more_judged import until_share
from barchain.judge.diagnosis.verdicts import needs_diagnosis, thinned
from barchain.judge.noise_to_declare import ROUND_OFF, round_off
from barchain.judge.verdict import no_verdict
from barchain.judge.written import Undeclared
from barchain.metrics.quantities import TRACK, differences
from barchain.result_files.accuracy import accuracy_of, other_start, promised_too_much, reached
from barchain.result_files.growth import leaves_too_fast, too_fast
from barchain.result_files.one_verdict import diagnosis, error_model, one_verdict
from reports.results.outcome import Outcome

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.engine import Declarations, Setting
    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.diagnose import Diagnosis
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
EVIDENT = 100.0
"""Least error, over digits and the solution's own error, that shows an order"""
CONVERGES = 1.5
"""Least ratio of two files' errors that shows that the finer one has another error"""
ROUNDED_UP = 1.1
"""Factor of a proposed noise, which is printed to two digits"""


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
    explains the rest. The file passes at the accuracy that it is found to have, down to
    :data:`barchain.result_files.accuracy.COARSEST`.

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
            found, setting, mistakes, said = accuracy_of(name, main, declared, found)
            advice.append(said)
    elif main.enough and not advice and needs_diagnosis(found):
        mistakes = diagnosis(found, main)
        mistakes = None if mistakes.inside_tolerances else mistakes
        if mistakes is not None and not mistakes.explanations:
            noise = rounded or undeclared_noise(found, own)
            said = noise or promised_too_much(name, main, finer, declared, tried=not mistakes.incomplete)
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
    notes += [*lower_order(found, main, finer, declared.order), *limited(found, main), *looked_at(found, main)]
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
    rtol, noise_m = 0.0 if isinstance(setting, Undeclared) else setting.value, declared.noise.get("com", 0.0)
    if finer is None and (left := leaves_too_fast(main, rtol, noise_m)):
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


def other_order(verdict: Verdict, main: Samples, finer: Samples, declared: float) -> list[str]:
    """What a file and its finer one show of the order, where that alone is what fails; empty else."""
    errors = [differences(each.trajectory, main.solution.trajectory) for each in (main, finer)]
    orders = set[float]()
    for quantity in {row["quantity"] for row in verdict.rows if not Outcome(row["outcome"]).ok}:
        coarse, fine = (float(each[quantity].max()) if quantity in each else 0.0 for each in errors)
        if not coarse or not fine or 1.0 / CONVERGES < coarse / fine < CONVERGES:
            return []  # an error that stays is no matter of the order
        orders.add(round(math.log2(coarse / fine), 1))
    if all(abs(order - declared) <= ORDER_SLACK for order in orders):  # also where nothing fails: too coarse
        return []
    if all(order < 0.0 for order in orders):
        return ["the errors of the finer file are larger: are the two files exchanged?"]
    return [order_words(orders, declared)]


def lower_order(found: Verdict, main: Samples, finer: Samples | None, declared: float | None) -> list[str]:
    """Warning of a file that passes though both files show a lower order in all errors that stand out of rounding."""
    if finer is None or declared is None or found.outcome is not Outcome.PASS or limited(found, main):
        return []
    solution, orders = main.solution, set[float]()
    coarse, fine = (differences(each.trajectory, solution.trajectory) for each in (main, finer))
    for quantity in main.judged & fine.keys() & solution.error.keys():
        known = main.written[quantity] + solution.error[quantity][: len(main.written[quantity])]
        if fine[quantity].max() > EVIDENT * known.max():
            orders.add(round(math.log2(coarse[quantity].max() / fine[quantity].max()), 1))
    if not orders or max(orders) > declared - ORDER_SLACK:
        return []
    return [f"warning: {order_words(orders, declared)}"]


def order_words(orders: set[float], declared: float) -> str:
    """What two files show of the order, beside the declared one."""
    shown = " and ".join(f"{order:g}" for order in sorted(orders))
    return f"the two files show errors of order {shown}; order {declared:g} is declared"


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
