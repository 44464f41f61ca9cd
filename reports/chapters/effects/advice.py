"""What follows from an effect budget, in words: one rule for all effects.

An effect matters where it changes, over what was compared, the attitude by more than M radians, the reactions by more
than M of the largest, or the place of the centre of mass by more than M of its initial distance from the centre of the
body, which is what turns the local horizon by M radians. What is not resolved counts by its bound: if that is above
M, nothing can be told.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from reports.chapters.effects.rows import MODELS
from reports.chapters.effects.words import (
    NAMES,
    NOT_RESOLVED,
    amount,
    cost_words,
    done,
    limit_words,
    named,
    span_words,
    spoken,
)
from reports.tables.effects import EffectKind
from reports.text.words import joined

if TYPE_CHECKING:
    from reports.chapters.effects.rows import EffectRow, Whole


class Worth(StrEnum):
    """What an effect is worth in a scene."""

    MATTERS = "matters"
    UNTOLD = "can't be told"
    """What the numerics resolve is above what matters"""
    SMALL = "small"
    UNRESOLVED = "not resolved"
    """All of it is below what the numerics resolve, and that is small"""
    NOT_SWITCHED = "not switched"

    @property
    def needless(self) -> bool:
        """Whether one may do without it."""
        return self in (Worth.SMALL, Worth.UNRESOLVED)


@dataclass(frozen=True)
class Advice:
    """What follows for one effect."""

    row: EffectRow
    worth: Worth
    text: str


def advise(row: EffectRow, whole: Whole) -> Advice:
    """Advice on one effect."""
    worth = worth_of(row, whole.matters)
    return Advice(row, worth, sentence(row, worth, whole))


def worth_of(row: EffectRow, matters: float) -> Worth:
    """The rule."""
    if row.reason or not row.changes:
        return Worth.NOT_SWITCHED
    large = [c for c in row.changes if c.share > matters]
    if any(c.resolved for c in large):
        return Worth.MATTERS
    if large:
        return Worth.UNTOLD
    return Worth.SMALL if any(c.resolved for c in row.changes) else Worth.UNRESOLVED


def sentence(row: EffectRow, worth: Worth, whole: Whole) -> str:
    """One effect's advice with its numbers."""
    if worth is Worth.NOT_SWITCHED:
        return f"{spoken(row)} is not switched: {row.reason or 'not run'}."
    found = f"{spoken(row)} {what_it_does(row, worth, whole)}"
    caveat = f" {row.caveat}" if row.caveat else ""
    return f"{found}: {verdict(row, worth, whole)}{cost_words(row)}.{limit_words(row, whole)}{caveat}"


def what_it_does(row: EffectRow, worth: Worth, whole: Whole) -> str:
    """Changes in words, those that matter in whole clauses."""
    span, all_of_it = span_words(row, whole), ", ".join(map(named, row.changes))
    if worth is Worth.UNRESOLVED:
        bounds = ", ".join(f"{NAMES[c.name]} {amount(c, c.bound)}" for c in row.changes)
        return f"stays {NOT_RESOLVED} in {span} ({bounds})"
    if worth is Worth.SMALL:
        return f"changes next to nothing in {span} ({all_of_it})"
    known, hidden = [done(c) for c in row.changes if c.resolved], [named(c) for c in row.changes if not c.resolved]
    aside = f" ({', '.join(hidden)})" if hidden else ""
    return f"{joined(known) or f'may change what is {NOT_RESOLVED}'}{aside} in {span}"


def verdict(row: EffectRow, worth: Worth, whole: Whole) -> str:
    """What to do."""
    if worth is Worth.UNTOLD:
        return f"whether that matters can't be told at rtol = {whole.rtol:g}, ask for a smaller --rtol"
    if row.kind is EffectKind.GRAVITY:
        return gravity_verdict(row, worth, whole.gravity)
    if row.on:
        return "keep it" if worth is Worth.MATTERS else "it can be left out"
    return "put it in" if worth is Worth.MATTERS else "leave it out"


def gravity_verdict(row: EffectRow, worth: Worth, own: str) -> str:
    """Which of two models of gravity to use."""
    richer = MODELS.index(row.model) > MODELS.index(own)
    if richer:
        return f"{own} is enough" if worth.needless else f"use {row.model}"
    return f"{row.model} would do" if worth.needless else f"keep {own}"


def headline(advice: tuple[Advice, ...], whole: Whole) -> str:
    """One sentence for each kind of worth, and one for gravity."""
    rest = [a for a in advice if not a.row.model]
    matter = [a.row.title for a in rest if a.worth is Worth.MATTERS]
    needless = [a.row.title for a in rest if a.worth.needless]
    untold = [a.row.title for a in rest if a.worth is Worth.UNTOLD]
    said = [
        f"What matters: {joined(matter) or 'nothing that was switched'}.",
        f"What changes next to nothing, {threshold(whole.matters)}: {joined(needless)}." if needless else "",
        f"What can't be told: {joined(untold)}." if untold else "",
        gravity_headline([a for a in advice if a.row.model], whole.gravity),
    ]
    return " ".join(s for s in said if s)


def threshold(matters: float) -> str:
    """Below what a change is next to nothing."""
    return f"less than {matters:g} rad, {matters:g} of the largest reaction and of the initial distance from the centre"


def gravity_headline(advice: list[Advice], own: str) -> str:
    """What other models of gravity would do, in one sentence."""
    other = [a.row.model for a in advice if a.worth is Worth.MATTERS]
    same = [a.row.model for a in advice if a.worth.needless]
    parts = [f"{joined(other)} {plural(other, 'differ')} from {own}"] if other else []
    parts += [f"{joined(same)} {plural(same, 'give')} next to what {own} gives"] if same else []
    return f"Of the models of gravity, {'; '.join(parts)}." if parts else ""


def plural(subjects: list[str], verb: str) -> str:
    """Verb for one or more subjects."""
    return verb if len(subjects) > 1 else f"{verb}s"
