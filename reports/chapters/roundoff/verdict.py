"""What the numbers say of the paper's claim, in sentences: each drops out, or turns, with the numbers it is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from reports.chapters.roundoff.absolute_failures import horizontal_says, read_off_says, single_says
from reports.chapters.roundoff.engine_verdict import engines_say
from reports.chapters.roundoff.rows import times
from reports.chapters.roundoff.run_verdict import growth_says, orbit_says
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
    counted,
    digits_between,
    exponent_words,
    length,
    listed,
    size,
    spelled,
    unit_text,
)

if TYPE_CHECKING:
    from collections.abc import Hashable

    from reports.chapters.roundoff.series import Digits, Named, RoundoffStudy

CLAIM = "could be impossible"
LONGEST_M = 100.0  # real things named in the text are of that length or less
ALIKE = 3.0  # errors within this factor of each other are the same
COSTLY = 10.0  # times the error of five bars in a generic state: from there on digits are lost


@dataclass(frozen=True)
class Paragraph:
    """Sentences about one thing."""

    head: str
    sentences: tuple[str, ...]
    apart: bool = False
    """Whether each is a point by itself"""


@dataclass(frozen=True)
class RoundoffVerdict:
    """The whole."""

    headline: str
    paragraphs: tuple[Paragraph, ...]


def verdict(study: RoundoffStudy) -> RoundoffVerdict:
    """Judge the claim by a study's numbers."""
    found = (
        Paragraph("In ordinary states.", ordinary_says(study)),
        Paragraph("Where the paper is right.", right_says(study), apart=True),
        Paragraph("Where it overstates.", overstated_says(study)),
        Paragraph("Over an orbit.", (*orbit_says(study), *growth_says(study))),
        Paragraph("In other engines.", engines_say(study)),
        Paragraph("Not the coordinates’ fault.", (*unequal_says(study), *long_chain_says(study))),
        Paragraph("What the cure costs.", cost_says(study)),
        Paragraph("Limits.", limits(study)),
    )
    return RoundoffVerdict(headline(study), tuple(p for p in found if p.sentences))


def kept(study: RoundoffStudy, longest_m: float = math.inf) -> list[tuple[Named, Digits]]:
    """Digits that double precision leaves of real things' reactions in absolute coordinates, ordinary state."""
    things = (o for o in study.named if o.length_m <= longest_m)
    return [(o, d) for o in things if (d := study.digits(Key(ABSOLUTE), o.ratio))]


def headline(study: RoundoffStudy) -> str:
    """Verdict in one sentence."""
    found = kept(study)
    if not found:
        return "What coordinates leave of the reactions’ digits"
    lost = [o.name for o, d in found if d.lost]
    if lost:
        return f"In double precision, absolute coordinates lose the reactions of {things_text(lost)}"
    spent = [d.median - absolute.median for o, absolute in found if (d := study.digits(Key(RELATIVE), o.ratio))]
    if spent and max(spent) < 1.0:
        return "In double precision absolute coordinates cost no digit of ordinary reactions"
    return f"In double precision absolute coordinates cost digits of ordinary reactions, but not all{in_single(study)}"


def in_single(study: RoundoffStudy) -> str:
    """What a headline adds of single precision."""
    law = study.law(Key(ABSOLUTE, SINGLE))
    if law is None or law.last_digit_ratio is None or not study.measured(law.last_digit_ratio):
        return ""
    return f"; in single precision they cost all of them at bars of {size(study, law.last_digit_ratio)}"


def things_text(names: list[str]) -> str:
    """``a 5 mm hinge and a 10 µm MEMS beam``."""
    return listed([f"a {name}" for name in names])


def ordinary_says(study: RoundoffStudy) -> tuple[str, ...]:
    """The claim, and the laws of both formulations."""
    theirs, ours = study.law(Key(ABSOLUTE)), study.law(Key(RELATIVE))
    said = [f"The paper says that getting internal forces from inertial coordinates “{CLAIM}”."]
    if theirs is not None:
        said.append(
            f"Solved for in absolute coordinates, in an ordinary state of {BARS} bars, they are off by "
            f"{unit_text(theirs)}, with ε a bar’s length over the Earth’s radius and u the unit round-off "
            f"({exponent_words(theirs)})."
        )
    if ours is not None:
        where = "at every size" if ours.certain else "on average over the sizes"
        said.append(f"In relative coordinates they are off by {unit_text(ours)} {where} ({exponent_words(ours)}).")
    return (*said, *production_says(study)) if len(said) > 1 else ()


def production_says(study: RoundoffStudy) -> list[str]:
    """The engines' own code, in the same states."""
    found = [(name, law) for name in PRODUCTION if (law := study.law(Key(name)))]
    each = listed([f"{unit_text(law)} for {name}{f' ({exponent_words(law)})' * law.off}" for name, law in found])
    return [f"The project’s own engines, as they run: {each}."] if found else []


def right_says(study: RoundoffStudy) -> tuple[str, ...]:
    """Where forces are lost: a point for each case."""
    lost = [o.name for o, d in kept(study) if d.lost]
    double = [f"In double precision absolute coordinates leave no digit of the reactions of {things_text(lost)}."]
    cases = (double if lost else (), single_says(study), read_off_says(study), horizontal_says(study))
    return tuple(" ".join(case) for case in cases if case)


