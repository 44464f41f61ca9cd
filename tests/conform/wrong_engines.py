"""The compiled reference with one mistake each, as another package would bring it."""

from __future__ import annotations

import dataclasses
import math
import os
import random
import signal
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine, EngineError, Setting
from adapters.reference.compiled_engine import ReferenceFast
from adapters.trajectory import Observable

if TYPE_CHECKING:
    from collections.abc import Callable

    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene

RTOL = AccuracyParameter.RTOL


class Right(ReferenceFast):
    """No mistake."""


def reading(change: Callable[[Any], Trajectory]) -> type[ReferenceFast]:
    """Engine whose trajectory is changed."""

    class Changed(ReferenceFast):
        def read(self) -> Trajectory:
            return change(super().read())

    return Changed


def declaring(**declared: Any) -> type[ReferenceFast]:
    """Engine with other declarations."""
    return type("Declaring", (ReferenceFast,), declared)


def with_noise(**size: float) -> classmethod[Any, Any, dict[str, float]]:
    """Declaration of noise that is the same in all scenes."""
    return classmethod(lambda cls, scene, setting, t_s: size)


def single(values: Array) -> Array:
    """Values as single precision leaves them, in double precision."""
    return values.astype(np.float32).astype(float)


ReactionsReversed = reading(lambda t: t.replace(reaction_N=-t.reaction_N))
"""Forces on the other bar"""
Degrees = reading(lambda t: t.replace(angle_rad=np.degrees(t.angle_rad)))
SinglePrecision = reading(lambda t: t.replace(angle_rad=t.angle_rad.astype(np.float32)))
SingleInside = reading(lambda t: t.replace(rate_rad_s=single(t.rate_rad_s)))
"""Rates that were computed in single precision and are given in double"""
SingleState = reading(lambda t: t.replace(reaction_N=single(t.reaction_N) * (1.0 + 1e-12)))
"""Errors of single precision in every quantity, kept in double precision"""
OtherTurns = reading(lambda t: t.replace(angle_rad=t.angle_rad + 2.0 * np.pi))
"""Angles that begin a turn later"""
RoundedAngles = reading(lambda t: t.replace(angle_rad=np.round(t.angle_rad, 6)))
FirstReactionWrong = reading(lambda t: t.replace(reaction_N=np.concatenate([t.reaction_N[1:2], t.reaction_N[1:]])))
"""Reactions at the start that are those of the next sample"""
Random = reading(lambda t: t.replace(angle_rad=t.angle_rad * (1.0 + 2e-16 * (time.perf_counter_ns() % 3))))
"""Another last bit in each run"""
Empty = reading(lambda t: dataclasses.replace(t.samples(slice(0)), ended="a bar reached the surface"))
"""A reason for the end, and no sample"""
Landed = reading(lambda t: dataclasses.replace(t.samples(slice(3)), ended="a bar reached the surface"))
"""A landing in a scene in which no bar lands"""
Noisy = declaring(noise=with_noise(reaction=1e6))
"""Noise of more than the scene's own forces"""
OrderOfChosenSteps = declaring(order=8.0)
UnknownEffect = declaring(effects=ReferenceFast.effects | {"oblatness"})
FineFirst = declaring(sweep=AccuracySweep(RTOL, (1e-12, 1e-9, 1e-6), 1e-9))
CoarserFinerRun = declaring(sweep=AccuracySweep(RTOL, (1e-6, 1e-9, 1e-12), 1e-9, finer_rtol=10.0))
OrderNotANumber = declaring(order=float("nan"))
StepConstantZero = declaring(step_constant=0.0)
NoClassMethod = declaring(unsupported=lambda self, scene: None)


class IgnoresSetting(ReferenceFast):
    """One accuracy whatever is requested: finer settings give no smaller error."""

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, Setting(setting.parameter, 1e-6))


class Rounding(ReferenceFast):
    """Order 16 in absolute coordinates: of many stages, round-off is left, another one at each setting."""

    coordinates = Coordinates.ABSOLUTE
    order = 16.0
    sweep = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (1000.0, 2000.0, 4000.0), 2000.0)
    size_m = 1e-5

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, Setting(AccuracyParameter.RTOL, 1e-13))
        self.seed = round(setting.value)

    def read(self) -> Trajectory:
        found = super().read()
        walk = np.random.default_rng(self.seed).normal(size=found.com_m.shape).cumsum(axis=0)
        return found.replace(com_m=found.com_m + self.size_m * (walk - walk[0]) / math.sqrt(len(walk)))


