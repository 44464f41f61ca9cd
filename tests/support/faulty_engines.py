"""Engines that go wrong in one way each: by a mistake of the catalogue, or by what their process does."""

import ctypes
import os
import time
from typing import ClassVar

from adapters.engine import Engine, EngineError
from adapters.reference.numpy_engines import Reference
from adapters.registry import ENGINES
from barchain.runs.environment import THREADS
from barchain.studies.selftest.faults.catalogue import FaultyEngine, find

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

    def made(self):
        return Reference()

    def build(self, scene, setting):
        self.inner = self.made()
        self.inner.build(scene, setting)

    def simulate(self):
        self.inner.simulate()

    def read(self):
        return self.change(self.inner.read())

    def change(self, seen):
        return seen


class Unmodified(Faulty):
    """No fault."""


def planted(called, name, size=None, module=__name__):
    """Class of the reference with a mistake of the catalogue; by default at its natural size."""
    fault = find(name)

    class Planted(Faulty):
        def made(self):
            return FaultyEngine(ENGINES["reference"], fault, fault.natural if size is None else size)

    Planted.__name__, Planted.__qualname__, Planted.__module__ = called, called, module
    return Planted


ReturnsNan = planted("ReturnsNan", "nan-attitude")
StopsEarly = planted("StopsEarly", "cut")
DropsChannel = planted("DropsChannel", "dropped-reaction")
LateClock = planted("LateClock", "clock-stretched")
IgnoresJoints = planted("IgnoresJoints", "opened-gap", 1e3)
IgnoresJointsInSilence = planted("IgnoresJointsInSilence", "joints-ignored-in-silence")
SwapsSign = planted("SwapsSign", "sign-reaction")
WrongVelocity = planted("WrongVelocity", "scale-com-velocity", 1e-9)
IsSloppy = planted("IsSloppy", "loosened", 1e6)
"""Mistakes of the catalogue"""


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


class WrongShape(Faulty):
    def change(self, seen):
        return seen.replace(rate_rad_s=seen.rate_rad_s[:, :1])


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


class Chatters(Faulty):
    def simulate(self):
        os.write(1, b"hello from C\n")
        print("hello from Python")
        with open("stray.txt", "w") as stray:  # noqa: PTH123
            stray.write("left behind")
        self.inner.simulate()
