"""Verdict on the paper's claim, in sentences that follow from the study's numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.absolute_failures import horizontal_sentences, read_off_sentences, single_sentences
from reports.chapters.roundoff.engine_verdict import engines_sentences
from reports.chapters.roundoff.rows import times
from reports.chapters.roundoff.run_verdict import growth_sentences, orbit_sentences
from reports.chapters.roundoff.series import (
    ABSOLUTE,
    BARS,
    INPUT,
    LONG,
    POSITIONS,
    PRODUCTION,
    RELATIVE,
    RELATIVE_POSITIONS,
    SINGLE,
    STRAIGHT,
    UNEQUAL,
    Key,
    other,
)  # fmt: skip
from reports.chapters.roundoff.words import (
    between,
    digits_between,
    exponent_words,
    length,
    listed,
    size,
    spelled,
    unit_text,
)
from reports.text.record import is_complete

if TYPE_CHECKING:
    from collections.abc import Hashable

    from reports.chapters.roundoff.series import Digits, NamedObject, RoundoffData, Spread

CLAIM = "could be impossible"
LONGEST_M = 100.0  # largest object named in the text
ALIKE = 3.0  # errors within this factor of each other are the same
COSTLY = 10.0  # times the error of five bars in a generic state: from there on digits are lost


@dataclass(frozen=True)
class Paragraph:
    """Sentences on one subject."""

    head: str
    sentences: tuple[str, ...]
    apart: bool = False
    """Whether each sentence is a list item"""


@dataclass(frozen=True)
class RoundoffVerdict:
    """Headline and paragraphs."""

    headline: str
    paragraphs: tuple[Paragraph, ...]


def verdict(study: RoundoffData) -> RoundoffVerdict:
    """Verdict of a study."""
    found = (
        Paragraph("Generic states.", ordinary_sentences(study)),
        Paragraph("Losses that confirm the paper.", right_sentences(study), apart=True),
        Paragraph("Losses that the paper overstates.", overstated_sentences(study)),
        Paragraph("Runs of one orbit.", (*orbit_sentences(study), *growth_sentences(study))),
        Paragraph("Other engines.", engines_sentences(study)),
        Paragraph("Losses in both sets of coordinates.", (*unequal_sentences(study), *long_chain_sentences(study))),
        Paragraph("Cost of relative coordinates.", cost_sentences(study)),
        Paragraph("Limits of this verdict.", limits(study)),
    )
    return RoundoffVerdict(headline(study), tuple(p for p in found if p.sentences))


def kept(study: RoundoffData, longest_m: float = math.inf) -> list[tuple[NamedObject, Digits]]:
    """Digits of the named objects' reactions in absolute coordinates, double precision, generic state."""
    things = (o for o in study.named if o.length_m <= longest_m)
    return [(o, d) for o in things if (d := study.digits(Key(ABSOLUTE), o.ratio))]


def headline(study: RoundoffData) -> str:
    """Verdict in one sentence."""
    found = kept(study)
    if not found:
        return measured_headline(study)
    lost = [o.name for o, d in found if d.lost]
    if lost:
        return f"In double precision, absolute coordinates lose the reactions of {things_text(lost)}"
    spent = [d.median - absolute.median for o, absolute in found if (d := study.digits(Key(RELATIVE), o.ratio))]
    if spent and max(spent) < 1.0:
        return "In double precision absolute coordinates cost no digit of reactions in generic states"
    return f"In double precision absolute coordinates cost some digits of reactions in generic states{in_single(study)}"


def measured_headline(study: RoundoffData) -> str:
    """Digits that the longest measured bars keep, of a study at the size of no named object."""
    sizes = Key(ABSOLUTE).of(study.tables.evaluation).ratio
    longest = float(sizes.max()) if len(sizes) else 0.0
    in_relative, in_absolute = (study.error(Key(f), longest) for f in (RELATIVE, ABSOLUTE))
    if in_relative is None or in_absolute is None:
        return "Nothing was measured at the sizes of the named objects"
    return f"A generic state leaves {left(in_relative, in_absolute)} for bars of {size(study, longest)}"


