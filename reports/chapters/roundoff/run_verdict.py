"""Sentences on whole runs: smallest error of the attitude, and its growth in time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.roundoff.run_charts import METHODS
from reports.chapters.roundoff.series import ABSOLUTE, DOUBLE, LOST, RELATIVE, SINGLE, exponents_text, fit_of, law_of
from reports.chapters.roundoff.words import between, exponent_words, listed, size, spelled, unit_text
from reports.tables.files import flags
from scenarios.plural import plural

if TYPE_CHECKING:
    import pandas as pd

    from reports.chapters.roundoff.series import ErrorLaw, RoundoffData

ATTITUDE = "attitude"


def orbit_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentences on the smallest error of the attitude in an orbit and its optimal step."""
    in_absolute, in_relative = (least(study, c, DOUBLE) for c in (ABSOLUTE, RELATIVE))
    if not len(in_absolute) or not len(in_relative):
        return ()
    scene = study.tables.record.get("scene")
    on = f" of {scene}" if scene else ""
    law, method = attitude_law(study)
    words = f" ({unit_text(law)} by {METHODS.get(method, method)}; {exponent_words(law)})" if law else ""
    said = (f"The smallest error of the attitude over an orbit{on} in double precision is "
            f"{at_ends(study, in_absolute)} in absolute coordinates{words}, and {bounded(in_relative)} in relative "
            f"ones at each of {plural(len(in_relative), 'size')}.")  # fmt: skip
    return (said, *optimum_sentences(study), *single_orbit_sentences(study))


def bounded(own: pd.DataFrame) -> str:
    """Range of smallest errors, with ``or less`` if the finest setting was the best."""
    return between([float(v) for v in own["median"]]) + " rad" + " or less" * (not flags(own.settled).all())


def least(study: RoundoffData, coordinates: str, arithmetic: str) -> pd.DataFrame:
    """Smallest median errors of the attitude over all methods, from the longest bars."""
    best = study.tables.best
    own = best[(best.quantity == ATTITUDE) & (best.coordinates == coordinates) & (best.arithmetic == arithmetic)]
    own = own[np.isfinite(own["median"].astype(float))]
    if not len(own):
        return own
    found: pd.DataFrame = own.loc[own.groupby("ratio")["median"].idxmin()].sort_values("ratio", ascending=False)
    return found


def at_ends(study: RoundoffData, own: pd.DataFrame) -> str:
    """``9×10⁻¹³ rad for bars of 6.4 km and 8×10⁻⁷ rad for bars of 6.4 mm``."""
    ends = own if len(own) < 2 else own.iloc[[0, -1]]
    shown = zip(ends["median"].astype(float), ends.ratio.astype(float), strict=True)
    return listed([f"{spelled(error)} rad for bars of {size(study, ratio)}" for error, ratio in shown])


def attitude_law(study: RoundoffData) -> tuple[ErrorLaw | None, str]:
    """Law of the smallest error in absolute coordinates, of the method with the most fitted points."""
    laws = study.tables.best_laws
    own = laws[(laws.quantity == ATTITUDE) & (laws.coordinates == ABSOLUTE) & (laws.arithmetic == DOUBLE)]
    own = own[own.exponent.astype(float).notna()]
    if not len(own):
        return None, ""
    row = own.sort_values(["points", "method"], ascending=[False, True]).iloc[0].to_dict()
    return law_of(row), str(row["method"])


def optimum_sentences(study: RoundoffData) -> list[str]:
    """Sentence on the optimal step and its dependence on the size."""
    best = study.tables.best
    own = best[(best.quantity == ATTITUDE) & (best.coordinates == ABSOLUTE) & (best.arithmetic == DOUBLE)]
    own = own[flags(own.settled) & own.steps_per_orbit.notna() & (own.method == "rk4")].sort_values("ratio")
    if len(own) < 2:
        return []
    few, many = own.iloc[0], own.iloc[-1]
    ends = [f"{r['steps_per_orbit']:.0f} per orbit for bars of {size(study, float(r['ratio']))}" for r in (many, few)]
    if few["steps_per_orbit"] >= many["steps_per_orbit"]:
        return [f"The optimal number of RK4 steps does not fall with the size: {listed(ends)}."]
    return [
        f"More steps than the optimum only add round-off. The optimal number of RK4 steps falls from "
        f"{ends[0]} to {ends[1]}."
    ]


def single_orbit_sentences(study: RoundoffData) -> list[str]:
    """Sentence on single precision."""
    in_absolute, in_relative = (least(study, c, SINGLE) for c in (ABSOLUTE, RELATIVE))
    if not len(in_absolute) or not len(in_relative):
        return []
    held, lost = in_absolute[in_absolute["median"] < LOST], in_absolute[in_absolute["median"] >= LOST]
    said = []
    if len(held):
        last = held.iloc[-1]
        said.append(f"reach {spelled(float(last['median']))} rad for bars of {size(study, float(last['ratio']))}")
    if len(lost):
        said.append(f"lose the attitude of bars of {size(study, float(lost.iloc[0]['ratio']))}")
    return [f"In single precision absolute coordinates {listed(said)}; relative ones reach {bounded(in_relative)}."]


def growth_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentence on the exponents of the attitude's error in time."""
    laws = study.tables.growth_laws
    own = laws[(laws.quantity == ATTITUDE) & laws.coordinates.isin((ABSOLUTE, RELATIVE)) & (laws.arithmetic == DOUBLE)]
    fits = [(str(r["coordinates"]), fit) for r in own.to_dict("records") if (fit := fit_of(r)).exponent is not None]
    if not fits:
        return ()
    by = {c: [fit for name, fit in fits if name == c] for c in (ABSOLUTE, RELATIVE)}
    each = listed([f"{exponents_text(found)} in {c} coordinates" for c, found in by.items() if found])
    edges = [v for fit in fits for v in (fit[1].low, fit[1].high) if v is not None]
    said = f"Errors of the attitude grow as powers of time, {each} [{min(edges):.2f} to {max(edges):.2f}]"
    off = [fit for _, fit in fits if fit.off]
    if not off:
        return (f"{said}, in agreement with the 3/2 of independent roundings.",)
    steeper = all(fit.exponent is not None and fit.exponent > fit.expected for fit in off)
    way = "above" if steeper else "apart from"
    some = "all intervals lie" if len(off) == len(fits) else f"{len(off)} of {len(fits)} intervals lie"
    return (f"{said}: {some} {way} the 3/2 of independent roundings.",)
