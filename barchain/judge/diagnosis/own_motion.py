"""An engine's own motion: rerun with dense samples where that is possible, and what its equations have wrong."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import make_interp_spline

from adapters.common.reference_model import chain_model
from barchain.judge.diagnosis.mistake import Explanation, Fit, Left
from barchain.judge.diagnosis.motion.balance import FEWEST, JOINTS, motion_of
from barchain.judge.diagnosis.motion.quadrature import SAME_INSTANT
from barchain.judge.diagnosis.motion.residual import Residual
from barchain.judge.diagnosis.motion.search import GAIN, MotionSearch
from barchain.judge.diagnosis.starts import starts
from barchain.metrics.quantities import arrays, differences
from reference_impl.model.kinematics import consistent_state
from reference_impl.model.relative import accelerations
from scenarios.scene import RunAt

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.diagnosis.motion.search import Fitted
    from scenarios import Scene

    OwnRuns = Callable[[Scene, Scene], tuple[Trajectory | None, Trajectory | None]]

DENSER = 6
"""Intervals of dense samples in each interval of a comparison, in which a bar turns half a radian at most"""
MOST_TURN_RAD = 0.15
"""Largest turn of a bar between dense samples, where an engine turns it faster than the scene does"""
MOST_SAMPLES = 2401
"""Samples of a dense run: more take longer than they tell"""
LIKELY = " Most likely:"
"""Beginning of the sentence on a candidate that leaves little, and yet more than the engine's own noise"""
NOTHING_NEAR = 0.1
"""Share of the residual that the nearest candidate leaves, from which on it says nothing"""
MOST_SPIKE = 100.0
"""Largest residual of an interval over the median one that scatter leaves"""
LEAST_JUMPS = 0.5
"""Least mean change of a residual from interval to interval over its mean size without a pattern: of noise it is 1.4"""
MOST_CHANGED = 0.5
"""Largest change of a fitted number, relative to it, that is believed beside a second mistake, if no slip gives it"""
SPLINE = 9
"""Degree of the splines that give rates by angles"""


