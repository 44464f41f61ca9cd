"""The results page of a history: verdict, error and time at equal error of each engine in each scene; and its table."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from reports.chapters.comparison.overview import SYMBOLS, kind
from reports.chapters.stability import SIGNS
from reports.nightly.calendar import STATES, months
from reports.nightly.charts import number
from reports.page import surroundings, templates
from reports.plotting.palette import COLOURS
from reports.plotting.svg import Chart, Scale
from reports.results.nights.site import FILE, TABLE
from reports.results.writing import write_atomically

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from markupsafe import Markup

    from reports.results.nights.document import NightlyFile
    from reports.results.nights.site import Measured, PairResult, SiteFile
    from reports.results.nights.trends import CalendarNight

TEMPLATE = "nightly/site.html.j2"
WIDTH, HEIGHT, MARGIN = 132.0, 26.0, 4.0
LEAST_RANGE = 1.05
"""Least factor between the ends of a small chart's axis: the least effect that is told of times"""
VERDICT_SIGNS = {str(word): found for word, found in SIGNS.items()}
VERDICT_SIGNS |= {str(word): (sign, kind(word)) for word, sign in SYMBOLS.items()}
"""Sign and colour class of each verdict; a word of both studies has those of a comparison"""
MOST_OPEN = 60
"""Results of a page whose engines are unfolded at first"""
COLUMNS = {
    "engine": "engine", "version": "version", "scene": "scene", "verdict.word": "verdict",
    "verdict.since": "verdict_since", "verdict.night": "verdict_night", "verdict.reason": "reason",
    "error.value": "error", "error.low": "error_low", "error.high": "error_high", "error.unit": "error_unit",
    "error.quantity": "error_quantity", "error.setting": "setting", "error.night": "error_night",
    "time.value": "time_ratio", "time.low": "time_low", "time.high": "time_high", "time.anchor": "relative_to",
    "time.setting": "at_error", "time.night": "time_night", "worse_since": "worse_since",
}  # fmt: skip
"""Columns of the table, by the fields of results"""


def write_site(
    folder: Path, found: SiteFile, facts: NightlyFile, nights: Sequence[CalendarNight], pages: Mapping[str, str]
) -> None:
    """Write the results page and its table into a folder.

    Parameters
    ----------
    folder : Path
    found : SiteFile
    facts : NightlyFile
        Of the latest night.
    nights : sequence of CalendarNight
    pages : mapping
        Addresses of the pages of nights, by name, relative to the folder.
    """
    pairs = pd.json_normalize([asdict(pair) for pair in found.pairs])
    rows = pairs.reindex(columns=list(COLUMNS)).rename(columns=COLUMNS)  # what is not known is empty
    write_atomically(folder / TABLE, rows.to_csv(index=False, lineterminator="\n"))
    engines = [(engine, list(own)) for engine, own in groupby(found.pairs, key=lambda pair: pair.engine)]
    text = templates().get_template(TEMPLATE).render(
        found=found,
        facts=facts,
        engines=engines,
        scenes=sorted({pair.scene for pair in found.pairs if pair.verdict}),
        cells={(pair.engine, pair.scene): pair for pair in found.pairs if pair.verdict},
        sign=lambda pair: sign_of(pair.verdict.word),
        words=[(word, sign_of(word)) for word in sorted({p.verdict.word for p in found.pairs if p.verdict})],
        spark=lambda one, engine: spark(one, [at for at, _ in found.releases[engine][1:]], len(found.nights)),
        table=TABLE,
        months=months(nights, pages),
        pages=pages,
        states=STATES,
        verdicts=verdict_counts,
        most_open=MOST_OPEN,
        **surroundings({"environment": facts.night.environment, "packages": facts.night.packages}),
    )  # fmt: skip
    write_atomically(folder / FILE, text)


def verdict_counts(pairs: Sequence[PairResult]) -> str:
    """``13 pass, 2 unsupported; 1 worse than accepted``."""
    found = Counter(pair.verdict.word.replace("_", " ") if pair.verdict else "not judged" for pair in pairs)
    worse = sum(bool(pair.worse_since) for pair in pairs)
    return ", ".join(f"{count} {word}" for word, count in found.most_common()) + (
        f"; {worse} worse than accepted" if worse else ""
    )


def sign_of(word: str) -> tuple[str, str]:
    """Sign and colour class of a verdict; of a word of another version a question mark."""
    return VERDICT_SIGNS.get(word, ("?", "gone"))


def spark(one: Measured, releases: Sequence[int], nights: int) -> tuple[Markup | None, str]:
    """Small chart of a number over the nights, with a dashed line at each release; and its range in words."""
    if one.curve is None:
        return None, f"the same on {one.nights} nights" if one.nights > 1 else "one night"
    at, factor = np.array(one.curve.night), np.array(one.curve.factor)
    half = max(float(np.max(np.abs(np.log(factor)))), np.log(LEAST_RANGE) / 2.0)
    across = Scale(-0.5, max(nights, 2) - 0.5, MARGIN, WIDTH - MARGIN)
    drawn = Chart(across, Scale(-half, half, HEIGHT - MARGIN, MARGIN), (WIDTH, HEIGHT))
    drawn.across_at(-half, COLOURS["grid"])
    for release in releases:
        drawn.up_at(release - 0.5, COLOURS["ink"], 1.0, "30 20")
    drawn.line(at, np.log(factor), COLOURS["accent"], 1.3)
    drawn.marks(at[-1], np.log(factor[-1]), "o", COLOURS["accent"], 4.4)
    words = f"×{number(float(factor.min()))} to ×{number(float(factor.max()))} of the median of {one.nights} nights"
    return drawn.svg(f"{one.quantity} over {nights} nights: {words}"), words
