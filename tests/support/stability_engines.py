"""Faulty engines for the stability study, each wrong in one way, and the scenes in which they show it."""

from __future__ import annotations

import dataclasses
import functools
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, EngineError, Setting
from adapters.reference.numpy_engines import Reference
from adapters.registry import Registration
from barchain.judge.checks.beyond_limit import MAX_KINETIC_RATIO
from scenarios import load_scene
from tests.support.faulty_engines import Faulty, planted

if TYPE_CHECKING:
    from adapters.trajectory import Trajectory
    from scenarios import Scene

FREE, FALLS = "basics/two_bars_free", "hard/straight_horizontal"
OPENED = 1e-6  # of a bar: far beyond a joint's error in relative coordinates, far below what is taken for no joint


class Drifts(Faulty):
    """Joints that open, ever faster."""

    def change(self, engine_runs: Trajectory) -> Trajectory:
        opened = OPENED * (engine_runs.t_s / engine_runs.t_s[-1])[:, None] ** 1.5
        return engine_runs.replace(gap_m=engine_runs.gap_m + opened)


class BlowsUp(Faulty):
    """Rates that grow exponentially to many times what they are."""

    def change(self, engine_runs: Trajectory) -> Trajectory:
        rate = 3.0 * MAX_KINETIC_RATIO * np.abs(engine_runs.rate_rad_s).max()
        grown = np.exp(20.0 * (engine_runs.t_s / engine_runs.t_s[-1] - 1.0))[:, None]
        angle = engine_runs.angle_rad + rate * engine_runs.t_s[-1] / 20.0 * (grown - grown[0])
        return engine_runs.replace(angle_rad=angle, rate_rad_s=engine_runs.rate_rad_s + rate * grown)


class KnowsItsRequest(Faulty):
    """No fault; for those that hang on what is asked for."""

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, setting)
        self.rtol = setting.value


class WorseWithFiner(KnowsItsRequest):
    """An error that grows as what is asked for shrinks."""

    def change(self, engine_runs: Trajectory) -> Trajectory:
        return engine_runs.replace(
            angle_rad=engine_runs.angle_rad + 1e-15 / self.rtol * (engine_runs.t_s / engine_runs.t_s[-1])[:, None]
        )


class Loose(KnowsItsRequest):
    """Errors as its own two settings say, far beyond what it was asked for."""

    def change(self, engine_runs: Trajectory) -> Trajectory:
        return engine_runs.replace(
            angle_rad=engine_runs.angle_rad + 1e6 * self.rtol * (engine_runs.t_s / engine_runs.t_s[-1])[:, None]
        )


class EndsAtOnce(Faulty):
    """A method of equal steps that loses the chain to the ground before its second sample."""

    sweep: ClassVar = AccuracySweep(AccuracyParameter.STEPS_PER_ORBIT, (1000.0, 4000.0), default=4000.0)
    order: ClassVar = 2
    coordinates: ClassVar = Coordinates.ABSOLUTE

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, Reference.sweep.setting())

    def change(self, engine_runs: Trajectory) -> Trajectory:
        first = {k: v[:1] for k, v in vars(engine_runs).items() if isinstance(v, np.ndarray)}
        return dataclasses.replace(engine_runs, **first, ended="a bar reached the surface")


class RunsAway(Faulty):
    """A departure that grows at twice the linear rate of a pendulum in the tide."""

    def build(self, scene: Scene, setting: Setting) -> None:
        super().build(scene, setting)
        self.rate = 2.0 * np.sqrt(3.0) * scene.mean_motion_rad_s

    def change(self, engine_runs: Trajectory) -> Trajectory:
        return engine_runs.replace(
            angle_rad=engine_runs.angle_rad
            + 1e-3 * np.exp(self.rate * (engine_runs.t_s - engine_runs.t_s[-1]))[:, None]
        )


class WillNot(Faulty):
    """Says so before its first step."""

    def build(self, scene: Scene, setting: Setting) -> None:
        raise EngineError("bars of this mass are too light for me")


class CanNotFactor(Faulty):
    """Arithmetic that fails while it builds: no rejection."""

    def build(self, scene: Scene, setting: Setting) -> None:
        raise np.linalg.LinAlgError("not positive definite")


Lands = planted("Lands", "invented-end", 0.5, __name__)
"""Ends where the reference solution does not"""


class CanNot(Faulty):
    """Supports nothing."""

    effects: ClassVar = frozenset()


class CanNotFollow(Faulty):
    """Has a limit that is known only from the motion."""

    @classmethod
    def unsupported_motion(cls, scene: Scene, motion: Trajectory) -> str | None:
        return f"{len(motion.t_s)} samples of {scene.name} are too many for me"


@functools.cache
def scene(name: str) -> Scene:
    """Scene, the unstable one for an orbit, the free one for as long as its faults take to show."""
    found = load_scene(name)
    share, samples = (1.0 / 3.0, 101) if name == FALLS else (0.25, 31)
    run = dataclasses.replace(found.run, duration_s=share * found.run.duration_s, samples=samples)
    return dataclasses.replace(found, run=run)


def registration(engine: type[Faulty]) -> Registration:
    """How a faulty engine is registered."""
    return Registration(f"{engine.__module__}:{engine.__name__}", ours=True)
