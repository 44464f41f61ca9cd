"""Numbers of an effect budget in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from reports.tables.effects import EffectKind
from reports.text.numerals import prefixed, significant
from reports.text.ratios import short
from reports.text.words import joined

if TYPE_CHECKING:
    from reports.chapters.effects.rows import BudgetScope, EffectChange, EffectRow

NAMES = {"com": "centre of mass", "attitude": "attitude", "reaction": "reactions"}
OF_LARGEST = " of the largest"
NOT_RESOLVED = "below the numerical resolution"
LEAST_PERCENT = 1e-4  # of the largest reaction: smaller shares read better as powers of ten
MANY_TIMES = 3.0  # from there on a factor says more than a share of the run's time
TELLING = 1.25  # smallest further factor that the words mention
SEARCHED = {
    "drag": "a bar turns its other face to the wind",
    "solar_pressure.shadow": "the shadow begins or ends",
    "solar_pressure": "a bar turns its other face to the Sun, or the shadow begins or ends",
}
WHOLE_RUN = 1e-9  # of the run: a comparison that ends closer to its end covers the run


def length_text(metres: float) -> str:
    """``612 km``; from a kilometre on kilometres, below it metres or parts of one."""
    factor, unit = (1e-3, "km") if metres >= 1e3 else prefixed(metres, "m")
    return f"{short(metres * factor)} {unit}"


def share_text(share: float) -> str:
    """``0.13 %``, ``3.1e-08 of the largest``."""
    if not math.isfinite(share):
        return ""
    return f"{short(100.0 * share)} %" if share >= LEAST_PERCENT else f"{significant(share, 2)}{OF_LARGEST}"


def amount(change: EffectChange, value: float) -> str:
    """Size of a change in its own unit, reactions as a share of the largest."""
    if change.name == "com":
        return length_text(value)
    if change.name == "attitude":
        return f"{significant(value, 2)} rad"
    return share_text(value / change.scale) if change.scale else f"{significant(value, 2)} N"


def shown(change: EffectChange) -> str:
    """``612 km``, or ``below the numerical resolution (3.1e-09 rad)``; never zero."""
    text = amount(change, change.bound)
    return text if change.resolved else f"{NOT_RESOLVED} ({text})"


def brief(change: EffectChange) -> str:
    """``612 km``, or ``unresolved, < 70 mm``, for a table; reactions relative to the largest."""
    text = amount(change, change.bound).removesuffix(OF_LARGEST)
    return text if change.resolved else f"unresolved, < {text}"


def named(change: EffectChange) -> str:
    """``reactions 0.13 %``."""
    return f"{NAMES[change.name]} {shown(change)}"


def change_words(change: EffectChange) -> str:
    """Clause on a resolved change."""
    text = amount(change, change.value)
    verbs = {"com": f"moves the centre of mass by {text}", "attitude": f"rotates bars by {text}"}
    return verbs.get(change.name, f"changes the reactions by {text}")


def spoken(row: EffectRow) -> str:
    """Effect as the subject of a sentence, with the width of the bars on which it depends."""
    if row.kind is EffectKind.GRAVITY:
        return f"{row.title} {row.said}"
    if row.widths_m is None:
        return row.title
    least, largest = map(length_text, row.widths_m)
    return f"{row.title} on bars {least if least == largest else f'{least} to {largest}'} wide"


def times(seconds: float, scope: BudgetScope) -> str:
    """``2.76 orbits``, or seconds where nothing is orbited."""
    if scope.bound and scope.period_s:
        count = f"{seconds / scope.period_s:.3g}"
        return f"{count} orbit{'s' * (count != '1')}"
    return f"{seconds:.4g} s"


def cut_short(row: EffectRow, scope: BudgetScope) -> bool:
    """Whether less than the run was compared."""
    return row.compared_s is not None and row.compared_s < (1.0 - WHOLE_RUN) * scope.duration_s


def span_words(row: EffectRow, scope: BudgetScope) -> str:
    """Compared duration of a row's runs."""
    until = times(row.compared_s or 0.0, scope)
    return f"the first {until} of {times(scope.duration_s, scope)}" if cut_short(row, scope) else until


def limit_words(row: EffectRow, scope: BudgetScope) -> str:
    """Sentence on why the comparison ended early; empty if it covers the run."""
    if not cut_short(row, scope):
        return ""
    if row.ended and not scope.ended:
        return f" With it {'off' if row.on else 'on'}, {row.ended}."
    if scope.ended and (row.compared_s or 0.0) >= (1.0 - WHOLE_RUN) * scope.end_s:
        return f" The run ends there: {scope.ended}."
    return f" That is the predictability limit: beyond it numerical errors alone exceed {scope.parted_rad:g} rad."


def cost_words(row: EffectRow) -> str:
    """Cost in time as the end of a sentence; empty with too few rounds."""
    run = row.time
    if run.value is None or run.low is None:
        return ""
    if not run.known:
        return "; its cost in time is too small to measure"
    if row.on and 1.0 <= run.value < MANY_TIMES:
        return f"; it takes {100.0 * (1.0 - 1.0 / run.value):.0f} % of the run time{why_words(row)}"
    return f"; with it the run takes {significant(run.value)} times as long{why_words(row)}"


def why_words(row: EffectRow) -> str:
    """Factors of a run's time; empty if one evaluation explains it."""
    one, number_of, rest = row.evaluation.value, row.evaluations_ratio, row.rest
    if one is None or number_of is None or rest is None or max(number_of, rest) < TELLING:
        return ""
    parts = [f"{significant(one, 2)} per evaluation"]
    parts += [f"{significant(number_of, 2)} in their number"] if number_of >= TELLING else []
    parts += [f"{significant(rest, 2)} for {rest_words(row)}"] if rest >= TELLING else []
    return f" (factors: {joined(parts)})"


def rest_words(row: EffectRow) -> str:
    """Work between evaluations."""
    for effect, words in SEARCHED.items():
        if row.effect.startswith(effect):
            return f"the search for instants at which {words}"
    return "work between evaluations"
