"""Search for the changes of the right equations that explain the residual of an engine's own motion."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property, partial
from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from barchain.judge.diagnosis.mistake import Explanation, Fit, Left, Mistake
from barchain.judge.diagnosis.motion.balance import BARS, CENTRE, JOINTS, LAWS, Balance
from barchain.judge.diagnosis.motion.candidate import Candidate, Candidates, linearised
from barchain.judge.diagnosis.motion.changed_loads import with_effects
from barchain.judge.diagnosis.motion.numbers import numbers
from barchain.judge.diagnosis.motion.others import others
from barchain.judge.diagnosis.motion.terms import of_reactions, terms
from barchain.judge.diagnosis.motion.words import BODIES, LOADS
from barchain.judge.equations import ENDS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from adapters.trajectory import Array
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
MOST_UNKNOWN = 0.1
"""Largest share of the rows that may be unknown in the scene of a fitted number"""
ROUNDS = 6
"""Rounds of such a fit"""
PAIRS = 40
"""Pairs that are fitted exactly, the best of all by their linear effects"""
MOST_PAIRS = 8
"""Pairs that leave noise alone, of which more say nothing"""
REACH_PROBE = 1e-5
"""Distance of a joint from its place, in lengths, that is small enough for a linear effect"""
REACHES = (
    ("joints-shifted", "at {} to the right, and so much less to the left,", -1.0, 1.0),
    ("right-joints-shifted", "at {} to the right", 0.0, 1.0),
    ("left-joints-shifted", "at {} to the left", 1.0, 0.0),
)
"""Places of the joints: name, words, and how an amount moves the left and the right one of each bar"""
SLIPS = (-1.0, -2.0, -0.5, 1.0)
"""Changes of a factor by a term that is missing, has the opposite sign, is halved, is doubled"""
UNCERTAIN = 2.0
"""Times the share of the residual that is left by which a fitted amount may be off"""
PARALLEL = 1e-8
"""Squared sine of the angle between two effects below which they are one"""
ALONE = {CENTRE: "in the motion of the centre of mass", BARS: "in the rotation of the bars",
         JOINTS: "in the reactions", LAWS: "in the prescribed angles"}  # fmt: skip


@dataclass(frozen=True)
class Fitted:
    """A candidate, or several, fitted to the residual of some blocks."""

    candidates: tuple[Candidate, ...]
    amounts: tuple[Array, ...]
    left: float = math.inf
    """What is left over its noise, root mean square"""
    share: float = 1.0
    """Share of the residual over its noise that is left, in the block with the largest share"""
    blocks: tuple[str, ...] = ()
    """Blocks of the residual that the candidates are fitted to"""
    alone: str = ""
    """Words if the candidates act in some blocks alone"""
    held: int = 0
    """Independent numbers in the residual"""

    @property
    def tells(self) -> bool:
        """Whether the residual holds more numbers than are fitted, or a slip gives these.

        An impulse leaves two numbers in the centre of mass: a size and a direction fit it, whatever is wrong.
        """
        fitted = sum(len(a) for c, a in zip(self.candidates, self.amounts, strict=True) if not c.fixed)
        return fitted < self.held or self.nice

    @property
    def explains(self) -> bool:
        """Whether noise is all that is left."""
        return self.left <= AT_NOISE and self.share * GAIN <= 1.0 and self.tells

    @property
    def order(self) -> tuple[bool, bool, bool, float]:
        """Key by which fits are sorted: those that leave noise, nice ones and other scenes first; then the rest."""
        of_scene = all(c.scene is not None for c in self.candidates)
        if not self.explains:
            return True, False, False, self.share if self.tells else 1.0
        return False, not self.nice, not of_scene, 0.0

    @property
    def nice(self) -> bool:
        """Whether all amounts are ones that a slip would give."""
        return all(c.nice(a) for c, a in zip(self.candidates, self.amounts, strict=True))

    @property
    def scene(self) -> Scene | None:
        """Scene whose right motion a single candidate is; None of a change that no scene has."""
        of = self.candidates[0].scene
        return of(float(self.amounts[0][0])) if of is not None and len(self.candidates) == 1 else None

    @property
    def explanation(self) -> Explanation:
        """The candidates as mistakes; amounts have the digits that the share that is left determines."""
        pairs = zip(self.candidates, self.amounts, strict=True)
        amounts = [a if c.nice(a) else slip_near(c, a, self.share) for c, a in pairs]
        said = [c.words(a) for c, a in zip(self.candidates, amounts, strict=True)]
        said[-1] += f" {self.alone}" if self.alone else ""
        mistakes = (Mistake(c.name, words, c.section) for c, words in zip(self.candidates, said, strict=True))
        left = Left(self.left / AT_NOISE, self.left / AT_NOISE, self.share)
        return Explanation(tuple(mistakes), Fit(motion=left))


def slip_near(candidate: Candidate, amounts: Array, share: float) -> Array:
    """Amounts that a slip would give, if the share that is left does not tell them from the fitted ones."""
    for slip in SLIPS:
        near = len(amounts) == 1 and abs(float(amounts[0]) - slip) <= UNCERTAIN * share * abs(slip)
        if near and candidate.nice(np.array([slip])):
            return np.array([slip])
    return determined(amounts, share)


def determined(amounts: Array, share: float) -> Array:
    """Amounts with the digits that a fit determines which leaves a share of the residual."""
    uncertain = (share * abs(a) for a in amounts.tolist())
    decimals = (-math.floor(math.log10(each)) if each > 0.0 else 0 for each in uncertain)
    return np.array([round(a, digits) for a, digits in zip(amounts.tolist(), decimals, strict=True)])


class MotionSearch:
    """Candidates for a residual."""

    def __init__(self, residual: Residual) -> None:
        """Keep the residual; no candidate is made yet."""
        self.residual, self.balance, self.scene = residual, residual.balance, residual.scene

    @cached_property
    def candidates(self) -> list[Candidate]:
        """All candidates: terms, numbers of the scene, other scenes, places of the joints."""
        found = Candidates(self.balance)
        found.found += terms(self.balance)
        for n in numbers(self.scene):
            of = partial(self.of_change, n.change)
            found.found.append(linearised(n.name, n.section, of, n.words, n.probe, n.range, n))
        for name, words, section, scene in others(self.scene):
            found.fixed(name, words, section, partial(self.of_scene, scene), scene)
        for name, words, left, right in REACHES if self.scene.bars > 1 else ():
            of, said = partial(self.of_reach, left, right), partial(reach_words, words)
            found.found.append(linearised(name, BODIES, of, said, REACH_PROBE, (-0.5, 0.5)))
        found.found += self.of_light()
        return [*found.found, *(of_reactions(self.balance) if JOINTS in self.residual.wrong else ())]

    def of_light(self) -> list[Candidate]:
        """Absorbed and reflected sunlight, each alone: the force is linear in the reflectivity."""
        light, found = self.scene.effects.solar_pressure, Candidates(self.balance)
        if light is None:
            return []
        for kind, share, reflectivity in (
            ("absorbed", 1.0 - light.reflectivity, 0.0),
            ("reflected", light.reflectivity, 1.0),
        ):
            lit = with_effects(self.scene, solar_pressure=dataclasses.replace(light, reflectivity=reflectivity))
            if share:
                found.times(f"sunlight-{kind}", f"the {kind} sunlight is", LOADS, partial(self.times_light, share, lit))
        return found.found

    def times_light(self, share: float, lit: Scene) -> Array:
        """Rows of a share of the light in another scene."""
        return share * (self.of_scene(lit) - self.of_scene(with_effects(self.scene, solar_pressure=None)))

    def of_change(self, change: Callable[[float], Scene], amount: float) -> Array:
        """Rows of another scene by an amount."""
        return self.of_scene(change(amount))

    def of_reach(self, left: float, right: float, amount: float) -> Array:
        """Rows of joints beside the bars' ends: reaches of 1/2 + amount, times `left` and `right`, in lengths."""
        return self.of_scene(self.scene, (0.5 + left * amount, 0.5 + right * amount))

    def of_scene(self, scene: Scene, reach: tuple[float, float] = ENDS) -> Array:
        """Rows (n - 1, c) that make the residual under another scene's equations; NaN where these fail.

        Lighter and shorter bars have smaller momenta, and would leave less: what they leave counts in the momenta of
        the right bars.
        """
        effects, own, right = scene.effects, self.scene.effects, self.balance
        same = (effects.solar_pressure, effects.drag) == (own.solar_pressure, own.drag)
        same &= scene.central_body.radius_m == self.scene.central_body.radius_m  # that of the shadow
        try:
            with np.errstate(all="ignore"):
                other = Balance(right.motion, scene, right.hidden if same else None, reach, right)
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
        wrong, whole = self.residual.wrong, tuple(self.balance.columns)
        found = self.fits(whole)
        for blocks in dict.fromkeys((wrong, tuple(name for name in wrong if name != JOINTS))):
            if any(f.explains for f in found):
                break
            if blocks and blocks != whole:
                found = sorted(
                    [*found, *(self.told_alone(f, blocks) for f in self.fits(blocks))], key=attrgetter("order")
                )
        return found

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
        if all(float(np.sqrt(np.nanmean(ratio[:, c] ** 2))) <= AT_NOISE for n, c in columns.items() if n not in blocks):
            return f
        places = [ALONE[n] for n in blocks if n in self.residual.wrong]
        return dataclasses.replace(f, alone=f"{' and '.join(places)} alone")


