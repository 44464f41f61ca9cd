"""Search for the changes of the right equations that explain the residual of an engine's own motion."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.motion.alternatives import alternatives
from barchain.judge.diagnosis.motion.balance import BARS, CENTRE, JOINTS, LAWS, Balance
from barchain.judge.diagnosis.motion.candidate import BODIES, Candidate, fixed
from barchain.judge.diagnosis.motion.equations import ENDS
from barchain.judge.diagnosis.motion.numbers import numbers
from barchain.judge.diagnosis.motion.reactions import of_reactions
from barchain.judge.diagnosis.motion.terms import terms

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from adapters.trajectory import Array
    from barchain.judge.diagnosis.motion.alternatives import Alternative
    from barchain.judge.diagnosis.motion.numbers import Number
    from barchain.judge.diagnosis.motion.residual import Residual
    from scenarios import Scene

AT_NOISE = 4.0
"""Largest ratio to the noise of what a believed fit leaves, root mean square"""
GAIN = 30.0
"""Least ratio of the residual to what a believed fit leaves"""
CLEARLY = 4.0
"""Least ratio of what one candidate leaves to what a pair leaves that is believed"""
FLOOR = 1e-7
"""Least noise that counts, relative to the residual of the block"""
REFINED = 12
"""Candidates whose numbers are fitted beyond the linear effect"""
ROUNDS = 6
"""Rounds of such a fit"""
PAIRS = 40
"""Pairs that are fitted exactly, the best of all by their linear effects"""
MOST_PAIRS = 8
"""Pairs that leave noise alone, of which more say nothing"""
SMALL = 0.02
"""Largest relative amount of a mass or length whose effect is linear enough for a pair"""
REACH_PROBE = 1e-5
"""Distance of a joint from its place, in lengths, that is small enough for a linear effect"""
REACHES = (
    ("joints-shifted", "at {} to the right, and so much less to the left,", -1.0, 1.0),
    ("right-joints-shifted", "at {} to the right", 0.0, 1.0),
    ("left-joints-shifted", "at {} to the left", 1.0, 0.0),
)
"""Places of the joints: name, words, and how an amount moves the left and the right one of each bar"""
PARALLEL = 1e-8
"""Squared sine of the angle between two effects below which they are one"""
ALONE = {CENTRE: "in the motion of the centre of mass", BARS: "in the rotation of the bars",
         JOINTS: "in the reactions", LAWS: "in the prescribed angles"}  # fmt: skip


@dataclass(frozen=True)
class Fitted:
    """A candidate, or several, fitted to the residual of some blocks."""

    candidates: tuple[Candidate, ...]
    amounts: tuple[Array, ...]
    left: float
    """What is left over its noise, root mean square"""
    share: float
    """Share of the residual over its noise that is left, in the block with the largest share"""
    alone: str = ""
    """Words if the candidates act in some blocks alone"""

    @property
    def words(self) -> str:
        """Sentences of the candidates."""
        said = " and ".join(c.words(a) for c, a in zip(self.candidates, self.amounts, strict=True))
        return f"{said}{self.alone and ' '}{self.alone}"

    @property
    def nice(self) -> bool:
        """Whether all amounts are ones that a slip would give."""
        return all(c.nice(a) for c, a in zip(self.candidates, self.amounts, strict=True))

    @property
    def explains(self) -> bool:
        """Whether noise is all that is left."""
        return self.left <= AT_NOISE and self.share * GAIN <= 1.0


def ranked(found: Sequence[Fitted]) -> list[Fitted]:
    """Fits that leave noise alone, those that a slip would give first; then the others by what they leave."""
    return sorted(found, key=lambda f: (not f.explains, f.explains and not f.nice, 0.0 if f.explains else f.share))


class MotionSearch:
    """Candidates for a residual."""

    def __init__(self, residual: Residual) -> None:
        """Keep the residual; no candidate is made yet."""
        self.residual, self.balance, self.scene = residual, residual.balance, residual.scene

    @cached_property
    def candidates(self) -> list[Candidate]:
        """All candidates: terms, numbers of the scene, other scenes."""
        other = map(self.of_alternative, alternatives(self.scene))
        found = [*terms(self.balance), *map(self.of_number, numbers(self.scene)), *other]
        if self.scene.bars > 1:
            found += [self.of_reach(*each) for each in REACHES]
        if JOINTS in self.residual.wrong:
            found += of_reactions(self.balance)
        return found

    def of_alternative(self, a: Alternative) -> Candidate:
        """Candidate of another scene."""
        found = fixed(a.name, a.section, partial(self.of_scene, a.scene), a.words)
        return dataclasses.replace(found, scene=lambda _: a.scene)

    def of_number(self, n: Number) -> NumberCandidate:
        """Candidate of a number, linear about the right value."""
        return NumberCandidate(
            n.name, n.section, lambda: self.of_scene(n.change(n.probe)) / n.probe, lambda a: n.words(float(a[0])),
            nice=lambda a: n.nice(float(a[0])), scene=n.change, of=lambda a: self.of_scene(n.change(a)),
            probe=n.probe, range=n.range,
        )  # fmt: skip

    def of_reach(self, name: str, words: str, left: float, right: float) -> NumberCandidate:
        """Candidate of joints beside the bars' ends: reaches of 1/2 + amount, times `left` and `right`, in lengths."""

        def of(amount: float) -> Array:
            return self.of_scene(self.scene, (0.5 + left * amount, 0.5 + right * amount))

        return NumberCandidate(
            name, BODIES, lambda: of(REACH_PROBE) / REACH_PROBE,
            lambda a: f"the joints are {words.format(f'{0.5 + float(a[0]):.6g}')} of the length from the bars' centres",
            of=of, probe=REACH_PROBE, range=(-0.5, 0.5),
        )  # fmt: skip

    def of_scene(self, scene: Scene, reach: tuple[float, float] = ENDS) -> Array:
        """Rows (n - 1, c) that make the residual under another scene's equations; NaN where these fail.

        Lighter and shorter bars have smaller momenta, and would leave less: what they leave counts in the momenta of
        the right bars.
        """
        effects, own, right = scene.effects, self.scene.effects, self.balance
        same = (effects.solar_pressure, effects.drag) == (own.solar_pressure, own.drag)
        try:
            with np.errstate(all="ignore"):
                other = Balance(right.motion, scene, right.hidden if same else None, reach)
                value = other.value
        except (ValueError, ArithmeticError, np.linalg.LinAlgError):
            return np.full_like(right.value, np.nan)
        if other.width != right.width:
            return np.full_like(right.value, np.nan)
        scale = np.full(other.width, right.shape.whole / other.shape.whole)
        sizes = [b.shape.inertia + np.diag(b.shape.coupling) for b in (right, other)]
        scale[right.columns[BARS]] = sizes[0] / sizes[1]
        if LAWS in right.columns:
            scale[right.columns[LAWS]] = 1.0
        found: Array = right.value - np.maximum(scale, 1.0) * value
        return found

    @cached_property
    def best(self) -> list[Fitted]:
        """Fits of all wrong blocks, best first; of some blocks alone where nothing explains all."""
        wrong = self.residual.wrong
        every = self.fits(tuple(self.balance.columns))
        if any(f.explains for f in every):
            return every
        found = list(every)
        sets = [wrong, tuple(name for name in wrong if name != JOINTS)]
        for blocks in dict.fromkeys(s for s in sets if s and s != tuple(self.balance.columns)):
            found += [self.told_alone(f, blocks) for f in self.fits(blocks)]
            if any(f.explains for f in found):
                break
        return ranked(found)

    def fits(self, blocks: tuple[str, ...]) -> list[Fitted]:
        """Fits of single candidates and, where none explains the residual, of two."""
        problem = Problem(self, blocks)
        single = problem.singles
        if single and single[0].explains:
            return single
        pairs = [p for p in problem.pairs if p.explains and p.left * CLEARLY < single[0].left]
        return [*(pairs if len(pairs) <= MOST_PAIRS else ()), *single]

    def told_alone(self, f: Fitted, blocks: tuple[str, ...]) -> Fitted:
        """Fit with the words that its candidates act in some blocks alone, if they would show in others."""
        known, columns = self.residual.known, self.balance.columns
        effect = sum(c.rows[known] @ a for c, a in zip(f.candidates, f.amounts, strict=True))
        ratio = np.abs(effect / self.residual.noise[known])
        if all(float(np.sqrt(np.mean(ratio[:, c] ** 2))) <= AT_NOISE for n, c in columns.items() if n not in blocks):
            return f
        places = [ALONE[n] for n in blocks if n in self.residual.wrong]
        return dataclasses.replace(f, alone=f"{' and '.join(places)} alone")


