"""The NumPy reference with one mistake each, as another package would bring it."""

from __future__ import annotations

import dataclasses
import math
import os
import random
import signal
import time
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Engine, EngineError, Setting
from adapters.reference.compiled_engine import ReferenceFast
from adapters.trajectory import Observable

if TYPE_CHECKING:
    from adapters.trajectory import Array, Trajectory
    from scenarios import Scene


class Right(ReferenceFast):
    """No mistake."""


class ReactionsReversed(ReferenceFast):
    """Forces on the other bar."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.reaction_N is not None
        return found.replace(reaction_N=-found.reaction_N)


class Degrees(ReferenceFast):
    """Angles in degrees."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.angle_rad is not None
        return found.replace(angle_rad=np.degrees(found.angle_rad))


class SinglePrecision(ReferenceFast):
    """Angles in single precision."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.angle_rad is not None
        return found.replace(angle_rad=found.angle_rad.astype(np.float32))  # type: ignore[arg-type]


class SingleInside(ReferenceFast):
    """Rates that were computed in single precision and are given in double."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.rate_rad_s is not None
        return found.replace(rate_rad_s=found.rate_rad_s.astype(np.float32).astype(float))


class IgnoresSetting(ReferenceFast):
    """One accuracy whatever is requested: finer settings give no smaller error."""

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, Setting(setting.parameter, 1e-6))


class Noisy(ReferenceFast):
    """Noise of more than the scene's own forces."""

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        del scene, setting, t_s
        return {"reaction": 1e6}


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

    @classmethod
    def noise(cls, scene: Scene, setting: Setting, t_s: Array) -> dict[str, float | Array]:
        del scene, setting, t_s
        return {"com": 1e-4}


class OrderOfChosenSteps(ReferenceFast):
    """An order, though the steps are chosen."""

    order = 8.0


class UnknownEffect(ReferenceFast):
    """An effect with a typing error."""

    effects = ReferenceFast.effects | {"oblatness"}


class FineFirst(ReferenceFast):
    """Settings from fine to coarse."""

    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-12, 1e-9, 1e-6), 1e-9)


class CoarserFinerRun(ReferenceFast):
    """A finer run that is ten times coarser."""

    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-6, 1e-9, 1e-12), 1e-9, finer_rtol=10.0)


class OrderNotANumber(ReferenceFast):
    """An order that is no number."""

    order = float("nan")


class StepConstantZero(ReferenceFast):
    """Steps without an error."""

    step_constant = 0.0


class NoClassMethod(ReferenceFast):
    """A method of the class that is none."""

    def unsupported(self, scene: Scene) -> str | None:  # type: ignore[override]
        del scene


class ChangesScene(ReferenceFast):
    """Doubled masses in the scene itself."""

    def build(self, scene: Scene, setting: Setting) -> None:
        heavy = dataclasses.replace(scene.chain, mass_kg=tuple(2.0 * m for m in scene.chain.mass_kg))
        super().build(scene, setting)
        object.__setattr__(scene, "chain", heavy)


class Empty(ReferenceFast):
    """A reason for the end, and no sample."""

    def read(self) -> Trajectory:
        return dataclasses.replace(super().read().samples(slice(0)), ended="a bar reached the surface")


class Landed(ReferenceFast):
    """A landing in a scene in which no bar lands."""

    def read(self) -> Trajectory:
        return dataclasses.replace(super().read().samples(slice(3)), ended="a bar reached the surface")


class OtherTurns(ReferenceFast):
    """Angles that begin a turn later."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.angle_rad is not None
        return found.replace(angle_rad=found.angle_rad + 2.0 * np.pi)


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


class Random(ReferenceFast):
    """Another last bit in each run."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.angle_rad is not None
        return found.replace(angle_rad=found.angle_rad * (1.0 + 2e-16 * (time.perf_counter_ns() % 3)))


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


class RoundedAngles(ReferenceFast):
    """Angles with six decimals."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.angle_rad is not None
        return found.replace(angle_rad=np.round(found.angle_rad, 6))


class NoRates(ReferenceFast):
    """Angles and the track alone, of an accuracy that does not reach to the end of every scene."""

    observables = frozenset({Observable.COM, Observable.ATTITUDE})
    sweep = AccuracySweep(AccuracyParameter.RTOL, (1e-4, 3e-6, 1e-7), 3e-6)

    def read(self) -> Trajectory:
        return super().read().replace(rate_rad_s=None, reaction_N=None, gap_m=None, com_residual_m=None)


class FirstReactionWrong(ReferenceFast):
    """Reactions at the start that are those of the next sample."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.reaction_N is not None
        return found.replace(reaction_N=np.concatenate([found.reaction_N[1:2], found.reaction_N[1:]]))


class SingleState(ReferenceFast):
    """Errors of single precision in every quantity, kept in double precision."""

    def read(self) -> Trajectory:
        found = super().read()
        assert found.reaction_N is not None
        single = found.reaction_N.astype(np.float32).astype(float)
        return found.replace(reaction_N=single * (1.0 + 1e-12))


class Unfinished(Engine):
    """No method is defined."""


class NoEngine:
    """No subclass of Engine."""