class LargeRounding(Rounding):
    """Errors of any sign that are larger than those of rounding."""

    size_m = 1e-2


class SharedRounding(Rounding):
    """The same small error at each setting, which no rounding leaves."""

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, setting)
        self.seed = 0


class DeclaredRounding(Rounding):
    """Its round-off, declared."""

    noise = with_noise(com=1e-4)


class ChangesScene(ReferenceFast):
    """Doubled masses in the scene itself."""

    def build(self, scene: Scene, setting: Setting) -> None:
        heavy = dataclasses.replace(scene.chain, mass_kg=tuple(2.0 * m for m in scene.chain.mass_kg))
        super().build(scene, setting)
        object.__setattr__(scene, "chain", heavy)


class HangsAtOneSetting(ReferenceFast):
    """A minute at the coarsest setting, no time at the others."""

    def build(self, scene: Scene, setting: Setting) -> None:
        if setting == self.sweep.settings[0]:
            time.sleep(60.0)
        super().build(scene, setting)


class HangsInOneScene(ReferenceFast):
    """No end in one scene."""

    def simulate(self) -> None:
        while self.name == "conform/two_bars_free":
            time.sleep(0.1)
        super().simulate()

    def build(self, scene: Scene, setting: Setting) -> None:
        self.name = scene.name
        super().build(scene, setting)


class RaisesOnLongRuns(ReferenceFast):
    """An error instead of a run of many orbits."""

    def build(self, scene: Scene, setting: Setting) -> None:
        if scene.run.duration_s > 1e7:
            raise EngineError("the run is too long")
        super().build(scene, setting)


class Untidy(ReferenceFast):
    """Prints, changes the folder and a signal handler, and leaves a file."""

    def simulate(self) -> None:
        print("step 1 of 1")
        Path("run.log").write_text("x", "utf-8")
        Path("inside").mkdir(exist_ok=True)
        os.chdir("inside")
        signal.signal(signal.SIGUSR1, signal.SIG_IGN)
        super().simulate()


class Seeds(ReferenceFast):
    """The same global seed and the same variable in each build."""

    def build(self, scene: Scene, setting: Setting) -> None:
        np.random.seed(7)  # noqa: NPY002
        random.seed(7)
        os.environ["MY_THREADS"] = "1"
        super().build(scene, setting)


class Slow(ReferenceFast):
    """Seconds for each run at a fine setting."""

    def simulate(self) -> None:
        time.sleep(1.5 if self.requested < 1e-5 else 0.0)
        super().simulate()

    def build(self, scene: Scene, setting: Setting) -> None:
        self.requested = setting.value
        super().build(scene, setting)


class Compiles(ReferenceFast):
    """A minute for each model."""

    def build(self, scene: Scene, setting: Setting) -> None:
        time.sleep(60.0)
        super().build(scene, setting)


class OneBuffer(ReferenceFast):
    """Angles in one array for all runs."""

    buffers: ClassVar[dict[tuple[int, ...], np.ndarray]] = {}

    def read(self) -> Trajectory:
        found = super().read()
        assert found.angle_rad is not None
        buffer = self.buffers.setdefault(found.angle_rad.shape, np.empty_like(found.angle_rad))
        buffer[:] = found.angle_rad
        return found.replace(angle_rad=buffer)


class KeepsModel(ReferenceFast):
    """The model of the first scene with as many bars."""

    kept: ClassVar[dict[int, Scene]] = {}

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(self.kept.setdefault(scene.bars, scene), setting)


class NoRates(ReferenceFast):
    """Angles and the track alone, of an accuracy that does not reach to the end of every scene."""

    observables = frozenset({Observable.COM, Observable.ATTITUDE})
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 3e-6, 1e-7), 3e-6)

    def read(self) -> Trajectory:
        return super().read().replace(rate_rad_s=None, reaction_N=None, gap_m=None, com_residual_m=None)


class Unfinished(Engine):
    """No method is defined."""


class NoEngine:
    """No subclass of Engine."""
