"""Engines that go wrong in one way each: the reference, with a fault inserted."""

import ctypes
import dataclasses
import os
import time
from typing import ClassVar

import numpy as np

from adapters.engine import Engine, EngineError
from adapters.reference.numpy_engines import Reference
from adapters.trajectory import Observable
from barchain.runs.environment import THREADS

TRACE = "BARCHAIN_TEST_TRACE"
UNSOLVABLE = "basics/libration"


class Faulty(Engine):
    """The reference behind the contract, to insert faults into."""

    title = "the reference with a fault"
    coordinates = Reference.coordinates
    order = None
    sweep = Reference.sweep
    effects = Reference.effects
    observables: ClassVar = Reference.observables

    def build(self, scene, setting):
        self.inner = Reference()
        self.inner.build(scene, setting)

    def simulate(self):
        self.inner.simulate()

    def read(self):
        return self.change(self.inner.read())

    def change(self, seen):
        return seen


class Unmodified(Faulty):
    """No fault."""


class Segfault(Faulty):
    def simulate(self):
        print("about to go", flush=True)
        ctypes.string_at(0)


class Aborts(Faulty):
    def simulate(self):
        os.abort()


class Hangs(Faulty):
    def simulate(self):
        time.sleep(3600)


class GivesUp(Faulty):
    def simulate(self):
        raise EngineError("step size became zero")


class Raises(Faulty):
    def simulate(self):
        raise ZeroDivisionError("inside\nthe engine")


class DoesNotImport(Faulty):
    def build(self, scene, setting):
        raise ImportError("libmissing.so: cannot open shared object file")


class ReturnsNan(Faulty):
    def change(self, seen):
        angle = seen.angle_rad.copy()
        angle[7, 1] = np.nan
        return seen.replace(angle_rad=angle)


class StopsEarly(Faulty):
    def change(self, seen):
        half = len(seen.t_s) // 2
        arrays = {k: v[:half] for k, v in vars(seen).items() if isinstance(v, np.ndarray)}
        return dataclasses.replace(seen, **arrays)


class DropsChannel(Faulty):
    def change(self, seen):
        return dataclasses.replace(seen, reaction_N=None)


class WrongShape(Faulty):
    def change(self, seen):
        return seen.replace(rate_rad_s=seen.rate_rad_s[:, :1])


class LateClock(Faulty):
    def change(self, seen):
        return seen.replace(t_s=seen.t_s * (1 + 1e-6))


class IgnoresJoints(Faulty):
    def change(self, seen):
        return seen.replace(gap_m=seen.gap_m + 0.3 * seen.t_s[:, None])


class IgnoresJointsInSilence(Faulty):
    """Free bars, and no gap to tell of it."""

    observables: ClassVar = Reference.observables - {Observable.GAP}

    def change(self, seen):
        straight = seen.angle_rad[0] + np.outer(seen.t_s, seen.rate_rad_s[0])
        rate = np.broadcast_to(seen.rate_rad_s[0], seen.rate_rad_s.shape)
        zero = np.zeros_like(seen.reaction_N)
        return seen.replace(angle_rad=straight, rate_rad_s=rate, reaction_N=zero, gap_m=None)


class SwapsSign(Faulty):
    def change(self, seen):
        return seen.replace(reaction_N=-seen.reaction_N)


class WrongVelocity(Faulty):
    """A track that is right, with velocities that are not its own."""

    def change(self, seen):
        return seen.replace(com_velocity_m_s=seen.com_velocity_m_s * (1 + 1e-9))


class LeavesTraces(Faulty):
    """Changes its process for whoever comes after."""

    def simulate(self):
        os.environ[TRACE] = "1"
        self.inner.simulate()


class SeesTraces(Faulty):
    def simulate(self):
        if TRACE in os.environ:
            raise EngineError("somebody was here before")
        self.inner.simulate()


class NeedsOneThread(Faulty):
    """Rejects a run where libraries may use several threads."""

    def build(self, scene, setting):
        several = [name for name in THREADS if os.environ.get(name) != "1"]
        if several:
            raise EngineError(f"not pinned to one thread: {', '.join(several)}")
        super().build(scene, setting)


class LosesItsGrip(Faulty):
    """A reference that can't run one scene."""

    def simulate(self):
        if self.scene == UNSOLVABLE:
            raise EngineError("the joint system is singular at t = 12 s")
        self.inner.simulate()

    def build(self, scene, setting):
        super().build(scene, setting)
        self.scene = scene.name


class IsSloppy(Faulty):
    """A tolerance loosened on the quiet: both settings run at 1e-3."""

    def build(self, scene, setting):
        super().build(scene, dataclasses.replace(setting, value=setting.value * 1e6))


class Chatters(Faulty):
    def simulate(self):
        os.write(1, b"hello from C\n")
        print("hello from Python")
        with open("stray.txt", "w") as stray:  # noqa: PTH123
            stray.write("left behind")
        self.inner.simulate()
