"""Numbers of an effect budget in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from reports.tables.effects import EffectKind
from reports.text.numerals import prefixed, significant
from reports.text.ratios import short
from reports.text.words import joined

if TYPE_CHECKING:
    from reports.chapters.effects.rows import Change, EffectRow, Whole

NAMES = {"com": "centre of mass", "attitude": "attitude", "reaction": "reactions"}
OF_LARGEST = " of the largest"
NOT_RESOLVED = "below what the numerics resolve"
LEAST_PERCENT = 1e-4  # of the largest reaction: smaller shares read better as powers of ten
MANY_TIMES = 3.0  # from there on a factor says more than a share of the run's time
TELLING = 1.25  # factor beyond an evaluation's own that is told in words
SEARCHED = {
    "drag": "a bar turns its other face to the wind",
    "solar_pressure.shadow": "the shadow begins or ends",
    "solar_pressure": "a bar turns its other face to the Sun, or the shadow begins or ends",
}
WHOLE_RUN = 1e-9  # of the run: what ends nearer its end than that was compared to it


def length_text(metres: float) -> str:
    """``612 km``; from a kilometre on kilometres, below it metres or parts of one."""
    factor, unit = (1e-3, "km") if metres >= 1e3 else prefixed(metres, "m")
    return f"{short(metres * factor)} {unit}"


def share_text(share: float) -> str:
    """``0.13 %``, ``3.1e-08 of the largest``."""
    if not math.isfinite(share):
        return ""
    return f"{short(100.0 * share)} %" if share >= LEAST_PERCENT else f"{significant(share, 2)}{OF_LARGEST}"


def amount(change: Change, value: float) -> str:
    """Size of a change in its own unit, reactions as a share of the largest."""
    if change.name == "com":
        return length_text(value)
    if change.name == "attitude":
        return f"{significant(value, 2)} rad"
    return share_text(value / change.scale) if change.scale else f"{significant(value, 2)} N"


def shown(change: Change) -> str:
    """``612 km``, or ``below what the numerics resolve (3.1e-09 rad)``; never zero."""
    text = amount(change, change.bound)
    return text if change.resolved else f"{NOT_RESOLVED} ({text})"


def brief(change: Change) -> str:
    """Return the same for a table: ``612 km``, or ``not resolved, < 70 mm``; reactions in shares of the largest."""
    text = amount(change, change.bound).removesuffix(OF_LARGEST)
    return text if change.resolved else f"not resolved, < {text}"


def named(change: Change) -> str:
    """``reactions 0.13 %``."""
    return f"{NAMES[change.name]} {shown(change)}"


def done(change: Change) -> str:
    """What a resolved change does."""
    text = amount(change, change.value)
    verbs = {"com": f"moves the centre of mass by {text}", "attitude": f"turns bars by {text}"}
    return verbs.get(change.name, f"changes the reactions by {text}")


def spoken(row: EffectRow) -> str:
    """Effect as a sentence begins with it."""
    return f"{row.title} {row.said}" if row.kind is EffectKind.GRAVITY else row.title


def times(seconds: float, whole: Whole) -> str:
    """``2.76 orbits``, or seconds where nothing is orbited."""
    if whole.bound and whole.period_s:
        count = f"{seconds / whole.period_s:.3g}"
        return f"{count} orbit{'s' * (count != '1')}"
    return f"{seconds:.4g} s"


def cut_short(row: EffectRow, whole: Whole) -> bool:
    """Whether less than the run was compared."""
    return row.compared_s is not None and row.compared_s < (1.0 - WHOLE_RUN) * whole.duration_s


def span_words(row: EffectRow, whole: Whole) -> str:
    """Over what a row's runs were compared."""
    until = times(row.compared_s or 0.0, whole)
    return f"the first {until} of {times(whole.duration_s, whole)}" if cut_short(row, whole) else until


def limit_words(row: EffectRow, whole: Whole) -> str:
    """Why no more of the run was compared; empty where all of it was."""
    if not cut_short(row, whole):
        return ""
    if row.ended and not whole.ended:
        return f" With it {'off' if row.on else 'on'}, {row.ended}."
    if whole.ended and (row.compared_s or 0.0) >= (1.0 - WHOLE_RUN) * whole.end_s:
        return f" The run ends there: {whole.ended}."
    return f" Beyond that the numerics alone part by more than {whole.parted_rad:g} rad: the motion is chaotic."


def cost_words(row: EffectRow) -> str:
    """What it costs in time, as the end of a sentence; empty where that was timed too seldom to tell."""
    run = row.time
    if run.value is None or run.low is None:
        return ""
    if not run.known:
        return "; what it costs in time is too small to measure here"
    if row.on and 1.0 <= run.value < MANY_TIMES:
        return f"; it takes {100.0 * (1.0 - 1.0 / run.value):.0f} % of the run's time{why_words(row)}"
    return f"; with it the run takes {significant(run.value)} times as long{why_words(row)}"


def why_words(row: EffectRow) -> str:
    """Where a run's time goes that one evaluation does not tell; empty where that tells it."""
    one, number_of, rest = row.evaluation.value, row.evaluations_ratio, row.rest
    if one is None or number_of is None or rest is None or max(number_of, rest) < TELLING:
        return ""
    parts = [f"{significant(one, 2)} times an evaluation"]
    parts += [f"{significant(number_of, 2)} times as many of them"] if number_of >= TELLING else []
    parts += [f"{significant(rest, 2)} times for {rest_words(row)}"] if rest >= TELLING else []
    return f" ({joined(parts)})"


def rest_words(row: EffectRow) -> str:
    """What is done between evaluations."""
    for effect, words in SEARCHED.items():
        if row.effect.startswith(effect):
            return f"the search for instants at which {words}"
    return "what is done between them"