def densely(scene: Scene, given: Trajectory) -> tuple[Scene, Scene]:
    """Scene with samples that are dense enough for integrals of a given motion, and one with twice as many.

    A method of equal steps makes two steps between samples at least: with twice the samples its error is another one.
    """
    intervals = scene.run.samples - 1
    turn_rad = 0.0 if given.rate_rad_s is None else float(np.abs(given.rate_rad_s).max()) * scene.run.duration_s
    wanted = turn_rad / (intervals * MOST_TURN_RAD)
    needed = math.ceil(wanted) if wanted < MOST_SAMPLES else MOST_SAMPLES
    times = max(1, min(max(DENSER, needed), (MOST_SAMPLES - 1) // intervals))
    runs = (dataclasses.replace(scene.run, samples=k * times * intervals + 1) for k in (1, 2))
    one, two = (dataclasses.replace(scene, run=run) for run in runs)
    return one, two


@dataclass(frozen=True)
class MadeRuns:
    """Dense runs that are there already, at the judged setting and, with twice the samples, at the next finer one."""

    main: Trajectory | None
    finer: Trajectory | None

    def __call__(self, *_: Scene) -> tuple[Trajectory | None, Trajectory | None]:
        """Return both runs."""
        return self.main, self.finer


class OwnMotion:
    """An engine's own motion in a scene; each part is computed once."""

    def __init__(
        self, scene: Scene, given: Trajectory, runs: OwnRuns | None, other: Trajectory | None = None, first: int = 0,
        *, starts_right: bool = False,
    ) -> None:  # fmt: skip
        """Keep the arguments; without `runs`, the given samples have to do, and an `other` run of them shows noise.

        Samples before the `first` are not the engine's: the scene's start, where a file has none. With `starts_right`
        the first sample is that start, as far as its digits tell.
        """
        self.starts_right = starts_right
        self.given_scene, self.given, self.runs, self.other, self.first = scene, given, runs, other, first

    @cached_property
    def dense(self) -> tuple[Scene, Trajectory, Trajectory | None]:
        """Scene of the samples, the finest run, and another run of the same samples."""
        if self.runs is not None:
            scene, twice = densely(self.given_scene, self.given)
            main, finer = self.runs(scene, twice)
            finer = None if finer is None else finer.samples(slice(None, None, 2))
            made = [t for t in (finer, main) if t is not None and finite(t)]
            n = min((at_instants(t, scene) for t in made), default=0)
            if n >= FEWEST:
                best, *other = (t.samples(slice(n)) for t in made)
                return first_samples(scene, n), best, other[0] if other else None
        return self.given_scene, self.given.samples(slice(self.first, None)), self.other

    def apart(self, quantity: str) -> float:
        """Largest difference of two runs of the engine, at its setting and at the next finer one; infinite without."""
        _, best, other = self.dense
        found = {} if other is None else differences(best, other)
        return float(found[quantity].max(initial=0.0)) if quantity in found else math.inf

    def repaired(self) -> Iterator[OwnMotion]:
        """The same motion at the given samples, made consistent in each way that there is."""
        _, best, other = self.dense
        every = round(float(self.given.t_s[1] - self.given.t_s[0]) / float(best.t_s[1] - best.t_s[0]))
        coarse = None if other is None else repaired(best.samples(slice(None, None, every)))
        for k, motion in enumerate(repaired(self.given)):
            other_run = coarse[k] if coarse else None
            yield OwnMotion(self.given_scene, motion, None, other_run, self.first, starts_right=self.starts_right)

    @cached_property
    def residual(self) -> Residual | None:
        """Residual of the motion; None where rates are no derivatives of angles, or too few samples are there."""
        scene, best, other = self.dense
        motion = motion_of(best)
        if motion is None:
            return None
        found = Residual(motion, scene, None if other is None else motion_of(other))
        return found if found.consistent else None

    @cached_property
    def search(self) -> MotionSearch | None:
        """Search for what is wrong in the equations; None where nothing is, or nothing is known."""
        r = self.residual
        if r is None or not r.wrong or r.clock_wrong:
            return None
        return MotionSearch(r)

    @cached_property
    def fits(self) -> list[Fitted]:
        """Fits of the residual, best first."""
        return [self.whole(f) for f in self.search.best] if self.search is not None else []

    def whole(self, f: Fitted) -> Fitted:
        """Fit of the motion that does not name blocks if the reactions belong to its scene, too.

        Their sums over intervals may tell less than they do at the samples.
        """
        reactions = self.given.reaction_N
        if not f.explains or not f.alone or f.scene is None or reactions is None or not reactions.size:
            return f
        scenes = (dataclasses.replace(scene, run=self.given_scene.run) for scene in (f.scene, self.given_scene))
        here, right = (differences(self.given, with_right_reactions(s, self.given))["reaction"] for s in scenes)
        return dataclasses.replace(f, alone="") if GAIN * here.max() <= right.max() else f

    @property
    def explaining(self) -> list[Explanation]:
        """Explanations of the residual."""
        return [f.explanation for f in self.fits if f.explains]

    def explaining_from(self, starts: Callable[[Scene], bool]) -> list[Explanation]:
        """Explanations of the residual; where the scene does not explain the start, those by a scene that does."""
        if starts(self.given_scene):
            return self.explaining
        return [f.explanation for f in self.fits if f.explains and f.scene is not None and starts(f.scene)]

    @cached_property
    def starts(self) -> list[Explanation]:
        """Explanations by another start, from which the motion obeys the right equations."""
        found = [] if self.starts_right else starts(self.given, self.given_scene)
        if not found or self.residual is None or not self.residual.moves_right:
            return []
        return [Explanation((m,), Fit(start=Left(0.0, 0.0, 0.0))) for m in found]

    @cached_property
    def moves_as(self) -> list[tuple[Explanation, Scene]]:
        """Explanations of the motion by other scenes, where the reactions do not belong to the motion."""
        found = []
        for f in self.fits:
            believed = f.nice or float(np.abs(f.amounts[0]).max()) <= MOST_CHANGED
            if f.explains and f.alone and f.scene is not None and believed:
                other = dataclasses.replace(f.scene, run=self.given_scene.run)
                found.append((dataclasses.replace(f, alone="").explanation, other))
        if self.starts and self.residual is not None and JOINTS in self.residual.wrong:
            found += [(e, self.given_scene) for e in self.starts]
        return found

    @cached_property
    def scatters(self) -> bool:
        """Whether the residual is without a pattern along the samples, as rounding leaves it; unknown: true."""
        r = self.residual
        if r is None or not r.wrong:
            return True
        values = r.value[r.known][:, r.balance.of_blocks(r.wrong)]
        size = np.median(np.abs(values), axis=0)
        few = np.abs(values).max(axis=0) > MOST_SPIKE * size  # a missed event is in one interval
        smooth = np.abs(np.diff(values, axis=0)).mean(axis=0) < LEAST_JUMPS * np.abs(values).mean(axis=0)
        return not bool(np.any((few | smooth) & (size > 0.0)))

    @property
    def nearest(self) -> str:
        """Where the residual sits, and the nearest candidate; empty without a residual."""
        said = self.departure
        if said and self.search is not None and self.fits and self.fits[0].nice and self.fits[0].share < NOTHING_NEAR:
            share, near = self.fits[0].share, LIKELY if self.fits[0].share * GAIN <= 1.0 else " Nearest:"
            said += f"{near} {self.fits[0].explanation.words} (leaves {100.0 * share:.2g}% of that)."
        return said

    @property
    def departure(self) -> str:
        """Where and from when on a residual sits, and of which effect; empty without a residual."""
        r = self.residual
        if r is None:
            return ""
        if not r.wrong or r.clock_wrong:
            return r.apart_words
        begun = f", from t = {r.begin_s:.4g} s on" if r.begin_s > 0.0 else ""
        said = f" Against the right equations at its own states, the motion has {r.place} too much{begun}."
        effects = [name for name in self.given_scene.effects.names if name.partition(".")[0] != "gravity"]
        alone = (
            f" The scene's only effect beside gravity is {effects[0].replace('_', ' ')}." if len(effects) == 1 else ""
        )
        return f"{said}{alone}"


def at_instants(t: Trajectory, scene: Scene) -> int:
    """Number of first samples that are at a scene's instants: a wrong engine may land, and end between two of them."""
    n = min(len(t.t_s), scene.run.samples)
    return int(np.cumprod(np.isclose(t.t_s[:n], scene.times_s[:n], rtol=SAME_INSTANT)).sum())


def first_samples(scene: Scene, samples: int) -> Scene:
    """Scene with its first samples alone."""
    if samples == scene.run.samples:
        return scene
    instants_s = scene.times_s[:samples].tolist()
    return dataclasses.replace(scene, run=RunAt(instants_s[-1], samples, tuple(instants_s)))


def finite(t: Trajectory) -> bool:
    """Whether the values that a balance needs are numbers."""
    return all(bool(np.isfinite(v).all()) for v in arrays(t).values())


def with_right_reactions(scene: Scene, t: Trajectory) -> Trajectory:
    """A motion with the reactions and torques that belong to its states under the right equations."""
    assert t.angle_rad is not None
    assert t.rate_rad_s is not None
    model = chain_model(scene)
    solved = [
        accelerations(model, float(at), consistent_state(model, *state))
        for at, *state in zip(t.t_s, t.com_m, t.com_velocity_m_s, t.angle_rad, t.rate_rad_s, strict=True)
    ]
    reaction = None if t.reaction_N is None else np.array([a.reaction_N for a in solved])
    torque = None if t.torque_N_m is None else np.array([a.torque_N_m for a in solved])
    return t.replace(reaction_N=reaction, torque_N_m=torque)


def repaired(t: Trajectory) -> list[Trajectory]:
    """The same motion with rates by its angles, with angles by its rates, and with velocities by its positions."""
    if t.angle_rad is None or t.rate_rad_s is None or len(t.t_s) <= SPLINE:
        return []
    slope: Array = make_interp_spline(t.t_s, t.angle_rad, SPLINE).derivative()(t.t_s)
    turned: Array = make_interp_spline(t.t_s, t.rate_rad_s, SPLINE).antiderivative()(t.t_s)
    drift: Array = make_interp_spline(t.t_s, t.com_m, SPLINE).derivative()(t.t_s)
    return [
        t.replace(rate_rad_s=slope),
        t.replace(angle_rad=t.angle_rad[0] + turned - turned[0]),
        t.replace(com_velocity_m_s=drift),
    ]
