"""Classification of effects as relevant, negligible, unresolved or undecided, and advice in words.

An effect is relevant if it changes, over the compared time, the attitude by more than M radians, the reactions by more
than M of the largest, or the position of the centre of mass by more than M of its initial distance from the centre of
the body. The last threshold rotates the local horizontal by M radians. An unresolved change counts by its bound: above
M the effect is undecided.
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
    change_words,
    cost_words,
    limit_words,
    named,
    span_words,
    spoken,
)
from reports.tables.effects import EffectKind
from reports.text.words import joined

if TYPE_CHECKING:
    from reports.chapters.effects.rows import BudgetScope, EffectRow


class Relevance(StrEnum):
    """Relevance of an effect in a scene."""

    RELEVANT = "relevant"
    UNDECIDED = "undecided"
    """The numerical resolution is coarser than the threshold of relevance"""
    NEGLIGIBLE = "negligible"
    """Resolved, and below the threshold"""
    UNRESOLVED = "unresolved"
    """All changes are below the numerical resolution, which is below the threshold"""
    NOT_SWITCHED = "not switched"

    @property
    def omissible(self) -> bool:
        """Whether the effect can be omitted."""
        return self in (Relevance.NEGLIGIBLE, Relevance.UNRESOLVED)


@dataclass(frozen=True)
class Advice:
    """Classification of one effect, and advice."""

    row: EffectRow
    relevance: Relevance
    text: str


def advise(row: EffectRow, scope: BudgetScope) -> Advice:
    """Advice on one effect."""
    relevance = classify(row, scope.matters)
    return Advice(row, relevance, sentence(row, relevance, scope))


def classify(row: EffectRow, matters: float) -> Relevance:
    """Classify an effect by the threshold `matters`."""
    if row.reason or not row.changes:
        return Relevance.NOT_SWITCHED
    large = [c for c in row.changes if c.share > matters]
    if any(c.resolved for c in large):
        return Relevance.RELEVANT
    if large:
        return Relevance.UNDECIDED
    return Relevance.NEGLIGIBLE if any(c.resolved for c in row.changes) else Relevance.UNRESOLVED


def sentence(row: EffectRow, relevance: Relevance, scope: BudgetScope) -> str:
    """One effect's advice with its numbers."""
    if relevance is Relevance.NOT_SWITCHED:
        return f"{spoken(row)} is not switched: {row.reason or 'not run'}."
    found = f"{spoken(row)} {effect_words(row, relevance, scope)}"
    caveat = f" {row.caveat}" if row.caveat else ""
    advised = recommendation(row, relevance, scope)
    return f"{found}{f': {advised}' if advised else ''}{cost_words(row)}.{limit_words(row, scope)}{caveat}"


def effect_words(row: EffectRow, relevance: Relevance, scope: BudgetScope) -> str:
    """Changes in words, relevant ones in whole clauses."""
    span, all_of_it = span_words(row, scope), ", ".join(map(named, row.changes))
    if relevance is Relevance.UNRESOLVED:
        bounds = ", ".join(f"{NAMES[c.name]} {amount(c, c.bound)}" for c in row.changes)
        return f"is {NOT_RESOLVED} in {span} ({bounds})"
    if relevance is Relevance.NEGLIGIBLE:
        return f"is negligible in {span} ({all_of_it})"
    known, hidden = (
        [change_words(c) for c in row.changes if c.resolved],
        [named(c) for c in row.changes if not c.resolved],
    )
    aside = f" ({', '.join(hidden)})" if hidden else ""
    return f"{joined(known) or f'may cause changes {NOT_RESOLVED}'}{aside} in {span}"


def recommendation(row: EffectRow, relevance: Relevance, scope: BudgetScope) -> str:
    """Recommendation; empty on a relevant effect of the design, which nobody would leave out."""
    if relevance is Relevance.UNDECIDED:
        return f"its relevance is undecided at rtol = {scope.rtol:g}, use a smaller --rtol"
    if row.kind is EffectKind.GRAVITY:
        return gravity_recommendation(row, relevance, scope.gravity)
    if row.kind is EffectKind.DESIGN and relevance is Relevance.RELEVANT:
        return ""
    if row.on:
        return "keep it on" if relevance is Relevance.RELEVANT else "it can be switched off"
    return "switch it on" if relevance is Relevance.RELEVANT else "leave it off"


def gravity_recommendation(row: EffectRow, relevance: Relevance, own: str) -> str:
    """Recommendation between two gravity models."""
    richer = MODELS.index(row.model) > MODELS.index(own)
    if richer:
        return f"{own} suffices" if relevance.omissible else f"use {row.model}"
    return f"{row.model} would suffice" if relevance.omissible else f"keep {own}"


def headline(advice: tuple[Advice, ...], scope: BudgetScope) -> str:
    """One sentence for each kind of worth, and one for gravity."""
    rest = [a for a in advice if not a.row.model]
    matter = [a.row.title for a in rest if a.relevance is Relevance.RELEVANT]
    omissible = [a.row.title for a in rest if a.relevance.omissible]
    untold = [a.row.title for a in rest if a.relevance is Relevance.UNDECIDED]
    without = [a.row.title for a in rest if a.relevance is Relevance.NOT_SWITCHED]
    said = [
        f"Relevant: {joined(matter) or 'none of the switched effects'}.",
        f"Negligible ({threshold(scope.matters)}): {joined(omissible)}." if omissible else "",
        f"Undecided: {joined(untold)}." if untold else "",
        f"No conclusion: {joined(without)}." if without else "",
        gravity_headline([a for a in advice if a.row.model], scope.gravity),
    ]
    return " ".join(s for s in said if s)


def threshold(matters: float) -> str:
    """Threshold of relevance in words."""
    return f"less than {matters:g} rad, {matters:g} of the largest reaction and of the initial distance from the centre"


def gravity_headline(advice: list[Advice], own: str) -> str:
    """Differences of the other gravity models, in one sentence."""
    other = [a.row.model for a in advice if a.relevance is Relevance.RELEVANT]
    same = [a.row.model for a in advice if a.relevance.omissible]
    parts = [f"{joined(other)} {plural(other, 'differ')} from {own}"] if other else []
    parts += [f"{joined(same)} {plural(same, 'agree')} with {own}"] if same else []
    return f"Of the gravity models, {'; '.join(parts)}." if parts else ""


def plural(subjects: list[str], verb: str) -> str:
    """Verb for one or more subjects."""
    return verb if len(subjects) > 1 else f"{verb}s"