def overstated_says(study: RoundoffStudy) -> tuple[str, ...]:
    """What double precision leaves in ordinary states."""
    left = [(o, d) for o, d in kept(study, LONGEST_M) if not d.lost]
    if not left:
        return ()
    each = listed([f"{d.text} for a {o.name}" for o, d in left])
    beside = [d.median for o, _ in left if (d := study.digits(Key(RELATIVE), o.ratio))]
    than = f", where relative ones leave {digits_between(beside)}" if beside else ""
    said = [f"In ordinary states and double precision, absolute coordinates leave these digits: {each}{than}."]
    law = study.law(Key(ABSOLUTE))
    if law is not None and law.last_digit_ratio is not None:
        beyond = "" if study.measured(law.last_digit_ratio) else ", by extrapolation"
        said.append(f"The last one would go at bars of {size(study, law.last_digit_ratio)}{beyond}.")
    return (*said, *read_off_left(study))


def read_off_left(study: RoundoffStudy) -> list[str]:
    """What even differenced positions leave in double precision."""
    key = Key(POSITIONS, state=STRAIGHT)
    left = [(o, d) for o in study.named if o.length_m <= LONGEST_M and (d := study.digits(key, o.ratio)) and not d.lost]
    if not left:
        return []
    law, beside = study.law(key), study.steady(Key(RELATIVE_POSITIONS, state=STRAIGHT))
    slope = f" ({exponent_words(law)})" if law else ""
    than = f"; from relative positions they err by {between(beside)} at every size" if beside else ""
    each = listed([f"{d.text} for a {o.name}" for o, d in left])
    return [f"Even read off from positions at three instants, reactions keep {each}{slope}{than}."]


def unequal_says(study: RoundoffStudy) -> tuple[str, ...]:
    """Masses of 1 : 1e6."""
    return shared_loss(study, Key(RELATIVE, state=UNEQUAL), "Masses that alternate as 1 : 10⁶")


def long_chain_says(study: RoundoffStudy) -> tuple[str, ...]:
    """A straight chain of as many bars as there were."""
    laws = study.tables.laws
    counts = sorted({int(n) for n in laws.bars[laws.state == STRAIGHT]})
    if not counts or counts[-1] <= BARS:
        return ()
    return shared_loss(study, Key(RELATIVE, state=STRAIGHT, bars=counts[-1]), f"{counts[-1]} bars in a straight line")


def shared_loss(study: RoundoffStudy, key: Key, what: str) -> tuple[str, ...]:
    """Digits that a state costs in both sets of coordinates, by its longest bars."""
    law, plain = study.law(key), study.law(Key(RELATIVE))
    sizes = key.of(study.tables.evaluation).ratio
    if law is None or plain is None or not law.constant or not plain.constant or not len(sizes):
        return ()
    longest = float(sizes.max())
    ours, theirs = (study.error(k, longest) for k in (key, other(key, formulation=ABSOLUTE)))
    if ours is None or theirs is None or law.constant < COSTLY * plain.constant:
        return ()
    lost = counted(round(math.log10(law.constant / plain.constant)), "digit")
    here = f"for bars of {size(study, longest)}"
    if theirs.median > ALIKE * ours.median:
        return (f"{what} cost {lost} in relative coordinates ({unit_text(law)}), and more in absolute ones: "
                f"{spelled(theirs.median)} beside {spelled(ours.median)} {here}.",)  # fmt: skip
    given = study.error(other(key, source=INPUT), longest)
    cause = (f" Rounding the input costs {spelled(given.median)}: the digits are lost in solving the joint system, not "
             "for want of data.") if given and given.median * COSTLY < ours.median else ""  # fmt: skip
    return (f"{what} cost {lost} in either: {here} errors are {spelled(ours.median)} in relative and "
            f"{spelled(theirs.median)} in absolute coordinates.{cause}",)  # fmt: skip


def cost_says(study: RoundoffStudy) -> tuple[str, ...]:
    """Time of an evaluation."""
    table = [r for r in study.tables.times.to_dict("records") if times(r)]
    if not table:
        return ()
    codes = list(dict.fromkeys(str(r["code"]) for r in table))[:2]
    each = [f"{listed([slowdown(r) for r in table if r['code'] == code])} ({code})" for code in codes]
    said = f"In relative coordinates an evaluation takes {'; '.join(each)} as in absolute ones"
    ratios = [float(r["ratio"]) for r in table]
    least, most = min(ratios), max(ratios)
    spread = f": {least:.2f} to {most:.2f} times in all that was timed, with intervals that hold within one run"
    return (f"{said}{spread * (len(table) > 1)}.",)


def slowdown(row: dict[Hashable, Any]) -> str:
    """``1.30 (1.29 to 1.31) times as long with 5 bars``."""
    return f"{times(row)} times as long with {int(row['bars'])} bars"


def limits(study: RoundoffStudy) -> tuple[str, ...]:
    """What the verdict does not cover."""
    record, sizes = study.tables.record, study.tables.evaluation.ratio
    metres, span = study.metres, ""
    if len(sizes) and metres is not None:
        span = f" and bars of {length(float(sizes.min()) * metres)} to {length(float(sizes.max()) * metres)}"
    said = [f"All this holds for a planar chain in a spherical field{span}; an error is the worst joint’s, over the "
            "largest joint’s reaction."]  # fmt: skip
    if record.get("members"):
        said.append(f"Numbers are medians over {record['members']} members, which differ by a turn of the frame and by "
                    "units in the last place.")  # fmt: skip
    said.append("Brackets hold 95\N{NO-BREAK SPACE}% intervals. An ordinary state is one draw: others have the same "
                "exponents, and constants of their own.")  # fmt: skip
    if record.get("long_doubles") is False:
        said.append(f"On this machine a {LONG} is no longer than a double.")
    if not record.get("finished"):
        said.append("The study was cut off before its end.")
    return tuple(said)