def reach_words(words: str, amount: float) -> str:
    """Sentence on joints beside the bars' ends."""
    return f"the joints are {words.format(f'{0.5 + amount:.6g}')} of the length from the bars' centres"


class Problem:
    """Least-squares problem of the residual in some blocks, weighted by its noise."""

    def __init__(self, search: MotionSearch, blocks: tuple[str, ...]) -> None:
        """Weigh the residual."""
        residual = search.residual
        balance = residual.balance
        self.known = residual.known
        self.blocks = blocks
        self.columns = balance.of_blocks(blocks)
        self.value, self.noise = (x[self.known][:, self.columns] for x in (residual.value, residual.noise))
        self.held = self.numbers_held(balance)
        self.parts = [np.isin(self.columns, balance.of_blocks([n])) for n in blocks if n in residual.wrong]
        least = np.zeros(len(self.columns))
        for part in self.parts:
            least[part] = FLOOR * np.sqrt(np.mean(self.value[:, part] ** 2))
        self.weight = 1.0 / np.hypot(self.noise, least)
        self.right = (self.value * self.weight).ravel()
        made = ((c, self.vectors(c.rows)) for c in search.candidates)
        self.effects = [(c, x) for c, x in made if self.says_enough(c, x)]
        """Candidates that have an effect, with it; of fixed ones, NaN in intervals of which they say nothing"""

    def numbers_held(self, balance: Balance) -> int:
        """Independent numbers in the residual: of the intervals that a fit has to meet, less what motors may give.

        Of intervals with less than what a believed fit may leave, any fit is good enough.
        """
        size = np.abs(self.value / self.noise).max(axis=1, initial=0.0)
        met = size > max(AT_NOISE, float(size.max(initial=0.0)) / GAIN)
        struck = np.isin(np.flatnonzero(self.known)[met], [k for k, _ in balance.impulses]) | balance.torques_unknown
        by_motors = balance.motors.shape[1] if BARS in self.blocks else 0
        return int(np.count_nonzero(met)) * len(self.columns) - int(np.count_nonzero(struck)) * by_motors

    @staticmethod
    def says_enough(c: Candidate, x: Array) -> bool:
        """Whether a candidate has an effect (k, m), known everywhere; of a fixed one, in most intervals."""
        unknown = int(np.count_nonzero(~np.isfinite(x)))
        return unknown <= (MOST_UNKNOWN * x.size if c.fixed else 0) and bool(np.nan_to_num(x).any())

    def vectors(self, rows: Array) -> Array:
        """Weighted rows (n - 1, c, m) as (k, m)."""
        found: Array = (rows[self.known][:, self.columns] * self.weight[..., None]).reshape(len(self.right), -1)
        return found

    def fitted(self, candidates: Sequence[Candidate], amounts: Sequence[Array], rest: Array) -> Fitted:
        """Fit that leaves a weighted rest (k,); NaN where the candidates say nothing."""
        weighted = rest.reshape(self.value.shape)
        clear = np.isfinite(weighted).all(axis=1)
        weighted, whole = weighted[clear], (self.value * self.weight)[clear]
        left = float(np.sqrt(np.mean((weighted / self.weight[clear] / self.noise[clear]) ** 2)))
        seen = [p for p in self.parts if clear.all() or np.sqrt(np.mean(whole[:, p] ** 2)) > AT_NOISE]
        shares = [np.linalg.norm(weighted[:, p]) / np.linalg.norm(whole[:, p]) for p in seen]
        share = float(max(shares, default=1.0))
        return Fitted(tuple(candidates), tuple(amounts), left, share, self.blocks, held=self.held)

    def linear_fit(self, effects: Sequence[tuple[Candidate, Array]]) -> Fitted:
        """Fit of candidates by their linear effects: amounts of least squares, 1 where they are fixed."""
        free = [x for c, x in effects if not c.fixed]
        rest = self.right - sum((x[:, 0] for c, x in effects if c.fixed), np.zeros(len(self.right)))
        found = iter(least_squares(np.concatenate(free, axis=1), rest).tolist() if free else ())
        amounts = [np.ones(1) if c.fixed else np.array([next(found) for _ in range(x.shape[1])]) for c, x in effects]
        left = self.right - sum(x @ a for (_, x), a in zip(effects, amounts, strict=True))
        return self.fitted([c for c, _ in effects], amounts, left)

    @cached_property
    def singles(self) -> list[Fitted]:
        """Fits of single candidates, best first; the best numbers beyond their linear effect."""
        found = [f if f.candidates[0].possible(f.amounts[0]) else dataclasses.replace(f, left=math.inf, share=1.0)
                 for f in (self.linear_fit([each]) for each in self.effects)]  # fmt: skip
        found.sort(key=lambda f: f.share)
        numbers = [f for f in found if f.candidates[0].of is not None][:REFINED]
        refined = {id(f): self.refined(f) for f in numbers}
        return sorted((refined.get(id(f), f) for f in found), key=attrgetter("order"))

    def refined(self, f: Fitted) -> Fitted:
        """Number fitted beyond its linear effect, by Gauss and Newton."""
        c, a = f.candidates[0], float(f.amounts[0][0])
        assert c.of is not None
        best = Fitted(f.candidates, f.amounts)
        for _ in range(ROUNDS):
            if not c.possible(np.array([a])):
                break
            here, there = (self.vectors(c.of(v)[..., None])[:, 0] for v in (a, a + c.probe))
            clear = np.isfinite(here) & np.isfinite(there)  # a bar may turn its face elsewhere in the other scene
            if np.count_nonzero(~clear) > MOST_UNKNOWN * len(clear):
                break
            rest = np.where(clear, self.right - here, 0.0)
            now = self.fitted((c,), (np.array([a]),), rest)
            if not now.left < best.left:
                break
            best, done = now, now.left > 0.9 * best.left
            slope = np.where(clear, there - here, 0.0) / c.probe
            step = float(least_squares(slope[:, None], rest)[0])
            if done or abs(step) < 1e-13 * max(abs(a), 1e-3):
                break
            a += step
        return best

    @cached_property
    def pairs(self) -> list[Fitted]:
        """Fits of two candidates, best first."""
        one = [(c, x) for c, x in self.effects if x.shape[1] == 1 and np.isfinite(x).all()]
        if len(one) < 2:
            return []
        fixed, size = np.array([c.fixed for c, _ in one]), np.array([np.linalg.norm(v) for _, v in one])
        x = np.concatenate([v / np.linalg.norm(v) for _, v in one], axis=1)
        gram, dots = x.T @ x, x.T @ self.right
        apart = 1.0 - gram**2
        with np.errstate(divide="ignore", invalid="ignore"):
            gain = (dots[:, None] ** 2 - 2.0 * gram * np.outer(dots, dots) + dots[None] ** 2) / apart
            # a fixed one takes its own part, and the free one what it can of the rest
            of_fixed = 2.0 * size * dots - size**2
            after = of_fixed[:, None] + (dots[None] - gram * size[:, None]) ** 2
        gain = np.where(fixed[:, None] & ~fixed, after, np.where(~fixed[:, None] & fixed, after.T, gain))
        both = of_fixed[:, None] + of_fixed - 2.0 * gram * np.outer(size, size)
        gain = np.where(fixed[:, None] & fixed, both, gain)
        gain[apart < PARALLEL] = -np.inf
        upper = np.triu_indices(len(one), 1)
        best = np.argsort(gain[upper])[::-1][: 2 * PAIRS]
        pairs = [(one[upper[0][k]], one[upper[1][k]]) for k in best]
        found = (self.linear_fit(pair) for pair in [p for p in pairs if not is_part(p[0][0], p[1][0])][:PAIRS])
        linear = (f for f in found if all(map(Candidate.linear, f.candidates, f.amounts)))
        return sorted(linear, key=attrgetter("order"))


def is_part(a: Candidate, b: Candidate) -> bool:
    """Whether one candidate is a part of the other: factors of both would be no factors of the right value."""
    short, long = sorted((a.name, b.name), key=len)
    of_sum = any(n.startswith("sum-of-all-thrusts") for n in (short, long))
    return long.startswith(f"{short}-") or (of_sum and "thrust" in short and "thrust" in long)


def least_squares(x: Array, r: Array) -> Array:
    """Amounts (m,) of least squares."""
    found: Array = np.asarray(np.linalg.lstsq(x, r, rcond=None)[0], float)
    return found