def in_single(study: RoundoffData) -> str:
    """Clause of the headline on single precision."""
    law = study.law(Key(ABSOLUTE, SINGLE))
    if law is None or law.last_digit_ratio is None or not study.measured(law.last_digit_ratio):
        return ""
    return f"; in single precision they cost all digits at bars of {size(study, law.last_digit_ratio)}"


def things_text(names: list[str]) -> str:
    """``a 5 mm hinge and a 10 µm MEMS beam``."""
    return listed([f"a {name}" for name in names])


def ordinary_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentences on the claim, and on the laws of both formulations."""
    in_absolute, in_relative = study.law(Key(ABSOLUTE)), study.law(Key(RELATIVE))
    said = [f"According to the paper, computing internal forces from inertial coordinates “{CLAIM}”."]
    if in_absolute is not None:
        said.append(
            f"Solved for in absolute coordinates, in a generic state of {BARS} bars, reactions have errors of "
            f"{unit_text(in_absolute)} ({exponent_words(in_absolute)})."
        )
    if in_relative is not None:
        some = " on average over the sizes" if in_relative.points > 1 else ""
        where = " at every size" if in_relative.certain else some
        said.append(
            f"In relative coordinates their errors are {unit_text(in_relative)}{where} ({exponent_words(in_relative)})."
        )
    return (*said, *production_sentences(study)) if len(said) > 1 else ()


def production_sentences(study: RoundoffData) -> list[str]:
    """Sentence on the code of barchain's engines in the same states."""
    found = [(name, law) for name in PRODUCTION if (law := study.law(Key(name)))]
    each = listed([f"{unit_text(law)} for {name}{f' ({exponent_words(law)})' * law.off}" for name, law in found])
    return [f"Errors of barchain’s engines: {each}."] if found else []


def right_sentences(study: RoundoffData) -> tuple[str, ...]:
    """List items on losses of reactions: one for each case."""
    lost = [o.name for o, d in kept(study) if d.lost]
    double = [f"In double precision absolute coordinates leave no digit of the reactions of {things_text(lost)}."]
    cases = (double if lost else (), single_sentences(study), read_off_sentences(study), horizontal_sentences(study))
    return tuple(" ".join(case) for case in cases if case)


def overstated_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentences on double precision in generic states."""
    left = [(o, d) for o, d in kept(study, LONGEST_M) if not d.lost]
    if not left:
        return ()
    each = listed([f"{d.text} for a {o.name}" for o, d in left])
    beside = [d.median for o, _ in left if (d := study.digits(Key(RELATIVE), o.ratio))]
    than = f"; relative coordinates leave {digits_between(beside)}" if beside else ""
    said = [f"In generic states and double precision, absolute coordinates leave these digits: {each}{than}."]
    law = study.law(Key(ABSOLUTE))
    if law is not None and law.last_digit_ratio is not None:
        beyond = "" if study.measured(law.last_digit_ratio) else ", by extrapolation"
        said.append(f"The last digit would be lost at bars of {size(study, law.last_digit_ratio)}{beyond}.")
    return (*said, *read_off_left(study))


def read_off_left(study: RoundoffData) -> list[str]:
    """Sentence on differenced positions in double precision."""
    key = Key(POSITIONS, state=STRAIGHT)
    left = [(o, d) for o in study.named if o.length_m <= LONGEST_M and (d := study.digits(key, o.ratio)) and not d.lost]
    if not left:
        return []
    law, beside = study.law(key), study.steady(Key(RELATIVE_POSITIONS, state=STRAIGHT))
    slope = f" ({exponent_words(law)})" if law else ""
    than = f"; from relative positions the errors are {between(beside)} at every size" if beside else ""
    each = listed([f"{d.text} for a {o.name}" for o, d in left])
    return [f"Even computed from positions at three instants, reactions keep {each}{slope}{than}."]


def unequal_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentence on masses of 1 : 1e6."""
    return shared_loss(study, Key(RELATIVE, state=UNEQUAL), "masses that alternate as 1 : 10⁶")