@dataclass(frozen=True)
class NumberCandidate(Candidate):
    """A number of the scene."""

    of: Callable[[float], Array] = field(kw_only=True)
    """Rows (n - 1, c) of an amount"""
    probe: float = field(kw_only=True)
    """Amount that is small enough for a linear effect"""
    range: tuple[float, float] = field(kw_only=True)
    """Least and largest amount"""

    def possible(self, amount: float) -> bool:
        """Whether the number can be wrong by an amount."""
        return self.range[0] <= amount <= self.range[1]

    def linear(self, amount: float) -> bool:
        """Whether the effect of an amount is linear: of masses and lengths, of small amounts alone."""
        return self.possible(amount) and (self.section != BODIES or abs(amount) <= SMALL)


class Problem:
    """Least-squares problem of the residual in some blocks, weighted by its noise."""

    def __init__(self, search: MotionSearch, blocks: tuple[str, ...]) -> None:
        """Weigh the residual."""
        self.search, residual = search, search.residual
        columns = residual.balance.columns
        self.known = residual.known
        self.columns = np.concatenate([np.arange(columns[name].start, columns[name].stop) for name in blocks])
        self.value, self.noise = (x[self.known][:, self.columns] for x in (residual.value, residual.noise))
        self.parts = [
            np.isin(self.columns, np.arange(columns[n].start, columns[n].stop)) for n in blocks if n in residual.wrong
        ]
        least = np.zeros(len(self.columns))
        for part in self.parts:
            least[part] = FLOOR * np.sqrt(np.mean(self.value[:, part] ** 2))
        self.weight = 1.0 / np.hypot(self.noise, least)
        self.right = (self.value * self.weight).ravel()

    def vectors(self, rows: Array) -> Array:
        """Weighted rows (n - 1, c, m) as (k, m)."""
        found: Array = (rows[self.known][:, self.columns] * self.weight[..., None]).reshape(len(self.right), -1)
        return found

    @cached_property
    def linear(self) -> list[tuple[Candidate, Array]]:
        """Candidates that have an effect, with it."""
        made = ((c, self.vectors(c.rows)) for c in self.search.candidates)
        return [(c, x) for c, x in made if np.isfinite(x).all() and x.any()]

    def fitted(self, candidates: tuple[Candidate, ...], amounts: tuple[Array, ...], rest: Array) -> Fitted:
        """Fit that leaves a weighted rest (k,)."""
        weighted, whole = rest.reshape(self.value.shape), self.value * self.weight
        left = float(np.sqrt(np.mean((weighted / self.weight / self.noise) ** 2)))
        shares = [np.linalg.norm(weighted[:, p]) / np.linalg.norm(whole[:, p]) for p in self.parts]
        return Fitted(candidates, amounts, left, float(max(shares, default=1.0)))

    def single(self, c: Candidate, x: Array) -> Fitted:
        """Fit of one candidate."""
        a = np.ones(1) if c.fixed else amounts_of(x, self.right)
        if isinstance(c, NumberCandidate) and not c.possible(float(a[0])):
            return Fitted((c,), (a,), math.inf, 1.0)
        return self.fitted((c,), (a,), self.right - x @ a)

    @cached_property
    def singles(self) -> list[Fitted]:
        """Fits of single candidates, best first; the best numbers beyond their linear effect."""
        found = sorted((self.single(c, x) for c, x in self.linear), key=lambda f: f.share)
        numbers = [f for f in found if isinstance(f.candidates[0], NumberCandidate)][:REFINED]
        refined = {id(f): self.refined(f) for f in numbers}
        return ranked([refined.get(id(f), f) for f in found])

    def refined(self, f: Fitted) -> Fitted:
        """Number fitted beyond its linear effect, by Gauss and Newton."""
        c, a = f.candidates[0], float(f.amounts[0][0])
        assert isinstance(c, NumberCandidate)
        best = dataclasses.replace(f, left=math.inf, share=1.0)
        for _ in range(ROUNDS):
            if not c.possible(a):
                break
            here, there = (self.vectors(c.of(v)[..., None])[:, 0] for v in (a, a + c.probe))
            rest = self.right - here
            if not np.isfinite(rest).all() or not np.isfinite(there).all():
                break
            now = self.fitted((c,), (np.array([a]),), rest)
            if not now.left < best.left:
                break
            best, done = now, now.left > 0.9 * best.left
            step = float(amounts_of(((there - here) / c.probe)[:, None], rest)[0])
            if done or abs(step) < 1e-13 * max(abs(a), 1e-3):
                break
            a += step
        return best

    @cached_property
    def pairs(self) -> list[Fitted]:
        """Fits of two candidates, best first."""
        one = [(c, x[:, 0]) for c, x in self.linear if x.shape[1] == 1]
        if len(one) < 2:
            return []
        x = np.stack([v / np.linalg.norm(v) for _, v in one], axis=1)
        gram, dots = x.T @ x, x.T @ self.right
        apart = 1.0 - gram**2
        with np.errstate(divide="ignore", invalid="ignore"):
            gain = (dots[:, None] ** 2 - 2.0 * gram * np.outer(dots, dots) + dots[None] ** 2) / apart
        gain[apart < PARALLEL] = -1.0
        upper = np.triu_indices(len(one), 1)
        found = []
        for k in np.argsort(gain[upper])[::-1][:PAIRS]:
            (ci, xi), (cj, xj) = one[upper[0][k]], one[upper[1][k]]
            ai, aj = pair_amounts(xi, xj, self.right, ci.fixed, cj.fixed)
            if not all(c.linear(a) for c, a in ((ci, ai), (cj, aj)) if isinstance(c, NumberCandidate)):
                continue
            found.append(self.fitted((ci, cj), (np.array([ai]), np.array([aj])), self.right - ai * xi - aj * xj))
        return ranked(found)


def pair_amounts(x: Array, y: Array, r: Array, x_fixed: bool, y_fixed: bool) -> tuple[float, float]:
    """Amounts of two effects; 1 where they are fixed."""
    if x_fixed and y_fixed:
        return 1.0, 1.0
    if x_fixed:
        return 1.0, float(amounts_of(y[:, None], r - x)[0])
    if y_fixed:
        return float(amounts_of(x[:, None], r - y)[0]), 1.0
    a = amounts_of(np.stack([x, y], axis=1), r)
    return float(a[0]), float(a[1])


def amounts_of(x: Array, r: Array) -> Array:
    """Amounts (m,) of least squares."""
    found: Array = np.asarray(np.linalg.lstsq(x, r, rcond=None)[0], float)
    return found
