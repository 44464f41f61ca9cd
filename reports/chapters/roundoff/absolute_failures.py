"""Sentences on cases in which absolute coordinates lose the reactions.

The cases are single precision, differencing, and reactions that nearly vanish.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from reports.chapters.roundoff.series import (
    ABSOLUTE,
    ACCELERATIONS,
    DOUBLE,
    HORIZONTAL,
    ORDINARY,
    POSITIONS,
    RELATIVE,
    RELATIVE_POSITIONS,
    SINGLE,
    STRAIGHT,
    Key,
    other,
)  # fmt: skip
from reports.chapters.roundoff.words import between, exponent_words, listed, size, unit_text

if TYPE_CHECKING:
    from reports.chapters.roundoff.series import ErrorLaw, RoundoffData

ALIKE = 3.0  # constants within this factor of each other are the same
VANISHING = "Reactions of the exactly horizontal chain nearly vanish; they lose their last digit"
PRECISIONS = {DOUBLE: "double", SINGLE: "single"}


def single_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentence on single precision in a generic state."""
    law, beside = study.law(Key(ABSOLUTE, SINGLE)), study.steady(Key(RELATIVE, SINGLE))
    if law is None or law.last_digit_ratio is None:
        return ()
    lost = [o.name for o in study.named if o.ratio < law.last_digit_ratio]
    said = f"In single precision the last digit is lost at bars of {last_digits(study, {'': law})[0]}"
    said += f": absolute coordinates leave no digit for a {lost[0]}" if lost else ""
    said += f", while errors in relative coordinates are {between(beside)} at every size" if beside else ""
    return (f"{said}.",)


def read_off_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentences on reactions computed from known motion instead of solved for."""
    key = Key(POSITIONS, state=STRAIGHT)
    laws = {f"in {word} precision": study.law(other(key, arithmetic=a)) for a, word in PRECISIONS.items()}
    goes = last_digits(
        study, {w: law for w, law in laws.items() if law and study.measured(law.last_digit_ratio or 0.0)}
    )
    if not goes:
        return ()
    said = f"Computed from differenced absolute positions, reactions lose their last digit at bars of {listed(goes)}"
    beside = study.steady(Key(RELATIVE_POSITIONS, state=STRAIGHT))
    said += (
        f"; from relative positions in double precision their errors are {between(beside)} at every size"
        if beside
        else ""
    )
    return (f"{said}.", *accelerations_sentences(study))


def last_digits(study: RoundoffData, laws: dict[str, ErrorLaw | None]) -> list[str]:
    """Lengths at which the last digit is lost, each with its words and its fitted exponent."""
    return [
        f"{size(study, law.last_digit_ratio)} {words} ({exponent_words(law)})".replace("  ", " ")
        for words, law in laws.items()
        if law is not None and law.last_digit_ratio is not None
    ]


def accelerations_sentences(study: RoundoffData) -> list[str]:
    """Sentence that separates the loss by differencing from the loss by absolute coordinates."""
    key = Key(ACCELERATIONS, state=STRAIGHT)
    law, solved = study.law(key), study.law(other(key, formulation=ABSOLUTE))
    if law is None or solved is None or not law.constant or not solved.constant:
        return []
    said = f"from known accelerations their error is {unit_text(law)}, solved for {unit_text(solved)}"
    return [f"{said[0].upper()}{said[1:]}."]


def horizontal_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentences on the chain with vanishing reactions, relative to both yardsticks."""
    said: list[str] = []
    for arithmetic, word in PRECISIONS.items():
        key = Key(ABSOLUTE, arithmetic, HORIZONTAL)
        goes = last_digits(study, {f"in {f} coordinates": study.law(other(key, formulation=f))
                                   for f in (ABSOLUTE, RELATIVE)})  # fmt: skip
        if goes:
            lead = "They lose it" if said else VANISHING
            said.append(f"{lead}, in {word} precision, at bars of {listed(goes)}.")
    return (*said, *ordinary_yardstick_sentences(study))


def ordinary_yardstick_sentences(study: RoundoffData) -> list[str]:
    """Sentence on the same errors relative to the reactions of a generic state."""
    key = Key(ABSOLUTE, state=HORIZONTAL, yardstick=ORDINARY)
    in_absolute, in_relative = study.law(key), study.law(other(key, formulation=RELATIVE))
    if in_absolute is None or in_relative is None:
        return []
    said = (f"Relative to m n² l, the order of reactions in a generic state, the same errors are "
            f"{unit_text(in_absolute)} in absolute and {unit_text(in_relative)} in relative coordinates")  # fmt: skip
    if in_absolute.certain and in_relative.certain:
        return [f"{said}, as in any state."]
    unsure = dict.fromkeys(exponent_words(law) for law in (in_absolute, in_relative) if not law.certain)
    return [f"{said}, but {listed(list(unsure))}."]
