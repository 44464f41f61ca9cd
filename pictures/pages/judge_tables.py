"""Tables of the judge: tolerances, bounds on what engines declare, outcomes, solutions that come with barchain."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.tolerances import SAFEGUARDS, TOLERANCES
from barchain.solutions.certified_file import ERROR, columns_of, read_file, shipped_path, shipped_solution
from barchain.solutions.proof import PROVEN, at_most, proof_of
from barchain.solutions.reference import closely_sampled
from pictures.pages.words import table
from reports.results.comparison import LINEAR_GROWTH
from reports.results.outcome import SEVERITY
from scenarios import load_scene, scene_names

if TYPE_CHECKING:
    from collections.abc import Callable

    from barchain.solutions.proof import Proof
    from barchain.solutions.reference import ReferenceSolution


def tolerances() -> str:
    """All tolerances with their derivations."""
    head = ("quantity", "tolerance", "value", "derivation", "tested by")
    return table(head, ((t.quantity, t.name, t.value, t.derivation, f"`{t.tested_by}`") for t in TOLERANCES))


def safeguards() -> str:
    """Bounds on quantities that an engine controls."""
    head = ("quantity that an engine controls", "bound", "fault that tests the bound", "tested by")
    return table(head, ((s.widened_by, s.bound, s.fault, f"`{s.tested_by}`") for s in SAFEGUARDS))


def outcomes() -> str:
    """All outcomes, from the least to the most severe."""
    head = ("outcome", "exit code", "meaning")
    return table(head, ((f"`{o}`", "0" if o.ok else "1", o.advice) for o in SEVERITY))


def judging_solutions() -> str:
    """Judging solutions that come with barchain, by scene."""
    head = (
        "scene",
        "kB:",
        "error bar of the attitude at the end, rad:",
        "of the reactions, N:",
        "error amplification:",
    )
    known = ((name, shipped_solution(closely_sampled(load_scene(name)))) for name in scene_names())
    return table(head, (solution_row(name, solution) for name, solution in known if solution is not None))


def solution_row(name: str, found: ReferenceSolution) -> tuple[str, ...]:
    """Row of one scene's judging solution."""
    reaction = f"{found.error['reaction'][-1]:.1e}" if "reaction" in found.error else "–"
    size, angle, grown = shipped_path(name).stat().st_size / 1e3, found.error["attitude"][-1], found.amplification[-1]
    growth = f"{grown:.2g}" if grown <= LINEAR_GROWTH else f"> {LINEAR_GROWTH:.0e}"
    return name, f"{size:.0f}", f"{angle:.1e}", reaction, growth


def enclosed_solutions() -> str:
    """Proofs that come with barchain, by scene."""
    head = (
        "scene", "bars:", "bits:", "order:", "steps:", "time, s:", "radius at the end over the largest value:",
        "largest proven distance over the error bar:",
    )  # fmt: skip
    known = [(name, proof_of(path)) for name in scene_names() if (path := shipped_path(name)).is_file()]
    return table(head, (proof_row(name, proof) for name, found in known if found for proof in found[1:]))


def proof_row(name: str, proof: Proof) -> tuple[str, ...]:
    """Row of one scene's proof."""
    _, frame = read_file(shipped_path(name))
    proven, error = columns_of(frame, PROVEN), columns_of(frame, ERROR)
    share = max(float(np.nanmax(proven[q] / np.where(error[q], error[q], np.nan))) for q in error if error[q].any())
    effort = (load_scene(name).bars, proof.bits, proof.order, proof.steps, round(proof.seconds))
    return name, *map(str, effort), at_most(proof.relative), f"{share:.2f}"


TABLES: dict[str, Callable[[], str]] = {
    "tolerances": tolerances,
    "safeguards": safeguards,
    "outcomes": outcomes,
    "judging-solutions": judging_solutions,
    "enclosed-solutions": enclosed_solutions,
}
"""Tables by their names"""
