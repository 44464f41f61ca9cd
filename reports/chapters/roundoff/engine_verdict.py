"""Sentences on errors of other engines in inertial and moving frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from reports.chapters.roundoff.engine_charts import INERTIAL, good, least_errors, libraries
from reports.chapters.roundoff.series import PRODUCTION, Key, exponents_text, fit_of
from reports.chapters.roundoff.words import exponent_words, listed, size, spelled, unit_text

if TYPE_CHECKING:
    import pandas as pd

    from reports.chapters.roundoff.series import FittedExponent, RoundoffData

REACTION = "reaction"
TYPICAL = 1e-5  # size ratio of which engines are compared: the paper's bars, roughly
COSTLY = 10.0  # times: a digit


def engines_sentences(study: RoundoffData) -> tuple[str, ...]:
    """All sentences on other engines."""
    return (*frames_sentences(study), *noise_sentences(study), *libraries_sentences(study))


def frames_sentences(study: RoundoffData) -> list[str]:
    """Sentence on the smallest errors of reactions in both frames."""
    table = good(study.tables.engines)
    own = least_errors(table[(table.quantity == REACTION) & ~table.engine.isin(PRODUCTION)])
    sizes = sorted({float(r) for r in own.ratio}, key=lambda r: abs(np.log(r / TYPICAL)))
    pairs = frame_pairs(own[own.ratio == sizes[0]]) if sizes else []
    if not pairs:
        return []
    each = listed([f"{spelled(inertial)} and {spelled(moving)} by {e}" for e, inertial, moving in pairs])
    worse = sum(inertial >= COSTLY * moving for _, inertial, moving in pairs)
    many = f"{worse} of {len(pairs)} engines that run in both"
    costs = f"costs a digit or more in {many}; barchain's code is not the cause" if worse else "costs no digit"
    return [f"The inertial frame {costs}: for bars of {size(study, sizes[0])}, the smallest errors of reactions in the "
            f"inertial and in a moving frame are {each}."]  # fmt: skip


def frame_pairs(own: pd.DataFrame) -> list[tuple[str, float, float]]:
    """Engine, smallest error in the inertial frame, smallest error in other frames, of engines with both."""
    found = []
    for engine, part in own.groupby("engine", sort=False):
        moving = part[part.frame != INERTIAL]["median"]
        inertial = part[part.frame == INERTIAL]["median"]
        if len(moving) and len(inertial):
            found.append((str(engine), float(inertial.min()), float(moving.min())))
    return found


def noise_sentences(study: RoundoffData) -> list[str]:
    """Sentence on engines with less accurate reactions at finer steps."""
    laws = study.tables.engine_laws
    own = laws[(laws.quantity == REACTION) & laws.against.str.startswith("step")]
    found: dict[str, dict[str, list[FittedExponent]]] = {}
    for r in own.to_dict("records"):
        fit = fit_of(r)
        if fit.low is not None and fit.low > 0.0:
            found.setdefault(str(r["engine"]), {}).setdefault(str(r["frame"]), []).append(fit)
    if not found:
        return []
    each = "; ".join(f"{engine} {by_frame(frames)}" for engine, frames in found.items())
    return [f"Beyond the optimum, errors grow with the number of steps, with these exponents: {each}."]


def by_frame(frames: dict[str, list[FittedExponent]]) -> str:
    """``2.04 to 2.22 in the inertial frame and 1.78 to 2.01 in the moving frame``."""
    return listed([f"{exponents_text(fits)} in the {frame} frame" for frame, fits in frames.items()])


def libraries_sentences(study: RoundoffData) -> list[str]:
    """Sentence on libraries' evaluations in coordinates of the orbit."""
    found = []
    for library, frame in libraries(study):
        law = study.law(Key(f"{library} ({frame})"))
        if frame == INERTIAL and law is not None and law.last_digit_ratio is not None:
            last = f"last digit at bars of {size(study, law.last_digit_ratio)}"
            found.append(f"{unit_text(law)} by {library} ({last}; {exponent_words(law)})")
    if not found:
        return []
    return [f"Errors of one evaluation by joint trees whose root moves along the orbit: {listed(found)}."]