def long_chain_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentence on the straight chain with the most bars."""
    laws = study.tables.laws
    counts = sorted({int(n) for n in laws.bars[laws.state == STRAIGHT]})
    if not counts or counts[-1] <= BARS:
        return ()
    return shared_loss(study, Key(RELATIVE, state=STRAIGHT, bars=counts[-1]), f"{counts[-1]} bars in a straight line")


def shared_loss(study: RoundoffData, key: Key, what: str) -> tuple[str, ...]:
    """Sentence on the digits that a state leaves in both sets of coordinates, for its longest bars.

    A generic state of the same bars is named beside it: absolute coordinates cost digits there, too.
    """
    sizes = key.of(study.tables.evaluation).ratio
    if not len(sizes):
        return ()
    longest = float(sizes.max())
    found, plain = (
        [study.error(other(k, formulation=f), longest) for f in (RELATIVE, ABSOLUTE)] for k in (key, Key(RELATIVE))
    )
    (in_relative, in_absolute), (usual, usual_absolute) = found, plain
    if in_relative is None or in_absolute is None or usual is None or usual_absolute is None:
        return ()
    if in_relative.median < COSTLY * usual.median:
        return ()
    said = (
        f"For bars of {size(study, longest)}, {what} leave {left(in_relative, in_absolute)}; a generic state leaves "
        f"{left(usual, usual_absolute)}."
    )
    given = study.error(other(key, source=INPUT), longest)
    alike = in_absolute.median <= ALIKE * in_relative.median
    cause = (f" Rounding the input costs {spelled(given.median)}: the digits are lost in solving the joint "
             "system.") if alike and given and given.median * COSTLY < in_relative.median else ""  # fmt: skip
    return (said + cause,)


def left(in_relative: Spread, in_absolute: Spread) -> str:
    """``10.0 digits in relative and in absolute coordinates``; both numbers where they differ."""
    relative, absolute = in_relative.digits.text, in_absolute.digits.text
    if relative == absolute:
        return f"{relative} digits in relative and in absolute coordinates"
    return f"{relative} digits in relative and {absolute} in absolute coordinates"


def cost_sentences(study: RoundoffData) -> tuple[str, ...]:
    """Sentence on the time of an evaluation."""
    table = [r for r in study.tables.times.to_dict("records") if times(r)]
    if not table:
        return ()
    codes = list(dict.fromkeys(str(r["code"]) for r in table))[:2]
    each = [f"{listed([slowdown(r) for r in table if r['code'] == code])} ({code})" for code in codes]
    said = f"In relative coordinates an evaluation takes {'; '.join(each)} as in absolute ones"
    ratios = [float(r["ratio"]) for r in table]
    least, most = min(ratios), max(ratios)
    spread = f": {least:.2f} to {most:.2f} times over all measurements, with intervals valid within one run"
    return (f"{said}{spread * (len(table) > 1)}.",)


def slowdown(row: dict[Hashable, Any]) -> str:
    """``1.30 (1.29 to 1.31) times as long with 5 bars``."""
    return f"{times(row)} times as long with {int(row['bars'])} bars"


def limits(study: RoundoffData) -> tuple[str, ...]:
    """Sentences on the scope of the verdict."""
    record, sizes = study.tables.record, study.tables.evaluation.ratio
    metres, span = study.metres, ""
    if len(sizes) and metres is not None:
        ends = dict.fromkeys(length(float(end) * metres) for end in (sizes.min(), sizes.max()))
        span = f" and bars of {' to '.join(ends)}"
    said = [f"The verdict holds for a planar chain in a spherical field{span}. Errors are those of the worst joint, "
            "relative to the largest reaction."]  # fmt: skip
    if record.get("members"):
        said.append(f"Numbers are medians over {record['members']} members that differ by a rotation of the frame and "
                    "by units in the last place.")  # fmt: skip
    said.append("Brackets hold 95\N{NO-BREAK SPACE}% intervals. The generic state is one random draw: others have the "
                "same exponents and other constants.")  # fmt: skip
    if record.get("long_doubles") is False:
        said.append(f"On this machine a {LONG} has the precision of a double.")
    if not is_complete(record):
        said.append("The study was cut off before its end.")
    return tuple(said)
