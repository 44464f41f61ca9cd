"""Diagnoses of several scenes of one engine against each other: names that another scene contradicts are withdrawn."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.search import MotionSearch, least_squares
from barchain.judge.diagnosis.motion.words import GRAVITY
from scenarios.plural import plural

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from barchain.judge.diagnosis.diagnose import Diagnosis
    from barchain.judge.diagnosis.motion.search import Fitted
    from barchain.judge.diagnosis.own_motion import OwnMotion
    from scenarios import Scene

OF_ONE_LOAD = re.compile(r"(impulse|thrust|joint[-_]torque|third[-_]body)-\d+(?:-|$)")
"""Names of candidates of one of several loads"""
OF_ONE_BAR = re.compile(r"(.*?-(?:bar-)?)(\d+)((?:-.*)?)$")
"""Names of candidates of one bar or joint: before, the number, and after"""
VISIBLE = 100.0
"""Ratio of an effect to the noise, root mean square, from which on a scene shows whether it is there"""
PRESENT = 0.2
"""Largest departure from 1 of the share of an effect that a scene has"""


def agreed(found: Mapping[str, Diagnosis], others: Mapping[str, OwnMotion]) -> dict[str, Diagnosis]:
    """Diagnoses without the names that another scene contradicts.

    Parameters
    ----------
    found : mapping of str to Diagnosis
        Diagnoses of scenes in which the engine is wrong.
    others : mapping of str to OwnMotion
        The engine's motion in these and in further scenes, in which it is right.

    Returns
    -------
    dict of str to Diagnosis
        Where other scenes tell explanations apart that are indistinguishable in one, those that hold in most scenes.
    """
    agreeing = {}
    for name, diagnosis in found.items():
        rest = {other: own for other, own in others.items() if other != name}
        against = {names: contradiction(names, diagnosis, rest) for names in diagnosis.names}
        kept = tuple(e for e in diagnosis.explanations if not against[e.names])
        shared = {e.names: sum(e.names in d.names for d in found.values()) for e in kept}
        most = max(shared.values(), default=0)
        kept = tuple(e for e in kept if shared[e.names] == most)
        withdrawn = [e for e in diagnosis.explanations if against[e.names]]
        said = diagnosis.nearest
        if withdrawn and not kept:
            alone = {names for d in found.values() for names in d.names if len(names) == 1}
            part = next((m for e in withdrawn for m in e.mistakes if (m.name,) in alone), None)
            said = f" Nearest: {part.sentence}, which not all scenes bear out." if part else place_alone(diagnosis)
        agreeing[name] = dataclasses.replace(diagnosis, explanations=kept, nearest=said)
    return agreeing


def place_alone(diagnosis: Diagnosis) -> str:
    """Where a motion departs, without a name."""
    return "" if diagnosis.own is None else diagnosis.own.departure


def contradiction(names: tuple[str, ...], diagnosis: Diagnosis, others: Mapping[str, OwnMotion]) -> str:
    """Scene in whose motion an explanation of another scene should show and does not; empty without one."""
    if diagnosis.own is None:
        return ""
    # with a mistake of reading on top of the motion's, that of the motion comes first
    fits = ((f, tuple(c.name for c in f.candidates)) for f in diagnosis.own.fits if f.explains)
    fit = next((f for f, of_motion in fits if of_motion == names[: len(of_motion)]), None)
    if fit is None:
        return ""
    gravity = diagnosis.own.given_scene.effects.gravity
    of_gravity = any(c.section == GRAVITY for c in fit.candidates)  # an engine may have one model of gravity wrong
    held = {s: own for s, own in others.items() if not of_gravity or own.given_scene.effects.gravity == gravity}
    return next((scene for scene, own in held.items() if lacks(own, fit, diagnosis.own.given_scene)), "")


def lacks(own: OwnMotion, fit: Fitted, scene: Scene) -> bool:
    """Whether a motion shows that some candidate of a fit to the motion in another `scene` is not there.

    The shares that the motion has of the effects follow by least squares, of all candidates together, in the blocks
    that the fit is about.
    """
    residual = own.residual
    if residual is None or not residual.known.any():
        return False
    search = own.search or MotionSearch(residual)
    if any(of_one_of_several(scene, c.name) for c in fit.candidates):
        return False  # another scene's load of that number is another one
    from_start = [name_in(own.given_scene, scene, c.name) for c in fit.candidates]
    from_end = [counted_from_end(own.given_scene, scene, name) for name in from_start]
    return all(misses(search, fit, names) for names in {tuple(from_start), tuple(from_end)})


def misses(search: MotionSearch, fit: Fitted, names: Sequence[str]) -> bool:
    """Whether a motion shows that some candidate of a fit, under its name here, is not there."""
    residual = search.residual
    here = {c.name: c for c in search.candidates}
    columns = residual.balance.of_blocks(name for name in fit.blocks if name in residual.balance.columns)
    noise = residual.noise[residual.known][:, columns]
    fitted = zip(names, fit.candidates, fit.amounts, strict=True)
    pairs = [(here[name], c, a) for name, c, a in fitted if name in here]
    effects = [one.effect_as_of(there, a)[residual.known][:, columns] / noise for one, there, a in pairs]
    seen = [x.ravel() for x in effects if np.isfinite(x).all() and x.size and np.sqrt(np.mean(x**2)) >= VISIBLE]
    if not seen:
        return False
    shares = least_squares(np.stack(seen, axis=1), (residual.value[residual.known][:, columns] / noise).ravel())
    return bool(np.any(np.abs(shares - 1.0) > PRESENT))


def of_one_of_several(scene: Scene, name: str) -> bool:
    """Whether a candidate is about one of several loads of a kind."""
    found = OF_ONE_LOAD.match(name)
    return found is not None and len(getattr(scene.effects, found[1].replace("-", "_"))) > 1


def counted_from_end(here: Scene, there: Scene, name: str) -> str:
    """Name of a candidate of another scene's bar or joint, that of the same place from the end of the chain here."""
    found = OF_ONE_BAR.match(name)
    if found is None or int(found[2]) > there.bars:
        return name
    number = here.bars - there.bars + int(found[2])
    return f"{found[1]}{number}{found[3]}" if number > 0 else name


