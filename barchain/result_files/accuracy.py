"""Accuracy that a file has: the finest request at which it agrees, and what contradicts a promise."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

from barchain.judge.diagnosis.mistake import explained_words
from barchain.judge.diagnosis.verdicts import needs_diagnosis
from barchain.judge.scales import scales
from barchain.metrics.quantities import TRACK, differences
from barchain.result_files.one_verdict import diagnosis, error_model, one_verdict
from reports.results.outcome import Outcome
from scenarios.channels import UNITS, WORDS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.engine import Setting
    from barchain.judge.diagnosis.diagnose import Diagnosis
    from barchain.judge.verdict import Verdict
    from barchain.judge.written import Declared
    from barchain.result_files.samples import Samples


STATES = ("com", "com_velocity", "attitude", "rate")
"""Quantities that a start is made of"""
SAME_START = 1e-9
"""Largest difference of the row at t = 0 from the scene's start, relative to a quantity's scale"""
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


def promised_too_much(
    name: str, main: Samples, finer: Samples | None, declared: Declared, *, tried: bool
) -> str:  # fmt: skip
    """Sentence on the larger requested error with which a file that no mistake explains passes; empty without one.

    `tried` is whether all known mistakes were.
    """
    promised = declared.rtol
    if finer is None and promised is not None:
        for rtol in LADDER:
            if rtol > promised and passes(name, main, declared, rtol):
                some = "" if tried else " that was tried (runs of this scene take long, and not all are)"
                return f"no known mistake{some} explains it, and it agrees at rtol={rtol:g}"
    return ""


def reached(name: str, main: Samples, declared: Declared, found: Verdict) -> list[str]:
    """Sentences on the accuracy that a file that passes has, beside the requested one.

    An error above that of a method that keeps its request passes by the width of the bound alone.
    """
    assert declared.rtol is not None
    best = next((r for r in LADDER if r < declared.rtol and passes(name, main, declared, r)), declared.rtol)
    size = scales(main.solution)
    told = min((float(main.written[q].max()) / size[q] for q in main.judged if size[q]), default=0.0)
    said = "all that its digits tell" if best < told else f"rtol={best:g}"
    notes = [f"requested: rtol={declared.rtol:g}; reached: {said}"]
    finer = {r: dataclasses.replace(declared, rtol=r) for r in LADDER if r < best}
    verdicts = {r: one_verdict(name, main, None, at, {}, restarts=False)[0] for r, at in finer.items()}
    notes += filter(None, [less_accurate(verdicts, best)])
    if start := other_start(main):
        notes.append(f"warning: {start}, which the bound at this request allows")
    above = above_request(main, declared, found)
    notes += [f"warning: {each}" for each in above]
    if above and main.enough and (cause := mistake_inside(main, verdicts)):
        notes.append(f"warning: inside the bound, and no error of a method: {cause}")
    return notes


def above_request(main: Samples, declared: Declared, found: Verdict) -> list[str]:
    """Sentences on errors above those of a method that keeps its request, of the attitude and of the track."""
    assert found.series is not None
    model, said = error_model(main, declared, {}), []
    for quantity, kept in model.kept_request.items():
        if f"{quantity}_difference" not in found.series:
            continue
        until = model.t_s <= (math.inf if quantity in TRACK else model.limit_s)
        error = found.series[f"{quantity}_difference"].to_numpy()[: model.n][until]
        ratio = float((error / kept[until]).max())
        if ratio > 1.0:
            said.append(
                f"the error of the {WORDS[quantity]} is {ratio:.2g} times what a method that keeps a request of "
                f"{declared.rtol:g} in each step leaves in this scene"
            )
    return said


def mistake_inside(main: Samples, finer: Mapping[float, Verdict]) -> str:
    """Mistakes that explain a difference which the bound at a request permits, in words; empty without one.

    They are sought as of a file that declares nothing: from the finest request on.

    Parameters
    ----------
    main : Samples
    finer : mapping
        Verdicts at finer requests that the file does not keep.
    """
    for rtol in DIAGNOSED:
        seen = diagnosis(finer[rtol], main) if rtol in finer and needs_diagnosis(finer[rtol]) else None
        if seen is not None and seen.explanations:
            return explained_words(seen.explanations, seen.next_best)
    return ""


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


def accuracy_of(
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
        By digits and error bars alone, no pass.
    """
    finest = dataclasses.replace(declared, rtol=LADDER[0])
    early = one_verdict(name, main, None, finest, {}, restarts=False)[0]
    return before_the_limit(name, main, finest, early) or on_the_ladder(name, main, declared, found, early)


def before_the_limit(
    name: str, main: Samples, at: Declared, early: Verdict
) -> tuple[Verdict, Setting, Diagnosis | None, str] | None:
    """Verdict on a file of which even the finest request leaves too little before its limit; None of any other one.

    Coarser requests have earlier limits still. What follows the limit is compared from the file's own states.

    Parameters
    ----------
    name : str
    main : Samples
    at : Declared
        With the finest request.
    early : Verdict
        At that request, without restarts.
    """
    some = any(row["metric"] == "judged_share" and row["value"] > 0.0 for row in early.rows)
    if early.outcome is not Outcome.TOO_COARSE or not some:
        return None
    whole, *_ = one_verdict(name, main, None, at, {})
    if whole.outcome is Outcome.PASS:
        said = f"agrees at rtol={at.rtol:g}; declare it (--rtol {at.rtol:g}) to demand it"
        return whole, at.setting, None, said
    return early, at.setting, None, f"it agrees at rtol={at.rtol:g} as far as it can be judged"


def on_the_ladder(
    name: str, main: Samples, declared: Declared, found: Verdict, early: Verdict
) -> tuple[Verdict, Setting, Diagnosis | None, str]:
    """Verdict by the first request with which a file agrees, from the finest one on, whose verdict is `early`.

    The verdict by digits stays where the file is outside of a stated error bar. Of what fails else, the verdict at the
    coarsest request that is allowed tells what is wrong: digits alone allow no error. See :func:`accuracy_of`.
    """
    finer: dict[float, Verdict] = {}
    mistakes, unexplained = None, None
    by_digits, setting, held = found, declared.setting, ""
    for rtol in LADDER:
        at = dataclasses.replace(declared, rtol=rtol)
        verdict = early if rtol == LADDER[0] else one_verdict(name, main, None, at, {}, restarts=False)[0]
        finer[rtol] = verdict
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