def name_in(here: Scene, there: Scene, name: str) -> str:
    """Name of a candidate of another scene: what is of the only impulse `there` is of all impulses `here`."""
    kind, _, number = name.partition("-1-")
    alone = len(getattr(there.effects, kind, ())) == 1 if number else False
    return f"{kind}s-{number}" if alone and len(getattr(here.effects, kind)) > 1 else name


TRAITS: tuple[tuple[str, Callable[[Scene], object]], ...] = (
    ("gravity", lambda s: s.effects.gravity != "none"),
    ("several bars", lambda s: s.bars > 1),
    ("more than two bars", lambda s: s.bars > 2),
    ("more than three bars", lambda s: s.bars > 3),
    ("a single bar", lambda s: s.bars == 1),
    ("an orbit that is not circular", lambda s: s.orbit.eccentricity != 0.0),
    ("the torque of the gravity gradient", lambda s: s.effects.gravity.turns),
    ("more than an orbit", lambda s: s.run.duration_s > s.period_s),
    ("angles from each bar's own horizontal", lambda s: s.chain.angle_from == "bar"),
    ("rates of both directions", lambda s: min(s.chain.rate_factor) * max(s.chain.rate_factor) < 0.0),
)
"""Properties of scenes that an engine may fail on"""


def in_common(failed: Sequence[Scene], passed: Iterable[Scene]) -> str:
    """What all scenes with a failure have and none of the others has, as a sentence; empty without anything."""
    right = list(passed)
    if not failed or not right:
        return ""
    effects = sorted(set.intersection(*(set(s.needs) for s in failed)))
    found = [words for words, has in TRAITS if all(map(has, failed)) and not any(map(has, right))]
    found += [name for name in effects if not any(name in s.needs for s in right)]
    verb = "fails" if len(failed) == 1 else "fail"
    return f" Of these scenes, {plural(len(failed), 'scene')} with {found[0]} {verb} alone." if found else ""
